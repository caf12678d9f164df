"""Least squares with bounds: against SciPy's on problems with a known minimum, and where there is none to be found."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from cosim.calibration._descent import bounded_step, descend

Array = NDArray[np.float64]


@dataclass(frozen=True)
class At:
    cost: float
    gradient: Array
    hessian: Array


def rosenbrock(x: Array, _near: At | None) -> At:
    r = np.array([10.0 * (x[1] - x[0] ** 2), 1.0 - x[0]])
    J = np.array([[-20.0 * x[0], 10.0], [-1.0, 0.0]])
    return At(0.5 * float(r @ r), J.T @ r, J.T @ J)


def test_the_curved_valley_is_followed_to_its_end_and_to_a_bound() -> None:
    start = np.array([-1.2, 1.0])
    wide = np.full(2, np.inf)
    found = descend(rosenbrock, start, rosenbrock(start, None), (-wide, wide), 100, 1e-12, lambda _step, _at: None)
    assert found.limit is None
    assert found.unknowns == pytest.approx([1.0, 1.0], abs=1e-5)
    # with x <= 0.5 the minimum is where y = x^2
    bounds = np.array([-2.0, -2.0]), np.array([0.5, 2.0])
    found = descend(rosenbrock, start, rosenbrock(start, None), bounds, 100, 1e-12, lambda _step, _at: None)
    assert found.limit is None
    # it ends where a step promises less than 1e-10, which is 50 (y - x^2)^2
    assert found.unknowns == pytest.approx([0.5, 0.25], abs=1.5e-6)


def test_places_that_are_none_are_gone_round_and_steps_are_counted() -> None:
    start = np.array([-1.2, 1.0])
    wide = np.full(2, np.inf)
    told: list[int] = []
    found = descend(
        lambda x, near: None if x[0] > 0.9 else rosenbrock(x, near),
        start, rosenbrock(start, None), (-wide, wide), 1000, 1e-12, lambda step, _at: told.append(step),
    )  # fmt: skip
    assert found.limit == "the steps became too small"
    assert found.unknowns[0] == pytest.approx(0.9, abs=1e-3)
    assert told == sorted(told)
    few = descend(rosenbrock, start, rosenbrock(start, None), (-wide, wide), 3, 1e-12, lambda _step, _at: None)
    assert (few.steps, few.limit) == (3, "it took more iterations than allowed")


def test_a_bounded_step_is_the_minimum_of_the_quadratic_model() -> None:
    rng = np.random.default_rng(3)
    for _ in range(100):
        J, r = rng.standard_normal((8, 4)), rng.standard_normal(8)
        lowest, highest = -rng.uniform(0.0, 0.5, 4), rng.uniform(0.0, 0.5, 4)
        lowest[rng.uniform(size=4) < 0.2] = -1e-12
        step = bounded_step(J.T @ J, J.T @ r, lowest, highest)
        expected = lsq_linear(J, -r, (lowest, highest), tol=1e-14).x
        assert step == pytest.approx(expected, abs=1e-6)
