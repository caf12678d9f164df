"""State events, sample clocks and the two ways to handle them."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from runtime_harness import FmiError, Sample
from scipy.optimize import brentq

GRAVITY = 9.81


def bounce_times(restitution: float, height: float, n: int) -> list[float]:
    """Closed form: each flight lasts 2 v / g, each bounce multiplies v by the restitution."""
    times = [math.sqrt(2.0 * height / GRAVITY)]
    speed = GRAVITY * times[0]
    for _ in range(n - 1):
        speed *= restitution
        times.append(times[-1] + 2.0 * speed / GRAVITY)
    return times


def test_bounce_times_are_exact() -> None:
    """The flight is a parabola, which the method and its dense output represent exactly."""
    ball = Sample("bouncing_ball", events=True, early=True).start(1e-4)
    ball.update()
    ball.call("fmi3EnterStepMode")
    found: list[float] = []
    while len(found) < 10:
        if not ball.step(0.4).event:
            continue
        bounces = ball.get(5, kind="Int32")
        ball.call("fmi3EnterEventMode")
        assert ball.get(5, kind="Int32") == bounces
        update = ball.update()
        ball.call("fmi3EnterStepMode")
        assert update.reinitialised == (ball.get(5, kind="Int32") > bounces)
        if update.reinitialised:
            found.append(ball.time)
    assert found == pytest.approx(bounce_times(0.8, 1.0, 10), abs=1e-12)


def test_bounces_inside_a_step_are_handled_there() -> None:
    ball = Sample("bouncing_ball").start(1e-6)
    times = bounce_times(0.8, 1.0, 9)
    ball.step_to(0.5 * (times[7] + times[8]))
    assert ball.get(5, kind="Int32") == 8
    flight = 0.5 * (times[8] - times[7])
    assert ball.get(1) == pytest.approx(0.5 * GRAVITY * flight**2, abs=1e-10)
    assert ball.get(2) == pytest.approx(0.0, abs=1e-9)


def test_endless_bounces_are_refused() -> None:
    ball = Sample("bouncing_ball").start(1e-6)
    with pytest.raises(FmiError, match=r"At t = 4\.0637\d* s the events of 'v < 0' accumulate: .*\. Let the"):
        ball.step(10.0)


def rectifier_current(t: float, since: float, omega: float, r: float, inductance: float) -> float:
    """L i' + R i = sin(omega t) with i = 0 at the time since."""
    z, phase, tau = math.hypot(r, omega * inductance), math.atan2(omega * inductance, r), inductance / r
    return (math.sin(omega * t - phase) - math.sin(omega * since - phase) * math.exp(-(t - since) / tau)) / z


def test_rectifier_conducts_until_the_angle_of_extinction() -> None:
    omega, r, inductance = 314.0, 1.0, 0.01
    period = 2.0 * math.pi / omega
    off = brentq(lambda t: rectifier_current(t, 0.0, omega, r, inductance), 0.5 * period, 0.999 * period)
    sample = Sample("rectifier", events=True, early=True).start(1e-9)
    sample.update()
    sample.call("fmi3EnterStepMode")
    times = []
    while sample.time < 2.4 * period:
        if sample.step_to(2.4 * period).event:
            times.append(sample.time)
            sample.call("fmi3EnterEventMode")
            sample.update()
            sample.call("fmi3EnterStepMode")
    for extinction in (off, off + period):
        assert min(abs(t - extinction) for t in times) < 1e-10
    assert sample.get(1) == pytest.approx(rectifier_current(2.4 * period, 2.0 * period, omega, r, inductance), abs=1e-7)


@pytest.mark.parametrize("level", [0.999, 0.9999, 0.99999])
def test_short_excursions_are_not_lost(level: float) -> None:
    """x = cos t rises above the level once per period, for a small part of a step only."""
    sample = Sample("excursion").start(1e-6, v3=level)
    sample.step(20.0 * 2.0 * math.pi + 1.0)
    assert sample.get(4, kind="Int32") == 20


def test_relation_of_an_algebraic_unknown() -> None:
    """z1 falls through 0.5, where the equation for it jumps: the state then is x = 0.5^3 + 0.5 - 0.1."""
    sample = Sample("algebraic", events=True, early=True).start(1e-7)
    sample.update()
    sample.call("fmi3EnterStepMode")
    assert sample.step(5.0).event
    assert sample.get(2) == pytest.approx(0.5, abs=1e-12)
    assert sample.get(1) == pytest.approx(0.525, abs=1e-12)
    sample.call("fmi3EnterEventMode")
    sample.update()
    assert sample.get(1) == pytest.approx(0.525, abs=1e-12)
    assert sample.get(2) < 0.45


def test_samples_of_a_step_are_those_at_its_start_and_inside() -> None:
    sample = Sample("sampler").start(v8=0.1)
    assert sample.get(2, kind="Int32") == 0
    for k in range(30):
        sample.set(1, float(k))
        sample.step_to((k + 1) * 0.1)
        assert sample.get(2, kind="Int32") == k + 1
        assert sample.get(3) == float(k)
        assert sample.get(4, kind="Boolean") == ((k + 1) % 2 == 1)
    sample.step_to(4.0)
    assert sample.get(2, kind="Int32") == 40
    assert sample.counters(12)["time_events"] == 40


