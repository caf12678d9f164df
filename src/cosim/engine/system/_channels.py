"""Channels as the loop needs them: a list of changes at instants, and interpolation."""

from __future__ import annotations

import math
from array import array
from bisect import bisect_left, bisect_right
from collections.abc import Sequence

from cosim.engine.system._system import SAME_INSTANT, Channel


def first_value(channel: Channel, start: float) -> float:
    """Return the value at initialisation: the first entry's if it is at t = 0, else the input's start value."""
    return float(channel.values[0]) if channel.times[0] <= SAME_INSTANT else start


class Line:
    """A linear channel: its signal ``slot`` holds the value at an instant, ``middle`` that in the middle of a step."""

    def __init__(self, channel: Channel, slot: int, middle: int, start: float) -> None:
        """Keep the table; ``start`` holds before its first entry."""
        self.slot = slot
        self.middle = middle
        self.times = channel.times
        self.values = channel.values
        self.start = start

    def at(self, t: float) -> float:
        """Return the value at t [s], after a step at t."""
        last = bisect_right(self.times, t + SAME_INSTANT) - 1
        if last < 0:
            return self.start
        if last == len(self.times) - 1:
            return self.values[last]
        t0, t1 = self.times[last], self.times[last + 1]
        y0, y1 = self.values[last], self.values[last + 1]
        return y0 + (y1 - y0) * max(0.0, t - t0) / (t1 - t0)

    def before(self, t: float) -> float:
        """Return the value at t [s], before a step at t."""
        first = bisect_left(self.times, t - SAME_INSTANT)
        if first == 0 and t > SAME_INSTANT:
            return self.start
        if first < len(self.times) and self.times[first] <= t + SAME_INSTANT:
            return self.values[first]
        return self.at(t)


class Schedule:
    """The changes of all hold channels and the corners of the linear ones, as instants in rising order.

    ``next`` is the time [s] of the first change that was not yet applied, infinite after the last; ``position`` is how
    many were applied.
    """

    def __init__(self, holds: Sequence[tuple[Channel, int]], lines: Sequence[Line]) -> None:
        """Merge the channels, each with the slot of its signal."""
        changes: list[tuple[float, int, float]] = []
        for channel, slot in holds:
            changes += [(time, slot, float(value)) for time, value in zip(channel.times, channel.values, strict=True)]
        corners = [(time, -1, 0.0) for line in lines for time in line.times]
        self.changes = sorted(changes + corners, key=lambda change: change[0])
        self.position = 0
        self._look()

    def skip(self, t: float) -> None:
        """Take all changes up to t [s] as applied, and no others."""
        self.position = bisect_right(self.changes, t + SAME_INSTANT, key=lambda change: change[0])
        self._look()

    def _look(self) -> None:
        ended = self.position == len(self.changes)
        self.next = math.inf if ended else self.changes[self.position][0]

    def apply(self, t: float, values: array[float]) -> None:
        """Put all changes up to t [s], and not yet applied, into the signals; of two at one time the second stays."""
        while self.next <= t + SAME_INSTANT:
            _, slot, value = self.changes[self.position]
            if slot >= 0:
                values[slot] = value
            self.position += 1
            self._look()
