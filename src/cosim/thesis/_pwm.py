"""Figure 4.8: the bridge that switches at 100 kHz, 1 kHz and 10 Hz, against the averaged one and closed forms.

Closed forms for a motor at constant speed with the back-EMF E, tau = L/R, and pulses of d T out of T:

* the current flows on from period to period: it goes between i_low and i_high, the fixed points of both exponentials,
  and its mean is (d V - E)/R, that of the averaged bridge;
* it does not: it rises from zero to i_peak = (V - E)/R (1 - exp(-d T/tau)) and freewheels for
  t_f = tau log(1 + R i_peak/E); as the inductor's mean voltage is zero, R mean = d (V - E) - E t_f/T.

The two meet where the mean is about half the ripple, V d (1 - d) T/(2 L).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cosim.engine import Fmu, Result
from cosim.scenario import read
from cosim.thesis._runs import Locate, run, scenario_run

Array = NDArray[np.float64]

STEP_AT = 2.0
"""When the duty ratio of the scenarios falls from one [s]."""
ROWS = {"100khz": "1.0037e-4 s", "1khz": "2e-5 s", "10hz": "1e-4 s", "averaged": "1e-4 s"}
"""Distance of the rows. 50 of them in a period of 1 ms hit both edges of the pulse; at 100 kHz 27 of them, 10.037
periods apart, lie evenly over a period, so that their mean is that of the ripple and not its foot."""
GROUP = {"100khz": 27, "1khz": 50, "10hz": 1000}
"""Rows from one mean to the next: a period, at 100 kHz as many rows as lie evenly over one."""


@dataclass(frozen=True)
class Machine:
    """Motor and supply: resistance [Ohm], all inductances [H], back-EMF constant [V s/rad], voltage [V]."""

    R: float
    L: float
    k: float
    V: float

    @property
    def tau(self) -> float:
        """Electrical time constant [s]."""
        return self.L / self.R

    def half_ripple(self, d: float, period: float) -> float:
        """Return half the ripple of a current that goes in straight lines, V d (1 - d) T/(2 L) [A]."""
        return self.V * d * (1.0 - d) * period / (2.0 * self.L)

    def extremes(self, d: float, period: float, emf: Array) -> tuple[Array, Array]:
        """Return least and greatest current [A] of the steady cycle at the back-EMFs [V], of their shape."""
        rise, fall = np.exp(-d * period / self.tau), np.exp(-(1.0 - d) * period / self.tau)
        up, down = (self.V - emf) / self.R, -emf / self.R
        low = (down * (1.0 - fall) + up * (1.0 - rise) * fall) / (1.0 - rise * fall)
        flows_on = low >= 0.0
        low = np.where(flows_on, low, 0.0)
        return low, up + (low - up) * rise

    def mean(self, d: float, period: float, emf: Array) -> Array:
        """Return the mean current [A] of the steady cycle, whichever way it conducts; of the shape of ``emf``."""
        low, peak = self.extremes(d, period, emf)
        freewheels = self.tau * np.log1p(self.R * peak / emf)
        stops: Array = (d * (self.V - emf) - emf * freewheels / period) / self.R
        return np.where(low > 0.0, (d * self.V - emf) / self.R, stops)


@dataclass(frozen=True)
class Periods:
    """What each period of a run holds, arrays of shape (n,)."""

    time: Array
    """Middle [s]."""
    mean: Array
    """Mean current [A]."""
    trough: Array
    """Least current [A]."""
    peak: Array
    """Greatest current [A]."""
    emf: Array
    """Mean back-EMF [V]."""
    averaged: Array
    """What the averaged bridge would carry in its place, (d V - E - L di/dt)/R [A] with the slope of the mean; none
    where this is below zero, as its diode lets no current flow back."""


@dataclass(frozen=True)
class Pwm:
    """The runs of figure 4.8 by name, ``averaged`` among them, with the machine they turn."""

    runs: Mapping[str, Result]
    machine: Machine
    duty: float
    """Duty ratio after the step."""

    def periods(self, name: str) -> Periods:
        """Return the periods of a switched run after the step, from 50 ms after it on."""
        run, group = self.runs[name], GROUP[name]
        time, current, speed = (
            run.time, run.columns["plant.i_motor"].astype(float), run.columns["plant.w_motor"].astype(float)
        )  # fmt: skip
        first = int(np.searchsorted(time, STEP_AT + 0.05 - 1e-9))
        starts = np.arange(first, len(time) - group - 1, group)
        rows = starts[:, None] + np.arange(group + 1)
        # the trapezoidal rule over a period; what the last row adds at 100 kHz is a 27th of the ripple's change
        mean = np.trapezoid(current[rows], axis=1) / group
        emf = self.machine.k * np.trapezoid(speed[rows], axis=1) / group
        middle = time[rows].mean(axis=1)
        slope = np.gradient(mean, middle)
        averaged = (self.duty * self.machine.V - emf - self.machine.L * slope) / self.machine.R
        return Periods(middle, mean, current[rows].min(axis=1), current[rows].max(axis=1), emf, averaged)

    def mean_current(self, name: str, since: float = 0.0) -> float:
        """Return the mean current from ``since`` [s] to the end [A]."""
        run = self.runs[name]
        rows = run.time >= since - 1e-9
        current = run.columns["plant.i_motor"][rows]
        return float(np.trapezoid(current, run.time[rows]) / (run.time[rows][-1] - run.time[rows][0]))

    def ripple_error(self) -> float:
        """Return the greatest relative difference between the ripple at 1 kHz and its closed form, over all periods.

        The speed changes little in a period; the ripple is that of the steady cycle at its mean back-EMF, which lasts
        from one period to the next.
        """
        found = self.periods("1khz")
        low, high = self.machine.extremes(self.duty, 1e-3, found.emf)
        return float(np.abs((found.peak - found.trough) / (high - low) - 1.0).max())

    def flowing(self, name: str, period: float) -> NDArray[np.bool_]:
        """Tell for each period whether the averaged bridge's mean exceeds half the ripple."""
        flows: NDArray[np.bool_] = self.periods(name).averaged > self.machine.half_ripple(self.duty, period)
        return flows


def pwm_runs(scenarios: Path, locate: Locate) -> Pwm:
    """Simulate the scenarios of figure 4.8, and the same inputs at the averaged bridge."""
    files = {name: scenarios / f"rig_pwm_{name}.csv" for name in GROUP}
    runs = {name: scenario_run(file, locate, f"output_interval={ROWS[name]}") for name, file in files.items()}
    same = read(files["100khz"], [f"output_interval={ROWS['averaged']}"])
    runs["averaged"] = run(replace(same, system="rig", settings=()), locate)
    return Pwm(runs, _machine(Fmu.read(locate("rig_switched"))), float(runs["averaged"].columns["plant.duty"][-1]))


def _machine(fmu: Fmu) -> Machine:
    def start(name: str) -> float:
        value = fmu.variables[name].start
        assert isinstance(value, float)
        return value

    inductance = start("motor.L") + 2.0 * start("motor.L_filter")
    return Machine(start("motor.R"), inductance, start("k_emf"), start("v_supply"))
