"""What a user reads when a simulation cannot go on, or cannot begin: when, where in the model, why, what to do."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path

import fmpy
import pytest
from scipy.integrate import quad

from cosim.fmu import export

pytest.importorskip("rumoca")

Fail = Callable[..., str]


@pytest.fixture(scope="module")
def fail(tmp_path_factory: pytest.TempPathFactory) -> Fail:
    """Run a model that must fail, and return the one message that it logs."""
    built: dict[str, Path] = {}

    def fail(text: str, *, stop: float = 3.0, tolerance: float = 1e-6, **start: float) -> str:
        if text not in built:
            folder = tmp_path_factory.mktemp("M")
            (folder / "M.mo").write_text(f'model M "Model"\n{text}\nend M;\n')
            built[text] = export(folder / "M.mo", "M", folder)
        logged: list[str] = []
        with pytest.raises(fmpy.fmi1.FMICallException):
            fmpy.simulate_fmu(
                str(built[text]),
                stop_time=stop,
                output_interval=stop,
                relative_tolerance=tolerance,
                start_values=start,
                logger=lambda *arguments: logged.append(arguments[-1].decode()),
            )
        assert len(logged) == 1, logged
        return logged[0]

    return fail


def time_of(message: str) -> float:
    found = re.search(r"t = (\S+) s", message)
    assert found is not None, message
    return float(found[1])


PENDULUM = """  Real x(start=0.7*sin(2){0});
  Real y(start=-0.7*cos(2){1});
  Real vx({2});
  Real vy({3});
  Real F;
initial equation
  x = 0.7*sin(2);
  vx = 0;
equation
  vx = der(x);
  vy = der(y);
  der(vx) = -F*x;
  der(vy) = -F*y - 9.81;
  x^2 + y^2 = 0.7^2;"""


@pytest.mark.parametrize("state", ["x", "y"])
def test_a_choice_of_states_that_becomes_singular_is_named_with_what_would_do(fail: Fail, state: str) -> None:
    prefer = "stateSelect=StateSelect.prefer"
    other = "y" if state == "x" else "x"
    choice = (f", {prefer}", "", prefer, "") if state == "x" else ("", f", {prefer}", "", prefer)
    message = fail(PENDULUM.format(*choice))
    # the time of the fall from 2 rad, by energy, with cos(phi) - cos(2) = s^2
    until = math.pi / 2 if state == "x" else 0
    fall = quad(lambda s: 2 / math.sqrt(1 - (s**2 + math.cos(2)) ** 2), 0, math.sqrt(math.cos(until) - math.cos(2)))[0]
    assert time_of(message) == pytest.approx(fall / math.sqrt(2 * 9.81 / 0.7), abs=0.02)
    assert re.sub(r"^(At|Shortly before) t = \S+ s ", "", message) == (
        f"the chosen states do not determine the other variables: {other} and v{other} cannot be computed from {state}"
        f" and v{state} by x ^ 2 + y ^ 2 = 0.7 ^ 2 (M.mo:15). There {other} and v{other} would do as states: give them"
        " stateSelect=StateSelect.prefer. If that fails elsewhere, or this is a dead centre, no choice holds"
        " everywhere: describe the motion by other variables, such as an angle, and prefer those."
    )


def test_a_point_that_the_solver_jumps_over_is_not_passed_in_silence(fail: Fail) -> None:
    message = fail(
        """  Real x(start=0, fixed=true);
  Real y(start=0, fixed=true);
  Real vx(start=1, fixed=true, stateSelect=StateSelect.always);
  Real vy;
  Real phi(start=0, fixed=true);
  Real F;
