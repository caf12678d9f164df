"""What connects a signal to an input."""

from __future__ import annotations

from typing import NamedTuple


class Wire(NamedTuple):
    """``inputs[target] = factor * values[source] + offset``, or what ``table`` has in the place of that."""

    target: int
    source: int
    factor: float
    offset: float
    table: tuple[tuple[float, float], ...] = ()

    def translated(self, source: float) -> float:
        """Return what the wire makes of a value of its source."""
        value = source * self.factor + self.offset
        return dict(self.table).get(value, value) if self.table else value
