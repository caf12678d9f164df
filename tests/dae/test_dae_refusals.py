"""What a user reads about equations that do not fit the variables: the smallest part, with text, file and line."""

from __future__ import annotations

from pathlib import Path

import pytest

from cosim.dae.structure import deficient
from cosim.errors import ModelError
from cosim.fmu import compile_model

pytest.importorskip("rumoca")


def refusal(tmp_path: Path, body: str) -> str:
    file = tmp_path / "M.mo"
    file.write_text(f'model M "Model"\n{body}\nend M;\n')
    with pytest.raises(ModelError) as caught:
        compile_model(file, "M")
    return str(caught.value).removeprefix(f"{file}:")


def test_the_smallest_part_with_too_many_equations_is_named(tmp_path: Path) -> None:
    body = """  Real x(start=1); Real a; Real b; Real c; Real d;
equation
  der(x) = a - x;
  a + b = 1;
  a - b = 2;
  a*b = 3;
  c + d + x = b;"""
    assert refusal(tmp_path, body) == (
        "5:3: M is structurally singular: for c, d there is only 1 equation: c + d + x = b (M.mo:8); for a, b alone"
        " there are 3 equations: a + b = 1 (M.mo:5), a - b = 2 (M.mo:6), a * b = 3 (M.mo:7)"
    )


def test_a_variable_that_is_in_no_equation_is_named(tmp_path: Path) -> None:
    body = "  Real a; Real b; Real y;\nequation\n  a + b = 1;\n  a - b = 2;"
    assert refusal(tmp_path, body) == "2:19: M has 2 equations for 3 unknowns: there is no equation for y"


def test_an_equation_of_what_is_known_is_one_too_many(tmp_path: Path) -> None:
    body = "  parameter Real p = 1; Real a;\nequation\n  a = 2*p;\n  p = sin(time);"
    assert refusal(tmp_path, body) == (
        "5:3: M has 2 equations for 1 unknown: there is nothing left to determine in p = sin(time) (M.mo:5)"
    )


def test_of_several_defects_the_smallest_is_shown() -> None:
    # rows 0 to 2 have two columns, rows 3 and 4 one; columns 3 and 4 have one row, column 5 none
    assert deficient([[0, 1], [0, 1], [0, 1], [2], [2], [3, 4]], 6) == (([3, 4], [2]), ([], [5]))


def test_constraints_that_repeat_each_other_are_named_without_the_others(tmp_path: Path) -> None:
    body = """  Real x(start=0.6); Real y(start=-0.8); Real z; Real F; Real G; Real H;
equation
  der(der_x) = -F*x + G;
  der(der_y) = -F*y + G;
  der(z) = H;
  der_x = der(x);
  der_y = der(y);
  x^2 + y^2 = 1;
  z = x + y;
  2*x^2 + 2*y^2 = 2;
  Real der_x; Real der_y;"""
    head, tail = body.rsplit("\n", 1)
    assert refusal(tmp_path, f"{tail}\n{head}") == (
        "10:3: M: these constraints contradict or repeat each other at the start values, so that no states can be"
        " chosen: x ^ 2 + y ^ 2 = 1 (M.mo:10), 2 * x ^ 2 + 2 * y ^ 2 = 2 (M.mo:12)"
    )


def test_initial_conditions_that_leave_nothing_to_each_other_are_named(tmp_path: Path) -> None:
    body = """  Real x(start=1, fixed=true); Real y; Real z(start=0, fixed=true);
initial equation
  y = 3;
  x + y = 4;
equation
  der(x) = -x;
  der(y) = x;
  der(z) = y;"""
    assert refusal(tmp_path, body) == (
        "5:3: M: one initial condition too many: these 3 determine only y, x: x = 1 (fixed start) (M.mo:2), y = 3"
        " (M.mo:4), x + y = 4 (M.mo:5). Take fixed=true or an initial equation away"
    )


def test_an_initial_condition_that_the_equations_decide_is_named(tmp_path: Path) -> None:
    body = (
        "  Real x(start=1, fixed=true); Real v;\ninitial equation\n  v = 2;\nequation\n  der(x) = v;\n  v = 3 + time;"
    )
    assert refusal(tmp_path, body) == (
        "4:3: M: one initial condition too many: the equations decide v = 2 (M.mo:4). Take fixed=true or an initial"
        " equation away"
    )


def test_equations_that_say_one_thing_twice_are_named(tmp_path: Path) -> None:
    body = "  Real x; Real y; Real z;\nequation\n  x - y = z;\n  x + y + z = 1 + time;\n  2*y + 2*z = 2*x;"
    assert refusal(tmp_path, body) == (
        "4:3: M: these equations say one thing twice, so that they leave something open (in a circuit, is there a"
        " ground?): x - y = z (M.mo:4), 2 * y + 2 * z = 2 * x (M.mo:6)"
    )


def test_equations_that_depend_on_each_other_whatever_the_numbers_are_named(tmp_path: Path) -> None:
    body = "  Real x; Real y; Real w;\n  parameter Real a = 2;\nequation\n  a*x + a*y = time;\n  x + y = 3;\n  w = x;"
    assert refusal(tmp_path, body) == (
        "5:3: M: these equations depend on each other, so that they do not determine x, y: a * x + a * y = time"
        " (M.mo:5), x + y = 3 (M.mo:6)"
    )
