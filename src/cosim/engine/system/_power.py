"""Pairs of connections that carry power between two components: an effort one way, a flow the other."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from cosim.engine.fmu._variable import Variable
from cosim.engine.system._connection import Connection
from cosim.errors import InputError
from cosim.units import BASE, parse

End = tuple[str, str]

_WATT = {"kg": 1, "m": 2, "s": -3}


@dataclass(frozen=True)
class PowerConnection:
    """An output that is an effort and one that is a flow, as (component, output), each connected to the other's owner.

    Their product is a power: force and velocity, torque and angular velocity, voltage and current. ``sign`` 1 tells
    that the effort, as its target gets it, times the flow is what the owner of the flow takes; -1 that it is what this
    gives: a torque that is counted as a load.
    """

    effort: End
    flow: End
    sign: float = 1.0

    def __str__(self) -> str:
        """Return it as a scenario writes it."""
        return f"{'-' if self.sign < 0.0 else ''}{'.'.join(self.effort)} * {'.'.join(self.flow)}"


def check_power(
    power: PowerConnection, connections: Sequence[Connection], find: Callable[[End, str], Variable]
) -> None:
    """Raise InputError if this is no pair of connections that carries power; ``find`` gives an output or raises."""
    effort, flow = (find(end, "output") for end in (power.effort, power.flow))
    if power.sign not in (1.0, -1.0):
        raise InputError(f"power {power}: its sign is {power.sign:g}; it can be 1 or -1")
    if (effort.type, flow.type) != ("Real", "Real"):
        raise InputError(f"power {power}: both have to be Real; they are {effort.type} and {flow.type}")
    for connection in ends_of(power, connections):
        if connection.factor == 0.0 or connection.table:
            raise InputError(f"power {power}: what connects {'.'.join(connection.source)} loses its value")
    watts(power, effort, flow)


def ends_of(power: PowerConnection, connections: Sequence[Connection]) -> tuple[Connection, Connection]:
    """Return the connection that hands on the effort, and that which hands on the flow; raises InputError."""
    found: list[Connection] = []
    for source, owner in ((power.effort, power.flow[0]), (power.flow, power.effort[0])):
        both = [c for c in connections if c.source == source and c.target[0] == owner != source[0]]
        if len(both) != 1:
            many = f"drives {len(both)} inputs" if both else "drives no input"
            raise InputError(
                f"power {power}: {'.'.join(source)} {many} of {owner}; power goes over one connection each way"
            )
        found += both
    return found[0], found[1]


def watts(power: PowerConnection, effort: Variable, flow: Variable) -> float:
    """Return how many watts a product of 1 is; raises InputError if it is no power. Without units, SI is meant."""
    if effort.unit is None or flow.unit is None:
        return 1.0
    try:
        units = [parse(variable.unit or "1") for variable in (effort, flow)]
    except InputError:
        return 1.0  # that it is not understood is said where units matter
    total = {base: sum(unit.exponents.get(base, 0) for unit in units) for base in BASE if base != "rad"}
    if {base: n for base, n in total.items() if n} != _WATT or any(unit.offset for unit in units):
        raise InputError(
            f"power {power}: {effort.unit} times {flow.unit} is no power; name an effort and a flow, such as a torque "
            "[N.m] and an angular velocity [rad/s]"
        )
    return math.prod(unit.factor for unit in units)
