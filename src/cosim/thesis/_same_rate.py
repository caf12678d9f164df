"""The voltage profile and constant voltage at the same wipe rate: the thesis's question, on the linkage and the rig."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from cosim.assessment import Comparison, Method, Vibration, compare, vibration
from cosim.engine import Channel, Component, Fmu, Result, System, simulate
from cosim.thesis._runs import Locate, scenario_run

SETTLED = 2.5
"""When the start and the first revolution, in which the period is learned, are over [s]."""
STOP = 25.0
SYSTEMS = ("linkage", "rig")


@dataclass(frozen=True)
class Pair:
    """A run under the profile and one at the constant ``duty`` at which a revolution takes as long."""

    duty: float
    profile: Result
    constant: Result

    @cached_property
    def _measured(self) -> Mapping[bool, tuple[Vibration, Vibration]]:
        methods = {True: Method(), False: Method(since=SETTLED)}
        return {whole: (vibration(self.profile, m), vibration(self.constant, m)) for whole, m in methods.items()}

    def measures(self, *, whole: bool) -> tuple[Vibration, Vibration]:
        """Return the vibration of profile and constant voltage, of the whole run or of what follows 2.5 s."""
        return self._measured[whole]

    def comparison(self, *, whole: bool) -> Comparison:
        """Return the ratios of the profile's measures to those of constant voltage."""
        return compare(*self.measures(whole=whole))


def same_rate(scenarios: Path, locate: Locate) -> Mapping[str, Pair]:
    """Simulate both systems under the profile, as in their scenarios for 20 ms, and at their wipe rate without it."""
    pairs = {}
    for system in SYSTEMS:
        profile = scenario_run(scenarios / f"{system}_20ms.csv", locate)
        fmu = Fmu.read(locate(system))
        duty = matching_duty(fmu, vibration(profile)["revolution_time"])
        pairs[system] = Pair(duty, profile, constant_voltage(fmu, duty))
    return pairs


def matching_duty(plant: Fmu, revolution: float) -> float:
    """Return the constant duty ratio at which a revolution takes ``revolution`` [s]."""
    from scipy.optimize import brentq

    def excess(duty: float) -> float:
        return vibration(constant_voltage(plant, duty))["revolution_time"] - revolution

    return float(brentq(excess, 0.9, 1.0, xtol=1e-4))


def constant_voltage(plant: Fmu, duty: float) -> Result:
    """Run a plant as today's production does: the voltage is switched on and stays."""
    system = System([Component("plant", plant)], channels=[Channel(("plant", "duty"), [0.0], [duty])])
    return simulate(system, stop=STOP, output_interval=1e-3, tolerance=1e-6)
