"""Faults at work: what the faulty inputs get, in plain Python over the state that the native loop uses, too.

At each communication point t ``arrive`` comes first, before channels and discrete components change anything: the
signals are what led to t, and faults begin, end and go on to their next period. In the exchange that follows, and in
the step from t on, ``value`` gives what an input gets, and changes nothing. ``settle`` comes last: it writes down what
the signals are from t on, for delays, and finds the next instant at which a fault does something.

The history of a delayed signal is a line through points; two points of one time are a step. A signal that holds its
value between communication points has its points at its steps only.
"""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from math import inf
from sys import float_info

from cosim.engine.native._structures import FaultClock, FaultState
from cosim.engine.system._channels import Line
from cosim.engine.system._fault import KINDS, Fault
from cosim.engine.system._system import SAME_INSTANT
from cosim.engine.system._wire import Wire

MOST_NEW_POINTS = 4
"""Points that a macro step may add to a history."""

_FIRST_CAPACITY = 64
_NUDGE = 1e-6
"""Of a value, by which it is changed to see what a fault makes of it."""

_WHOLE = 2.0**52
"""From here on all doubles are whole numbers."""


class SignalFault:
    """One fault of an input.

    ``draws`` are its random numbers: noise in the input's unit, or 1 where a value is lost; the first is for the time
    up to ``boundary`` times its period, each of the others for a period. ``watch`` is the time [s] from which on it
    looks at the signal: for drops, the last instant before its start at which a value arrives. ``points`` are pairs of
    time [s] and value of which ``state.first`` to ``state.count`` are in use.
    """

    def __init__(self, fault: Fault, watch: float, boundary: int, draws: Sequence[float], stepwise: bool) -> None:
        """Make room; ``stepwise`` tells whether the signal keeps its value between communication points."""
        self.kind = KINDS.index(fault.kind)
        self.is_delay, self.is_drop = fault.kind == "delay", fault.kind == "drop"
        self.amount, self.start, self.stop = fault.amount, fault.start, fault.stop
        self.every = fault.every or inf
        self.watch = watch
        self.boundary = boundary
        self.draws = array("d", draws)
        self.stepwise = stepwise
        self.points = array("d", bytes(16 * _FIRST_CAPACITY if self.is_delay else 0))
        self.state = FaultState(period=-1)
        if fault.kind in ("override", "bias", "scale", "quantise", "noise") and fault.start <= SAME_INSTANT:
            self.state.active, self.state.period = 1, 0  # also while the system is initialised

    @property
    def capacity(self) -> int:
        """How many points there is room for."""
        return len(self.points) // 2

    def output(self, given: float, t: float, before: bool = False) -> float:
        """Return what the fault makes of a value at t [s], or ``before`` what happens at t."""
        if not self.state.active:
            return given
        match KINDS[self.kind]:
            case "override":
                return self.amount
            case "bias":
                return given + self.amount
            case "scale":
                return given * self.amount
            case "freeze":
                return self.state.kept
            case "delay":
                return self._earlier(t - self.amount, before)
            case "drop":
                return given if self.state.passing else self.state.kept
            case "quantise":
                steps = given / self.amount
                return self.amount * (float(round(steps)) if abs(steps) < _WHOLE else steps)
            case "noise":
                return given + self.draws[self.state.period]

    def go_to(self, t: float, given: float) -> None:
        """Begin, end, or go on to the period that begins at t [s]; ``given`` is the signal that has led to t."""
        state = self.state
        if self.is_delay and not (self.stepwise and state.count):
            self._note_course(t, given)
        state.passing = 0
        if state.period < 0 and t >= self.watch - SAME_INSTANT:
            state.period, state.kept = 0, given
            state.passing = self.is_drop and t < self.start - SAME_INSTANT
        if self.start - SAME_INSTANT <= t < self.stop - SAME_INSTANT:
            state.active = 1
            if self.is_drop and state.period == 0 and t <= self.start + SAME_INSTANT:
                state.passing = self.draws[0] == 0.0
            while (self.boundary + state.period) * self.every <= t + SAME_INSTANT:
                state.period += 1
                if self.is_drop and self.draws[state.period] == 0.0:
                    state.passing = 1
        else:
            state.active = 0
        if self.is_delay:
            self._forget(t - self.amount)

    def settle(self, t: float, given: float) -> None:
        """Take the signal as it is from t [s] on."""
        state = self.state
        if self.is_delay:
            self._note_step(t, given)
        if state.passing:
            state.kept, state.passing = given, 0

    def next_instant(self, t: float) -> float:
        """Return when it does something after t [s] that changes the signal between two communication points."""
        if t < self.start - SAME_INSTANT:
            return self.watch if self.state.period < 0 else self.start
        if t >= self.stop - SAME_INSTANT:
            return inf
        following = self._next_step(t) if self.is_delay else (self.boundary + self.state.period) * self.every
        return min(following, self.stop)

    def make_room(self) -> bool:
        """Move the points in use to the front if the end is near; tell whether there is room for a macro step."""
        state = self.state
        if not self.is_delay or state.count + MOST_NEW_POINTS <= self.capacity:
            return True
        live = self.points[2 * state.first : 2 * state.count]
        self.points[: len(live)] = live
        state.jump -= state.first
        state.count -= state.first
        state.first = 0
        return 2 * state.count <= self.capacity

    def grow(self) -> None:
        """Double the memory for points: they lie elsewhere from then on."""
        self.points.extend(array("d", bytes(8 * len(self.points))))

    def _time(self, index: int) -> float:
        return self.points[2 * index]

    def _value(self, index: int) -> float:
        return self.points[2 * index + 1]

    def _append(self, t: float, value: float) -> None:
        count = self.state.count
        self.points[2 * count], self.points[2 * count + 1] = t, value
        self.state.count = count + 1

    def _note_course(self, t: float, value: float) -> None:
        """Note where the signal has come to; three points of one value in a row need two."""
        last = self.state.count - 1
        if last > self.state.first and self._value(last) == value and self._value(last - 1) == value:
            self.points[2 * last] = t
        else:
            self._append(t, value)

    def _note_step(self, t: float, value: float) -> None:
        last = self.state.count - 1
        if last < 0:
            self._append(t, value)
        elif self._value(last) != value:
            if self._time(last) != t:
                self._append(t, self._value(last))
            self._append(t, value)

    def _forget(self, t: float) -> None:
        """Drop the points before the last one that is at t [s] or earlier, and of two at t neither."""
        state = self.state
        while state.first + 1 < state.count and self._time(state.first + 1) < t - SAME_INSTANT:
            state.first += 1
        state.jump = max(state.jump, state.first)

    def _earlier(self, t: float, before: bool) -> float:
        """Return the value at t [s]; ``before`` tells which side of a step at t is meant."""
        state = self.state
        if before:
            after = state.first
            while after < state.count and self._time(after) < t - SAME_INSTANT:
                after += 1
            if after == state.count:
                return self._value(after - 1)
            if after == state.first or self._time(after) <= t + SAME_INSTANT:
                return self._value(after)
        else:
            after = state.first
            while after < state.count and self._time(after) <= t + SAME_INSTANT:
                after += 1
            if after == state.first:
                return self._value(after)
            if after == state.count or self._time(after - 1) >= t - SAME_INSTANT:
                return self._value(after - 1)
        t0, t1 = self._time(after - 1), self._time(after)
        y0, y1 = self._value(after - 1), self._value(after)
        return y0 + (y1 - y0) * ((t - t0) / (t1 - t0))

    def _next_step(self, t: float) -> float:
        """Return when the next step of the signal comes out of the delay after t [s]."""
        state = self.state
        while state.jump + 1 < state.count:
            time = self._time(state.jump)
            if time == self._time(state.jump + 1) and time + self.amount > t + SAME_INSTANT:
                return time + self.amount
            state.jump += 1
        return inf


