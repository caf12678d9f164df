"""Nested systems flattened: components by dotted names, and each of their inputs traced back to what drives it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

from cosim.engine import Component, Connection, Fmu, Variable
from cosim.errors import InputError
from cosim.ssp._model import ComponentElement, Connector, Link, Structure, SystemElement
from cosim.ssp._package import read_fmu
from cosim.ssp._signals import Hop, Table, compose
from cosim.units import Unit, parse

Path = tuple[str, ...]
"""The names of the systems that lead to an element, and its own; that of the root is empty."""
Key = tuple[Path, str]
"""A connector: the path of its element, and its name."""
End = tuple[str, str]
"""A component's name and its variable's name."""

_OUT = ("output", "calculatedParameter", "local", "constant")
_IN = ("input", "parameter", "structuralParameter")
# The kind of a connector for each causality of the variable behind it.
_KINDS = {"structuralParameter": ("structuralParameter", "parameter")}


@dataclass(frozen=True)
class Tap:
    """An input that a connector of the whole system drives: ``target = factor * value + offset``, or by ``table``."""

    target: End
    factor: float
    offset: float
    table: Table


@dataclass(frozen=True)
class Input:
    """An input connector of the whole system, which a scenario may drive."""

    name: str
    type: str
    unit: Unit | None
    literals: tuple[str, ...] | None
    taps: tuple[Tap, ...]


@dataclass
class Leaf:
    """A component's input or parameter connector, with the chain of connectors that leads to it, from its origin."""

    end: End
    variable: Variable
    chain: list[tuple[Key, Hop | None]]


@dataclass
class Flat:
    """A structure without its hierarchy. ``fmus`` and ``elements`` are those of the components by path."""

    structure: Structure
    elements: dict[Path, ComponentElement] = field(default_factory=dict)
    fmus: dict[Path, Fmu] = field(default_factory=dict)
    connectors: dict[Key, Connector] = field(default_factory=dict)
    incoming: dict[Key, tuple[Key, Link]] = field(default_factory=dict)
    leaves: list[Leaf] = field(default_factory=list)

    @property
    def components(self) -> list[Component]:
        """The components under their dotted names, in the order of the files."""
        return [Component(".".join(path), fmu) for path, fmu in self.fmus.items()]

    def variable(self, key: Key) -> Variable | None:
        """Return the variable behind a connector of a component."""
        return self.fmus[key[0]].variables[key[1]] if key[0] in self.fmus else None

    def unit(self, key: Key) -> Unit | None:
        """Return the unit of a connector: that of the variable behind it, if it is understood, or its own."""
        variable = self.variable(key)
        known = None if variable is None else unit_of(variable)
        return self.connectors[key].unit if known is None and key in self.connectors else known


def unit_of(variable: Variable) -> Unit | None:
    """Return the unit that an FMU gives; None if it gives none, or one that only its maker understands."""
    try:
        return None if variable.unit is None else parse(variable.unit)
    except InputError:
        return None


def flatten(structure: Structure) -> Flat:
    """Read the FMUs of a structure and trace its connections. Raises `InputError` for what cannot be connected."""
    flat = Flat(structure)
    _collect(flat, structure.root, (), {})
    if not flat.fmus:
        raise structure.root.place.fail("the structure has no component that is an FMU; there is nothing to run")
    _check_names(flat)
    for key, connector in flat.connectors.items():
        variable = flat.variable(key)
        if variable is not None and connector.kind in _IN:
            chain = _chain(flat, key)
            flat.leaves.append(Leaf((".".join(key[0]), key[1]), variable, chain))
    return flat


def connections(flat: Flat) -> list[Connection]:
    """Return what components drive components, in the order of the inputs."""
    found: list[Connection] = []
    for leaf in flat.leaves:
        origin = leaf.chain[0][0]
        source = flat.variable(origin)
        if len(leaf.chain) == 1 or source is None:
            continue
        hops = [hop for _, hop in leaf.chain if hop is not None]
        if leaf.variable.causality != "input" or source.causality != "output":
            raise hops[-1].place.fail(
                f"{hops[-1].text}: a {source.causality} cannot drive a {leaf.variable.causality}; values are handed on "
                "from outputs to inputs only"
            )
        signal = compose(flat.unit(origin), hops, source, leaf.variable)
        end = (".".join(origin[0]), origin[1])
        found.append(Connection(end, leaf.end, signal.factor, signal.offset, signal.table))
    return found