equation
  der(x) = vx;
  der(y) = vy;
  der(phi) = 1;
  -vx*sin(phi) + vy*cos(phi) = 0;
  der(vx) = -F*sin(phi);
  der(vy) = F*cos(phi);"""
    )
    # the skate points across at a quarter turn
    assert time_of(message) == pytest.approx(math.pi / 2, abs=0.02)
    assert (
        "y and vy cannot be computed from x and vx by -vx * sin(phi) + vy * cos(phi) = 0 (M.mo:12). There y" in message
    )


def test_chattering_is_reported_with_condition_and_time(fail: Fail) -> None:
    message = fail("  Real x(start=1, fixed=true);\nequation\n  der(x) = if x > 0 then -1 else 1;")
    assert message == (
        "At t = 1 s the model chatters: 1000 state events within 1e-05 s, the last one in the relation 'x > 0'. Smooth"
        " the discontinuity or give it a hysteresis."
    )


@pytest.mark.parametrize(
    ("equations", "name", "sliding"),
    [
        ("  Real v(start=0);\nequation\n  der(x) = -sign(x) + 0.5*sin(time);\n  der(v) = x;", "x", 1.3),
        ("  Real v(start=0, fixed=true);\nequation\n  der(x) = v;\n  der(v) = -5*sign(v + x);", "v", 0.17),
    ],
)
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
def test_sliding_along_a_discontinuity_without_events_does_not_hang(
    fail: Fail, equations: str, name: str, sliding: float, tolerance: float
) -> None:
    message = fail(f"  Real x(start=1, fixed=true);\n{equations}", stop=1000, tolerance=tolerance)
    assert sliding < time_of(message) < sliding + 2
    assert re.sub(r"\b[0-9][0-9.e-]* s\b", "# s", message) == (
        "At t = # s the solver makes no progress: its last 10000 steps have covered # s, the largest error is in"
        f" {name}. Check for a discontinuity that changes sides again and again without an event, as in sign(), abs(),"
        " noEvent() and smooth(): smooth it, or write it as an if-expression with a hysteresis."
    )


@pytest.mark.parametrize("restitution", [0.2, 0.7, 0.9])
def test_bounces_without_end_are_not_followed_through_the_floor(fail: Fail, restitution: float) -> None:
    message = fail(
        """  Real h(start=1, fixed=true);
  Real v(start=0, fixed=true);
  parameter Real restitution = 0;
equation
  der(h) = v;
  der(v) = -9.81;
  when h < 0 then
    reinit(v, -restitution*pre(v));
  end when;""",
        stop=100,
        restitution=restitution,
    )
    # the sum of the geometric series
    end = math.sqrt(2 / 9.81) * (1 + 2 * restitution / (1 - restitution))
    assert time_of(message) == pytest.approx(end, abs=1e-6)
    assert re.sub(r"\b[0-9][0-9.e-]* s\b", "# s", message) == (
        "At t = # s the events of 'h < 0' accumulate: each follows the one before after a shorter time, the last after"
        " # s, so that there is no time after them all. Let the model come to rest before, for instance below a speed,"
        " or let a spring and damper do what reinit() does."
    )


def test_initial_equations_without_solution_are_named_with_their_residuals(fail: Fail) -> None:
    message = fail("  Real x(start=4, fixed=true);\n  Real z(start=2);\nequation\n  der(x) = z;\n  z^2 + x = 0;")
    assert re.sub("residual [0-9.]+", "residual #", message) == (
        "The initial equations do not determine z: near the start values these depend on each other, or have no"
        " solution: z ^ 2 + x = 0 (M.mo:6) (residual #); x = 4 (fixed start) (M.mo:2). Give other start values, or one"
        " of the unknowns a fixed start value in place of one of these equations."
    )


def test_unknowns_that_the_initial_equations_leave_open_are_named(fail: Fail) -> None:
    message = fail(
        """  Real x(start=1);
  Real v(start=0);
  Real w(start=3, fixed=true);
initial equation
  x + v = 1;
  2*x + 2*v = 2;
equation
  der(x) = v;
  der(v) = -w;
  der(w) = -w;"""
    )
    assert message == (
        "The initial equations do not determine x, v: near the start values these depend on each other, or have no"
        " solution: x + v = 1 (M.mo:6); 2 * x + 2 * v = 2 (M.mo:7). Give other start values, or one of the unknowns a"
        " fixed start value in place of one of these equations."
    )


def test_the_largest_residual_comes_first(fail: Fail) -> None:
    message = fail("  Real x(start=3);\n  Real y(start=2);\nequation\n  x^2 + y^2 = -1 - time;\n  x - y/3 = 1;")
    assert re.sub("residual [0-9.e-]+", "residual #", message) == (
        "The initial equations cannot be solved; the unknown concerned is x. The equations farthest from their"
        " solution: x ^ 2 + y ^ 2 = -1 - time (M.mo:5) (residual #). Check the start values and parameters in them."
    )
