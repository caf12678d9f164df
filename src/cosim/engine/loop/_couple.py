"""Makes the coupling of a run: which links there are, how each input is held, what is corrected."""

from __future__ import annotations

from array import array
from collections.abc import Mapping, Sequence
from ctypes import c_double, c_uint

from cosim.engine.coupling._coupling import SMALL, Correction, Coupling, Link, Member, Observed
from cosim.engine.fmu._fmu import Fmu
from cosim.engine.loop._plan import Plan
from cosim.engine.signals._participant import Participant
from cosim.engine.signals._signal_faults import FaultyInput
from cosim.engine.system._connection import Connection, dotted
from cosim.engine.system._method import Method, fed_through, holds_end
from cosim.engine.system._system import System
from cosim.engine.system._wire import Wire


def couple(system: System, plan: Plan, method: Method, tolerance: float, stop: float) -> Coupling:
    """Let the inputs of the links of a plan take their values from the signals that the coupling holds for them."""
    fmus = {component.name: component.fmu for component in system.components}
    connections = {c.target: c for c in system.connections if c.target in plan.held}
    ends = {name for c in connections.values() for name in (c.source[0], c.target[0])}
    together = [p for p in plan.continuous if p.instance.name in ends]
    place = {participant.instance.name: number for number, participant in enumerate(together)}
    links: list[Link] = []
    members: list[Member] = []
    for participant in together:
        own: dict[str, int] = {}
        for name, wire, faulty in _engage(participant, plan.held):
            connection = connections[participant.instance.name, name]
            own[name] = len(links)
            slot = plan.held[connection.target]
            ahead = place[connection.source[0]] < place[participant.instance.name]
            held = holds_end(participant.instance.fmu, name)
            known = is_compared(fmus[connection.source[0]])
            small = SMALL * _nominal(connection, fmus)
            links.append(Link(wire, dotted(connection.target), slot, ahead, held, known, small, faulty))
            plan.values[slot] = links[-1].of(plan.values)
        correction = _correction(participant, own, links, plan, system)
        observed = _observed(participant) if method.algorithm == "adaptive" else None
        members.append(Member(participant, tuple(own.values()), correction, observed))
    coupling = Coupling(
        method,
        tolerance,
        stop,
        links,
        members,
        [p for p in plan.continuous if p not in together],
        (plan.values, plan.inputs, plan.first_text),
        plan.lines,
        plan.faults,
        plan.power,
    )
    for member in members:
        if method.goes_back:
            member.participant.instance.no_return.value = 0
    return coupling


def _engage(
    participant: Participant, held: Mapping[tuple[str, str], int]
) -> list[tuple[str, Wire, FaultyInput | None]]:
    """Let linked inputs, or their faults, read what is held for them; return their names and what they read before."""
    engaged: list[tuple[str, Wire, FaultyInput | None]] = []
    groups = []
    for group in participant.input_groups:
        wires = list(group.wires)
        for k, name in enumerate(group.names):
            slot = held.get((participant.instance.name, name))
            if slot is None:
                continue
            faulty = next((one for one in participant.faulty if one.slot == wires[k].source), None)
            if faulty is None:
                engaged.append((name, wires[k], None))
                wires[k] = Wire(wires[k].target, slot, 1.0, 0.0)
            else:
                engaged.append((name, faulty.at, faulty))
                faulty.held, faulty.linked = Wire(-1, slot, 1.0, 0.0), True
        groups.append(group._replace(wires=tuple(wires)))
    participant.input_groups = tuple(groups)
    return engaged


def is_compared(fmu: Fmu) -> bool:
    """Tell whether the continuous states of an FMU are known, as doubles, so that they can be compared."""
    return bool(fmu.state_names) and all(fmu.fmi_types[name] in ("Real", "Float64") for name in fmu.state_names)


def _nominal(connection: Connection, fmus: Mapping[str, Fmu]) -> float:
    """Return what is usual for a connection, in the unit of its target: what either end says, or else 1."""
    (source, output), (target, name) = connection.source, connection.target
    own, given = fmus[target].variables[name].nominal, fmus[source].variables[output].nominal
    return abs(own or (given or 0.0) * connection.factor) or 1.0


def _observed(participant: Participant) -> Observed | None:
    instance = participant.instance
    names = instance.fmu.state_names
    if not is_compared(instance.fmu):
        return None
    n = len(names)
    values, full = array("d", bytes(8 * n)), array("d", bytes(8 * n))
    access = instance.access("Get", names, values.buffer_info()[0])
    small = [SMALL * abs(instance.fmu.variables[name].nominal or 1.0) for name in names]
    return Observed(access, values, full, array("d", small))


def _correction(
    participant: Participant, own: Mapping[str, int], links: Sequence[Link], plan: Plan, system: System
) -> Correction | None:
    instance, fmu = participant.instance, participant.instance.fmu
    inputs = [name for name, i in own.items() if not links[i].holds_end and fed_through(fmu, name)]
    dependent = {output for name in inputs for output in fed_through(fmu, name)}
    taken = {c.source for c in system.connections}
    outputs = sorted(dependent, key=lambda name: ((instance.name, name) not in taken, name))
    if not inputs:
        return None
    n_connected = sum((instance.name, name) in taken for name in outputs)
    knowns = (c_uint * len(inputs))(*(fmu.variables[name].value_reference for name in inputs))
    unknowns = (c_uint * len(outputs))(*(fmu.variables[name].value_reference for name in outputs))
    seed, slope = (c_double * len(inputs))(), (c_double * len(outputs))()
    connected, whole = (
        instance.directional_derivative((unknowns, n), (knowns, len(inputs)), seed, slope)
        for n in (n_connected, len(outputs))
    )
    slots = tuple(plan.columns[dotted((instance.name, name))] for name in outputs)
    return Correction(
        links=tuple(own[name] for name in inputs),
        slots=slots,
        n_connected=n_connected,
        calls=(connected, whole),
        inputs=knowns,
        outputs=unknowns,
        seed=seed,
        slope=slope,
        raw=(c_double * len(outputs))(),
    )
