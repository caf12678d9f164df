"""The runtime's sines and its small dense matrices, against higher precision and numpy."""

from __future__ import annotations

import ctypes
import math
import subprocess
from collections.abc import Callable

import numpy as np
import pytest
from runtime_harness import RUNTIME, compiler

SOURCE = """
#include "elementary.h"
#include "lu.h"
void sines(int n, const double *x, double *s, double *c)
{
    for (int i = 0; i < n; i++) s[i] = model_sin(x[i]), c[i] = model_cos(x[i]);
}
int solve(int n, double *A, const double *b, double *x)
{
    int pivots[20];
    int singular = lu_prepare(n, A, pivots);
    if (!singular) lu_apply(n, A, pivots, b, x);
    return singular;
}
"""


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    folder = tmp_path_factory.mktemp("numerics")
    (folder / "numerics.c").write_text(SOURCE)
    output = folder / "numerics.so"
    flags = ["-std=c11", "-O2", "-fPIC", "-shared", "-ffp-contract=off", "-I", str(RUNTIME), "-o", str(output)]
    subprocess.run([*compiler(), *flags, str(folder / "numerics.c"), "-lm"], check=True)
    return ctypes.CDLL(str(output))


def doubles(values: np.ndarray) -> ctypes.Array[ctypes.c_double]:
    return (ctypes.c_double * values.size)(*values.ravel(order="F"))


def sines(library: ctypes.CDLL, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    s, c = doubles(np.zeros(x.size)), doubles(np.zeros(x.size))
    library.sines(x.size, doubles(x), s, c)
    return np.array(s), np.array(c)


@pytest.mark.parametrize("largest", [1.0, 100.0, 1e5])
def test_sine_and_cosine_are_right_to_three_units_in_the_last_place(library: ctypes.CDLL, largest: float) -> None:
    x = np.random.default_rng(1).uniform(-largest, largest, 200_000)
    quarter_turns = np.arange(-600, 600) * (math.pi / 2)
    x = np.concatenate([x, quarter_turns[abs(quarter_turns) <= largest]])
    # libm's own error is about half a unit, so its own value serves as the reference
    references: tuple[Callable[[float], float], ...] = (math.sin, math.cos)
    for values, reference in zip(sines(library, x), references, strict=True):
        exact = np.array([reference(value) for value in x])
        assert (np.abs(values - exact) / np.spacing(np.abs(exact))).max() <= 3.0


def test_sines_of_what_lies_outside(library: ctypes.CDLL) -> None:
    x = np.array([0.0, -0.0, 1e5, -3e7, 1e300, math.inf, -math.inf, math.nan])
    s, c = sines(library, x)
    assert s[:2].tolist() == [0.0, 0.0]
    assert s[2:5].tolist() == [math.sin(value) for value in x[2:5]]
    assert c[:5].tolist() == [math.cos(value) for value in x[:5]]
    assert np.isnan(s[5:]).all()
    assert np.isnan(c[5:]).all()


@pytest.mark.parametrize("n", [1, 2, 3, 5, 8, 9, 15])
def test_linear_systems_are_solved_whatever_the_order_of_their_rows(library: ctypes.CDLL, n: int) -> None:
    """Small ones by their inverse, larger ones by their factors."""
    random = np.random.default_rng(n)
    for _ in range(50):
        matrix = random.normal(size=(n, n)) * (random.random((n, n)) < 0.5) + np.eye(n)[random.permutation(n)] * 3.0
        if np.linalg.cond(matrix) > 1e6:
            continue
        right, found = random.normal(size=n), doubles(np.zeros(n))
        assert library.solve(n, doubles(matrix), doubles(right), found) == 0
        assert np.allclose(np.array(found), np.linalg.solve(matrix, right), rtol=1e-8, atol=1e-9)


@pytest.mark.parametrize("n", [2, 5, 12])
def test_a_singular_matrix_is_said_to_be_one(library: ctypes.CDLL, n: int) -> None:
    matrix = np.eye(n)
    matrix[:, n - 1] = matrix[:, 0]
    assert library.solve(n, doubles(matrix), doubles(np.ones(n)), doubles(np.zeros(n))) == n
    matrix[0, 0] = math.nan
    assert library.solve(n, doubles(matrix), doubles(np.ones(n)), doubles(np.zeros(n))) > 0
