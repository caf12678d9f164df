"""The solver for x = g(x), by itself."""

from __future__ import annotations

import numpy as np
import pytest

from cosim.engine.algebra._newton import Matrix, Scale, Solution, Vector, iterate, solve


def run(g, slope, start: list[float], enough: float = 1e-9) -> tuple[Solution, int]:  # noqa: ANN001
    """Return the solution and the number of evaluations of g."""
    last: list[Vector] = []

    def counted(x: Vector) -> Vector:
        last.append(x.copy())
        return np.asarray(g(x))

    x0 = np.array(start)
    with np.errstate(all="ignore"):
        found = solve(counted, lambda: np.asarray(slope(last[-1])), x0, Scale(np.ones_like(x0)), enough)
    return found, len(last)


@pytest.mark.parametrize("unit", [1e-12, 1.0, 1e12])
def test_the_unit_of_an_unknown_does_not_matter(unit: float) -> None:
    """Two unknowns of which one is given in another unit: the same steps, to rounding."""

    def g(x: Vector) -> Vector:
        return np.array([np.cos(x[1] / unit), unit * (0.5 * x[0] ** 2 - 2.0 * x[1] / unit)])

    def slope(x: Vector) -> Matrix:
        return np.array([[0.0, -np.sin(x[1] / unit) / unit], [unit * x[0], -2.0]])

    found, evaluations = run(g, slope, [3.0, 3.0 * unit])
    assert found.solved
    a, b = found.x
    assert a == pytest.approx(np.cos(b / unit), rel=1e-12)
    assert 3.0 * b / unit == pytest.approx(0.5 * a**2, rel=1e-12)
    assert evaluations == 8


def test_damping_keeps_to_where_g_is_defined() -> None:
    """x = 0.01 sqrt(x) + log(x) + 3: a full step from 0.3 leads to negative x."""
    found, _ = run(
        lambda x: 0.01 * np.sqrt(x) + np.log(x) + 3.0, lambda x: np.diag(0.005 / np.sqrt(x) + 1.0 / x), [0.9]
    )
    assert found.solved
    assert found.x == pytest.approx(0.01 * np.sqrt(found.x) + np.log(found.x) + 3.0, rel=1e-12)


def test_where_two_unknowns_are_determined_by_their_sum_only() -> None:
    """The smallest change of the start values that fulfils x + y = 1."""
    found, _ = run(lambda x: np.array([x[0], 1.0 - x[0]]), lambda x: np.array([[1.0, 0.0], [-1.0, 0.0]]), [1.0, 1.0])
    assert found.solved
    assert found.free == 1
    assert found.x == pytest.approx([0.5, 0.5], rel=1e-12)


def test_noise_ends_the_iteration_within_what_is_enough() -> None:
    random = np.random.default_rng(1)
    found, _ = run(lambda x: 3.0 * x - 2.0 + 1e-11 * random.normal(size=1), lambda x: np.array([[3.0]]), [5.0])
    assert found.solved
    assert found.x == pytest.approx([1.0], rel=1e-9)
    found, _ = run(lambda x: 3.0 * x - 2.0 + 1e-5 * random.normal(size=1), lambda x: np.array([[3.0]]), [5.0])
    assert not found.solved


def test_repeated_evaluation_finds_what_has_no_slope() -> None:
    found = iterate(lambda x: np.floor(0.5 * x) + 3.0, np.array([100.0]), Scale(np.ones(1)), 50)
    assert found.solved
    assert found.x == np.floor(0.5 * found.x) + 3.0
