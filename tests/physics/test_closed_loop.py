"""A sampled controller has no coupling error: the co-simulation equals one model of plant and controller."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cosim.engine import Result, simulate
from cosim.fmu import catalogue
from cosim.scenario import assemble, read
from reference.closed_loop import ClosedLoop, closed_loop
from reference.controller import Parameters
from reference.plant import linkage_plant

SCENARIO = Path(__file__).parents[2] / "scenarios" / "linkage_20ms.csv"


def cosimulated(stop: float, tolerance: float, *settings: str) -> Result:
    scenario = read(SCENARIO, settings)
    system = assemble(scenario, catalogue.ensure)
    return simulate(system, stop=stop, output_interval=scenario.output_interval, tolerance=tolerance)


def compare(result: Result, expected: ClosedLoop) -> None:
    state, names = result.columns["controller.state"], result.literals["controller.state"]
    entered = np.flatnonzero(np.diff(state, prepend=-1))
    decisions = [(round(float(result.time[k]), 9), names[int(state[k]) - 1]) for k in entered]
    assert decisions == [(round(t, 9), s.value.rpartition(".")[2]) for t, s in expected.changes]
    assert np.abs(result.columns["controller.duty"] - expected.values["duty"]).max() < 1e-12
    assert np.abs(result.columns["plant.i_motor"] - expected.values["i_motor"]).max() < 1e-4
    assert np.abs(result.columns["plant.phi_crank"] - expected.values["phi_crank"]).max() < 1e-5
    assert np.array_equal(result.columns["plant.park"], expected.values["park"])


def test_linkage_20ms_equals_the_monolithic_loop_over_five_seconds() -> None:
    compare(cosimulated(5.0, 1e-7), closed_loop(linkage_plant(), Parameters(), stop=5.0))


@pytest.mark.slow
def test_linkage_20ms_equals_the_monolithic_loop_over_the_whole_scenario() -> None:
    compare(cosimulated(25.0, read(SCENARIO).tolerance), closed_loop(linkage_plant(), Parameters(), stop=25.0))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("sample_time", "compute_time", "stop"),
    [(0.001, 0.001, 12.0), (0.002, 0.001, 12.0), (0.01, 0.001, 12.0), (0.05, 0.001, 12.0), (0.0073, 0.0001, 6.0)],
)
def test_any_sample_time_gives_the_decisions_of_the_monolithic_loop(
    sample_time: float, compute_time: float, stop: float
) -> None:
    result = cosimulated(
        stop,
        1e-8,
        f"sample_time={sample_time} s",
        f"controller.T_compute={compute_time} s",
        f"output_interval={compute_time} s",
    )
    parameters = Parameters(T_sample=sample_time, T_compute=compute_time)
    compare(result, closed_loop(linkage_plant(), parameters, stop=stop))
