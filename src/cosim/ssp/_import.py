"""A system structure as the pieces of the engine's system."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from cosim.engine import Channel, Component, Connection
from cosim.ssp._flatten import End, Input, connections, flatten, inputs, unknown_units
from cosim.ssp._package import open_package
from cosim.ssp._read import read_structure
from cosim.ssp._values import values

SAME_INSTANT = 1e-9


@dataclass
class Imported:
    """What an SSP has for a simulation.

    ``components`` have dotted names (``sub.plant``) and the parameters that the SSP sets, ``inputs`` are the input
    connectors of the whole system, which a scenario may drive, ``starts`` the start values of inputs, in the FMUs'
    units, and ``notes`` what has no effect.
    """

    components: list[Component]
    connections: list[Connection]
    inputs: dict[str, Input]
    starts: dict[End, float]
    notes: list[str]


def read_ssp(path: Path) -> Imported:
    """Read an ``.ssp`` (``x.ssp#Variant.ssd`` for another system structure in it than the default one) or an ``.ssd``.

    Raises `InputError`, with file and line, for what is wrong with it or not supported.
    """
    structure = read_structure(open_package(path))
    flat = flatten(structure)
    given = values(flat)
    components = flat.components
    by_name = {component.name: component for component in components}
    for (owner, name), (value, origin) in given.parameters.items():
        by_name[owner].parameters[name] = value
        by_name[owner].origins[name] = f"set by {origin}"
    notes = [*given.notes, *unknown_units(flat)]
    if structure.start:
        notes.append(f"{structure.location.label}: startTime is {structure.start:g} s; the simulation starts at 0 s")
    return Imported(components, connections(flat), inputs(flat), given.starts, notes)


def start_values(imported: Imported, channels: list[Channel], connected: set[End]) -> list[Channel]:
    """Let inputs start at the values that the SSP gives: before the first entry of their channel, or all the time.

    ``connected`` inputs get theirs from an output at once.
    """
    variables = {(c.name, v.name): v for c in imported.components for v in c.fmu.variables.values()}
    starts = {
        end: value
        for end, value in imported.starts.items()
        if end not in connected and value != float(variables[end].start or 0.0)
    }
    channels = [
        _starting_at(starts.pop(channel.target), channel) if channel.target in starts else channel
        for channel in channels
    ]
    return channels + [Channel(end, [0.0], [value]) for end, value in starts.items()]


def _starting_at(value: float, channel: Channel) -> Channel:
    """Return a channel that has a value from 0 s on and steps from there to its own first entry."""
    times, entries = channel.times, channel.values
    if times[0] <= SAME_INSTANT:
        return channel
    if len(times) > 1 and times[1] == times[0]:  # of its step at once only the second value counts
        times, entries = times[1:], entries[1:]
    step = ([0.0, times[0]], [value, value]) if channel.linear else ([0.0], [value])
    return Channel(channel.target, [*step[0], *times], [*step[1], *entries], channel.linear)
