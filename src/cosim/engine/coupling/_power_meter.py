"""What both sides of a power connection see of it, in time: what one gives, what the other takes.

Over a macro step each side holds what it has got of the other: the owner of the effort e sees the power e f', with the
flow f' that it holds, and that of the flow f sees e' f. The integrals of both, with the trapezoidal rule for what is
not held, differ by the energy that the coupling adds to the system (S. Sadjina et al., Engineering with Computers 33,
2017, p. 607). All numbers are in arrays, so that they can be saved and restored.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from cosim.engine.system._connection import dotted
from cosim.engine.system._power import PowerConnection, ends_of, watts
from cosim.engine.system._role import Role, fixed_step_of, role_of
from cosim.engine.system._system import Component, System

GIVEN, TAKEN, THROUGH = 0, 1, 2
"""Energies of a bond in ``PowerMeter.energies``: from one side, by the other, and the mean of both without signs."""


@dataclass(frozen=True)
class Bond:
    """One power connection in the tables: the signals of effort and flow, and the places of inputs that hold them.

    Each input is ``factor`` times its signal plus ``offset``; ``watts`` is what a product of 1 is, with its sign.
    """

    effort: int
    flow: int
    held_effort: int
    held_flow: int
    effort_factor: float
    effort_offset: float
    flow_factor: float
    flow_offset: float
    watts: float


@dataclass(frozen=True)
class Entry:
    """A power connection and what is to be said of it; without a bond it is not measured."""

    power: PowerConnection
    bond: Bond | None
    note: str


class PowerMeter:
    """The bonds of a run; ``energies`` [J] are three for each, ``start`` its effort and flow where the step begins."""

    def __init__(self, entries: Sequence[Entry] = ()) -> None:
        """Begin with nothing exchanged."""
        self.entries = tuple(entries)
        self.bonds = tuple(entry.bond for entry in entries if entry.bond is not None)
        self.energies = array("d", bytes(24 * len(self.bonds)))
        self.start = array("d", bytes(16 * len(self.bonds)))

    def begin(self, values: array[float]) -> None:
        """Note the signals where the first macro step begins."""
        for i, bond in enumerate(self.bonds):
            self.start[2 * i] = values[bond.effort]
            self.start[2 * i + 1] = values[bond.flow]

    def end(self, values: array[float], inputs: array[float], h: float) -> None:
        """Add what went over in a macro step of h [s], after it, while the inputs are still what was held."""
        energies = self.energies
        for i, bond in enumerate(self.bonds):
            effort = 0.5 * (self.start[2 * i] + values[bond.effort])
            flow = 0.5 * (self.start[2 * i + 1] + values[bond.flow])
            held_effort = (inputs[bond.held_effort] - bond.effort_offset) / bond.effort_factor
            held_flow = (inputs[bond.held_flow] - bond.flow_offset) / bond.flow_factor
            given = bond.watts * effort * held_flow * h
            taken = bond.watts * held_effort * flow * h
            energies[3 * i + GIVEN] = energies[3 * i + GIVEN] + given
            energies[3 * i + TAKEN] = energies[3 * i + TAKEN] + taken
            energies[3 * i + THROUGH] = energies[3 * i + THROUGH] + 0.5 * (abs(given) + abs(taken))
        self.begin(values)  # of the next step

    def account(self) -> list[dict[str, object]]:
        """Return what is known of each power connection, ready for JSON: see ``Result.statistics``."""
        energies = iter(self.energies)
        return [
            _account(entry, *((next(energies), next(energies), next(energies)) if entry.bond else (None,) * 3))
            for entry in self.entries
        ]


def _account(entry: Entry, given: float | None, taken: float | None, exchanged: float | None) -> dict[str, object]:
    error = taken - given if taken is not None and given is not None else None
    return {
        "effort": dotted(entry.power.effort),
        "flow": dotted(entry.power.flow),
        "given_J": given,
        "taken_J": taken,
        "error_J": error,
        "exchanged_J": exchanged,
        "relative": error / exchanged if error is not None and exchanged else None,
        "note": entry.note,
    }


def meter_of(
    system: System, columns: Mapping[str, int], inputs: Mapping[tuple[str, str], int], output_interval: float
) -> PowerMeter:
    """Return the meter of a checked system; ``columns`` are signals by name, ``inputs`` places of driven inputs."""
    by_name = {component.name: component for component in system.components}
    entries: list[Entry] = []
    for power in system.power:
        owners = [by_name[power.effort[0]], by_name[power.flow[0]]]
        if why := next((why for owner in owners if (why := _why_unmeasured(owner, output_interval))), ""):
            entries.append(Entry(power, None, why))
            continue
        effort, flow = ends_of(power, system.connections)
        found = (by_name[name].fmu.variables[output] for name, output in (power.effort, power.flow))
        bond = Bond(
            columns[dotted(power.effort)],
            columns[dotted(power.flow)],
            inputs[effort.target],
            inputs[flow.target],
            effort.factor,
            effort.offset,
            flow.factor,
            flow.offset,
            watts(power, *found) * power.sign * math.copysign(1.0, effort.factor),
        )
        through = _fed_through(owners[0], power.effort[1], flow.target[1])
        through = through or _fed_through(owners[1], power.flow[1], effort.target[1])
        entries.append(Entry(power, bond, through))
    return PowerMeter(entries)


def _why_unmeasured(component: Component, output_interval: float) -> str:
    if role_of(component.fmu) is not Role.CONTINUOUS:
        return f"not measured: {component.name} acts at instants"
    step = fixed_step_of(component, output_interval)
    return f"not measured: {component.name} takes steps of {step:g} s only" if step < math.inf else ""


def _fed_through(component: Component, output: str, got: str) -> str:
    """Return a note on an output that depends directly on an input: it is another one as soon as that changes."""
    known = component.fmu.dependencies.get(output)
    if known is None or got in known:
        return f"approximate: {component.name}.{output} depends directly on {component.name}.{got}"
    return ""
