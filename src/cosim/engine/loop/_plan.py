"""The flat tables that the loop runs over: one vector of signals, one of inputs, and groups of variables in them.

Signals (``values``), in this order: the outputs of all components, the channels, what inputs with faults get, the
middles of linear channels, a zero, from which the elements of arrays that nothing drives take their start values, what
linked inputs hold (see ``_coupling``), and the texts and Binary variables that drive something.
The first ``recorded`` of them are the columns of the result. Each group of Float64 variables lies in one piece, so
that the FMU reads and writes the doubles of these vectors themselves; other types go through a buffer. In a group of
outputs those that drive something come first, so that between the rows of the result only they are read.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Callable, Iterable
from ctypes import addressof, c_char_p, c_size_t
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from cosim.engine.coupling._coupling import Coupling
from cosim.engine.coupling._power_meter import PowerMeter, meter_of
from cosim.engine.fmu._instance import Instance
from cosim.engine.fmu._variable import OPAQUE, Variable
from cosim.engine.signals._fault_memory import FaultMemory
from cosim.engine.signals._fault_signals import Source, faulty_inputs
from cosim.engine.signals._participant import Binaries, Buffer, InputGroup, OutputGroup, Participant
from cosim.engine.signals._signal_faults import SignalFaults
from cosim.engine.system._channels import Line, Schedule, first_value
from cosim.engine.system._connection import dotted
from cosim.engine.system._memory import Memory, Numbers
from cosim.engine.system._method import links_of
from cosim.engine.system._order import continuous_order, discrete_order
from cosim.engine.system._role import Role, fixed_step_of, period_of, role_of
from cosim.engine.system._system import Channel, Component, System
from cosim.engine.system._wire import Wire


@dataclass
class Plan:
    """All that the loop needs.

    ``columns`` maps "component.variable" to its signal, in the order of the result; ``ends`` are the (component,
    variable) of the recorded signals, ``variables`` describes the columns. The signals from ``first_text`` on are those
    of the texts, which are in ``texts``. ``signals`` has those of all outputs and channels, ``held`` the slots in which
    the values of linked inputs may be put, by the inputs; ``coupling`` puts them there, from the end of initialisation
    on, if the algorithm does. ``coupled`` tells whether continuous components drive each other or follow a linear
    channel, so that every output point is an exchange. ``memory`` has by name all else that the run's future depends
    on: what is neither in them, in the signals and inputs, in a participant, in an FMU nor derived from the time is
    lost at a checkpoint.
    """

    values: array[float]
    inputs: array[float]
    recorded: int
    columns: dict[str, int]
    ends: list[tuple[str, str]]
    variables: dict[str, Variable]
    discrete: list[Participant]
    continuous: list[Participant]
    schedule: Schedule
    lines: list[Line]
    faults: SignalFaults
    power: PowerMeter
    coupled: bool
    held: dict[tuple[str, str], int]
    first_text: int
    texts: dict[int, bytes]
    signals: dict[tuple[str, str], int]
    memory: dict[str, Memory] = field(default_factory=dict)
    coupling: Coupling | None = None


def roles_of(system: System) -> dict[str, Role]:
    """Return the role of each component by name."""
    return {component.name: role_of(component.fmu) for component in system.components}


def make_plan(
    system: System,
    roles: dict[str, Role],
    instances: dict[str, Instance],
    output_interval: float,
    stop: float,
    kind: Callable[..., Participant] = Participant,
) -> Plan:
    """Lay out the signals of a checked system and bind the calls of its instances; ``kind`` makes the participants.

    Faults have what they need for a run to ``stop`` [s].
    """
    signals, columns, recorded, total, variables, faulty_slots = lay_out(system)
    links = links_of(system, roles, output_interval)
    held = {link.target: slot for slot, link in enumerate(links, total + 1)}
    first_text = total + 1 + len(held)
    texts = _text_signals(system, first_text)
    values = array("d", bytes(8 * (first_text + len(texts))))
    holds, lines = _channel_signals(system, signals, values, total)
    ends = [*signals, *faulty_slots]
    signals |= texts
    wires = _sources(system, signals, roles, lines)
    faulty = faulty_inputs(system, stop, output_interval, wires, signals, faulty_slots, roles, lines, zero=total)
    wires |= {target: (one.slot, 1.0, 0.0, ()) for target, one in faulty.items()}
    faults = SignalFaults(list(faulty.values()), values)
    for component in system.components:
        wires |= _idle_elements(component, wires, zero=total)
    inputs = array("d", bytes(8 * len(wires)))
    taken = {connection.source for connection in system.connections}
    participants: dict[str, Participant] = {}
    present: dict[int, bytes] = {}
    free = 0
    for component in system.components:
        instance = instances[component.name]
        groups = _input_groups(component, instance, wires, inputs, free)
        free += sum(len(group.wires) for group in groups)
        participants[component.name] = kind(
            instance,
            roles[component.name],
            _period(component, roles[component.name], output_interval),
            values,
            inputs,
            groups,
            _output_groups(component, instance, signals, taken, values),
            _triggers(system, groups, signals, roles, faults) if roles[component.name] is Role.EVENT else (),
            present,
        )
        own = [one for (name, _), one in faulty.items() if name == component.name]
        if own:
            participants[component.name].faulty, participants[component.name].faults = own, faults
    continuous = [c for c in system.components if roles[c.name] is Role.CONTINUOUS]
    discrete = [c for c in system.components if roles[c.name] is not Role.CONTINUOUS]
    names = {component.name for component in continuous}
    coupled = any(c.source[0] in names and c.target[0] in names for c in system.connections)
    power = meter_of(system, columns, _places(participants.values()), output_interval)
    memory: dict[str, Memory] = {"faults": FaultMemory(faults)} if faults.inputs else {}
    if power.bonds:
        memory["power"] = Numbers(power.start, power.energies)
    return Plan(
        values=values,
        inputs=inputs,
        recorded=recorded,
        columns=columns,
        ends=ends,
        variables=variables,
        discrete=[participants[c.name] for c in discrete_order(discrete, system.connections)],
        continuous=[participants[c.name] for c in continuous_order(continuous, system.connections)],
        schedule=Schedule(holds, lines),
        lines=lines,
        faults=faults,
        power=power,
        coupled=coupled or bool(lines),
        held=held,
        first_text=first_text,
        texts=present,
        signals=signals,
        memory=memory,
    )


def _places(participants: Iterable[Participant]) -> dict[tuple[str, str], int]:
    """Return the places of all driven inputs."""
    return {
        (participant.instance.name, name): wire.target
        for participant in participants
        for group in participant.input_groups
        for wire, name in zip(group.wires, group.names, strict=True)
    }


def _period(component: Component, role: Role, output_interval: float) -> float:
    if role is Role.EVENT:
        return math.inf
    return (period_of if role is Role.SAMPLED else fixed_step_of)(component, output_interval)


def _recorded_outputs(component: Component) -> list[str]:
    return [v.name for v in component.fmu.variables.values() if v.causality == "output" and v.type not in OPAQUE]


def _by_type(component: Component, names: list[str]) -> dict[str, list[str]]:
    groups: dict[str, list[str]] = {}
    for name in names:
        groups.setdefault(component.fmu.fmi_types[name], []).append(name)
    return groups


def _outputs(component: Component, taken: set[tuple[str, str]]) -> dict[str, list[str]]:
    """Return the outputs that are read by FMI type, those first that drive something; no other texts."""
    texts = [
        v.name for v in component.fmu.variables.values() if v.type in OPAQUE and _is_taken(component, v.name, taken)
    ]
    names = _recorded_outputs(component) + texts
    return _by_type(component, sorted(names, key=lambda name: not _is_taken(component, name, taken)))


def _is_taken(component: Component, name: str, taken: set[tuple[str, str]]) -> bool:
    """Tell whether an output, or another element of its array, drives something."""
    array_name = component.fmu.variables[name].array
    if array_name is None:
        return (component.name, name) in taken
    return any(owner == component.name and component.fmu.variables[n].array == array_name for owner, n in taken)


class Layout(NamedTuple):
    """The slot of each signal and of each column, the number of recorded signals, and of all but texts.

    ``columns`` and ``variables`` are as in ``Plan``, ``faulty`` are the slots of what inputs with faults get.
    """

    signals: dict[tuple[str, str], int]
    columns: dict[str, int]
    recorded: int
    total: int
    variables: dict[str, Variable]
    faulty: dict[tuple[str, str], int]


def lay_out(system: System) -> Layout:
    """Lay out the signals of a checked system."""
    signals: dict[tuple[str, str], int] = {}
    taken = {connection.source for connection in system.connections}
    for component in system.components:
        for fmi_type, names in _outputs(component, taken).items():
            for name in names if fmi_type not in OPAQUE else []:
                signals[component.name, name] = len(signals)
    for channel in system.channels:
        signals[channel.target] = len(signals)
    columns = {
        dotted((component.name, name)): signals[component.name, name]
        for component in system.components
        for name in _recorded_outputs(component)
    }
    columns |= {dotted(channel.target): signals[channel.target] for channel in system.channels}
    targets = dict.fromkeys(fault.target for fault in system.faults)
    faulty = {target: slot for slot, target in enumerate(targets, len(signals))}
    columns |= {dotted(target): slot for target, slot in faulty.items()}
    by_name = {component.name: component for component in system.components}
    variables = {dotted(end): by_name[end[0]].fmu.variables[end[1]] for end in (*signals, *faulty)}
    recorded = len(signals) + len(faulty)
    total = recorded + sum(channel.linear for channel in system.channels)
    return Layout(signals, columns, recorded, total, variables, faulty)


def _text_signals(system: System, first: int) -> dict[tuple[str, str], int]:
    """Return the slots of the texts that drive something, those of a component in a row."""
    taken = {connection.source for connection in system.connections}
    ends = [
        (component.name, name)
        for component in system.components
        for fmi_type, names in _outputs(component, taken).items()
        if fmi_type in OPAQUE
        for name in names
    ]
    return {end: slot for slot, end in enumerate(ends, first)}


def _channel_signals(
    system: System, signals: dict[tuple[str, str], int], values: array[float], total: int
) -> tuple[list[tuple[Channel, int]], list[Line]]:
    """Put the values for initialisation into the signals of the channels."""
    by_name = {component.name: component for component in system.components}
    holds: list[tuple[Channel, int]] = []
    lines: list[Line] = []
    middle = total - sum(channel.linear for channel in system.channels)
    for channel in system.channels:
        name, variable = channel.target
        start = float(by_name[name].fmu.variables[variable].start or 0.0)
        slot = signals[channel.target]
        values[slot] = first_value(channel, start)
        if channel.linear:
            values[middle] = values[slot]
            lines.append(Line(channel, slot, middle, start))
            middle += 1
        else:
            holds.append((channel, slot))
    return holds, lines


def _sources(
    system: System, signals: dict[tuple[str, str], int], roles: dict[str, Role], lines: list[Line]
) -> dict[tuple[str, str], Source]:
    """Return slot, factor, offset and table of each driven input: a continuous one follows a line by its middles."""
    sources: dict[tuple[str, str], Source] = {}
    for connection in system.connections:
        sources[connection.target] = (
            signals[connection.source],
            connection.factor,
            connection.offset,
            connection.table,
        )
    middles = {line.slot: line.middle for line in lines}
    for channel in system.channels:
        slot = signals[channel.target]
        fmu = next(c.fmu for c in system.components if c.name == channel.target[0])
        any_step = fmu.capabilities["canHandleVariableCommunicationStepSize"]
        if roles[channel.target[0]] is Role.CONTINUOUS and any_step:
            slot = middles.get(slot, slot)
        sources[channel.target] = (slot, 1.0, 0.0, ())
    return sources


def _idle_elements(
    component: Component, sources: dict[tuple[str, str], Source], zero: int
) -> dict[tuple[str, str], Source]:
    """Return the elements of arrays, other elements of which are driven: they are set with them, to their start."""
    variables = component.fmu.variables.values()
    arrays = {v.array for v in variables if v.array is not None and (component.name, v.name) in sources}
    return {
        (component.name, v.name): (zero, 1.0, float(v.start or 0.0), ())
        for v in variables
        if v.array in arrays and (component.name, v.name) not in sources
    }


def _input_groups(
    component: Component,
    instance: Instance,
    sources: dict[tuple[str, str], Source],
    inputs: array[float],
    free: int,
) -> tuple[InputGroup, ...]:
    driven = [name for name in component.fmu.variables if (component.name, name) in sources]
    groups: list[InputGroup] = []
    for fmi_type, names in _by_type(component, driven).items():
        wires = tuple(Wire(target, *sources[component.name, name]) for target, name in enumerate(names, free))
        buffer, address = _memory(component, instance, names, inputs, free)
        access = instance.access("Set", names, address, _sizes(buffer))
        groups.append(InputGroup(fmi_type, access, free, buffer, wires, tuple(names)))
        free += len(names)
    return tuple(groups)


def _output_groups(
    component: Component,
    instance: Instance,
    signals: dict[tuple[str, str], int],
    taken: set[tuple[str, str]],
    values: array[float],
) -> tuple[OutputGroup, ...]:
    groups: list[OutputGroup] = []
    for fmi_type, names in _outputs(component, taken).items():
        start = signals[component.name, names[0]]
        buffer, address = _memory(component, instance, names, values, start)
        connected_names = [name for name in names if _is_taken(component, name, taken)]
        whole = instance.access("Get", names, address, _sizes(buffer))
        connected = instance.access("Get", connected_names, address, _sizes(buffer)) if connected_names else None
        groups.append(OutputGroup(fmi_type, whole, connected, start, buffer))
    return tuple(groups)


def _memory(
    component: Component, instance: Instance, names: list[str], vector: array[float], start: int
) -> tuple[Buffer, int]:
    """Return the buffer and the address that a call uses: the vector itself for doubles."""
    fmi_type, count = component.fmu.fmi_types[names[0]], len(names)
    if fmi_type == "String":
        texts = (c_char_p * count)()
        return texts, addressof(texts)
    if fmi_type == "Binary":
        kinds = [component.fmu.variables[name].binary for name in names]
        binaries = Binaries([c_size_t(-1).value if kind is None or kind.most is None else kind.most for kind in kinds])
        return binaries, addressof(binaries.places)
    code = instance.type_codes[fmi_type]
    if code == "d":
        return None, vector.buffer_info()[0] + start * vector.itemsize
    buffer: array[Any] = array(code, [0] * count)
    return buffer, buffer.buffer_info()[0]


def _sizes(buffer: Buffer) -> int | None:
    return addressof(buffer.sizes) if isinstance(buffer, Binaries) else None


def _triggers(
    system: System,
    groups: tuple[InputGroup, ...],
    signals: dict[tuple[str, str], int],
    roles: dict[str, Role],
    faults: SignalFaults,
) -> tuple[Wire, ...]:
    """Return the wires from sources that change at instants only: discrete components and hold channels.

    A fault does not change what the source is.
    """
    stepwise = {signals[channel.target] for channel in system.channels if not channel.linear}
    stepwise |= {
        slot for (name, variable), slot in signals.items() if _is_discrete_output(system, name, variable, roles)
    }
    stepwise |= {one.slot for one in faults.inputs if one.triggers}
    return tuple(wire for group in groups for wire in group.wires if wire.source in stepwise)


def _is_discrete_output(system: System, name: str, variable: str, roles: dict[str, Role]) -> bool:
    fmu = next(component.fmu for component in system.components if component.name == name)
    return roles[name] is not Role.CONTINUOUS and fmu.variables[variable].causality == "output"
