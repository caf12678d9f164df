"""Initialisation: all components brought to t = 0, their connections fulfilled."""

from __future__ import annotations

from collections.abc import Collection
from functools import partial

from cosim.engine.algebra._algebraic import LoopError, Network
from cosim.engine.algebra._port import Port
from cosim.engine.fmu._instance import CallError
from cosim.engine.loop._loop import check_numbers
from cosim.engine.loop._plan import Plan
from cosim.engine.signals._participant import Participant
from cosim.engine.system._graph import Depends, Phase, declared
from cosim.engine.system._role import Role
from cosim.engine.system._system import System

_MOST_PASSES = 50


def initialize(plan: Plan, system: System, tolerance: float, stop: float | None) -> list[str]:
    """Bring all components to t = 0, their connections fulfilled; return what the user should know of the solution.

    Outputs are read once all inputs are set that they depend on according to the model descriptions. What depends on
    itself around a loop is solved for. If the connections are not fulfilled then, the descriptions are wrong, and every
    output is taken to depend on every input of its component; so are those of a component that cannot be read before
    all its inputs are set. Only continuous components are told the stop time: one that is sampled at stop must be
    allowed to step past it; ``stop`` [s] is None if the end is not known. Raises CallError.
    """
    participants = [*plan.continuous, *plan.discrete]
    for participant in participants:
        if not participant.instance.initializes_at_once:
            _enter(participant, tolerance, stop)
    remarks = _settle(plan, system, tolerance, stop)
    for participant in participants:
        participant.instance.exit_initialization()
    for participant in plan.continuous:
        participant.read()
    return remarks


def _enter(participant: Participant, tolerance: float, stop: float | None) -> None:
    continuous = participant.role is Role.CONTINUOUS
    participant.instance.enter_initialization(tolerance, stop if continuous else None)


def _settle(plan: Plan, system: System, tolerance: float, stop: float | None) -> list[str]:
    """Set all inputs and read all outputs, and do so again if descriptions turn out to be wrong."""
    ports = _ports(plan, tolerance, stop)
    for port in ports.values():
        port.start()
    described = declared(system.components, Phase.INITIALIZATION)
    wary: set[str] = set()  # components whose descriptions are not believed
    while True:
        network = Network.of(plan, system, ports, _unless(wary, described), tolerance)
        try:
            network.settle()
            fulfilled = _is_fulfilled(plan, network)
        except CallError as failure:
            name = failure.instance.name
            if isinstance(failure, LoopError) or name in wary or ports[name].is_complete:
                raise
            wary.add(name)
            continue
        if fulfilled:
            return network.remarks
        if len(wary) < len(ports):
            wary.update(ports)
            continue
        for _ in range(_MOST_PASSES):
            if _is_fulfilled(plan, network):
                return network.remarks
        raise CallError(
            next(port for port in ports.values() if port.wires).participant.instance,
            f"inputs and outputs do not agree after {_MOST_PASSES} more passes of initialisation",
            "look for an output that changes whenever it is read",
        )


def _ports(plan: Plan, tolerance: float, stop: float | None) -> dict[str, Port]:
    slots: dict[str, dict[str, int]] = {}
    for (name, variable), slot in plan.signals.items():
        slots.setdefault(name, {})[variable] = slot
    return {
        participant.instance.name: Port(
            participant,
            slots.get(participant.instance.name, {}),
            partial(_enter, participant, tolerance, stop) if participant.instance.initializes_at_once else None,
        )
        for participant in (*plan.continuous, *plan.discrete)
    }


def _unless(wary: Collection[str], described: Depends) -> Depends:
    return lambda output, name: output[0] in wary or described(output, name)


def _is_fulfilled(plan: Plan, network: Network) -> bool:
    """Set all inputs, read all outputs, and tell whether the inputs agree with them; if not, set them again."""
    ports = network.ports.values()
    for port in ports:
        port.write(network.known)
    for port in ports:
        port.participant.read()
    check_numbers(plan)
    before = list(plan.inputs)
    for port in ports:
        port.write(network.known)
    single = {slot for end, slot in plan.signals.items() if network.is_single(end)}
    for port in ports:
        for wire, _, group in port.wires:
            old, new = before[wire.target], plan.inputs[wire.target]
            size = max(abs(old), abs(new), abs(wire.factor) * network.sizes.get(wire.source, 0.0))
            if abs(new - old) > size * network.agreement(group.fmi_type == "Float32" or wire.source in single):
                return False
    return True
