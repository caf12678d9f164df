"""What a system structure says: systems, components, connectors, connections and parameter bindings, with places."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from cosim.engine import Interface
from cosim.ssp._package import Location
from cosim.ssp._xml import Place
from cosim.units import Unit

REAL = ("Real", "Float64", "Float32")
INTEGER = ("Integer", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64")


def plain_type(name: str) -> str:
    """Return the type without its width: ``Real`` for ``Float64``, ``Integer`` for ``UInt8``."""
    return "Real" if name in REAL else "Integer" if name in INTEGER else name


@dataclass(frozen=True)
class Transformation:
    """What is done to a value after the conversion of its unit.

    ``kind`` is ``Linear`` (``target = factor * source + offset``), ``Boolean``, ``Integer`` or ``Enumeration``; for the
    last three ``table`` has the values that change.
    """

    kind: str
    factor: float = 1.0
    offset: float = 0.0
    table: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Connector:
    """A connector; ``type`` and ``unit`` are None where the file leaves them to the variable behind it."""

    name: str
    kind: str
    type: str | None
    unit: Unit | None
    place: Place


@dataclass(frozen=True)
class Link:
    """A connection as written: both ends are (element, connector), the element None for the system itself."""

    start: tuple[str | None, str]
    end: tuple[str | None, str]
    keeps_unit: bool
    transformation: Transformation | None
    place: Place


@dataclass(frozen=True)
class Parameter:
    """A value of a parameter set, as text; ``type`` without its width."""

    name: str
    type: str
    value: str
    unit: Unit | None
    place: Place


@dataclass(frozen=True)
class MappingEntry:
    """A parameter ``source`` of a set sets ``target`` of the system."""

    source: str
    target: str
    keeps_unit: bool
    transformation: Transformation | None
    place: Place


@dataclass(frozen=True)
class Binding:
    """A parameter set, with a prefix for its names; without a ``mapping`` it sets what has its parameters' names."""

    parameters: tuple[Parameter, ...]
    prefix: str
    mapping: tuple[MappingEntry, ...] | None
    origin: str
    place: Place


@dataclass
class Element:
    """What components and systems have in common."""

    name: str
    place: Place
    connectors: dict[str, Connector]
    arrays: dict[str, list[str]]
    """The connectors that are the elements of an array, by its name."""
    bindings: list[Binding]


@dataclass
class ComponentElement(Element):
    """An FMU in a system; ``interface`` is None where either will do."""

    source: Location
    interface: Interface | None = None


@dataclass
class SystemElement(Element):
    """A system of components and systems."""

    elements: dict[str, Element] = field(default_factory=dict)
    links: list[Link] = field(default_factory=list)


@dataclass
class Structure:
    """An SSD with all that it refers to; times in s, None where the file gives none."""

    root: SystemElement
    location: Location
    start: float | None = None
    stop: float | None = None
