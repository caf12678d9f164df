"""Models that cannot be simulated: the message names the place, the time and the remedy."""

from __future__ import annotations

import pytest
from runtime_harness import FmiError, Sample

MESSAGES = {
    1: r"At t = 0\.7\d* s the equations give no finite number.* tank\.level\. Check for a division by zero",
    2: r"At t = 0\.5 s the model chatters: 1000 state events .*'tank\.level > 0\.5'\. Smooth .* hysteresis",
    3: r"At t = 1\.5707\d* s the step size had to be reduced .* tolerance 1e-06; .* tank\.level\. Try a looser",
    4: r"At t = 0\.5 s the event iteration finds no consistent state: the discrete variables keep changing",
    6: r"At t = [\d.]+ s an assertion of the model is violated: The tank overflows\.",
    8: r"the event iteration finds no consistent state: the relations 'valve\.open', 'valve\.shut' keep changing",
    10: r"At t = 0\.5 s reinit\(\) sets tank\.level to -?nan",
    11: r"At t = 0\.5 s the discrete variable tank\.alarm is not a number\. Check",
    9: r"At t = 0\.5 s one event causes the next without end",
}


@pytest.mark.parametrize("kind", MESSAGES)
def test_failing_step_says_why(kind: int) -> None:
    sample = Sample("faults").start(v2=kind)
    with pytest.raises(FmiError, match=MESSAGES[kind]):
        sample.step(2.0)
    with pytest.raises(FmiError, match="fmi3DoStep is not allowed after an error; call fmi3Reset"):
        sample.step(2.0)
    sample.call("fmi3Reset")
    sample.start(v2=0).step(2.0)
    assert sample.get(1) == pytest.approx(2.0)


def test_failed_step_can_be_undone_by_restoring_the_state() -> None:
    sample = Sample("faults").start(v2=1)
    sample.step(0.25)
    state = sample.save()
    with pytest.raises(FmiError):
        sample.step_to(2.0)
    sample.restore(state)
    sample.time = 0.25
    sample.step_to(0.6)
    assert sample.get(1) == pytest.approx(0.6)
    sample.forget(state)


def test_warning_is_logged_once() -> None:
    sample = Sample("faults").start(v2=6)
    warnings = []
    for _ in range(7):
        sample.step(0.1)
        warnings += sample.log
    assert warnings == ["At t = 0.3 s: The tank is nearly full."]


def test_initial_equations_without_solution_are_named() -> None:
    sample = Sample("faults")
    sample.set(2, 7)
    sample.enter()
    with pytest.raises(FmiError, match=r"initial equations cannot be solved.* tank\.level\^2 = -1 \(residual"):
        sample.exit()
    sample.set(2, 0)  # still in Initialization Mode
    sample.exit()
    assert sample.get(1) == 0.0


def test_singular_initial_equations_are_named() -> None:
    sample = Sample("faults")
    sample.set(2, 12)
    sample.enter()
    with pytest.raises(FmiError, match=r"initial equations do not determine tank\.level: "):
        sample.exit()


def test_clock_without_positive_interval_is_refused() -> None:
    sample = Sample("sampler")
    sample.set(8, 0.0)
    sample.enter()
    with pytest.raises(FmiError, match="Sample clock 1 starts at 0 s with the interval 0 s, which must be positive"):
        sample.exit()
