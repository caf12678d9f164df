"""The three criteria of the thesis's section 4.5, revolution by revolution."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cosim.assessment._rules import Rules
from cosim.assessment._trace import Array, Trace, trace
from cosim.assessment._verdict import Failure, Revolution, Score
from cosim.engine import Result
from cosim.errors import InputError

if TYPE_CHECKING:
    import pandas as pd

DECELERATIONS = ("turn_point_dec", "Soft_stop")
"""States in which the profile lowers the voltage."""
ONCE = ("turn_point_acc", "turn_point_dec", "Soft_start", "Soft_stop")
"""States that criterion 3 allows once between two park signals."""
LOOKED_AT = ("park", "state", "phi_crank", "enable")
"""Signals that are looked at in a run."""
COARSEST = 5e-3
"""Largest distance of rows that can be scored [s]: at full voltage the park contact is closed for about 12 ms."""
_NEAR = 0.25
"""Share of a revolution within which a deceleration is that of its end."""
_SAME = 1e-9
"""Two times closer than this are one [s]."""


def score(source: Trace | Result | pd.DataFrame | Path | str, rules: Rules | None = None) -> Score:
    """Score a run as section 4.5 of the thesis does, one revolution after the other.

    A revolution lies between two closings of the park contact; a run that begins on the contact begins with one. Of it
    the source asks:

    1. park prediction: when the contact closes, the profile is decelerating. Literally it says RUN.turn_point_dec, yet
       the chart decelerates at the end of a revolution in Soft_stop; both readings are given. What counts is the state
       just before the contact closes, as the profile answers any park signal with Soft_stop (`Rules.early`,
       `Rules.late`).
    2. turn prediction: turn_point_acc is entered, "on the same position on the current signal" (`Rules.position`).
    3. none of turn_point_acc, turn_point_dec, Soft_start and Soft_stop is entered more than once (`Rules.repeats`).
       What is entered at the very instant of the park signal belongs to the revolution that begins there.

    Revolutions at whose end ``enable`` has fallen are left out, if it is recorded: then no end is to be predicted. No
    criterion depends on the number of a revolution.

    Args:
        source: the run, with columns ``park`` and ``state``, and ``phi_crank`` and ``enable`` if there are any.
        rules: the choices where the source is open.

    Raises:
        InputError: a column is missing or unreadable, a state is unknown, or the rows are too far apart.
    """
    rules = rules or Rules()
    record = _Record(trace(source), rules)
    turns = [turn for k in range(len(record.parks) - 1) for turn in record.turns(k)]
    usual = float(np.median([position for _, position in turns])) if turns else None
    scored = [k for k in range(len(record.parks) - 1) if record.enabled(k)]
    revolutions = tuple(_judge(record, k, number, usual) for number, k in enumerate(scored, 1))
    return Score(
        name=record.trace.name,
        rules=rules,
        revolutions=revolutions,
        unfinished_turn=_unfinished(record, usual) if rules.unfinished else None,
        notes=tuple(record.notes(left_out=len(record.parks) - 1 - len(scored))),
    )


@dataclass(frozen=True)
class _Stay:
    """A state from its entry to the first row with another [s]; one that lasts to the end ends never."""

    state: str
    start: float
    end: float


class _Record:
    """The rows of a run, as events: closings of the contact, and stays in states."""

    def __init__(self, trace: Trace, rules: Rules) -> None:
        self.trace, self.rules = trace, rules
        self.time = trace.time
        if not trace.has("state"):
            raise InputError(
                f"{trace.name}: no column 'state' nor 'component.state': only a run with a controller that has the "
                f"states of the voltage profile can be scored; another column is given by --column state=NAME"
            )
        self.state = trace.labels("state")
        self.park = trace.switch("park")
        self._check()

    def _check(self) -> None:
        name = self.trace.name
        if (step := float(np.diff(self.time).max())) > COARSEST + _SAME:
            raise InputError(
                f"{name}: rows are up to {step:.3g} s apart, too far to see when the park contact closes; "
                f"run it with --set output_interval=1ms, at most {COARSEST * 1e3:g} ms"
            )
        unknown = sorted(set(self.state.tolist()) - {*ONCE, "RUN", "IDLE"})
        if unknown:
            raise InputError(
                f"{name}: the states {', '.join(unknown)} are none of the voltage profile's: "
                f"IDLE, Soft_start, RUN, turn_point_dec, turn_point_acc, Soft_stop"
            )

    @cached_property
    def rows(self) -> int:
        """How many rows lie within the span."""
        return int(np.searchsorted(self.time, self.time[0] + self.rules.span + _SAME))

    @cached_property
    def parks(self) -> list[int]:
        """The rows at which the contact closes within the span; the first one if it is closed there."""
        closes = np.flatnonzero(self.park[1 : self.rows] & ~self.park[: self.rows - 1]) + 1
        return [*([0] if self.park[0] else []), *closes.tolist()]

    @cached_property
    def entries(self) -> NDArray[np.int64]:
        """The rows at which a state is entered, the first one among them."""
        return np.flatnonzero(np.r_[True, self.state[1:] != self.state[:-1]])

    @cached_property
    def stays(self) -> list[_Stay]:
        """The states in the order of time."""
        starts = self.time[self.entries].tolist()
        states = self.state[self.entries].tolist()
        return [_Stay(s, a, b) for s, a, b in zip(states, starts, [*starts[1:], math.inf], strict=True)]

    @cached_property
    def angle(self) -> Array | None:
        """Crank angle [rad]."""
        return self.trace.signal("phi_crank", "rad") if self.trace.has("phi_crank") else None

    def entered(self, start: int, end: int) -> list[tuple[str, int]]:
        """Return the states entered from row ``start`` on, before row ``end``, and the rows."""
        first, last = np.searchsorted(self.entries, (start, end))
        return [(str(self.state[row]), int(row)) for row in self.entries[first:last]]

    def turns(self, k: int) -> list[tuple[float, float]]:
        """Return when [s] and where (share of the revolution) turn_point_acc is entered in revolution ``k``."""
        start, end = self.parks[k], self.parks[k + 1]
        rows = [row for state, row in self.entered(start, end) if state == "turn_point_acc"]
        return [(float(self.time[row]), self.share(start, end, row)) for row in rows]

    def share(self, start: int, end: int, row: int) -> float:
        """Return how much of a revolution that begins at row ``start`` is over at ``row``."""
        if self.angle is not None:
            return float(self.angle[row] - self.angle[start]) / (2 * math.pi)
        return float((self.time[row] - self.time[start]) / (self.time[end] - self.time[start]))

    def enabled(self, k: int) -> bool:
        """Tell whether the end of revolution ``k`` is one that the profile is to predict."""
        return not self.trace.has("enable") or bool(self.trace.switch("enable")[self.parks[k + 1] - 1])

    def notes(self, left_out: int) -> list[str]:
        """Tell what a reader of the counts should know."""
        found = []
        if not self.trace.complete:
            found.append("the run ended early: its result is marked incomplete")
        covered, span = float(self.time[-1] - self.time[0]), self.rules.span
        if covered < span - _SAME:
            found.append(f"the run covers {covered:g} s of the {span:g} s that are scored")
        if not self.park[0]:
            found.append(
                "the run does not begin on the park contact; what comes before the first closing is not scored"
            )
        if left_out:
            found.append(f"{left_out} closings of the contact with enable off are not scored")
        if len(self.parks) < 2:
            found.append("the park contact closes too rarely for a whole revolution: nothing to score")
        if self.angle is not None:
            for start, end in zip(self.parks, self.parks[1:], strict=False):
                turned = float(self.angle[end] - self.angle[start]) / (2 * math.pi)
                if abs(turned - 1) > 0.5:
                    found.append(
                        f"between the closings at {self.time[start]:.3f} s and {self.time[end]:.3f} s the crank turned "
                        f"{turned:.2f} times, not once"
                    )
        return found


def _judge(record: _Record, k: int, number: int, usual: float | None) -> Revolution:
    start, end = record.parks[k], record.parks[k + 1]
    began, ended = float(record.time[start]), float(record.time[end])
    rules = record.rules
    failures: list[Failure] = []

    literal, decelerating = (_predicted(record, ended, states) for states in (DECELERATIONS[:1], DECELERATIONS))
    before = str(record.state[end - 1])
    ended_before, began_after = _gaps(record, began, ended)
    if not decelerating:
        failures.append(Failure(1, number, ended, _why_not_predicted(before, ended_before, began_after)))
    elif not literal:
        failures.append(Failure(1, number, ended, f"in {before}; no turn_point_dec at the signal", "literal"))

    turns = record.turns(k)
    turned = usual is not None and any(abs(position - usual) <= rules.position for _, position in turns)
    if not turns:
        failures.append(Failure(2, number, ended, "no turn_point_acc since the last park signal"))
    elif not turned:
        at, position = turns[0]
        failures.append(
            Failure(2, number, at, f"turned after {position:.2f} of the revolution, where {usual:.2f} is usual")
        )

    entered = record.entered(start, end)
    occurrences = {state: sum(name == state for name, _ in entered) for state in ONCE}
    repeated = [state for state in ONCE if occurrences[state] > 1]
    for state in repeated:
        again = [float(record.time[row]) for name, row in entered if name == state][1]
        failures.append(Failure(3, number, again, f"{state} {occurrences[state]} times since the last park signal"))

    grouped = rules.repeats == "grouped"
    once_at_park = not (grouped and {"Soft_start", "Soft_stop"} & set(repeated))
    once_at_turn = not (grouped and {"turn_point_acc", "turn_point_dec"} & set(repeated))
    return Revolution(
        number=number,
        start=began,
        end=ended,
        state_at_park=before,
        park_literal=literal and once_at_park,
        park_deceleration=decelerating and once_at_park,
        ended_before=ended_before,
        began_after=began_after,
        turn=turned and once_at_turn,
        turn_time=turns[0][0] if turns else None,
        turn_position=turns[0][1] if turns else None,
        occurrences=occurrences,
        failures=tuple(sorted(failures, key=lambda failure: failure.time)),
    )


def _predicted(record: _Record, park: float, states: Sequence[str]) -> bool:
    """Tell whether one of the states holds at the park signal [s], within the tolerances of the rules."""
    early, late = record.rules.early, record.rules.late
    return any(
        stay.state in states
        and (stay.start < park - _SAME or (late > 0 and stay.start <= park + late + _SAME))
        and stay.end >= park - early - _SAME
        for stay in record.stays
    )


def _gaps(record: _Record, began: float, park: float) -> tuple[float | None, float | None]:
    """Return how far before and after the park signal at ``park`` [s] the nearest decelerations are [s].

    Those farther away than a quarter of the revolution, which began at ``began`` [s], are those of its turn.
    """
    near = _NEAR * (park - began)
    stays = [stay for stay in record.stays if stay.state in DECELERATIONS]
    earlier = [stay.end for stay in stays if stay.start < park - _SAME and stay.end > park - near]
    later = [stay.start for stay in stays if park - _SAME <= stay.start < park + near]
    return max(0.0, park - earlier[-1]) if earlier else None, max(0.0, later[0] - park) if later else None


def _why_not_predicted(before: str, ended_before: float | None, began_after: float | None) -> str:
    """Tell in which state the park signal found the profile, and when that decelerated instead."""
    texts = [f"in {before}"]
    if ended_before is not None:
        texts.append(f"the deceleration had ended {_gap(ended_before)} before the signal")
    if began_after is not None:
        late = "at" if began_after < _SAME else f"{_gap(began_after)} after"
        texts.append(f"a deceleration began {late} the signal")
    return "; ".join(texts if len(texts) > 1 else [*texts, "no deceleration near the signal"])


def _gap(seconds: float) -> str:
    return f"{seconds * 1e3:.0f} ms" if seconds < 0.1 else f"{seconds:.2f} s"


def _unfinished(record: _Record, usual: float | None) -> bool | None:
    """Return the turn of the revolution that the span cuts off; None if it has not turned and need not have."""
    if not record.parks:
        return None
    start, end = record.parks[-1], record.rows
    times = record.time
    if record.angle is None:
        lengths = np.diff(times[record.parks])
        if not len(lengths):
            return None
        length = float(np.median(lengths))
        shares = [float(times[row] - times[start]) / length for row in range(start, end)]
    else:
        shares = ((record.angle[start:end] - record.angle[start]) / (2 * math.pi)).tolist()
    positions = [shares[row - start] for state, row in record.entered(start, end) if state == "turn_point_acc"]
    if positions:
        return usual is None or any(abs(position - usual) <= record.rules.position for position in positions)
    late = 1.0 if usual is None else usual + min(record.rules.position, 1.0)
    return False if shares and shares[-1] > late else None
