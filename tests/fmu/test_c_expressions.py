"""Expressions printed as C: the same bits as CasADi computes, whatever the parentheses, and the names of the model."""

from __future__ import annotations

import ctypes
import subprocess
from pathlib import Path

import casadi as ca
import numpy as np

from cosim.fmu.c_expressions import print_function
from cosim.fmu.c_text import WIDTH, function
from cosim.fmu.toolchain import RUNTIME, compiler

NAMES = ["a", "b", "in.side", "t1"]


def random_expression(random: np.random.Generator, leaves: list[ca.SX], depth: int) -> ca.SX:
    """A tree with every kind of operator, biased to those whose order matters."""
    if depth == 0 or random.random() < 0.1:
        return leaves[random.integers(len(leaves))] if random.random() < 0.8 else ca.SX(float(random.integers(-3, 4)))
    x, y, z = (random_expression(random, leaves, depth - 1) for _ in range(3))
    choices = [
        lambda: x + y, lambda: x - y, lambda: x * y, lambda: x / (2.0 + y * y), lambda: -x, lambda: x - (y - z),
        lambda: x - (y + z), lambda: x * (y / (1.5 + ca.fabs(z))), lambda: ca.if_else(x < y, y, z), lambda: 2 * x,
        lambda: 1 / (1.0 + x * x), lambda: (x - y) ** 2, lambda: ca.tanh(x), lambda: ca.sign(x) / 2,
        lambda: ca.if_else(ca.logic_or(ca.logic_and(x < y, y <= z), ca.logic_not(x > 0)), x, y),
        lambda: (x < y) / 2, lambda: ca.fmin(x, y) - ca.fmax(y, z), lambda: ca.floor(x) - ca.atan2(y, 2 + x * x),
    ]  # fmt: skip
    return choices[random.integers(len(choices))]()


def test_random_expressions_have_the_bits_that_casadi_computes(tmp_path: Path) -> None:
    random = np.random.default_rng(11)
    leaves = [ca.SX.sym(name) for name in NAMES]
    values = ca.vertcat(*(random_expression(random, leaves, 5) for _ in range(120)))
    named = [ca.cse(values)[k] for k in range(0, 120, 7)]
    expected = ca.Function("f", [ca.vertcat(*leaves)], [values])
    printed = ca.Function("f", [ca.vertcat(*leaves)], [ca.cse(values), ca.vertcat(*named)])
    lines = print_function(printed, ["x"], ["y"], [NAMES], [(f"named.{k}", "a remark") for k in range(len(named))])
    code = ["#include <math.h>", *function("void f(const double *x, double *y)", lines)]
    assert max(len(line) for line in code) <= WIDTH + 20
    source, library = tmp_path / "f.c", tmp_path / "f.so"
    source.write_text("\n".join(code), encoding="utf-8")
    flags = ["-std=c11", "-O2", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-ffp-contract=off", "-fPIC", "-shared"]
    subprocess.run([*compiler(), *flags, "-I", str(RUNTIME), str(source), "-o", str(library), "-lm"], check=True)
    compiled = ctypes.CDLL(str(library)).f
    for point in random.normal(size=(50, len(leaves))) * 2.0:
        found = (ctypes.c_double * 120)()
        compiled((ctypes.c_double * len(leaves))(*point), found)
        # tanh and atan2 of two C libraries may differ in the last place; everything else is exact
        assert np.allclose(np.array(found), np.array(expected(point)).ravel(), rtol=1e-12, atol=1e-13, equal_nan=True)


def test_values_get_the_names_of_the_model_where_they_are_needed() -> None:
    a, b = ca.SX.sym("a"), ca.SX.sym("b")
    torque, unused = a * b + 1.0, ca.sin(b)
    power = torque * a
    printed = ca.Function("f", [ca.vertcat(a, b)], [power - b, ca.vertcat(torque, power, unused)])
    named = [("load.tau", "load.tau = a * b + 1"), ("load.P", ""), ("load.x", "")]
    assert print_function(printed, ["v"], ["f"], [["a", "b"]], named) == [
        "const double a = v[0];",
        "const double b = v[1];",
        "const double load_tau = a * b + 1.0; /* load.tau = a * b + 1 */",
        "const double load_P = load_tau * a;",
        "f[0] = load_P - b;",
    ]
