"""Macro steps that a component does not finish, or that lead astray: the adaptive algorithm takes shorter ones."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from both_loops import simulate

from cosim.engine import Component, Connection, Fmu, PartialResultError, Result, System
from cosim.engine import simulate as simulate_once
from cosim.engine.coupling import _adaptive
from cosim.errors import FmuWarning

Get = Callable[..., Fmu]
LONG = 0.013
"""A step [s] that goes wrong."""


def circle(fmu: Fmu, **parameters: float | str) -> System:
    """x' = y, y' = -x, in a component each; these also tell each other their times."""
    return System(
        [Component("x", fmu, {"x0": 1.0, **parameters}), Component("y", fmu, dict(parameters))],
        [
            *(Connection(("y", "x"), ("x", "u")), Connection(("x", "x"), ("y", "u"), factor=-1.0)),
            *(Connection(("y", "said"), ("x", "heard")), Connection(("x", "said"), ("y", "heard"))),
        ],
    )


def run(system: System, tolerance: float = 1e-4) -> Result:
    return simulate(system, stop=1.0, output_interval=0.1, tolerance=tolerance, coupling_error=False)


def counted(result: Result, what: str) -> int:
    algorithm = result.statistics["algorithm"]
    assert isinstance(algorithm, dict)
    return int(algorithm[what])


WRONG = ["not_a_number", "error", "discard", "terminate", "early", "run_away"]


@pytest.mark.parametrize(("fmi", "wrong"), [(2, w) for w in WRONG if w != "early"] + [(3, w) for w in WRONG])
def test_a_step_that_goes_wrong_is_tried_again_shorter(saving: Get, wrong: str, fmi: int) -> None:
    result = run(circle(saving("picky", fmi), wrong=wrong, longest=LONG))
    np.testing.assert_allclose(result.columns["x.x"], np.cos(result.time), atol=1e-4)
    np.testing.assert_allclose(result.columns["y.x"], -np.sin(result.time), atol=1e-4)
    assert counted(result, "rejected") > 0
    assert counted(result, "forced") == 0


def test_a_step_that_runs_away_does_not_loosen_the_tolerance(saving: Get) -> None:
    """What it has led to is no magnitude of the signals."""
    result = run(circle(saving("picky"), wrong="run_away", longest=LONG), tolerance=1e-8)
    np.testing.assert_allclose(result.columns["x.x"], np.cos(result.time), rtol=0.0, atol=1e-8)


def test_texts_go_back_with_the_step(saving: Get) -> None:
    """The first of the two hears what the second has said at the beginning of the step, never at a later time."""
    result = run(circle(saving("picky"), wrong="discard", longest=LONG))
    assert counted(result, "rejected") > 0
    np.testing.assert_allclose(result.columns["x.lag"], 0.0, atol=1e-15)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (
            "discard",
            "fmi3DoStep returned Discard; the FMU says: the step is too long at 0 s; it could not finish this step",
        ),
        ("terminate", "asked to end the simulation"),
        ("not_a_number", "its input x.u becomes nan, however short the macro step"),
        ("fatal", "fmi3DoStep returned Fatal; the FMU says: memory is exhausted at 0 s"),
    ],
)
def test_what_fails_in_every_step_is_told(saving: Get, wrong: str, said: str) -> None:
    system = circle(saving("picky"), wrong=wrong, longest=-1.0)
    if wrong == "not_a_number":
        system.components[0].parameters["longest"] = 1e9
    with pytest.raises(PartialResultError) as caught:
        run(system)
    assert str(caught.value).startswith(f"the simulation failed at t = 0 s: x (picky): {said}"), str(caught.value)


def test_noise_above_the_tolerance_is_told(saving: Get, monkeypatch: pytest.MonkeyPatch) -> None:
    """Noise of 1e-6, whatever the step, and a tolerance of 1e-9: the shortest steps are taken, and none shorter."""
    monkeypatch.setattr(_adaptive, "SHORTEST", 0.01)
    monkeypatch.setenv("COSIM_ENGINE", "python")
    arguments = {"stop": 1.0, "output_interval": 0.1, "tolerance": 1e-9, "coupling_error": False}
    with pytest.warns(FmuWarning) as said:
        result = simulate_once(circle(saving("picky"), wrong="noise"), **arguments)  # type: ignore[arg-type]
    assert counted(result, "macro_steps") <= 300
    assert counted(result, "forced") > 50
    np.testing.assert_allclose(result.columns["x.x"], np.cos(result.time), atol=1e-3)
    assert str(said[0].message).startswith("the tolerance 1e-09 is not reached: ")


@pytest.mark.parametrize("stop", [1e-6, 1e6])
def test_short_and_long_runs_are_the_same_in_their_own_time(saving: Get, stop: float) -> None:
    system = circle(saving("picky"))
    system.connections[0] = Connection(("y", "x"), ("x", "u"), factor=1.0 / stop)
    system.connections[1] = Connection(("x", "x"), ("y", "u"), factor=-1.0 / stop)
    result = simulate(system, stop=stop, output_interval=0.1 * stop, tolerance=1e-4, coupling_error=False)
    np.testing.assert_allclose(result.columns["x.x"], np.cos(result.time / stop), atol=1e-4)
    assert counted(result, "forced") == 0