def inputs(flat: Flat) -> dict[str, Input]:
    """Return the input connectors of the whole system by name."""
    return {
        name: _input(flat, connector)
        for name, connector in flat.structure.root.connectors.items()
        if connector.kind == "input"
    }


def _input(flat: Flat, connector: Connector) -> Input:
    key: Key = ((), connector.name)
    taps: list[Tap] = []
    leaves = [leaf for leaf in flat.leaves if leaf.chain[0][0] == key and leaf.variable.causality == "input"]
    unit = connector.unit
    for leaf in leaves:
        hops = [hop for _, hop in leaf.chain if hop is not None]
        signal = compose(connector.unit, hops, target=leaf.variable)
        taps.append(Tap(leaf.end, signal.factor, signal.offset, signal.table))
        if connector.unit is None and leaf.variable.type == "Real":
            first = next((hop.unit for hop in hops if hop.unit is not None), None)
            if unit is not None and first is not None and not same(unit, first):
                raise connector.place.fail(
                    f"connector '{connector.name}' has no unit, and drives inputs in {unit} and {first}; give it one"
                )
            unit = unit if first is None else first
    type_ = connector.type or (leaves[0].variable.type if leaves else "Real")
    literals = next((leaf.variable.literals for leaf in leaves if leaf.variable.literals), None)
    return Input(connector.name, type_, unit, literals, tuple(taps))


def same(a: Unit, b: Unit) -> bool:
    """Tell whether two units are one, however named; tools write factors such as that of the degree with few digits."""
    close = math.isclose(a.factor, b.factor, rel_tol=1e-5) and math.isclose(a.offset, b.offset, rel_tol=1e-5)
    return close and dict(a.exponents) == dict(b.exponents)


def _collect(flat: Flat, system: SystemElement, path: Path, cache: dict[tuple[int, str, str | None], Fmu]) -> None:
    for connector in system.connectors.values():
        flat.connectors[path, connector.name] = connector
    for name, element in system.elements.items():
        inner = (*path, name)
        if isinstance(element, SystemElement):
            _collect(flat, element, inner, cache)
        elif isinstance(element, ComponentElement):
            source = (id(element.source.package), element.source.name, element.interface)
            if source not in cache:
                fmu = read_fmu(element.source, element.place, element.interface)
                cache[source] = cache.setdefault((*source[:2], fmu.interface), fmu)
            flat.elements[inner], flat.fmus[inner] = element, cache[source]
            for connector in element.connectors.values():
                _check_connector(connector, name, cache[source])
                flat.connectors[inner, connector.name] = connector
    for link in system.links:
        _connect(flat, system, path, link)


def _check_names(flat: Flat) -> None:
    """Refuse names with dots that would make one of two variables, such as ``b.c`` in ``a`` and ``c`` in ``a.b``."""
    names = {".".join(path): path for path in flat.fmus}
    for path, element in flat.elements.items():
        dotted = ".".join(path)
        other = next((name for name in names if name.startswith(f"{dotted}.")), None)
        if names[dotted] != path or other is not None:
            raise element.place.fail(
                f"components '{dotted}' and '{other or dotted}' cannot be told apart by the names of their variables; "
                "rename one"
            )


