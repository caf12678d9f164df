"""A connection between two components."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass
class Connection:
    """``target = factor * source + offset``; both ends are (component, variable).

    ``table``, between whole numbers, Booleans and enumerations only, has pairs of a source's value and what the target
    gets in its place; values that are not in it are handed on as they are.
    """

    source: tuple[str, str]
    target: tuple[str, str]
    factor: float = 1.0
    offset: float = 0.0
    table: tuple[tuple[float, float], ...] = ()


def dotted(end: tuple[str, str]) -> str:
    """Return the name of a variable of a component as the user writes it: "plant.duty"."""
    return ".".join(end)
