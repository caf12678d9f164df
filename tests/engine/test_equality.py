"""The native loop and the Python loop give the same bytes: for systems at random, and for the wiper drive."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest
from both_loops import simulate
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from random_systems import systems

from cosim.engine import Fmu, PartialResultError
from cosim.fmu import catalogue
from cosim.scenario import assemble, read

Get = Callable[..., Fmu]


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_systems_at_random(fmu: Get, data: st.DataObject) -> None:
    system = data.draw(systems(fmu))
    stop = data.draw(st.floats(0.01, 0.1))
    interval = data.draw(st.sampled_from([0.001, 0.003, 0.01]) | st.floats(0.001, 0.1))
    with suppress(PartialResultError):  # an algebraic loop, or events without end, are found by both
        simulate(system, stop=stop, output_interval=interval, tolerance=1e-6)


@settings(max_examples=50, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_systems_at_random_with_a_fixed_step(fmu: Get, data: st.DataObject) -> None:
    system = data.draw(systems(fmu))
    step = data.draw(st.sampled_from([0.001, 0.0025, 0.0073]))
    every = data.draw(st.integers(1, 5))
    steps = data.draw(st.integers(5, 60))
    stop, interval = steps * step, every * step
    with suppress(PartialResultError):
        simulate(system, stop=stop, output_interval=interval, tolerance=1e-6, algorithm="jacobi", step=step)


@pytest.mark.parametrize("name", ["linkage_20ms", "linkage_disturbed", "rig_20ms"])
def test_the_wiper_drive(name: str) -> None:
    scenario = read(Path(__file__).parents[2] / "scenarios" / f"{name}.csv")
    system = assemble(scenario, catalogue.ensure)
    simulate(system, stop=5.0, output_interval=scenario.output_interval, tolerance=scenario.tolerance)