def test_held_value_acts_from_its_instant_on() -> None:
    sample = Sample("sampler").start(v8=0.1)
    for k in range(10):
        sample.set(1, float(k))
        sample.step_to((k + 1) * 0.1)
    assert sample.get(6) == pytest.approx(sum(range(10)) * 0.1, abs=1e-12)


def test_a_million_ticks_do_not_drift() -> None:
    sample = Sample("sampler").start(v8=1e-3)
    sample.step_to(1000.0 - 1e-4)
    assert sample.get(2, kind="Int32") == 1_000_000
    sample.step_to(1000.0)
    assert sample.get(2, kind="Int32") == 1_000_000
    sample.step_to(1000.0 + 1e-4)
    assert sample.get(2, kind="Int32") == 1_000_001


@settings(max_examples=50, deadline=None)
@given(st.lists(st.integers(1, 400), min_size=1, max_size=12), st.integers(1, 250))
def test_any_communication_steps_see_every_tick_once(steps: list[int], interval: int) -> None:
    """At the end of the steps [t, t + h), in milliseconds, all ticks before their end have happened."""
    sample = Sample("sampler").start(v8=interval * 1e-3)
    end = 0
    for step in steps:
        end += step
        sample.step_to(end * 1e-3)
        assert sample.get(2, kind="Int32") == -(-end // interval)
    sample.free()


@settings(max_examples=50, deadline=None)
@given(st.lists(st.floats(1e-6, 1.0), min_size=1, max_size=10))
def test_bounces_do_not_depend_on_the_communication_steps(steps: list[float]) -> None:
    scale = 2.0 / sum(steps)
    ball, reference = Sample("bouncing_ball").start(1e-6), Sample("bouncing_ball").start(1e-6)
    for step in steps:
        ball.step(step * scale)
    reference.step_to(ball.time)
    assert ball.get(5, kind="Int32") == reference.get(5, kind="Int32")
    assert ball.get(1, 2) == pytest.approx(reference.get(1, 2), abs=1e-11)
    for sample in (ball, reference):
        sample.free()


def test_clock_that_starts_later_and_second_clock() -> None:
    sample = Sample("sampler").start(v8=0.1, v9=0.25, v10=0.2)
    sample.step_to(0.25)
    assert sample.get(2, kind="Int32") == 0
    assert sample.get(5, kind="Int64") == 3  # ticks at 0 and 0.2
    sample.step_to(0.36)
    assert sample.get(2, kind="Int32") == 2  # ticks at 0.25 and 0.35


def test_simulation_that_starts_late_meets_the_next_tick() -> None:
    sample = Sample("sampler").start(start=5.03, v8=0.1)
    sample.step_to(5.1)
    assert sample.get(2, kind="Int32") == 0
    sample.step_to(5.15)
    assert sample.get(2, kind="Int32") == 1


@pytest.mark.parametrize("change", [0.3, 0.3 - 1e-10, 0.25])
def test_state_event_does_not_bring_a_tick_forward(change: float) -> None:
    """A relation changes at the end of a step, where a tick has to wait for the inputs of the next step."""
    sample = Sample("sampler").start(v8=0.1, v11=change)
    for k in range(5):
        sample.set(1, float(k))
        sample.step_to((k + 1) / 10)
        assert sample.get(3) == float(k)
        assert sample.get(2, kind="Int32") == k + 1
    assert sample.counters(12)["state_events"] == 1


def test_event_mode_reads_the_inputs_set_in_it() -> None:
    sample = Sample("sampler", events=True, early=True).start(v8=0.1)
    for k in range(30):
        sample.set(1, 10.0 + k)
        update = sample.update()
        assert update.next_time == pytest.approx((k + 1) * 0.1, abs=1e-12)
        assert sample.get(3) == 10.0 + k
        assert sample.get(2, kind="Int32") == k + 1
        sample.update()  # the instant ticks once
        assert sample.get(2, kind="Int32") == k + 1
        sample.call("fmi3EnterStepMode")
        step = sample.step_to((k + 1) * 0.1)
        assert step.event
        assert not step.early
        assert sample.get(2, kind="Int32") == k + 1
        sample.call("fmi3EnterEventMode")


def test_event_mode_stops_at_a_tick_inside_the_step() -> None:
    sample = Sample("sampler", events=True, early=True).start(v8=0.1)
    sample.update()
    sample.call("fmi3EnterStepMode")
    assert sample.step_to(0.25) == (True, False, True, 0.1)
    assert sample.get(2, kind="Int32") == 1


def test_without_early_return_ticks_inside_are_computed_there_and_show_in_event_mode() -> None:
    sample = Sample("sampler", events=True).start(v8=0.1)
    sample.set(1, 2.0)
    sample.update()
    sample.call("fmi3EnterStepMode")
    sample.set(1, 3.0)
    # x' = held, which was 2 until the tick at 0.1 s and is 3 from then on
    for end in (0.25, 0.35):
        assert sample.step_to(end) == (True, False, False, end)
        assert sample.get(6) == pytest.approx(0.2 + 3 * (end - 0.1), abs=1e-9)
        assert sample.get(2, kind="Int32") == 1
        assert sample.get(3) == 2.0
    state = sample.save()
    sample.call("fmi3EnterEventMode")
    assert sample.get(2, kind="Int32") == 4
    assert sample.get(3) == 3.0
    assert sample.update().next_time == pytest.approx(0.4, abs=1e-12)
    assert sample.get(2, kind="Int32") == 4
    sample.call("fmi3EnterStepMode")
    assert sample.step_to(0.38) == (False, False, False, 0.38)
    sample.restore(state)
    sample.forget(state)
    assert sample.get(2, kind="Int32") == 1


def test_without_early_return_state_events_are_computed_inside_and_show_in_event_mode() -> None:
    """Two balls, one seen in Event Mode only: they fly alike, and their counts of bounces agree there."""
    plain, watched = Sample("bouncing_ball").start(1e-8), Sample("bouncing_ball", events=True).start(1e-8)
    watched.update()
    watched.call("fmi3EnterStepMode")
    seen = bounces = 0
    for k in range(20):
        plain.step_to(0.1 * (k + 1))
        step = watched.step_to(0.1 * (k + 1))
        assert watched.get(1, 2) == pytest.approx(plain.get(1, 2), abs=1e-9)
        assert watched.get(5, kind="Int32") == seen
        assert not step.early
        bounces = plain.get(5, kind="Int32")
        if bounces > seen:
            assert step.event
        if step.event:  # at the top of its flight, too
            watched.call("fmi3EnterEventMode")
            watched.update()
            seen = watched.get(5, kind="Int32")
            watched.call("fmi3EnterStepMode")
        assert seen == bounces
    assert bounces > 2


def test_both_modes_give_the_same_trajectory() -> None:
    plain, stopping = Sample("sampler").start(v8=0.1), Sample("sampler", events=True, early=True).start(v8=0.1)
    for k in range(20):
        for sample in (plain, stopping):
            sample.set(1, math.sin(k))
        stopping.update()
        stopping.call("fmi3EnterStepMode")
        plain.step_to((k + 1) * 0.1)
        stopping.step_to((k + 1) * 0.1)
        stopping.call("fmi3EnterEventMode")
        assert plain.get(3, 6, 7) == stopping.get(3, 6, 7)


def test_terminate_ends_the_step() -> None:
    sample = Sample("faults").start(v2=5)
    step = sample.step(2.0)
    assert step.terminate
    assert step.time == pytest.approx(0.5, abs=1e-12)
    assert sample.log == ["At t = 0.5 s the model ends the simulation: The tank is half full."]
    # an early return that was not allowed is none: the flag to end and the last time say it all
    assert sample.step(0.1) == (False, True, False, step.time)
    sample.call("fmi3Terminate")
    assert sample.get(1) == pytest.approx(0.5, abs=1e-12)


def test_terminate_at_the_start() -> None:
    assert Sample("faults").start(v2=13).step(1.0) == (False, True, False, 0.0)
    sample = Sample("faults", events=True).start(v2=13)
    assert sample.update().terminate


def test_event_notes_are_logged_on_request() -> None:
    sample = Sample("faults", logging=True).start()
    sample.step(1.0)
    assert sample.log == ["State event at t = 0.5 s: 'tank.level > 0.5'"]


def test_outputs_without_events_are_continuous() -> None:
    sample = Sample("oscillator").start(1e-6)
    energies = [sample.get(8)]
    for k in range(50):
        sample.step_to((k + 1) * 0.02)
        energies.append(sample.get(8))
    # between two steps of the solver values are read off its dense output, which errs by about the tolerance
    tolerance = 1e-6
    assert all(abs(a - b) < 2.0 * tolerance * energies[0] for a, b in pairwise(energies))


def test_steps_beyond_the_communication_point_are_given_up_when_an_input_changes() -> None:
    """x'' + 4 x = u, a step of u in the middle of a step of the solver: the closed form, and few steps."""
    sample = Sample("oscillator").start(1e-8)
    for k in range(600):
        sample.step_to((k + 1) / 1000)
    steps = sample.counters(10)["steps"]
    assert steps < 100
    sample.set(4, 3.0)
    for k in range(600, 1000):
        sample.step_to((k + 1) / 1000)
    x, w = math.cos(1.2), -2.0 * math.sin(1.2)
    phase = 2.0 * 0.4
    expected = 0.75 + (x - 0.75) * math.cos(phase) + 0.5 * w * math.sin(phase)
    assert sample.get(1) == pytest.approx(expected, abs=1e-7)
    assert sample.counters(10)["steps"] < 2 * steps


def test_saved_state_goes_on_the_same_from_within_a_step_of_the_solver() -> None:
    sample = Sample("oscillator").start(1e-6)
    sample.step_to(0.1)
    sample.step_to(0.1001)
    state = sample.save()
    sample.step_to(0.9)
    once = sample.get(1)
    sample.restore(state)
    sample.time = 0.1001
    sample.step_to(0.9)
    assert sample.get(1) == once
    sample.forget(state)
