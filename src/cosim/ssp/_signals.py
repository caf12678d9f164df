"""What happens to a value on its way from connector to connector: units converted, then transformed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from cosim.engine import Variable
from cosim.errors import InputError
from cosim.ssp._model import Transformation
from cosim.ssp._xml import Place
from cosim.units import Unit, linear_map

Table = tuple[tuple[float, float], ...]
"""Pairs of a value and what takes its place; values that are not listed stay."""


@dataclass(frozen=True)
class Hop:
    """One connection of a chain; ``unit`` is that of the connector it leads to, None if it gives none."""

    keeps_unit: bool
    transformation: Transformation | None
    unit: Unit | None
    place: Place
    text: str


@dataclass(frozen=True)
class Signal:
    """``target = factor * source + offset``, or by ``table``; ``unit`` is that of the target, as far as known."""

    factor: float
    offset: float
    table: Table
    unit: Unit | None


def compose(
    unit: Unit | None, hops: Sequence[Hop], source: Variable | None = None, target: Variable | None = None
) -> Signal:
    """Follow a value of a ``unit`` over connections.

    ``source`` and ``target`` have the literals that tables of enumeration items need. Raises `InputError` for units
    that do not fit each other.
    """
    factor, offset = 1.0, 0.0
    tables: list[dict[float, float]] = []
    for hop in hops:
        for f, o in _linear(unit, hop):
            factor, offset = f * factor, f * offset + o
        if hop.transformation is not None and hop.transformation.kind != "Linear":
            tables.append(_table(hop.transformation, source, target, hop.place))
        unit = unit_after(unit, hop)
    if tables and (factor, offset) != (1.0, 0.0):
        raise hops[-1].place.fail(f"{hops[-1].text}: a mapping of values cannot follow a linear transformation")
    return Signal(factor, offset, _composed(tables), unit)


def unit_after(unit: Unit | None, hop: Hop) -> Unit | None:
    """Return the unit in which a value arrives."""
    return hop.unit if hop.unit is not None or hop.keeps_unit else unit


def _linear(unit: Unit | None, hop: Hop) -> Iterable[tuple[float, float]]:
    """Give factor and offset of the conversion of the unit, and of the transformation, where they do something."""
    if unit is not None and hop.unit is not None and not hop.keeps_unit:
        try:
            conversion = linear_map(unit, hop.unit)
        except InputError as error:
            raise hop.place.fail(
                f"{hop.text}: {error}; correct a unit, or set suppressUnitConversion to take the numbers as they are"
            ) from error
        if conversion != (1.0, 0.0):
            yield conversion
    if hop.transformation is not None and hop.transformation.kind == "Linear":
        yield hop.transformation.factor, hop.transformation.offset


def _composed(tables: Sequence[Mapping[float, float]]) -> Table:
    def follow(value: float) -> float:
        for table in tables:
            value = table.get(value, value)
        return value

    sources = sorted({value for table in tables for value in table})
    return tuple((value, follow(value)) for value in sources if follow(value) != value)


def _table(
    transformation: Transformation, source: Variable | None, target: Variable | None, place: Place
) -> dict[float, float]:
    if transformation.kind != "Enumeration":
        return {float(a): float(b) for a, b in transformation.table.items()}
    if source is None or target is None or source.literals is None or target.literals is None:
        raise place.fail("EnumerationMappingTransformation needs an enumeration with named items at both ends")
    found: dict[float, float] = {}
    for one, other in transformation.table.items():
        found[_literal(one, source, place)] = _literal(other, target, place)
    return found


def _literal(name: str, variable: Variable, place: Place) -> float:
    literals = variable.literals or ()
    if name not in literals:
        raise place.fail(f"'{name}' is no item of the enumeration of '{variable.name}'; it has {', '.join(literals)}")
    return float(literals.index(name) + 1)
