"""Runs that test what the source claims, and what is measured in them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cosim.assessment import score
from cosim.engine import Channel, Fmu, Result, System, simulate
from cosim.scenario import assemble, read
from cosim.thesis._readings import DIP
from cosim.thesis._runs import FULL_STOP, Locate, scenario_run

Array = NDArray[np.float64]

NO_LOAD = "plant.ext_load=0 N.m"
PULSE_AT = 6.5
"""When the single pulse of torque begins [s]: in the fourth revolution, with the period learned."""
PULSE = 0.3
"""Its length [s], that of the pulses in the disturbed runs."""
SIZES = {"braked": -5.0, "pushed": 5.0}
"""Its torque [N.m], that of the pulses in the disturbed runs."""
AFTER = 6
"""Revolutions that are looked at after the pulse."""


@dataclass(frozen=True)
class Budget:
    """Means over whole revolutions at full voltage: where the power of the linkage goes."""

    revolution: float
    """Time of a revolution [s]."""
    electrical: float
    """Power that the motor takes up [W]."""
    torque: float
    """Torque at the crank, as power over speed [N.m]."""
    load_torque: float
    """The external load's part of it [N.m]; the rest is damping, as the kinetic energy returns."""
    current: float
    """RMS [A]."""

    @property
    def damping_torque(self) -> float:
        """The part of the torque that damping takes [N.m]."""
        return self.torque - self.load_torque


def load_budgets(scenarios: Path, locate: Locate) -> Mapping[str, Budget]:
    """Return the budget of the linkage at full voltage ``with`` and ``without`` its external load."""
    file = scenarios / "linkage_full_voltage.csv"
    return {
        "with": budget(scenario_run(file, locate)),
        "without": budget(scenario_run(file, locate, NO_LOAD)),
    }


def budget(run: Result) -> Budget:
    """Return the means over the revolutions after the first one."""
    columns = {name.removeprefix("plant."): values for name, values in run.columns.items()}
    closes = np.flatnonzero(np.diff(columns["park"]) > 0) + 1
    rows = slice(closes[1], closes[-1] + 1)
    time = run.time[rows]

    def mean(values: NDArray[np.floating] | NDArray[np.integer]) -> float:
        return float(np.trapezoid(values[rows], time) / (time[-1] - time[0]))

    speed = mean(columns["w_crank"])
    return Budget(
        revolution=float(time[-1] - time[0]) / (len(closes) - 2),
        electrical=mean(columns["v_motor"] * columns["i_motor"]),
        torque=mean(columns["tau_crank"] * columns["w_crank"]) / speed,
        load_torque=mean(columns["tau_ds"] * columns["w_ds"] + columns["tau_ps"] * columns["w_ps"]) / speed,
        current=mean(columns["i_motor"] ** 2) ** 0.5,
    )


def no_load_revolution(plant: Fmu) -> float:
    """Return 2 pi n / w with the no-load speed w = (V0 - R i0) / K of the motor (table 3.4) [s]."""
    resistance, current, voltage, constant, ratio = (
        float(plant.variables[name].start or 0.0)
        for name in ("motor.R", "motor.i_no_load", "motor.v_no_load", "k_emf", "gear.ratio")
    )
    return 2.0 * np.pi * ratio * constant / (voltage - resistance * current)


@dataclass(frozen=True)
class Aftermath:
    """How much a pulse of torque changes the crank's speed, revolution by revolution.

    ``difference`` [1], of shape (1 + AFTER,): RMS of the difference to the run without the pulse, at the same crank
    angle, over that of the revolution with the pulse, which is the first entry. ``speeds`` are both speeds [rad/s] at
    ``angle`` [revolutions since the pulse began].
    """

    name: str
    difference: Array
    angle: Array
    speeds: tuple[Array, Array]


def aftermaths(scenarios: Path, locate: Locate) -> list[Aftermath]:
    """Return what a pulse leaves behind on the rig: at constant voltage, and under both forms of the profile."""
    file = scenarios / "rig_20ms.csv"
    found = []
    for name, settings in (
        ("constant voltage", None),
        ("profile, Soft_stop Ts/2", ()),
        ("profile, Soft_stop Ts", (FULL_STOP,)),
    ):
        plain, *pulsed = (_pulsed(file, settings, size, locate) for size in (0.0, *SIZES.values()))
        found += [aftermath(f"{name}, {hand}", plain, run) for hand, run in zip(SIZES, pulsed, strict=True)]
    return found