class FaultyInput:
    """An input with faults: its signal ``slot``, and where what drives it lies.

    ``at`` reads what drives it at a communication point, ``held`` in a step between two; both differ for a linear
    channel, which is ``line``, and for a ``linked`` input: one of a component that is stepped together with its source.
    ``triggers`` tells that a change of it is an event for a component with event mode.
    """

    def __init__(
        self, slot: int, *, at: Wire, held: Wire, line: Line | None, faults: list[SignalFault], triggers: bool
    ) -> None:
        """Keep them."""
        self.slot = slot
        self.at, self.held = at, held
        self.line = line
        self.faults = faults
        self.triggers = triggers
        self.linked = False

    def slope(self, values: Sequence[float]) -> float:
        """Return how it changes with what drives it, at t = 0."""
        given = self.at.translated(values[self.at.source])
        width = max(_NUDGE * (abs(given) or 1.0), float_info.min)
        return self.at.factor * (self._faulty(given + width, 0.0) - self._faulty(given, 0.0)) / width

    def _faulty(self, value: float, t: float) -> float:
        for fault in self.faults:
            value = fault.output(value, t)
        return value


class SignalFaults:
    """All faulty inputs of a run.

    ``clock.next`` is the next instant [s] at which a fault does something; ``clock.changed`` tells that one has, to a
    linked input.
    """

    def __init__(self, inputs: Sequence[FaultyInput], values: array[float]) -> None:
        """Start before t = 0."""
        self.inputs = list(inputs)
        self.clock = FaultClock(next=inf)
        self._values = values

    @property
    def states(self) -> list[FaultState]:
        """What changes while a run goes on, beside the clock and the histories."""
        return [fault.state for one in self.inputs for fault in one.faults]

    def refresh(self, inputs: Sequence[FaultyInput]) -> None:
        """Compute what these inputs get now."""
        stepping, t = self.clock.stepping, self.clock.time
        for one in inputs:
            wire = one.held if stepping else one.at
            value = wire.translated(self._values[wire.source])
            for fault in one.faults:
                value = fault.output(value, t)
            self._values[one.slot] = value

    def begin_step(self, now: float, h: float) -> None:
        """From now [s] on inputs are asked for a step over h [s], in which they act with their values in the middle."""
        self.clock.time, self.clock.until, self.clock.stepping = now + 0.5 * h, now + h, 1

    def at_end(self, one: FaultyInput, given: float) -> float:
        """Return what an input would get at the end of the step, from a value of what drives it."""
        for fault in one.faults:
            given = fault.output(given, self.clock.until)
        return given

    def arrive(self, t: float) -> None:
        """Go to t [s], the signals being what has led there."""
        self.clock.time, self.clock.stepping = t, 0
        for one in self.inputs:
            value = one.at.translated(self._values[one.at.source] if one.line is None else one.line.before(t))
            for fault in one.faults:
                given = value
                value = fault.output(given, t, before=True)
                if one.linked and t >= fault.state.next - SAME_INSTANT:
                    self.clock.changed = 1
                fault.go_to(t, given)

    def settle(self, t: float) -> None:
        """Take what the signals are from t [s] on."""
        following = inf
        for one in self.inputs:
            value = one.at.translated(self._values[one.at.source])
            for fault in one.faults:
                given = value
                value = fault.output(given, t)
                fault.settle(t, given)
                fault.state.next = fault.next_instant(t)
                following = min(following, fault.state.next)
                if not fault.make_room():
                    fault.grow()
            self._values[one.slot] = value
        self.clock.next = following
