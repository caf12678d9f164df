"""Algebraic loops while the components are stepped, against their closed forms, and what is said of unsolvable ones."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest
from algebraic_loops import Blocks, wired
from both_loops import simulate

from cosim.engine import Algorithm, Fmu, PartialResultError, Result, System, explain_timing
from cosim.errors import FmuWarning

pytest.importorskip("rumoca")

SOLVING: tuple[Algorithm, ...] = ("iterated", "adaptive")


@pytest.fixture(scope="module")
def blocks(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Blocks]:
    made = Blocks(tmp_path_factory.mktemp("loops"))
    yield made
    made.close()


def run(system: System, algorithm: Algorithm, **more: float) -> Result:
    return simulate(
        system, stop=1.0, output_interval=0.1, tolerance=1e-6, algorithm=algorithm, coupling_error=False, **more
    )


def driven(block: Fmu, gain: float) -> System:
    """a = gain b + sin t, b = a."""
    return wired({"a": (block, {"k": gain}), "b": (block, {})}, "a.wave b.u", "b.affine a.u")


@pytest.mark.parametrize("algorithm", SOLVING)
@pytest.mark.parametrize(("version", "gain"), [(2, -0.5), (3, 0.5), (3, 3.0), (2, -40.0)])
def test_a_linear_loop_follows_what_drives_it(blocks: Blocks, algorithm: Algorithm, version: int, gain: float) -> None:
    result = run(driven(blocks.plain(version), gain), algorithm)
    expected = np.sin(result.time) / (1.0 - gain)
    assert result.columns["a.wave"] == pytest.approx(expected, rel=0, abs=1e-8)
    assert result.columns["b.affine"] == pytest.approx(expected, rel=0, abs=1e-8)


@pytest.mark.parametrize("algorithm", SOLVING)
def test_a_nonlinear_loop(blocks: Blocks, algorithm: Algorithm) -> None:
    """y = cos(y + sin t), without directional derivatives and dependencies."""
    block = blocks.bare()
    result = run(wired({"a": (block, {}), "b": (block, {})}, "a.cosine b.u", "b.wave a.u"), algorithm)
    y = result.columns["a.cosine"]
    assert y == pytest.approx(np.cos(y + np.sin(result.time)), rel=0, abs=1e-8)
    assert y[0] == pytest.approx(0.73908513321516064, rel=1e-12)


@pytest.mark.parametrize("algorithm", SOLVING)
def test_two_loops_that_share_a_component(blocks: Blocks, algorithm: Algorithm) -> None:
    """a = -2 b + 3 c + sin-driven, with a conversion of units on the way."""
    block = blocks.plain()
    system = wired(
        {"a": (block, {"k": -2.0, "m": 3.0}), "b": (block, {"k": 0.5}), "c": (block, {"k": 1.0, "b": 1.0})},
        *("a.affine b.u", "a.affine c.u 2 1", "b.wave a.u", "c.affine a.v"),
    )
    result = run(system, algorithm)
    # a = -2 (a/2 + sin t) + 3 (2 a + 1 + 1)
    expected = (-2.0 * np.sin(result.time) + 6.0) / (1.0 + 1.0 - 6.0)
    assert result.columns["a.affine"] == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize("algorithm", SOLVING)
def test_a_gain_of_1_has_no_solution(blocks: Blocks, algorithm: Algorithm) -> None:
    with (
        pytest.warns(FmuWarning, match="does not determine its variables"),
        pytest.raises(PartialResultError) as caught,
    ):
        run(driven(blocks.plain(), 1.0), algorithm)
    # of what the adaptive algorithm tries, this is the shortest
    step, taken, given, residual = {
        "iterated": ("0.1", "0.599833417", "0.699726817", "0.0999"),
        "adaptive": ("1e-07", "0.5", "0.5000001", "1e-07"),
    }[algorithm]
    assert str(caught.value) == (
        f"the simulation failed at t = 0 s: in the step to {step} s no values are found that fulfil the algebraic loop "
        f"a.wave -> b.u -> b.affine -> a.u: a.u = {taken} V comes back as {given} V (residual {residual} V); see "
        "whether there is a solution; take shorter steps, or break the loop by a state, a sample or a delay"
    )
    assert caught.value.result.time.tolist() == [0.0]


@pytest.mark.parametrize("algorithm", SOLVING)
def test_a_solution_that_ceases_to_exist(blocks: Blocks, algorithm: Algorithm) -> None:
    """x = x^2 + sin t has one until sin t = 1/4."""
    block = blocks.plain()
    system = wired({"a": (block, {}), "b": (block, {})}, "a.square b.u", "b.wave a.u")
    with pytest.raises(
        PartialResultError, match=r"algebraic loop a\.square -> b\.u -> b\.wave -> a\.u: a\.u = "
    ) as caught:
        run(system, algorithm)
    times = caught.value.result.time
    assert times[-1] == pytest.approx(0.2)  # the last row before asin(1/4) = 0.2527
    x = (1.0 - np.sqrt(1.0 - 4.0 * np.sin(times))) / 2.0
    assert caught.value.result.columns["b.wave"] == pytest.approx(x, abs=1e-7)


def test_algorithms_that_do_not_solve_it_say_so(blocks: Blocks) -> None:
    system = driven(blocks.plain(), -0.5)
    for algorithm in ("gauss-seidel", "extrapolated", "jacobi"):
        with pytest.warns(FmuWarning) as caught:
            run(system, algorithm, **({"step": 0.1} if algorithm == "jacobi" else {}))
        assert str(caught[0].message) == (
            "the algebraic loop a.wave -> b.u -> b.affine -> a.u is not solved while the components are stepped: with "
            f"the algorithm {algorithm} what goes round it arrives a macro step late, and if its gain is above 1 it "
            "grows beyond bounds; choose the algorithm adaptive or iterated"
        )


def test_the_explanation_of_the_timing_lists_them(blocks: Blocks) -> None:
    block = blocks.plain()
    text = explain_timing(driven(block, 0.5), stop=1.0, output_interval=0.1)
    assert "\nAlgebraic loops while components are stepped:\n  a.wave -> b.u -> b.affine -> a.u\n" in text
    open_ = wired({"a": (block, {}), "b": (block, {})}, "a.wave b.u")
    assert "Algebraic loops" not in explain_timing(open_, stop=1.0, output_interval=0.1)


def test_fmus_that_cannot_go_back_say_so(blocks: Blocks) -> None:
    system = driven(blocks.forward(), 0.25)
    with pytest.warns(FmuWarning) as caught:
        result = run(system, "auto")
    assert any(
        "; to solve it would take going back to a state, but a (Block) cannot save its state" in str(warning.message)
        for warning in caught
    )
    assert result.columns["a.wave"][0] == 0.0
    assert math.isfinite(result.columns["a.wave"][-1])
