"""What is simulated: components, the connections between them, channels that drive inputs from a table, and faults."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import partial

from cosim.engine.fmu._fmu import Fmu
from cosim.engine.fmu._variable import OPAQUE, Value, Variable
from cosim.engine.system._connection import Connection, dotted
from cosim.engine.system._fault import Fault
from cosim.engine.system._power import PowerConnection, check_power
from cosim.errors import FmuError, InputError

SAME_INSTANT = 1e-9
"""Two instants closer than this are one [s]."""

_ACCEPTED = {
    "Real": ("Real", "Integer", "Enumeration", "Boolean"),
    "Integer": ("Integer", "Enumeration", "Boolean"),
    "Enumeration": ("Enumeration", "Integer"),
    "Boolean": ("Boolean",),
    "String": ("String",),
    "Binary": ("Binary",),
}


@dataclass
class Component:
    """An FMU under the name it has in this system, and the parameters that differ from its start values (SI).

    ``origins`` tells for reports where they come from ("set by the scenario"), as far as known.
    """

    name: str
    fmu: Fmu
    parameters: dict[str, Value] = field(default_factory=dict)
    origins: dict[str, str] = field(default_factory=dict)


@dataclass
class Channel:
    """An input driven from a table: ``values`` (in the input's unit) at ``times`` [s], as long as each other.

    Two entries with one time are a step. A channel holds each value until the next entry, or, if ``linear``, is
    interpolated. Before its first entry the input keeps its start value; after the last it keeps the last value. At
    t = 0 initialisation uses the first of two entries, the second acts from then on.
    """

    target: tuple[str, str]
    times: list[float]
    values: list[float]
    linear: bool = False


@dataclass
class System:
    """Components, and what drives their inputs; an input that nothing drives keeps its start value.

    ``power`` are pairs of connections that carry power: runs tell how much energy the coupling has added to each.
    ``faults`` are done on purpose to what the inputs get; those of one input act in the order in which they are here.
    """

    components: list[Component]
    connections: list[Connection] = field(default_factory=list)
    channels: list[Channel] = field(default_factory=list)
    faults: list[Fault] = field(default_factory=list)
    power: list[PowerConnection] = field(default_factory=list)

    def check(self) -> None:
        """Raise InputError (FmuError for a variable that an FMU does not have) if this system cannot be simulated."""
        if not self.components:
            raise InputError("the system has no components; give it at least one FMU")
        by_name: dict[str, Component] = {}
        for component in self.components:
            if component.name in by_name:
                raise InputError(f'two components have the name "{component.name}"; give each a name of its own')
            by_name[component.name] = component
            _check_single_instance(component, self.components)
        driven: set[tuple[str, str]] = set()
        for connection in self.connections:
            source = _find(by_name, connection.source, "output")
            target = _find(by_name, connection.target, "input")
            _claim(driven, connection.target)
            _check_types(connection, source, target)
        _check_whole_arrays(by_name, driven)
        for channel in self.channels:
            target = _find(by_name, channel.target, "input")
            _claim(driven, channel.target)
            _check_table(channel, target)
        for fault in self.faults:
            fault.check(_find(by_name, fault.target, "input"))
        for power in self.power:
            check_power(power, self.connections, partial(_find, by_name))


def suggestion(name: str, known: Iterable[str]) -> str:
    """Return ``; did you mean ...?`` with the known names closest to ``name``, or nothing."""
    close = difflib.get_close_matches(name, list(known), n=3)
    return f"; did you mean {' or '.join(close)}?" if close else ""


def _check_single_instance(component: Component, components: list[Component]) -> None:
    if component.fmu.capabilities["canBeInstantiatedOnlyOncePerProcess"]:
        names = [other.name for other in components if other.fmu.sha256 == component.fmu.sha256]
        if len(names) > 1:
            raise FmuError(
                f"can be used only once in a system, but it is {', '.join(names)}; keep one of them",
                file=component.fmu.path,
            )


def _find(by_name: dict[str, Component], end: tuple[str, str], causality: str) -> Variable:
    name, variable_name = end
    component = by_name.get(name)
    if component is None:
        raise InputError(
            f'{dotted(end)}: there is no component "{name}"; there are {", ".join(by_name)}{suggestion(name, by_name)}'
        )
    variable = component.fmu.variables.get(variable_name)
    if variable is None:
        if variable_name in component.fmu.left_out:
            what = component.fmu.left_out[variable_name]
            raise FmuError(f"{dotted(end)}: is {what}; it cannot be exchanged")
        names = [v.name for v in component.fmu.variables.values() if v.causality == causality]
        raise FmuError(
            f"{dotted(end)}: {component.fmu.name} has no {causality} {variable_name}; its {causality}s are "
            f"{', '.join(names) or 'none'}{suggestion(variable_name, names)}"
        )
    if variable.causality != causality:
        raise FmuError(f"{dotted(end)}: is of causality {variable.causality}; an {causality} is needed here")
    return variable


def _claim(driven: set[tuple[str, str]], target: tuple[str, str]) -> None:
    if target in driven:
        raise InputError(f"{dotted(target)}: is driven twice; keep one of its connections and channels")
    driven.add(target)


def _check_whole_arrays(by_name: dict[str, Component], driven: set[tuple[str, str]]) -> None:
    """Numbers of an array that nothing drives keep their start values; texts and Binary have to be given all."""
    for name, variable_name in driven:
        variables = by_name[name].fmu.variables
        array = variables[variable_name].array
        kind = variables[variable_name].type
        if array is not None and kind in OPAQUE:
            idle = [v.name for v in variables.values() if v.array == array and (name, v.name) not in driven]
            if idle:
                missing = ", ".join(dotted((name, element)) for element in idle)
                raise InputError(f"{name}.{array}: nothing drives {missing}; drive all elements of an array of {kind}")


def _check_types(connection: Connection, source: Variable, target: Variable) -> None:
    ends = f"{dotted(connection.source)} -> {dotted(connection.target)}"
    if source.type not in _ACCEPTED[target.type]:
        raise InputError(
            f"{ends}: a {source.type} cannot drive a {target.type}; it takes {' or '.join(_ACCEPTED[target.type])}"
        )
    if source.binary and target.binary and source.binary.media_type != target.binary.media_type:
        raise InputError(
            f"{ends}: the source is of the type {source.binary.media_type}, but the target takes "
            f"{target.binary.media_type}; connect what agrees"
        )
    if target.type != "Real" and (connection.factor, connection.offset) != (1.0, 0.0):
        raise InputError(f"{ends}: factor and offset need a Real target, but it is a {target.type}; leave them out")
    if not (math.isfinite(connection.factor) and math.isfinite(connection.offset)):
        raise InputError(f"{ends}: factor {connection.factor} and offset {connection.offset} must be finite")
    if connection.table:
        _check_mapping(connection, ends, source, target)


def _check_mapping(connection: Connection, ends: str, source: Variable, target: Variable) -> None:
    for variable in (source, target):
        if variable.type not in ("Integer", "Boolean", "Enumeration"):
            raise InputError(f"{ends}: a table maps whole numbers, Booleans and enumerations, not a {variable.type}")
    known = dict(connection.table)
    possible = {"Boolean": [0, 1], "Enumeration": range(1, len(source.literals or ()) + 1)}.get(source.type, ())
    accepted = {"Boolean": (0, 1), "Enumeration": (1, len(target.literals or ()) or math.inf)}.get(target.type)
    for value in (*known.values(), *(known.get(value, value) for value in possible)):
        if value != int(value) or (accepted and not accepted[0] <= value <= accepted[1]):
            raise InputError(
                f"{ends}: the table gives {value:g}, which the target, of the type {target.type}, cannot take"
            )


def _check_table(channel: Channel, target: Variable) -> None:
    name = dotted(channel.target)
    if target.type in OPAQUE:
        raise FmuError(f"channel {name}: is a {target.type}; a channel has numbers only")
    if not channel.times or len(channel.times) != len(channel.values):
        raise InputError(
            f"channel {name}: it has {len(channel.times)} times and {len(channel.values)} values; "
            "as many of both are needed, at least one"
        )
    if not all(map(math.isfinite, [*channel.times, *channel.values])):
        raise InputError(f"channel {name}: every time and value must be finite")
    if channel.times[0] < 0.0:
        raise InputError(f"channel {name}: its first time is {channel.times[0]:g} s; a simulation starts at 0 s")
    for before, after in zip(channel.times, channel.times[1:], strict=False):
        if after < before:
            raise InputError(f"channel {name}: time goes back from {before:g} s to {after:g} s; sort the entries")
    for first, third in zip(channel.times, channel.times[2:], strict=False):
        if third == first:
            raise InputError(f"channel {name}: three entries at {first:g} s; a step has two")
    if channel.linear and target.type != "Real":
        raise InputError(f"channel {name}: a {target.type} cannot be interpolated; let it hold")
    if target.type != "Real" and any(value != int(value) for value in channel.values):
        raise InputError(f"channel {name}: a {target.type} takes whole numbers only")
    if target.type == "Boolean" and any(value not in (0, 1) for value in channel.values):
        raise InputError(f"channel {name}: a Boolean takes 0 and 1 only")
    if target.literals and not all(1 <= value <= len(target.literals) for value in channel.values):
        names = ", ".join(f"{i} {literal}" for i, literal in enumerate(target.literals, 1))
        raise InputError(f"channel {name}: an Enumeration takes its numbers only: {names}")