def aftermath(name: str, plain: Result, pulsed: Result) -> Aftermath:
    """Compare a run with a pulse to the one without, at the same crank angles."""
    begin = float(np.interp(PULSE_AT, pulsed.time, pulsed.columns["plant.phi_crank"]))
    per_turn = 1000
    angle = np.arange((1 + AFTER) * per_turn) / per_turn
    a, b = (
        np.interp(begin + 2.0 * np.pi * angle, run.columns["plant.phi_crank"], run.columns["plant.w_crank"])
        for run in (plain, pulsed)
    )
    rms = np.sqrt(np.mean((b - a).reshape(-1, per_turn) ** 2, axis=1))
    return Aftermath(name, rms / rms[0], angle, (a, b))


def _pulsed(file: Path, settings: Sequence[str] | None, size: float, locate: Locate) -> Result:
    """Simulate with one pulse of torque; without settings at full voltage and without a controller."""
    scenario = read(file, settings or ())
    system = assemble(scenario, locate)
    if settings is None:
        plant = [component for component in system.components if component.name == "plant"]
        system = System(plant, channels=[Channel(("plant", "duty"), [0.0], [1.0])])
    end = PULSE_AT + PULSE
    times, values = [0.0, PULSE_AT, PULSE_AT, end, end], [0.0, 0.0, size, size, 0.0]
    system.channels.append(Channel(("plant", "tau_disturbance"), times, values))
    return simulate(system, stop=24.0, output_interval=1e-3, tolerance=scenario.tolerance)


@dataclass(frozen=True)
class SlowUnit:
    """A unit that does everything every ``period`` [s], the park input too."""

    period: float
    contacts: int
    """How often the park contact closes in the run."""
    seen: int
    """How many of the closings a sample falls into."""
    late: int
    """Park signals to which the deceleration comes after, and none just before (of all that are scored)."""
    scored: int


def slow_units(scenarios: Path, locate: Locate, periods: Sequence[float] = (0.02, 0.05)) -> list[SlowUnit]:
    """Simulate the rig with a unit that has one rate only, the case that the source's words describe."""
    found = []
    for period in periods:
        file = scenarios / f"rig_{period * 1e3:.0f}ms.csv"
        run = scenario_run(file, locate, f"controller.T_compute={period} s")
        park = run.columns["plant.park"] > 0
        closes = np.flatnonzero(park[1:] & ~park[:-1]) + 1
        opens = np.flatnonzero(park[:-1] & ~park[1:]) + 1
        pairs = [(a, opens[opens > a][0]) for a in closes if (opens > a).any()]
        ticks = np.arange(0, len(park), round(period * 1e3))
        seen = sum(bool(((ticks >= a) & (ticks < b)).any()) for a, b in pairs)
        late, scored = late_decelerations(run)
        found.append(SlowUnit(period, len(pairs), seen, late, scored))
    return found


def late_decelerations(run: Result) -> tuple[int, int]:
    """Return at how many park signals the deceleration comes after the signal only, and how many are scored."""
    revolutions = score(run, DIP.rules).revolutions
    late = [r for r in revolutions if not r.park_deceleration and r.began_after is not None]
    return len(late), len(revolutions)


@dataclass(frozen=True)
class TurnPosition:
    """Where the profile turns, the median of a run: ``share`` of the revolution."""

    sample_time: float
    n_window: int
    share: float

    @property
    def window(self) -> float:
        """How far back the sliding minimum of the current reaches [s]."""
        return self.sample_time * self.n_window


def turn_positions(scenarios: Path, locate: Locate) -> list[TurnPosition]:
    """Vary sampling time and length of the minimum's window apart: 50 samples as in the source, and other numbers."""
    found = []
    for sample_time, n_window in (
        (0.001, 50), (0.002, 50), (0.01, 50), (0.02, 50), (0.05, 50), (0.01, 100), (0.01, 250), (0.02, 3), (0.05, 1),
        (0.05, 20),
    ):  # fmt: skip
        file = scenarios / f"rig_{sample_time * 1e3:.0f}ms.csv"
        run = scenario_run(file, locate, f"controller.n_window={n_window}")
        shares = [r.turn_position for r in score(run).revolutions if r.turn_position is not None]
        found.append(TurnPosition(sample_time, n_window, float(np.median(shares))))
    return found
