"""FMI 1.0 Co-Simulation FMUs as components."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from both_loops import simulate
from fmu_builder import build_first

from cosim.engine import Channel, Component, Connection, Fmu, PartialResultError, System


@pytest.fixture(scope="module")
def first(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Fmu]:
    with Fmu.read(build_first(tmp_path_factory.mktemp("first"))) as opened:
        yield opened


def test_it_takes_part_in_a_system(first: Fmu) -> None:
    """Two integrators in a row, the first driven by a step: a ramp, and its integral by exchanges at each row."""
    system = System(
        [Component("a", first, {"x0": -0.5, "name": "the first"}), Component("b", first, {"gain": 2.0})],
        [Connection(("a", "x"), ("b", "u"))],
        [Channel(("a", "u"), [0.0, 0.5, 0.5], [0.0, 0.0, 3.0])],
    )
    result = simulate(system, stop=1.0, output_interval=0.01, tolerance=1e-6)
    ramp = -0.5 + 3.0 * np.maximum(result.time - 0.5, 0.0)
    assert result.columns["a.x"] == pytest.approx(ramp, abs=1e-12)
    assert result.columns["a.positive"].tolist() == [int(x > 1e-12) for x in ramp]
    assert result.columns["a.steps"].tolist() == list(range(101))
    assert result.units["a.x"] == "m"


def test_inputs_are_set_before_it_is_initialised(first: Fmu) -> None:
    system = System([Component("a", first)], channels=[Channel(("a", "u"), [0.0], [2.5])])
    assert simulate(system, stop=0.1, output_interval=0.1, tolerance=1e-6).columns["a.begun"].tolist() == [2.5, 2.5]


def test_what_it_says_is_in_the_message(first: Fmu) -> None:
    system = System([Component("a", first, {"t_wrong": 0.5, "name": "slave"})])
    with pytest.raises(PartialResultError) as caught:
        simulate(system, stop=1.0, output_interval=0.1, tolerance=1e-6)
    assert "at t = 0.5 s: a (first): first_fmiDoStep returned Error" in str(caught.value)
    assert "the FMU says: slave cannot go beyond 0.5 s" in str(caught.value)


def test_negated_aliases_are_left_out_and_capabilities_read(first: Fmu) -> None:
    assert first.left_out == {"minus_x": "the negative of another variable"}
    assert first.capabilities["canHandleVariableCommunicationStepSize"] is True
    assert first.variables["x0"].causality == "parameter"
