"""The criteria of section 4.5 on sequences made by hand, whose verdicts follow from the text."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cosim.assessment import Counts, Rules, Trace, score

from .conftest import CYCLE, cycles, make

STOP = (1.95, "Soft_stop")
"""The chart's Soft_stop, over at the end of the revolution."""


def test_the_profile_of_figure_3_12_passes_but_for_the_literal_reading() -> None:
    found = score(make(cycles([[STOP]] * 4), [0, 1.98, 3.98, 5.98], 7))
    assert found.counts == Counts(park_literal=0, park_deceleration=3, park_total=3, turn=3, turn_total=3)
    assert found.counts_without_first == Counts(0, 2, 2, 2, 2)
    assert [(f.criterion, f.reading, f.time) for f in found.failures] == [
        (1, "literal", pytest.approx(t)) for t in (1.98, 3.98, 5.98)
    ]
    first = found.revolutions[0]
    assert (first.start, first.end, first.state_at_park) == (0.0, pytest.approx(1.98), "Soft_stop")
    assert (first.ended_before, first.turn_time) == (0.0, pytest.approx(1.0))
    assert first.turn_position == pytest.approx(1.0 / 1.98)
    assert set(first.occurrences.values()) == {1}


def test_a_park_signal_in_turn_point_dec_passes_the_literal_reading() -> None:
    found = score(make([*CYCLE, (1.9, "turn_point_dec"), (1.96, "Soft_stop"), (2.0, "Soft_start")], [0, 1.95], 2.5))
    # its second turn_point_dec is one too many for the turn
    assert found.counts == Counts(park_literal=1, park_deceleration=1, park_total=1, turn=0, turn_total=1)
    assert [(f.criterion, f.time) for f in found.failures] == [(3, pytest.approx(1.9))]
    separate = score(make([*CYCLE, (1.9, "turn_point_dec")], [0, 1.95], 2.5), Rules(repeats="separate"))
    assert separate.counts == Counts(park_literal=1, park_deceleration=1, park_total=1, turn=1, turn_total=1)
    assert [f.criterion for f in separate.failures] == [3]


def test_the_answer_to_a_park_signal_is_no_prediction() -> None:
    # in RUN when the contact closes; Soft_stop begins at that very row
    run = make([*CYCLE, (2.0, "Soft_stop"), (2.05, "Soft_start"), (2.15, "RUN")], [0, 2.0], 2.5)
    found = score(run)
    assert found.counts.park_deceleration == 0
    (failure,) = found.failures
    assert failure.reason == "in RUN; a deceleration began at the signal"
    assert found.revolutions[0].began_after == 0.0
    assert score(run, Rules(late=1e-3)).counts.park_deceleration == 1


@pytest.mark.parametrize(("early", "passes"), [(0.0, False), (0.019, False), (0.02, True), (0.1, True)])
def test_a_deceleration_may_have_ended_early_by_as_much_as_the_rules_say(early: float, passes: bool) -> None:
    run = make([*CYCLE, (1.93, "Soft_stop"), (1.98, "Soft_start"), (2.08, "RUN")], [0, 2.0], 2.5)
    found = score(run, Rules(early=early, repeats="separate"))
    assert found.counts.park_deceleration == passes
    assert found.revolutions[0].ended_before == pytest.approx(0.02)


@pytest.mark.parametrize(("late", "passes"), [(0.0, False), (0.029, False), (0.03, True)])
def test_or_begin_late(late: float, passes: bool) -> None:
    run = make([*CYCLE, (2.03, "Soft_stop"), (2.08, "Soft_start")], [0, 2.0], 2.5)
    assert score(run, Rules(late=late)).counts.park_deceleration == passes


def test_a_deceleration_that_ends_with_the_signal_still_held_before_it() -> None:
    run = make([*CYCLE, (1.95, "Soft_stop"), (2.0, "Soft_start")], [0, 2.0], 2.5)
    assert score(run).counts.park_deceleration == 1


def test_a_revolution_without_turn_fails_whatever_its_number() -> None:
    straight = [(0.0, "Soft_start"), (0.1, "RUN"), STOP]
    turning = [*CYCLE, STOP]
    for missing in range(3):
        states = [(2 * k + t, s) for k in range(4) for t, s in (straight if k == missing else turning)]
        found = score(make(states, [0, 1.98, 3.98, 5.98], 7))
        assert [r.turn for r in found.revolutions] == [k != missing for k in range(3)]
        (failure,) = [f for f in found.failures if f.criterion == 2]
        assert (failure.revolution, failure.reason) == (missing + 1, "no turn_point_acc since the last park signal")
        assert found.counts.turn == 2
        assert found.counts_without_first.turn == (1 if missing else 2)


def test_a_turn_must_be_where_the_others_are() -> None:
    odd = [(0.0, "Soft_start"), (0.1, "RUN"), (0.4, "turn_point_dec"), (0.5, "turn_point_acc"), (0.6, "RUN"), STOP]
    states = [(2 * k + t, s) for k in range(5) for t, s in (odd if k == 2 else [*CYCLE, STOP])]
    run = make(states, [0, 2, 4, 6, 8], 9)
    assert [r.turn for r in score(run).revolutions] == [True, True, False, True]
    (failure,) = [f for f in score(run).failures if f.criterion == 2]
    assert failure.reason == "turned after 0.25 of the revolution, where 0.50 is usual"
    assert failure.time == pytest.approx(4.5)
    assert score(run, Rules(position=0.26)).counts.turn == 4
    assert score(run, Rules(position=math.inf)).counts.turn == 4


