"""Controllers that other tools have exported are asked for the delay inside them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from both_loops import simulate
from fmu_builder import MODELS, build

from cosim.engine import Component, Connection, Fmu, System, explain_timing
from cosim.engine._probe import probe

Get = Callable[..., Fmu]

START = "probed: it computes at the start of its steps; "
END = (
    "probed: it computes at the end of its steps, so that its own time is 0.1 s ahead of the instants at which it is "
    "sampled; "
)
SAME = "its outputs answer its inputs with the same sample: a delay of 0 s inside it"
NEXT = "its outputs answer its inputs after 1 sample: a delay of 0.1 s inside it"


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize(
    ("parameters", "expected"),
    [
        ({"kind": 1}, START + SAME),
        ({"kind": 2}, END + SAME),
        ({"kind": 3}, START + NEXT),
        ({"kind": 0}, "probed: no answer to its inputs was seen within 50 samples"),
        ({"kind": 2, "deaf": 3.0}, END + SAME),
    ],
)
def test_what_a_controller_is_found_to_do(
    fmu: Get, version: int, parameters: dict[str, float | int | bool | str], expected: str
) -> None:
    assert probe(Component("c", fmu("foreign", version), parameters), 0.1) == expected


def test_our_own_sampler_computes_at_the_start(fmu: Get) -> None:
    assert probe(Component("c", fmu("sampler", 2)), 0.02) == START + SAME


@pytest.mark.parametrize(("kind", "delay"), [(1, 0), (2, 0), (3, 1)])
def test_the_closed_loop_has_the_delay_that_was_found(fmu: Get, kind: int, delay: int) -> None:
    """x' = -x(t_k - delay T): x falls by T times an earlier sample in each period."""
    system = System(
        [Component("plant", fmu("integrator", 2), {"x0": 1.0}), Component("c", fmu("foreign", 2), {"kind": kind})],
        [Connection(("plant", "x"), ("c", "u")), Connection(("c", "y"), ("plant", "u"))],
    )
    x = simulate(system, stop=2.0, output_interval=0.1, tolerance=1e-6).columns["plant.x"]
    expected = [1.0]
    for k in range(20):
        expected.append(expected[-1] - 0.1 * (expected[k - delay] if k >= delay else 0.0))
    np.testing.assert_allclose(x, expected, rtol=1e-12)
    text = explain_timing(system, stop=2.0, output_interval=0.1)
    lines = text.splitlines()
    sampled = lines.index("  c      sampled: samples every 0.1 s, the first at 0 s")
    assert lines[sampled + 1] == f"         {(END if kind == 2 else START) + (NEXT if delay else SAME)}"


def test_steps_of_one_length_only(tmp_path: Path) -> None:
    path = build(MODELS["foreign"], 2, tmp_path, variable_steps=False)
    with Fmu.read(path) as fixed:
        assert probe(Component("c", fixed, {"kind": 3}), 0.1) == (
            f"probed: {NEXT}; whether it computes at the start or at the end of its steps cannot be seen"
        )
