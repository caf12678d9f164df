"""What the source leaves open in the runs of table 4.1, as factors with levels, and the rig with such a setting."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from cosim.engine import Channel, Component, System
from cosim.scenario import assemble, read
from cosim.scenario.disturbance import Pulses, rows
from cosim.thesis._runs import Locate

Level = float | str
Setting = Mapping[str, Level]
"""A level for each factor, by its key."""

TICK = 0.001
"""Finest period of the controller unit [s], which both rates and the latch can have."""
FAST, SLOW = "1 ms", "sampling time"
LATCHED, SAMPLED = "latched", "sampled"
DISTURBANCE = frozenset({"pulse_size_Nm", "pulse_phase_s"})
"""Factors that a run without a hand on the load does not know."""


@dataclass(frozen=True)
class Factor:
    """Something that the source leaves open, or states in two ways.

    ``key`` is its column, with the unit, ``label`` its name in texts, ``assumed`` the level in the scenarios,
    ``others`` the further ones that are tried alone. ``low`` and ``high`` are those of the factorial, ``why`` tells
    where all of them come from, ``unit`` is that of ``format``.
    """

    key: str
    label: str
    assumed: Level
    others: tuple[Level, ...]
    low: Level
    high: Level
    why: str
    unit: str = ""
    scale: float = 1.0

    def format(self, level: Level) -> str:
        """Return a level with its unit."""
        if isinstance(level, str):
            return level
        return f"{level * self.scale:.4g} {self.unit}".strip()


FACTORS = (
    Factor("measuring", "rate of ADC and moving average", FAST, (SLOW,), FAST, SLOW,
           "the source varies \"the sampling time of the current\" and leaves different rates out"),
    Factor("pulse_size_Nm", "disturbance, size", 5.0, (2.5, 10.0, 20.0), 2.5, 10.0,
           "\"large\", by hand; 5 N m are 20 N on the arm; half to double", "N m"),
    Factor("soft_stop", "Soft_stop over ramp time", 0.5, (0.75, 1.0), 0.5, 1.0,
           "half a ramp in the chart, a whole one in figure 3.12"),
    Factor("J_rotor_kgm2", "rotor inertia", 1e-4, (0.5e-4, 2e-4), 0.5e-4, 2e-4,
           "assumed for a 70 W wiper motor; half to double", "kg cm²", 1e4),
    Factor("park", "park contact", LATCHED, (SAMPLED,), LATCHED, SAMPLED,
           "an input that a slow chart reads, or one that keeps a closing for it"),
    Factor("T_ramp_s", "ramp time", 0.1, (0.05, 0.2), 0.08, 0.12,
           "table 3.5 gives it, and calls it sampling time; a fifth either way", "ms", 1e3),
    Factor("noise_A", "noise of a current sample, RMS", 0.0, (0.1, 0.2, 0.5), 0.0, 0.2,
           "averaged over the three samples of 0.125 s at 50 ms, 0.2 A give the ripple of 0.5 A of chapter 5", "A"),
    Factor("chart", "rate of the chart", FAST, (SLOW,), FAST, SLOW,
           "as for measuring: one rate in the generated code, or a hold for the current alone"),
    Factor("T_filter_s", "length of the moving average", 0.125, (0.0, 0.0625, 0.25), 0.1, 0.15,
           "4.3 gives it: \"approximate\", of a revolution's order; a fifth either way", "ms", 1e3),
    Factor("n_window", "samples in the minimum", 50.0, (25.0, 100.0, 200.0), 40.0, 60.0,
           "3.5.1 gives it, which makes 50 ms to 2.5 s; a fifth either way"),
    Factor("pulse_phase_s", "disturbance, later by", 0.0, (0.5, 1.0, 1.5), 0.0, 1.0,
           "\"periodically\"; in quarters of a revolution", "s"),
)  # fmt: skip
"""In the order of the columns of the factorial, see `_sensitivity_design`."""

ASSUMED: Setting = {factor.key: factor.assumed for factor in FACTORS}
"""The setting of the scenarios."""


@dataclass(frozen=True)
class Bench:
    """The rig and the sampled part of the controller unit, loaded once for all runs."""

    base: System

    @classmethod
    def load(cls, scenarios: Path, locate: Locate) -> Bench:
        """Take the rig with its parameters from the shipped scenario of 20 ms; raises `CosimError`."""
        scenario = replace(read(scenarios / "rig_20ms.csv"), controller="ecu_sampled")
        return cls(assemble(scenario, locate))

    def system(self, setting: Setting, sample_time: float, load: str, stop: float) -> System:
        """Return the rig under a setting, with the current's sampling time [s] and a ``load`` up to ``stop`` [s]."""
        plant, controller = self.base.components
        compute = _period(setting["chart"], sample_time)
        settings = {
            "T_sample": sample_time,
            "T_compute": compute,
            "T_measure": _period(setting["measuring"], sample_time),
            "n_read": round(compute / TICK) if setting["park"] == LATCHED else 1,
            "i_noise": setting["noise_A"],
            "T_filter": setting["T_filter_s"],
            "T_ramp": setting["T_ramp_s"],
            "n_window": round(float(setting["n_window"])),
            "stop_ratio": setting["soft_stop"],
        }
        return System(
            [
                Component("plant", plant.fmu, {**plant.parameters, "J_rotor": setting["J_rotor_kgm2"]}),
                Component("controller", controller.fmu, {**controller.parameters, **settings}),
            ],
            self.base.connections,
            _hand(setting, stop) if load == "disturbed" else [],
        )


def relevant(setting: Setting, sample_time: float, load: str) -> tuple[Level, ...]:
    """Return what a run depends on: equal tuples, equal runs.

    Without a hand on the load there are no pulses, at a sampling time of 1 ms all rates are one, and a chart that runs
    every millisecond reads the contact as often as its latch does.
    """
    values = dict(setting)
    if load == "normal":
        values |= dict.fromkeys(DISTURBANCE, 0.0)
    if sample_time <= TICK:
        values |= {"chart": FAST, "measuring": FAST}
    if values["chart"] == FAST:
        values["park"] = LATCHED
    return (sample_time, load, *(values[factor.key] for factor in FACTORS))


def chart_period(setting: Setting, sample_time: float) -> float:
    """Return the period of the chart [s]."""
    return _period(setting["chart"], sample_time)


def _period(rate: Level, sample_time: float) -> float:
    return TICK if rate == FAST else sample_time


def _hand(setting: Setting, stop: float) -> list[Channel]:
    """The pulses of the disturbed scenarios, of another size and later."""
    shift = float(setting["pulse_phase_s"])
    table = rows(Pulses(size=float(setting["pulse_size_Nm"])), stop)
    times = [time + shift if time > 0 else time for time, _ in table]
    return [Channel(("plant", "tau_disturbance"), times, [torque for _, torque in table])]
