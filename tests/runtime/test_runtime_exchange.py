"""Model Exchange of hand-written models, call by call."""

from __future__ import annotations

import math
from collections.abc import Sequence
from ctypes import CDLL, byref, c_bool, c_double, c_size_t, c_void_p
from typing import Self

import pytest
from fmpy.fmi3 import fmi3LogMessageCallback
from runtime_harness import TOKEN, FmiError, Sample, built, library_of

DISCARD = 2


class Exchange(Sample):
    """An instance of a sample model whose importer integrates; the methods raise FmiError as those of Sample do."""

    def __init__(self, name: str) -> None:
        self.log: list[str] = []
        self._callback = fmi3LogMessageCallback(lambda _env, _status, _category, text: self.log.append(text.decode()))
        self.dll = CDLL(str(library_of(name, built(name))))
        instantiate = self.dll.fmi3InstantiateModelExchange
        instantiate.restype = c_void_p
        arguments = (name.encode(), TOKEN.encode(), None, c_bool(False), c_bool(True), None, self._callback)
        self.instance = c_void_p(instantiate(*arguments))
        self.time = 0.0

    def go(self, **parameters: float) -> Self:
        """Initialise, and take the first event."""
        self.start(**parameters)
        self.update()
        self.call("fmi3EnterContinuousTimeMode")
        return self

    def at(self, t: float, *x: float) -> Self:
        self.call("fmi3SetTime", c_double(t))
        self.call("fmi3SetContinuousStates", (c_double * len(x))(*x), c_size_t(len(x)))
        return self

    def ask(self, what: str, n: int) -> list[float]:
        values = (c_double * n)()
        self.call(f"fmi3Get{what}", values, c_size_t(n))
        return list(values)

    def complete(self) -> None:
        enter, end = c_bool(), c_bool()
        self.call("fmi3CompletedIntegratorStep", c_bool(True), byref(enter), byref(end))
        assert not enter.value


def test_derivatives_are_those_of_the_equation() -> None:
    oscillator = Exchange("oscillator").go(v5=3.0)
    oscillator.set(4, 0.5)
    assert oscillator.at(0.1, 0.7, -0.2).ask("ContinuousStateDerivatives", 2) == [-0.2, 0.5 - 9.0 * 0.7]
    assert oscillator.ask("ContinuousStates", 2) == [0.7, -0.2]
    assert oscillator.get(8) == pytest.approx(0.5 * (0.04 + 9.0 * 0.49), rel=1e-15)


def test_algebraic_unknowns_belong_to_the_point_and_trial_points_leave_no_trace() -> None:
    model = Exchange("algebraic").go()
    here = model.at(0.1, 1.9).ask("ContinuousStateDerivatives", 1)
    z = -here[0]
    assert z**3 + z - 0.1 == pytest.approx(1.9, rel=1e-12)
    model.at(0.5, -40.0).ask("ContinuousStateDerivatives", 1)
    assert model.at(0.1, 1.9).ask("ContinuousStateDerivatives", 1) == here


def domains(values: Sequence[float]) -> list[bool]:
    return [z > 0 for z in values]


@pytest.mark.parametrize("miss", [-1e-12, 0.0, 1e-18, -1e-18])
def test_an_indicator_does_not_sit_at_zero_after_an_event(miss: float) -> None:
    """The ball touches the ground, as exactly as the importer's search has found it."""
    ball = Exchange("bouncing_ball").go(v3=0.5)
    before = domains(ball.at(0.4, 0.2, -3.0).ask("EventIndicators", 2))
    at_ground = domains(ball.at(0.45, -1e-12, -3.0).ask("EventIndicators", 2))
    assert (before[0], before[1]) != (at_ground[0], at_ground[1])
    ball.at(0.45, miss, -3.0).complete()
    ball.call("fmi3EnterEventMode")
    update = ball.update()
    touched = miss <= 0.0
    assert update.reinitialised == touched
    assert ball.ask("ContinuousStates", 2) == [miss, 1.5 if touched else -3.0]
    ball.call("fmi3EnterContinuousTimeMode")
    after = ball.ask("EventIndicators", 2)
    assert min(abs(z) for z in after) > 5e-14
    assert domains(after)[0] == (at_ground if touched else before)[0]
    # a little higher it is in the air, a little lower on the ground, whatever the event has left
    assert domains(ball.at(0.46, 1e-9, 1.5).ask("EventIndicators", 2))[0] == before[0]
    assert domains(ball.at(0.46, -1e-9, 1.5).ask("EventIndicators", 2))[0] == at_ground[0]


def test_samples_are_taken_at_their_instants_and_none_is_left_out() -> None:
    sampler = Exchange("sampler")
    sampler.start()
    assert sampler.update().next_time == pytest.approx(0.1, abs=1e-15)
    sampler.call("fmi3EnterContinuousTimeMode")
    sampler.set(1, 2.0)
    sampler.at(0.1, 0.0).call("fmi3EnterEventMode")
    assert sampler.update().next_time == pytest.approx(0.2, abs=1e-15)
    assert (sampler.get(2, kind="Int32"), sampler.get(3)) == (2, 2.0)
    sampler.call("fmi3EnterContinuousTimeMode")
    sampler.at(0.35, 0.5).call("fmi3EnterEventMode")
    with pytest.raises(FmiError, match=r"more than one instant of a sample clock .* The events at nextEventTime must"):
        sampler.update()


def test_what_cannot_be_computed_is_discarded_and_the_instance_goes_on() -> None:
    NOT_A_NUMBER = 1
    model = Exchange("faults").go(v2=NOT_A_NUMBER)
    values = (c_double * 1)()
    model.at(0.1, 0.8)
    assert model.dll.fmi3GetContinuousStateDerivatives(model.instance, values, c_size_t(1)) == DISCARD
    assert "the derivative of tank.level is" in model.log[-1]
    assert model.at(0.1, 0.4).ask("ContinuousStateDerivatives", 1) == [1.0]


def test_what_an_importer_must_not_do_is_refused_and_leaves_no_trace() -> None:
    ball = Exchange("bouncing_ball").go()
    ball.at(0.1, 0.5, -1.0).complete()
    ball.at(0.2, 0.4, -1.0).complete()
    with pytest.raises(FmiError, match=r"SetTime: the time 0.08\d* s is before 0.1\d* s, and nothing goes back beyond"):
        ball.call("fmi3SetTime", c_double(0.09))
    with pytest.raises(FmiError, match="fmi3SetTime: the time nan is not a finite number"):
        ball.call("fmi3SetTime", c_double(math.nan))
    with pytest.raises(FmiError, match="fmi3SetContinuousStates: the state v is set to inf"):
        ball.at(0.2, 0.3, math.inf)
    with pytest.raises(FmiError, match="3 values are asked for, or given, where there are 2"):
        ball.ask("EventIndicators", 3)
    with pytest.raises(FmiError, match="fmi3GetContinuousStates: an array is null"):
        ball.call("fmi3GetContinuousStates", None, c_size_t(2))
    with pytest.raises(FmiError, match="fmi3DoStep does not exist in Model Exchange"):
        ball.step(0.1)
    other = Sample("bouncing_ball").start()
    with pytest.raises(FmiError, match="the state is one of the other type, Co-Simulation or Model Exchange"):
        ball.restore(other.save())
    assert (ball.get(0), ball.ask("ContinuousStates", 2)) == (0.2, [0.4, -1.0])
