"""What the scoring of a run returns: a verdict for each revolution, and the counts of table 4.1."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Literal

from cosim.assessment._rules import Rules


@dataclass(frozen=True)
class Failure:
    """A criterion that was not met: which of the three, when [s], and why.

    ``reading`` is "literal" if the park criterion is failed in its literal reading only, else "both".
    """

    criterion: Literal[1, 2, 3]
    revolution: int
    time: float
    reason: str
    reading: Literal["literal", "both"] = "both"


@dataclass(frozen=True)
class Revolution:
    """The time between two closings of the park contact, and what the criteria say of it."""

    number: int
    """Counted from 1, for display; no criterion depends on it."""
    start: float
    """When the contact on which it began closed, or the run began on it [s]."""
    end: float
    """When the contact closed again [s]."""
    state_at_park: str
    """State of the profile just before ``end``."""
    park_literal: bool
    """Park prediction, literal reading: the state at the park signal is turn_point_dec."""
    park_deceleration: bool
    """Park prediction, reading "deceleration": it is turn_point_dec or Soft_stop."""
    ended_before: float | None
    """How long before ``end`` the deceleration was over [s]; 0 if it lasted until then.

    None if there was none within a quarter of a revolution.
    """
    began_after: float | None
    """How long after ``end`` the next deceleration began [s]; None as before."""
    turn: bool
    """Turn prediction."""
    turn_time: float | None
    """When turn_point_acc was first entered [s], None if it was not."""
    turn_position: float | None
    """The same as a share of the revolution, from the crank angle if it is recorded, else from time."""
    occurrences: Mapping[str, int]
    """How often each state of criterion 3 was entered."""
    failures: tuple[Failure, ...]


@dataclass(frozen=True)
class Counts:
    """A line of table 4.1: successes and how many there could be, the park prediction in both readings."""

    park_literal: int
    park_deceleration: int
    park_total: int
    turn: int
    turn_total: int


@dataclass(frozen=True)
class Score:
    """The revolutions of a run that were scored, in the order of time, and what is worth knowing about them.

    ``unfinished_turn`` is the turn of the revolution that the span cuts off: None if it does not count.
    """

    name: str
    rules: Rules
    revolutions: tuple[Revolution, ...]
    unfinished_turn: bool | None = None
    notes: tuple[str, ...] = ()

    @property
    def failures(self) -> list[Failure]:
        """All failures, in the order of time."""
        return sorted((f for r in self.revolutions for f in r.failures), key=lambda failure: failure.time)

    @property
    def counts(self) -> Counts:
        """The counts of all revolutions."""
        return self._count(self.revolutions)

    @property
    def counts_without_first(self) -> Counts:
        """The counts without the first revolution, before which no period can have been measured."""
        return self._count(self.revolutions[1:])

    def _count(self, revolutions: tuple[Revolution, ...]) -> Counts:
        return Counts(
            park_literal=sum(r.park_literal for r in revolutions),
            park_deceleration=sum(r.park_deceleration for r in revolutions),
            park_total=len(revolutions),
            turn=sum(r.turn for r in revolutions) + bool(self.unfinished_turn),
            turn_total=len(revolutions) + (self.unfinished_turn is not None),
        )

    def to_dict(self) -> dict[str, object]:
        """Return everything as plain texts, lists and numbers, for JSON."""
        rules = {key: "inf" if value == float("inf") else value for key, value in asdict(self.rules).items()}
        return {
            "name": self.name,
            "rules": rules,
            "counts": asdict(self.counts),
            "counts_without_first": asdict(self.counts_without_first),
            "unfinished_turn": self.unfinished_turn,
            "revolutions": [asdict(r) | {"occurrences": dict(r.occurrences)} for r in self.revolutions],
            "notes": list(self.notes),
        }
