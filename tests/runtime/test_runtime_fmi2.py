"""The FMI 2.0 shell: when samples are taken, what waits for the next step, and that it equals the FMI 3.0 shell."""

from __future__ import annotations

import math
from ctypes import c_char_p, c_double, c_size_t

import pytest
from fmi2_harness import DISCARD, Sample2
from fmpy.fmi2 import FMU2Slave
from runtime_harness import TOKEN, FmiError, Sample, built

COUNT, HOLD, ODD, LEVEL, X, Y = 2, 3, 4, 5, 6, 7
"""Variables of the model "sampler": x' = hold, y = x + u, where hold takes the input u each 0.1 s."""


def test_the_sample_at_the_start_of_a_step_is_taken_with_the_inputs_before_it() -> None:
    sample = Sample2("sampler").start()
    assert (sample.get(COUNT, kind="Integer"), sample.get(HOLD)) == (0, 0.0)
    sample.set(1, 5.0)
    sample.step_to(0.1)
    assert (sample.get(COUNT, kind="Integer"), sample.get(HOLD)) == (1, 5.0)
    assert sample.get(X) == pytest.approx(0.5, rel=1e-14)  # held over the whole step: no delay


def test_the_sample_at_the_end_of_a_step_belongs_to_the_next() -> None:
    sample = Sample2("sampler").start()
    for k in range(1, 21):
        sample.set(1, float(k))
        sample.step_to(0.1 * k)
        assert (sample.get(COUNT, kind="Integer"), sample.get(HOLD)) == (k, float(k))


def test_samples_inside_a_step_are_taken_too() -> None:
    sample = Sample2("sampler").start()
    sample.set(1, 1.0)
    sample.step_to(0.05)
    sample.set(1, 2.0)
    sample.step_to(0.35)
    assert sample.get(COUNT, kind="Integer") == 4
    assert sample.get(X) == pytest.approx(0.1 * 1.0 + 0.25 * 2.0, rel=1e-14)


def test_a_sum_of_steps_that_misses_the_sample_by_rounding_does_not_miss_it() -> None:
    sample = Sample2("sampler").start()
    t = 0.0
    for k in range(300):
        sample.set(1, float(k))
        sample.call("fmi2DoStep", c_double(t), c_double(0.1), 1)
        assert sample.get(HOLD) == float(k)
        t += 0.1
    assert sample.get(COUNT, kind="Integer") == 300


def test_outputs_are_those_of_the_last_step_until_the_next() -> None:
    sample = Sample2("sampler").start()
    sample.step_to(0.05)
    before = sample.get(X, Y)
    sample.set(1, 2.5)
    assert sample.get(X, Y) == before
    assert sample.get(1) == 2.5
    sample.step_to(0.06)
    assert sample.get(Y) == sample.get(X) + 2.5


def test_values_follow_inputs_in_initialization_mode() -> None:
    sample = Sample2("algebraic").set_up().enter()
    sample.set(4, 8.0)
    z = sample.get(2)
    assert z**3 + z - 10.1 == pytest.approx(0.0, abs=1e-12)
    sample.exit()


def test_types_of_fmi_2() -> None:
    sample = Sample2("sampler").start(v10=0.1)
    sample.step_to(0.15)
    assert sample.get(LEVEL, kind="Integer") == 3  # an enumeration
    assert sample.get(ODD, kind="Boolean") == 0
    counters = sample.get(*range(12, 18), kind="Integer")
    assert counters[5] == 2  # ticks
    oscillator = Sample2("oscillator").start()
    oscillator.set(9, 7, kind="Boolean")  # whatever is not false is true
    assert oscillator.get(4) == 1.0


@pytest.mark.parametrize(("name", "references"), [("oscillator", (1, 2, 8)), ("algebraic", (1, 2, 3, 5)),
                                                  ("sampler", (X, Y)), ("bouncing_ball", (1, 2))])  # fmt: skip
