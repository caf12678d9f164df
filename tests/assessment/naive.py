"""The criteria once more, row by row: slow, and written from section 4.5 alone, with the plainest choices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

DECELERATIONS = {"turn_point_dec", "Soft_stop"}


@dataclass
class Cycle:
    """What was seen between two closings of the contact: the states entered, and the state before the second one."""

    entered: list[str] = field(default_factory=list)
    at_park: str = ""

    @property
    def repeated(self) -> set[str]:
        watched = ("turn_point_acc", "turn_point_dec", "Soft_start", "Soft_stop")
        return {state for state in watched if self.entered.count(state) > 1}


def cycles_of(states: Sequence[str], parks: Sequence[bool], rows: int) -> list[Cycle]:
    """Go through the first ``rows`` rows; what lies after the last closing is no cycle."""
    done: list[Cycle] = []
    current = Cycle() if parks[0] else None
    for k in range(rows):
        if k and parks[k] and not parks[k - 1]:
            if current is not None:
                current.at_park = states[k - 1]
                done.append(current)
            current = Cycle()
        if current is not None and (k == 0 or states[k] != states[k - 1]):
            current.entered.append(states[k])
    return done
