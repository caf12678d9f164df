"""What a rule is, and the list of all of them: each is one small function that yields what it has found."""

from __future__ import annotations

import enum
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Generic, NamedTuple, TypeVar


class Severity(enum.IntEnum):
    """How bad a finding is.

    An error is against the standard and can give wrong results or a refusal; a warning is against the standard or
    good practice, and importers can live with it; a note is only worth knowing.
    """

    NOTE = 1
    WARNING = 2
    ERROR = 3


class Found(NamedTuple):
    """What a rule has found, ``where`` (a member, a line, a variable; empty: the FMU), and what to do about it."""

    what: str
    where: str = ""
    remedy: str = ""


@dataclass(frozen=True)
class Finding:
    """A rule's finding, as it is shown."""

    rule: str
    severity: Severity
    what: str
    where: str
    remedy: str


T = TypeVar("T")
Body = Callable[[T], Iterator[Found]]


@dataclass(frozen=True)
class Rule(Generic[T]):
    """A rule: its ``id``, how bad its findings are, what it looks at, and its sentence for the documentation."""

    id: str
    severity: Severity
    body: Body[T]
    instances: int = 1

    @property
    def text(self) -> str:
        """The first line of the rule's docstring: what has to be so."""
        return (self.body.__doc__ or "").strip().splitlines()[0]

    def finding(self, found: Found) -> Finding:
        """Return what was found with the rule's name and severity."""
        return Finding(self.id, self.severity, found.what, found.where, found.remedy)

    def apply(self, subject: T) -> list[Finding]:
        """Return the rule's findings in a subject."""
        return [self.finding(found) for found in self.body(subject)]


class Rules(list[Rule[T]]):
    """Rules of one kind, in the order in which they are applied."""

    def __call__(self, name: str, severity: Severity, *, instances: int = 1) -> Callable[[Body[T]], Body[T]]:
        """Add a function as a rule; ``instances`` are as many as it makes of the FMU, one after another."""

        def add(body: Body[T]) -> Body[T]:
            self.append(Rule(name, severity, body, instances))
            return body

        return add


def shortened(items: list[str], most: int = 5) -> str:
    """Return the first items and how many more there are."""
    more = len(items) - most
    return ", ".join(items[:most]) + (f" and {more} more" if more > 0 else "")
