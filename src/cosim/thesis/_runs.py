"""The simulations behind the figures: the shipped scenarios, with what the source varies."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from cosim.assessment import Score, score
from cosim.engine import Channel, Component, Fmu, Result, System, simulate
from cosim.scenario import Scenario, assemble, read

SAMPLE_TIMES = (0.001, 0.002, 0.010, 0.020, 0.050)
"""Sampling times of the current in section 4.5 [s]."""
FULL_STOP = "controller.stop_ratio=1"
"""Soft_stop as long as the other ramps, as figure 3.12 draws it; figure 3.11 makes it half as long."""

Locate = Callable[[str], Path]


@dataclass(frozen=True)
class RigRun:
    """A run of the lifetime-test rig as in chapter 4: the current's sampling time [s], the result, its score."""

    sample_time: float
    load: str
    result: Result
    score: Score


def scenario_run(file: Path, locate: Locate, *settings: str) -> Result:
    """Simulate a scenario file with ``name=value`` settings, as ``cosim run --set`` does."""
    return run(read(file, settings), locate)


def run(scenario: Scenario, locate: Locate) -> Result:
    """Simulate what a scenario says."""
    return simulate(
        assemble(scenario, locate),
        stop=scenario.stop,
        output_interval=scenario.output_interval,
        tolerance=scenario.tolerance,
    )


def rig_runs(scenarios: Path, locate: Locate, *settings: str) -> list[RigRun]:
    """The rig under the profile: each sampling time with its normal load, then braked and pushed in turn."""
    runs = []
    for sample_time in SAMPLE_TIMES:
        for load, ending in (("normal", ""), ("disturbed", "_disturbed")):
            result = scenario_run(scenarios / f"rig_{sample_time * 1e3:.0f}ms{ending}.csv", locate, *settings)
            runs.append(RigRun(sample_time, load, result, score(result)))
    return runs


def preset_run(scenarios: Path, locate: Locate) -> Result:
    """The rig's first two revolutions, with half a revolution preset so that the first park signal is predicted."""
    return scenario_run(scenarios / "rig_20ms.csv", locate, "controller.T_default=1.045 s", "stop=5 s")


def linkage_runs(scenarios: Path, locate: Locate) -> dict[str, Result]:
    """The linkage at full voltage with the naive load of figure 3.4 and with the simple one of equation 3.1."""
    file = scenarios / "linkage_full_voltage.csv"
    return {
        "naive": scenario_run(file, locate, "plant.naive_load=true"),
        "simple": scenario_run(file, locate),
    }


def profile_run(locate: Locate, *, stop: float = 4.0) -> Result:
    """The controller alone, as figure 3.12 draws it: half a revolution of 1 s, a current that invites every turn.

    The half revolution is the one that the chart assumes until it has measured one; the park contact closes at the
    start only, so that every end is predicted. The soft stop lasts as long as the other ramps.
    """
    with Fmu.read(locate("voltage_profile")) as fmu:
        system = System(
            [Component("controller", fmu, {"stop_ratio": 1.0})],
            channels=[
                Channel(("controller", "i_motor"), [0.0], [0.5]),
                Channel(("controller", "park"), [0.0, 0.05, 0.05], [1.0, 1.0, 0.0]),
            ],
        )
        return simulate(system, stop=stop, output_interval=1e-3, tolerance=1e-6)
