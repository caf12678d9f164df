"""The XML documents of an SSP that describes one of the engine's systems: structure, parameter values and mapping."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

from cosim import __version__
from cosim.engine import Component, System, Value, Variable
from cosim.errors import InputError
from cosim.ssp._flatten import End, unit_of
from cosim.ssp._xml import SPACES
from cosim.units import Unit

VERSIONS = ("1.0", "2.0")
VALUES = "resources/parameters.ssv"
MAPPING = "resources/parameters.ssm"
OPAQUE = ("String", "Binary")


def connector_names(system: System) -> dict[End, str]:
    """Return the connector of the whole system for each channel, by the input that it drives.

    It is the variable's name where only one of them has it, else ``component_variable``. Outputs get none: importers
    that know no connections with the system itself can then take a system without channels.
    """
    ends = [channel.target for channel in system.channels]
    plain = [re.sub(r"\W+", "_", variable) for _, variable in ends]
    names: dict[End, str] = {}
    for end, name in zip(ends, plain, strict=True):
        wanted = name if plain.count(name) == 1 else re.sub(r"\W+", "_", "_".join(end))
        taken = set(names.values()) | {component.name for component in system.components}
        count = 2
        free = wanted
        while free in taken:
            free, count = f"{wanted}_{count}", count + 1
        names[end] = free
    return names


class Documents:
    """Writes the documents for one system and one version of the standard."""

    def __init__(self, system: System, sources: Mapping[str, str], version: str) -> None:
        """Take the system, the path of each component's FMU in the SSP, and the version, ``1.0`` or ``2.0``."""
        from lxml import etree

        self._etree = etree
        self._system = system
        self._sources = sources
        self._version = version
        self._names = connector_names(system)
        self._variables = {
            (component.name, variable.name): variable
            for component in system.components
            for variable in component.fmu.variables.values()
        }
        self._types = {(c.name, name): kind for c in system.components for name, kind in c.fmu.fmi_types.items()}
        used = {*(c.source for c in system.connections), *(c.target for c in system.connections), *self._names}
        for end in sorted(used):
            if self._variables[end].array is not None:
                raise InputError(
                    f"{'.'.join(end)} is an element of an array, which an SSP cannot connect alone: none is written; "
                    "use an FMU with scalars"
                )

    def structure(self, name: str, title: str, stop: float) -> bytes:
        """Return the SSD; ``stop`` [s] is the end of its default experiment."""
        root = self._root("ssd", "SystemStructureDescription", name=title or name, **self._made())
        system = self._add(root, "ssd:System", name=name)
        self._add_connectors(system, self._names)
        if self._given():
            binding = self._add(self._add(system, "ssd:ParameterBindings"), "ssd:ParameterBinding", source=VALUES)
            self._add(binding, "ssd:ParameterMapping", source=MAPPING)
        elements = self._add(system, "ssd:Elements")
        for component in self._system.components:
            self._add_component(elements, component)
        self._add_connections(system)
        self._add_enumerations(root)
        self._add_units(root, "ssd", (self._variables[end] for end in self._connected()))
        self._add(root, "ssd:DefaultExperiment", startTime="0.0", stopTime=repr(stop))
        return self._text(root)

    def values(self, name: str) -> bytes | None:
        """Return the SSV: parameters that are set, and the values at which channels start; None if there are none."""
        given = self._given()
        if not given:
            return None
        root = self._root("ssv", "ParameterSet", name=f"{name} parameters", **self._made())
        parameters = self._add(root, "ssv:Parameters")
        for end, value in given.items():
            self._add_value(self._add(parameters, "ssv:Parameter", name=".".join(end)), end, value)
        self._add_units(root, "ssv", (self._variables[end] for end in given))
        return self._text(root)

    def mapping(self) -> bytes | None:
        """Return the SSM, in which each value sets what it is named after; None if there is none."""
        given = self._given()
        if not given:
            return None
        root = self._root("ssm", "ParameterMapping", **self._made())
        for end in given:
            self._add(root, "ssm:MappingEntry", source=".".join(end), target=".".join(end))
        return self._text(root)

    def _given(self) -> dict[End, Value]:
        """Return the values of parameters, and of channels at the beginning."""
        given: dict[End, Value] = {
            (component.name, name): value
            for component in self._system.components
            for name, value in component.parameters.items()
        }
        for channel in self._system.channels:
            start = self._variables[channel.target].start
            first = channel.values[0] if channel.times[0] <= 1e-9 else float(start or 0.0)
            given[channel.target] = first
        return given

    def _connected(self) -> dict[End, str]:
        """Return all variables that have a connector, those driven and all outputs, with their own names."""
        ends = [*self._names]
        for connection in self._system.connections:
            ends += (connection.source, connection.target)
        ends += (
            end
            for end, variable in self._variables.items()
            if variable.causality == "output" and variable.type not in OPAQUE and variable.array is None
        )
        return {end: end[1] for end in ends}

    def _add_component(self, elements: Any, component: Component) -> None:  # noqa: ANN401
        node = self._add(
            elements,
            "ssd:Component",
            name=component.name,
            type="application/x-fmu-sharedlibrary",
            source=self._sources[component.name],
            implementation=component.fmu.interface,
        )
        self._add_connectors(node, {e: name for e, name in self._connected().items() if e[0] == component.name})

    def _add_connectors(self, node: Any, names: Mapping[End, str]) -> None:  # noqa: ANN401
        if not names:
            return
        around = self._add(node, "ssd:Connectors")
        for end, name in names.items():
            variable = self._variables[end]
            connector = self._add(around, "ssd:Connector", name=name, kind=variable.causality)
            match variable.type:
                case "Enumeration" if variable.literals:
                    self._add(connector, "ssc:Enumeration", name=_enumeration(end))
                case "Enumeration":
                    self._add(connector, "ssc:Integer")
                case "Binary" if variable.binary:
                    self._add(connector, "ssc:Binary", **{"mime-type": variable.binary.media_type})
                case _:
                    attributes = {"unit": variable.unit} if variable.unit and unit_of(variable) else {}
                    self._add(connector, f"ssc:{self._type_of(end)}", **attributes)

    def _type_of(self, end: End) -> str:
        """Return the type of a variable as this version of the standard calls it."""
        return self._types[end] if self._version == "2.0" else self._variables[end].type

    def _add_connections(self, system: Any) -> None:  # noqa: ANN401
        if not self._system.connections and not self._names:
            return
        around = self._add(system, "ssd:Connections")
        for end, own in self._names.items():
            self._add(around, "ssd:Connection", startConnector=own, endElement=end[0], endConnector=end[1])
        for connection in self._system.connections:
            source, target = connection.source, connection.target
            factor, offset = connection.factor, connection.offset
            node = self._add(
                around,
                "ssd:Connection",
                startElement=source[0],
                startConnector=source[1],
                endElement=target[0],
                endConnector=target[1],
            )
            if (factor, offset) != self._conversion(source, target):
                # The whole of it is written, so that it is exactly what it was.
                node.set("suppressUnitConversion", "true")
                self._add(node, "ssc:LinearTransformation", factor=repr(factor), offset=repr(offset))
            if connection.table:
                kind = "Boolean" if self._variables[source].type == "Boolean" else "Integer"
                table = self._add(node, f"ssc:{kind}MappingTransformation")
                for one, other in connection.table:
                    self._add(table, "ssc:MapEntry", source=str(int(one)), target=str(int(other)))

    def _conversion(self, source: End, target: End) -> tuple[float, float]:
        """Return what a reader does to a value because of the units alone."""
        from cosim.units import compatible, linear_map

        one, other = unit_of(self._variables[source]), unit_of(self._variables[target])
        return linear_map(one, other) if one and other and compatible(one, other) else (1.0, 0.0)

    def _add_enumerations(self, root: Any) -> None:  # noqa: ANN401
        found = {end: v.literals for end in self._connected() if (v := self._variables[end]).literals}
        if not found:
            return
        around = self._add(root, "ssd:Enumerations")
        for end, literals in found.items():
            node = self._add(around, "ssc:Enumeration", name=_enumeration(end))
            for number, literal in enumerate(literals or (), 1):
                self._add(node, "ssc:Item", name=literal, value=str(number))

    def _add_units(self, root: Any, prefix: str, variables: Iterable[Variable]) -> None:  # noqa: ANN401
        units: dict[str, Unit] = {}
        for variable in variables:
            unit = unit_of(variable)
            if variable.unit and unit is not None:
                units[variable.unit] = unit
        if not units:
            return
        around = self._add(root, f"{prefix}:Units")
        for text, unit in sorted(units.items()):
            attributes = {base: str(power) for base, power in unit.exponents.items()}
            attributes |= {"factor": repr(unit.factor)} if unit.factor != 1.0 else {}
            attributes |= {"offset": repr(unit.offset)} if unit.offset else {}
            self._add(self._add(around, "ssc:Unit", name=text), "ssc:BaseUnit", **attributes)

    def _add_value(self, node: Any, end: End, value: Value) -> None:  # noqa: ANN401
        variable = self._variables[end]
        match variable.type:
            case "Boolean":
                self._add(node, "ssv:Boolean", value="true" if value else "false")
            case "String":
                self._add(node, "ssv:String", value=str(value))
            case "Enumeration" if isinstance(value, str):
                self._add(node, "ssv:Enumeration", value=value)
            case "Enumeration" if variable.literals:
                self._add(node, "ssv:Enumeration", value=variable.literals[int(value) - 1])
            case "Integer" | "Enumeration":
                kind = self._type_of(end) if variable.type == "Integer" else "Integer"
                self._add(node, f"ssv:{kind}", value=str(int(value)))
            case _:
                attributes = {"unit": variable.unit} if variable.unit and unit_of(variable) else {}
                self._add(node, f"ssv:{self._type_of(end)}", value=_double(float(value)), **attributes)

    def _made(self) -> dict[str, str]:
        return {"version": self._version, "generationTool": f"cosim {__version__}"}

    def _root(self, prefix: str, kind: str, /, **attributes: str) -> Any:  # noqa: ANN401
        spaces = {one: SPACES[one] for one in dict.fromkeys((prefix, "ssc"))}
        return self._etree.Element(f"{{{SPACES[prefix]}}}{kind}", attributes, nsmap=spaces)

    def _add(self, node: Any, kind: str, /, **attributes: str) -> Any:  # noqa: ANN401
        prefix, _, local = kind.partition(":")
        return self._etree.SubElement(node, f"{{{SPACES[prefix]}}}{local}", attributes)

    def _text(self, root: Any) -> bytes:  # noqa: ANN401
        text: bytes = self._etree.tostring(root, pretty_print=True, xml_declaration=True, encoding="UTF-8")
        return text


def _enumeration(end: End) -> str:
    return ".".join(end)


def _double(value: float) -> str:
    """Return a number as XML has it: shortest round trip, with its own words for infinity."""
    return {"inf": "INF", "-inf": "-INF", "nan": "NaN"}.get(repr(value), repr(value))