def test_the_position_is_that_of_the_crank_where_it_is_known() -> None:
    # the second revolution takes longer, by a halt after the turn: the same angle, another share of the time
    states = cycles([[STOP]]) + [(2 + t, s) for t, s in CYCLE] + [(3.95 + 2, "Soft_stop")]
    time = np.arange(6501) * 1e-3
    phi = 2 * np.pi * np.interp(time, [0, 2, 3.2, 5.2, 6.0, 6.5], [0, 1, 1.6, 1.6, 2.0, 2.25])
    run = make(states, [0, 2, 6], 6.5, **{"plant.phi_crank": phi})
    assert [r.turn_position for r in score(run).revolutions] == pytest.approx([0.5, 0.5], abs=1e-3)
    run = make(states, [0, 2, 6], 6.5)
    assert [r.turn_position for r in score(run).revolutions] == pytest.approx([0.5, 0.25], abs=1e-3)


def test_each_state_may_be_entered_once_between_two_parks() -> None:
    for state, column in {
        "Soft_start": "park",
        "Soft_stop": "park",
        "turn_point_dec": "turn",
        "turn_point_acc": "turn",
    }.items():
        states = [*CYCLE, (1.3, state), (1.4, "RUN"), STOP, *((2 + t, s) for t, s in CYCLE)]
        found = score(make(states, [0, 1.98], 3.5))
        (failure,) = [f for f in found.failures if f.criterion == 3]
        at = 1.95 if state == "Soft_stop" else 1.3
        assert (failure.time, failure.reason) == (pytest.approx(at), f"{state} 2 times since the last park signal")
        assert (found.revolutions[0].park_deceleration, found.revolutions[0].turn) == (
            column != "park",
            column != "turn",
        )


def test_what_is_entered_with_the_park_signal_belongs_to_the_next_revolution() -> None:
    states = [
        *CYCLE,
        (2.0, "Soft_stop"),
        (2.05, "Soft_start"),
        *((2.05 + t, s) for t, s in CYCLE[1:]),
        (4.0, "Soft_stop"),
    ]
    found = score(make(states, [0, 2.0, 4.02], 4.5))
    assert [r.occurrences["Soft_stop"] for r in found.revolutions] == [0, 2]
    assert [(f.revolution, f.time) for f in found.failures if f.criterion == 3] == [(2, pytest.approx(4.0))]


def test_only_the_span_counts_and_the_revolution_it_cuts_off_may_count_its_turn() -> None:
    run = make(cycles([[STOP]] * 5), [0, 1.98, 3.98, 5.98, 7.98], 9.5)
    assert score(run, Rules(span=3.98)).counts.park_total == 2
    assert score(run, Rules(span=3.979)).counts.park_total == 1

    def turns(span: float) -> tuple[int, int]:
        counts = score(run, Rules(span=span, unfinished=True)).counts
        return counts.turn, counts.turn_total

    assert turns(4.5) == (2, 2)  # not yet where it should turn
    assert turns(5.2) == (3, 3)
    straight = make([*cycles([[STOP]] * 2), (4.0, "Soft_start"), (4.1, "RUN")], [0, 1.98, 3.98], 9.5)
    counts = score(straight, Rules(span=5.5, unfinished=True)).counts
    assert (counts.turn, counts.turn_total, counts.park_total) == (2, 3, 2)


def test_a_run_that_begins_off_the_contact_begins_with_the_first_closing() -> None:
    found = score(make(cycles([[STOP]] * 3), [1.98, 3.98, 5.98], 6.5))
    assert found.counts.park_total == 2
    assert "the run does not begin on the park contact" in " ".join(found.notes)


def test_a_closing_with_enable_off_is_no_prediction_to_be_made() -> None:
    time = np.arange(6501) * 1e-3
    enable = (time < 3.0).astype(int)
    found = score(make(cycles([[STOP]] * 3), [0, 1.98, 3.98, 5.98], 6.5, enable=enable))
    assert [r.end for r in found.revolutions] == pytest.approx([1.98])
    assert "2 closings of the contact with enable off are not scored" in found.notes


def test_a_missed_contact_is_told() -> None:
    time = np.arange(5001) * 1e-3
    run = make(cycles([[STOP]] * 3), [0, 3.98], 5, **{"plant.phi_crank": np.pi * time})
    assert "between the closings at 0.000 s and 3.980 s the crank turned 1.99 times, not once" in score(run).notes


def test_the_notes_tell_what_is_not_covered() -> None:
    made = make(cycles([[STOP]]), [0], 1.5)
    found = score(Trace("short", made.time, made.columns, complete=False))
    assert found.counts == Counts(0, 0, 0, 0, 0)
    assert found.notes == (
        "the run ended early: its result is marked incomplete",
        "the run covers 1.5 s of the 20 s that are scored",
        "the park contact closes too rarely for a whole revolution: nothing to score",
    )
