"""One Newton sweep: exact for linear systems, quadratically convergent for others, refused where blocks are large."""

from __future__ import annotations

import itertools

import casadi as ca
import numpy as np

from cosim.dae.sweep import newton_sweep


def test_a_linear_system_in_block_triangular_form_is_solved_at_once() -> None:
    z = [ca.SX.sym(f"z{k}") for k in range(6)]
    random = np.random.default_rng(7)
    matrix = random.normal(size=(6, 6)) * np.array(
        # blocks of 1, 2 and 3, hidden by the order of equations and unknowns
        [[1, 1, 1, 1, 1, 1], [0, 0, 0, 1, 0, 0], [1, 0, 0, 1, 0, 1],
         [1, 1, 1, 1, 1, 1], [1, 0, 0, 1, 0, 1], [1, 1, 1, 1, 1, 1]]
    )  # fmt: skip
    right = random.normal(size=6)
    swept = newton_sweep(ca.DM(matrix) @ ca.vertcat(*z) - ca.DM(right), z)
    assert swept is not None
    values = ca.Function("sweep", [ca.vertcat(*z)], [swept])(random.normal(size=6))
    assert np.allclose(np.array(values).ravel(), np.linalg.solve(matrix, right), rtol=1e-10, atol=1e-12)


def test_convergence_is_quadratic_across_blocks() -> None:
    a, b, c = (ca.SX.sym(name) for name in "abc")
    residuals = ca.vertcat(a**3 + a - 2.0 - b, b + ca.sin(b) - 0.5 * a, c * ca.exp(c) - a * b)
    swept = newton_sweep(residuals, [a, b, c])
    sweep = ca.Function("sweep", [ca.vertcat(a, b, c)], [swept])
    points = [ca.DM([1.2, 0.4, 0.3])]
    for _ in range(8):
        points.append(sweep(points[-1]))
    errors = [float(ca.norm_inf(point - points[-1])) for point in points[:5]]
    for before, after in itertools.pairwise(errors):
        assert after < 2.0 * before**2 + 1e-15


def test_large_blocks_are_left_to_the_runtime() -> None:
    z = [ca.SX.sym(f"z{k}") for k in range(4)]
    total = sum(z, ca.SX(0.0))
    assert newton_sweep(ca.vertcat(*(zk**3 + total for zk in z)), z) is None