def _check_connector(connector: Connector, owner: str, fmu: Fmu) -> None:
    """Refuse a connector that is not what the FMU has under its name."""
    variable = fmu.variables.get(connector.name)
    what = f"connector '{connector.name}' of '{owner}'"
    if variable is None:
        if connector.name in fmu.left_out:
            raise connector.place.fail(f"{what} is {fmu.left_out[connector.name]}; it cannot be connected")
        if any(one.array == connector.name for one in fmu.variables.values()):
            raise connector.place.fail(f"{what} is an array in the FMU; give it a Dimension with its size")
        raise connector.place.fail(f"{what}: {fmu.path.name} has no such variable; correct the name")
    kinds = _KINDS.get(variable.causality, (variable.causality,))
    if connector.kind not in kinds and not (connector.kind == "constant" and variable.variability == "constant"):
        raise connector.place.fail(f"{what} is of the kind {connector.kind}, in {fmu.path.name} it is {kinds[0]}")
    types = ("Enumeration", "Integer") if variable.type == "Enumeration" else (variable.type,)
    if connector.type is not None and connector.type not in types:
        raise connector.place.fail(f"{what} is a {connector.type}, in {fmu.path.name} it is a {variable.type}")
    known = unit_of(variable)
    differs = connector.unit is not None and known is not None and not same(connector.unit, known)
    if differs and connector.unit is not None and connector.unit.text != variable.unit:
        raise connector.place.fail(
            f"{what} is in {connector.unit}, in {fmu.path.name} it is in {variable.unit}; give it the FMU's unit, "
            "connections convert units"
        )


def _connect(flat: Flat, system: SystemElement, path: Path, link: Link) -> None:
    """Note a connection of a system, in the direction in which values go."""
    ends: list[tuple[Key, bool]] = []
    for element, name in (link.start, link.end):
        key: Key = (path if element is None else (*path, element), name)
        owner = f"system '{system.name}'" if element is None else f"'{element}'"
        if element is not None and element not in system.elements:
            known = ", ".join(system.elements) or "none"
            raise link.place.fail(f"there is no element '{element}' in system '{system.name}'; elements are {known}")
        connector = flat.connectors.get(key)
        if connector is None:
            known = ", ".join(one for owned, one in flat.connectors if owned == key[0]) or "none"
            raise link.place.fail(f"{owner} has no connector '{name}'; its connectors are {known}")
        if connector.kind not in (*_IN, *_OUT):
            raise connector.place.fail(
                f"connector '{name}' of {owner} is of the kind {connector.kind}; write input or output, so that it is "
                "known where its value comes from"
            )
        ends.append((key, (connector.kind in _IN) == (element is None)))
    (start, start_gives), (end, end_gives) = ends
    if start_gives == end_gives:
        what = "gives" if start_gives else "takes"
        raise link.place.fail(
            f"{_shown(start)} and {_shown(end)} are connected, but each of them {what} a value; connect what gives one "
            "with what takes it"
        )
    source, target = (start, end) if start_gives else (end, start)
    if target in flat.incoming:
        first = flat.incoming[target][1].place.line
        raise link.place.fail(f"{_shown(target)} is connected a second time, first in line {first}; it has one source")
    flat.incoming[target] = (source, link)


def _shown(key: Key) -> str:
    return f"'{'.'.join((*key[0], key[1]))}'"


def _chain(flat: Flat, leaf: Key) -> list[tuple[Key, Hop | None]]:
    """Return the connectors from the origin of a value to a leaf, each but the first with the hop that leads to it."""
    reversed_chain: list[tuple[Key, Hop | None]] = []
    seen: set[Key] = set()
    key = leaf
    while True:
        if key in seen:
            raise flat.incoming[key][1].place.fail(
                f"{_shown(key)} is connected with itself through other systems; nothing gives it a value"
            )
        seen.add(key)
        if key not in flat.incoming:
            return [(key, None), *reversed(reversed_chain)]
        source, link = flat.incoming[key]
        text = f"{_shown(source)} -> {_shown(key)}"
        reversed_chain.append((key, Hop(link.keeps_unit, link.transformation, flat.unit(key), link.place, text)))
        key = source


def unknown_units(flat: Flat) -> Iterator[str]:
    """Tell of units of FMUs that are not understood, where a connection would have to convert them."""
    for leaf in flat.leaves:
        origin = leaf.chain[0][0]
        source = flat.variable(origin)
        if source is None or len(leaf.chain) == 1 or source.unit == leaf.variable.unit:
            continue
        for key, variable in ((origin, source), ((leaf.chain[-1][0]), leaf.variable)):
            if variable.unit is not None and flat.unit(key) is None:
                yield (
                    f"{_shown(origin)} drives {'.'.join(leaf.end)} without conversion, the unit '{variable.unit}' of "
                    "the FMU is not understood"
                )
