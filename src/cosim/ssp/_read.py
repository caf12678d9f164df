"""Reading of system structures (SSD), with the parameter sets (SSV), mappings (SSM) and systems they refer to."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from cosim.engine import Interface
from cosim.errors import InputError
from cosim.ssp._arrays import elements
from cosim.ssp._model import (
    Binding,
    ComponentElement,
    Connector,
    Element,
    Link,
    MappingEntry,
    Parameter,
    Structure,
    SystemElement,
    Transformation,
    plain_type,
)
from cosim.ssp._package import DEFAULT, Location
from cosim.ssp._xml import Node, Place, parse
from cosim.units import BASE, Unit
from cosim.units import parse as parse_unit

_FMU = "application/x-fmu-sharedlibrary"
_SSD = "application/x-ssp-definition"
_SSP = "application/x-ssp-package"
_TYPES = {"ssv": "application/x-ssp-parameter-set", "ssm": "application/x-ssp-parameter-mapping"}
_TRANSFORMATIONS = ("Boolean", "Integer", "Enumeration")
_IMPLEMENTATIONS: dict[str, Interface | None] = {
    "any": None,
    "CoSimulation": "CoSimulation",
    "ModelExchange": "ModelExchange",
}
_MOST_ELEMENTS = 10_000


def read_structure(location: Location) -> Structure:
    """Read an SSD and what it refers to, except for the FMUs. Raises `InputError`, with file and line, for the rest."""
    return _Reader().structure(location, None, ())


@dataclass
class _File:
    """An SSD that is being read: its root, where it is, the units that it defines, and what it is read for."""

    root: Node
    location: Location
    units: dict[str, Unit]
    within: tuple[str, ...]


class _Reader:
    def __init__(self) -> None:
        self._elements = 0

    def structure(self, location: Location, place: Place | None, within: tuple[str, ...]) -> Structure:
        content = location.content(place)
        root = parse(content, location.label, "ssd")
        file = _File(root, location, _units(root, "ssd"), (*within, location.label))
        system = root.child("ssd:System")
        if system is None:
            raise root.place.fail("has no System; export it again")
        structure = Structure(self._system(system, file), location)
        experiment = root.child("ssd:DefaultExperiment")
        if experiment is not None:
            structure.start = experiment.number("startTime", math.nan) if experiment.has("startTime") else None
            structure.stop = experiment.number("stopTime", math.nan) if experiment.has("stopTime") else None
        return structure

    def _count(self, place: Place) -> None:
        self._elements += 1
        if self._elements > _MOST_ELEMENTS:
            raise place.fail(f"the structure has more than {_MOST_ELEMENTS} systems and components; split it")

    def _system(self, node: Node, file: _File) -> SystemElement:
        self._count(node.place)
        system = SystemElement(node.text("name"), node.place, *_connectors(node, file), _bindings(node, file))
        for path in ("ssd:SignalDictionaries/ssd:SignalDictionary", "ssd:Elements/ssd:SignalDictionaryReference"):
            found = node.child(path)
            if found is not None:
                raise found.place.fail(
                    f"'{found.text('name')}' is a {found.name}, which this version does not read; "
                    "connect the components directly"
                )
        around = node.child("ssd:Elements")
        for inner in around.of("ssd") if around else ():
            element = self._system(inner, file) if inner.name == "System" else self._component(inner, file)
            if element.name in system.elements:
                raise inner.place.fail(f"a second element '{element.name}' in system '{system.name}'; rename one")
            system.elements[element.name] = element
        for link in node.children("ssd:Connections/ssd:Connection"):
            system.links += _links(link, system)
        return system

    def _component(self, node: Node, file: _File) -> Element:
        self._count(node.place)
        name, kind = node.text("name"), node.text("type", _FMU).partition(";")[0].strip()
        if not node.has("source"):
            raise node.place.fail(f"component '{name}' has no source, only its interface is described; give it an FMU")
        location, fragment = file.location.at(node.text("source"), node.place)
        if kind in (_SSD, _SSP):
            return self._referenced(node, file, location, fragment, kind)
        if kind != _FMU:
            raise node.place.fail(
                f"component '{name}' is of the type '{kind}'; only FMUs ({_FMU}) and other system structures are run: "
                "export it as an FMU"
            )
        wanted = node.text("implementation", "any")
        if wanted not in _IMPLEMENTATIONS:
            raise node.place.fail(
                f"component '{name}' asks for {wanted}; FMUs are run by Co-Simulation or Model Exchange: set "
                "implementation to one of these, or leave it out"
            )
        return ComponentElement(
            name,
            node.place,
            *_connectors(node, file),
            _bindings(node, file, location),
            location,
            _IMPLEMENTATIONS[wanted],
        )

    def _referenced(self, node: Node, file: _File, location: Location, fragment: str, kind: str) -> SystemElement:
        """Read the system that a component stands for; the component's bindings come after the system's own."""
        here = not node.text("source").partition("#")[0]
        target = f"{(file.location if here else location).label}#{fragment}" if fragment else location.label
        if target in file.within:
            raise node.place.fail(f"component '{node.text('name')}' refers to a system that it is part of; take it out")
        if here:
            found = _by_id(file.root, fragment)
            if found is None:
                raise node.place.fail(f"there is no System with the id '{fragment}' in this file")
            system = self._system(found, _File(file.root, file.location, file.units, (*file.within, target)))
        elif kind == _SSD:
            system = self.structure(location, node.place, file.within).root
        else:
            system = self.structure(location.inside(node.place, fragment or DEFAULT), node.place, file.within).root
        system.name = node.text("name")
        system.bindings += _bindings(node, file, location)
        return system


def _by_id(root: Node, wanted: str) -> Node | None:
    """Return the system that has an id."""
    return next((node for node in root.children(".//ssd:System") if wanted and node.text("id") == wanted), None)


def _units(root: Node, kind: str) -> dict[str, Unit]:
    """Return the units that a file defines, by their names."""
    units: dict[str, Unit] = {}
    for node in root.children(f"{kind}:Units/ssc:Unit"):
        base = node.child("ssc:BaseUnit")
        if base is None:
            continue
        factor, offset = base.number("factor", 1.0), base.number("offset", 0.0)
        if not (math.isfinite(factor) and math.isfinite(offset) and factor):
            raise base.place.fail(f"unit '{node.text('name')}' has the factor {factor:g}; it must not be 0 or infinite")
        powers = {name: int(base.text(name, "0")) for name in BASE}
        units[node.text("name")] = Unit(
            node.text("name"), factor, offset, {name: power for name, power in powers.items() if power}
        )
    return units


def _unit(node: Node, units: dict[str, Unit]) -> Unit | None:
    """Return the unit of an element; other tools leave it empty for none, or do not define all units that they use."""
    name = node.text("unit").strip()
    if not name or name in units:
        return units.get(name)
    try:
        unit = parse_unit(name)
    except InputError:
        unit = None
    taken = "taken as the SI has it" if unit else "so that numbers in it are not converted"
    node.place.warn(f"the unit '{name}' is not defined in the Units of this file, {taken}")
    return unit


def _connectors(node: Node, file: _File) -> tuple[dict[str, Connector], dict[str, list[str]]]:
    """Return the connectors of an element, those of arrays one by one, and the names of these."""
    found: dict[str, Connector] = {}
    arrays: dict[str, list[str]] = {}
    for inner in node.children("ssd:Connectors/ssd:Connector"):
        name = inner.text("name")
        if name in found:
            raise inner.place.fail(f"a second connector '{name}' of '{node.text('name')}'; names must differ")
        typed = next((one for one in inner.of("ssc") if one.name not in ("Dimension", "Annotations", "MetaData")), None)
        type_ = None if typed is None else plain_type(typed.name)
        unit = None if typed is None else _unit(typed, file.units)
        several = elements(inner, name)
        if several is not None:
            arrays[name] = several
        for one in [name] if several is None else several:
            found[one] = Connector(one, inner.text("kind"), type_, unit, inner.place)
    return found, arrays


def _links(node: Node, system: SystemElement) -> list[Link]:
    """Return a connection, or one for each element of the arrays that it connects."""
    for attribute in ("startIndices", "endIndices"):
        if node.has(attribute):
            raise node.place.fail(
                f"'{attribute}' picks elements of an array, and the standard does not say whether they count from 0 or "
                "1; connect whole arrays"
            )
    # An empty name stands for the system itself too: other tools write it so.
    start = (node.text("startElement") or None, node.text("startConnector"))
    end = (node.text("endElement") or None, node.text("endConnector"))
    link = Link(start, end, node.flag("suppressUnitConversion"), _transformation(node), node.place)
    arrays: list[list[str] | None] = []
    for owner, name in (start, end):
        element = system if owner is None else system.elements.get(owner)
        arrays.append(None if element is None else element.arrays.get(name))
    one, other = arrays
    if one is None and other is None:
        return [link]
    if one is None or other is None or len(one) != len(other):
        sizes = " and ".join("a scalar" if array is None else f"{len(array)} elements" for array in arrays)
        raise node.place.fail(f"'{start[1]}' and '{end[1]}' are connected, but have {sizes}; connect what has as many")
    return [
        replace(link, start=(start[0], first), end=(end[0], second)) for first, second in zip(one, other, strict=True)
    ]


def _transformation(node: Node) -> Transformation | None:
    linear = node.child("ssc:LinearTransformation")
    if linear is not None:
        factor, offset = linear.number("factor", 1.0), linear.number("offset", 0.0)
        if not (math.isfinite(factor) and math.isfinite(offset)):
            raise linear.place.fail(f"factor {factor} and offset {offset} must be finite")
        return Transformation("Linear", factor, offset)
    for kind in _TRANSFORMATIONS:
        found = node.child(f"ssc:{kind}MappingTransformation")
        if found is None:
            continue
        table: dict[str, str] = {}
        for entry in found.children("ssc:MapEntry"):
            source = _canonical(kind, entry.text("source"))
            if source in table:
                raise entry.place.fail(f"a second entry for {entry.text('source')}; one value can have one target")
            table[source] = _canonical(kind, entry.text("target"))
        return Transformation(kind, table=table)
    return None


def _canonical(kind: str, text: str) -> str:
    if kind == "Boolean":
        return "1" if text.strip() in ("true", "1") else "0"
    return str(int(text)) if kind == "Integer" else text


def _bindings(node: Node, file: _File, component: Location | None = None) -> list[Binding]:
    """Return the parameter bindings of an element; their files may lie inside of the ``component``."""
    return [_binding(inner, file, component) for inner in node.children("ssd:ParameterBindings/ssd:ParameterBinding")]


def _binding(node: Node, file: _File, component: Location | None) -> Binding:
    values, origin = _content(node, node.child("ssd:ParameterValues"), file, component, "ssv")
    if values is None:
        raise node.place.fail("the parameter binding has neither a source nor ParameterValues; give it one")
    mapping_node = node.child("ssd:ParameterMapping")
    mapping: tuple[MappingEntry, ...] | None = None
    if mapping_node is not None:
        found, _ = _content(mapping_node, mapping_node, file, component, "ssm")
        if found is None:
            raise mapping_node.place.fail("the parameter mapping has neither a source nor content; give it one")
        mapping = _entries(found)
    return Binding(_parameters(values), node.text("prefix"), mapping, origin, node.place)


def _content(
    node: Node, around: Node | None, file: _File, component: Location | None, kind: str
) -> tuple[Node | None, str]:
    """Return the root of a parameter set or mapping, from its own file or inline, and what a user knows it by."""
    type_ = _TYPES[kind]
    if node.text("type", type_) != type_:
        raise node.place.fail(f"'{node.text('source')}' is of the type '{node.text('type')}'; {type_} is read")
    if not node.has("source"):
        return (around.inline(kind) if around is not None else None), file.location.label
    base = file.location
    if node.text("sourceBase", "SSD") != "SSD":
        if component is None:
            raise node.place.fail(f"'{node.text('source')}' is said to lie inside of a component, but this is a system")
        base = component.inside(node.place)
    location, _ = base.at(node.text("source"), node.place)
    return parse(location.content(node.place), location.label, kind), location.label


def _parameters(root: Node) -> tuple[Parameter, ...]:
    units = _units(root, "ssv")
    found: dict[str, Parameter] = {}
    for node in root.children("ssv:Parameters/ssv:Parameter"):
        name = node.text("name")
        typed = next((one for one in node.of("ssv") if one.name != "Annotations"), None)
        if typed is None or not typed.has("value"):
            raise node.place.fail(f"parameter '{name}' has no value; give it one")
        names, given = elements(node, name), [typed.text("value")]
        if names is not None:
            given = typed.text("value").split()
            if plain_type(typed.name) not in ("Real", "Integer", "Boolean") or len(given) != len(names):
                raise node.place.fail(
                    f"parameter '{name}' is an array of {len(names)} elements, its value has {len(given)}; give as "
                    "many numbers"
                )
        for one, text in zip(names or [name], given, strict=True):
            parameter = Parameter(one, plain_type(typed.name), text, _unit(typed, units), node.place)
            if found.setdefault(one, parameter).value != text:
                raise node.place.fail(f"a second value of parameter '{one}' in this parameter set; give one")
    return tuple(found.values())


def _entries(root: Node) -> tuple[MappingEntry, ...]:
    found: dict[str, MappingEntry] = {}
    for node in root.children("ssm:MappingEntry"):
        entry = MappingEntry(
            node.text("source"),
            node.text("target"),
            node.flag("suppressUnitConversion"),
            _transformation(node),
            node.place,
        )
        if entry.target in found:
            raise node.place.fail(f"'{entry.target}' is mapped a second time; one parameter can set it")
        found[entry.target] = entry
    return tuple(found.values())