def test_both_shells_give_the_same_bits(name: str, references: tuple[int, ...]) -> None:
    two, three = Sample2(name).start(1e-6), Sample(name).start(1e-6)
    driven = {"oscillator": 4, "algebraic": 4, "sampler": 1}.get(name)
    for k in range(40):
        for sample in (two, three):
            if driven is not None:
                sample.set(driven, math.sin(k // 4))
            sample.step_to(0.03 * (k + 1))
        assert two.get(*references) == three.get(*references)


def trace(sample: Sample2, steps: int) -> list[object]:
    result: list[object] = []
    for k in range(steps):
        sample.step_to((30 + k + 1) * 0.07)
        sample.set(1, float(k % 3))
        result.append((sample.get(COUNT, kind="Integer"), sample.get(HOLD, X, Y)))
        result.append(sample.get(*range(12, 18), kind="Integer"))
    return result


def test_restored_state_continues_bit_by_bit_with_the_inputs_that_wait() -> None:
    sample = Sample2("sampler").start(v8=0.1)
    for k in range(30):
        sample.set(1, 0.1 * k * k - k)
        sample.step_to((k + 1) * 0.07)
    sample.set(1, 42.0)  # not yet taken over
    time, state = sample.time, sample.save()
    data = sample.serialize(state)
    first = trace(sample, 20)
    sample.restore(state)
    assert sample.get(1) == 42.0
    sample.time = time
    assert trace(sample, 20) == first
    other = Sample2("sampler")
    copy = other.deserialize(data)
    other.restore(copy)
    other.time = time
    assert trace(other, 20) == first
    for owner, saved in ((sample, state), (other, copy)):
        owner.forget(saved)
        assert not saved.value


def test_repeated_step_after_restore_is_identical_with_events_inside() -> None:
    ball = Sample2("bouncing_ball").start(1e-6)
    ball.step(0.3)
    state = ball.save()
    results = []
    for _ in range(3):
        ball.restore(state)
        ball.time = 0.3
        ball.step(1.7)
        results.append((ball.get(1, 2), ball.get(*range(6, 12), kind="Integer")))
    assert results[0] == results[1] == results[2]


def test_terminate_discards_the_rest_of_the_step() -> None:
    sample = Sample2("faults").start(v2=5)
    with pytest.raises(FmiError, match=r"^At t = 0\.5 s the model ends the simulation: The tank is half full\.$"):
        sample.step(2.0)
    assert sample.status == DISCARD
    assert sample.log[0][:2] == (DISCARD, "logStatusDiscard")
    assert sample.terminated()
    assert sample.last_time() == pytest.approx(0.5, abs=1e-12)
    sample.call("fmi2Terminate")
    assert sample.get(1) == pytest.approx(0.5, abs=1e-12)


def test_a_failed_step_is_an_error_and_leaves_looking_restoring_and_resetting() -> None:
    sample = Sample2("faults").start(v2=1)
    state = sample.save()
    with pytest.raises(FmiError, match="the equations give no finite number"):
        sample.step(2.0)
    assert sample.log[0][:2] == (3, "logStatusError")
    assert math.isfinite(sample.get(1))
    with pytest.raises(FmiError, match="fmi2DoStep is not allowed after an error; call fmi2Reset, fmi2SetFMUstate or"):
        sample.step(0.1)
    sample.restore(state)
    sample.step(0.5)
    sample.call("fmi2Reset")
    sample.start().step(1.0)


def test_tolerance_is_honoured() -> None:
    errors = []
    for tolerance in (1e-3, 1e-6, 1e-9):
        sample = Sample2("oscillator").start(tolerance)
        sample.step(10.0)
        errors.append(abs(sample.get(1) - math.cos(20.0)))
    assert errors[0] > 10 * errors[1] > 100 * errors[2]


def test_warnings_are_logged_always_and_events_on_request() -> None:
    sample = Sample2("faults").start(v2=6)
    sample.step(0.7)
    assert [entry[:2] for entry in sample.log if "nearly full" in entry[2]] == [(1, "logStatusWarning")]
    note = (0, "logEvents", "State event at t = 0.5 s: 'tank.level > 0.5'")
    loud = Sample2("faults", logging=True).start()
    loud.step(1.0)
    assert loud.log == [note]
    for categories, expected in (([b"logEvents"], [note]), ([b"logStatusError"], []), ([], [note])):
        sample = Sample2("faults")
        names = (c_char_p * max(1, len(categories)))(*categories)
        sample.call("fmi2SetDebugLogging", 1, c_size_t(len(categories)), names)
        sample.start().step(1.0)
        assert sample.log == expected


def test_messages_are_formats_without_conversions() -> None:
    with pytest.raises(FmiError, match=r"^50%% duty: the instantiation token is not that of this FMU"):
        Sample2("oscillator", called="50% duty", guid="{other}")


def test_fmpy_can_drive_it() -> None:
    slave = FMU2Slave(
        guid=TOKEN, unzipDirectory=str(built("oscillator", 2)), modelIdentifier="oscillator", instanceName="o"
    )
    slave.instantiate()
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    slave.doStep(currentCommunicationPoint=0.0, communicationStepSize=0.5)
    assert slave.getReal([0]) == [0.5]
    slave.terminate()
    slave.freeInstance()
