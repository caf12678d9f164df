"""What was simulated, as far as a checkpoint depends on it, and what differs in another system."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from cosim.engine.fmu._variable import Value
from cosim.engine.system._connection import Connection, dotted
from cosim.engine.system._fault import Fault, described
from cosim.engine.system._parameters import parameters_of
from cosim.engine.system._role import Role, role_of
from cosim.engine.system._system import SAME_INSTANT, Channel, Component, System
from cosim.errors import InputError

Setting = float | str | None


@dataclass(frozen=True)
class UsedFmu:
    """A component: its name, the FMU's model, FMI version, interface and hash, the role, and all parameters given."""

    name: str
    model: str
    fmi_version: str
    interface: str
    sha256: str
    role: str
    parameters: dict[str, Value]


@dataclass(frozen=True)
class Past:
    """A channel, with the entries (times in s, values) that were of influence up to the checkpoint."""

    target: tuple[str, str]
    linear: bool
    times: tuple[float, ...]
    values: tuple[float, ...]


@dataclass(frozen=True)
class Setup:
    """Everything, with the channels' past up to a checkpoint; ``settings`` are the numbers that ask for the run.

    ``horizon`` [s] is the stop time that the FMUs were told: there the run ends at the latest, infinite if none.
    """

    components: tuple[UsedFmu, ...]
    connections: tuple[Connection, ...]
    channels: tuple[Past, ...]
    faults: tuple[Fault, ...]
    settings: dict[str, Setting]
    horizon: float


def describe(system: System, settings: dict[str, Setting], horizon: float, time: float) -> Setup:
    """Return the setup of a checked system for a checkpoint at ``time`` [s]."""
    return Setup(
        tuple(_used(component, settings["algorithm"] == "jacobi") for component in system.components),
        tuple(
            Connection(c.source, c.target, c.factor, c.offset, tuple((a, b) for a, b in c.table))
            for c in system.connections
        ),
        tuple(past(channel, time) for channel in system.channels),
        tuple(system.faults),
        dict(settings),
        horizon,
    )


def _used(component: Component, stepped_together: bool) -> UsedFmu:
    fmu = component.fmu
    role = Role.CONTINUOUS if stepped_together else role_of(fmu)
    given = parameters_of(component)
    return UsedFmu(component.name, fmu.name, fmu.fmi_version, fmu.interface, fmu.sha256, role.value, given)


def past(channel: Channel, time: float) -> Past:
    """Return the entries up to ``time`` [s]; of a linear channel between two entries also the one after."""
    count = sum(1 for t in channel.times if t <= time + SAME_INSTANT)
    between = 0 < count < len(channel.times) and channel.times[count - 1] < time - SAME_INSTANT
    count += channel.linear and between
    return Past(channel.target, channel.linear, tuple(channel.times[:count]), tuple(channel.values[:count]))


def differences(saved: Setup, present: Setup) -> list[str]:
    """Return what makes it impossible to go on from the saved one in the present one, each as part of a sentence.

    Parameters that may be tuned are left out: ``tuned`` has those.
    """
    return [
        *_settings(saved, present),
        *_components(saved, present),
        *_connections(saved, present),
        *_past(saved, present),
        *_faults(saved, present),
    ]


def _settings(saved: Setup, present: Setup) -> Iterator[str]:
    for name in {**saved.settings, **present.settings}:
        here, there = present.settings.get(name), saved.settings.get(name)
        if here != there:
            yield f"{name} is {_shown(here)}, in the checkpoint {_shown(there)}"


def _components(saved: Setup, present: Setup) -> Iterator[str]:
    names, before = [c.name for c in present.components], [c.name for c in saved.components]
    if names != before:
        yield f"the components are {', '.join(names)}, in the checkpoint {', '.join(before)}"
        return
    for here, there in zip(present.components, saved.components, strict=True):
        if here.sha256 != there.sha256:
            yield (
                f"{here.name} has another FMU: {_fmu(here)}, in the checkpoint {_fmu(there)}, and a state belongs to "
                "one build"
            )
        elif (here.interface, here.role) != (there.interface, there.role):
            yield (
                f"{here.name} is used as {here.interface}, {here.role}, in the checkpoint as {there.interface}, "
                f"{there.role}"
            )


def _fmu(used: UsedFmu) -> str:
    return f"{used.model} (FMI {used.fmi_version}, SHA-256 {used.sha256[:12]}...)"


def _connections(saved: Setup, present: Setup) -> Iterator[str]:
    for connection in present.connections:
        if connection not in saved.connections:
            yield f"the connection {_wire(connection)} is not in the checkpoint"
    for connection in saved.connections:
        if connection not in present.connections:
            yield f"the checkpoint has a connection {_wire(connection)}"
    here, there = (sorted(map(_wire, setup.connections)) for setup in (present, saved))
    if here == there and present.connections != saved.connections:
        yield "the connections are in another order than in the checkpoint"


def _wire(connection: Connection) -> str:
    text = f"{dotted(connection.source)} -> {dotted(connection.target)}"
    if (connection.factor, connection.offset) != (1.0, 0.0):
        text += f" (factor {connection.factor:g}, offset {connection.offset:g})"
    return text + (f" (table {connection.table})" if connection.table else "")


def _past(saved: Setup, present: Setup) -> Iterator[str]:
    names, before = ([dotted(c.target) for c in setup.channels] for setup in (present, saved))
    if names != before:
        yield (
            f"the channels are {', '.join(names) or 'none'}, in the checkpoint {', '.join(before) or 'none'} (an input "
            "that is to be driven later has to be driven from the beginning, by its start value)"
        )
        return
    for here, there in zip(present.channels, saved.channels, strict=True):
        name = dotted(here.target)
        if here.linear != there.linear:
            kinds = {True: "interpolated", False: "held"}
            yield f"the channel {name} is {kinds[here.linear]}, in the checkpoint {kinds[there.linear]}"
        elif (here.times, here.values) != (there.times, there.values):
            yield f"the channel {name} has another past{_first_difference(here, there)}"


def _first_difference(here: Past, there: Past) -> str:
    ours, theirs = (list(zip(one.times, one.values, strict=True)) for one in (here, there))
    for mine, other in zip(ours, theirs, strict=False):
        if mine != other:
            return f": {mine[1]:.12g} at {mine[0]:.12g} s, in the checkpoint {other[1]:.12g} at {other[0]:.12g} s"
    longer, where = (ours, "here") if len(ours) > len(theirs) else (theirs, "in the checkpoint")
    t, value = longer[min(len(ours), len(theirs))]
    return f": {value:.12g} at {t:.12g} s is only {where}"


def _faults(saved: Setup, present: Setup) -> Iterator[str]:
    if saved.faults != present.faults:
        here, there = (_told(setup.faults) for setup in (present, saved))
        yield f"the faults are {here}, in the checkpoint {there}"


def _told(faults: Sequence[Fault]) -> str:
    return ", ".join(f"{dotted(fault.target)} {described(fault, None)}" for fault in faults) or "none"


def tuned(saved: Setup, system: System) -> dict[str, dict[str, Value]]:
    """Return by component the parameters that differ from those of the checkpoint, with the values that they get.

    Raises InputError if one of them cannot be changed while a simulation runs.
    """
    found: dict[str, dict[str, Value]] = {}
    for component, before in zip(system.components, saved.components, strict=True):
        given = parameters_of(component)
        for name in {**before.parameters, **given}:
            variable = component.fmu.variables[name]
            value = given.get(name, variable.start)
            if value == before.parameters.get(name, variable.start):
                continue
            full = dotted((component.name, name))
            if value is None:
                raise InputError(f"{full}: was set for the checkpoint; set it here too, since it has no start value")
            if variable.variability != "tunable":
                was = _shown(before.parameters.get(name, variable.start))
                raise InputError(
                    f"{full}: is {_shown(value)}, in the checkpoint {was}; "
                    f"it is {variable.variability}, so it cannot change while a simulation runs; tunable are "
                    f"{', '.join(_tunable(component)) or 'none'}"
                )
            found.setdefault(component.name, {})[name] = value
    return found


def _tunable(component: Component) -> Sequence[str]:
    return [
        dotted((component.name, variable.name))
        for variable in component.fmu.variables.values()
        if variable.causality == "parameter" and variable.variability == "tunable"
    ]


def _shown(value: object) -> str:
    if isinstance(value, float):
        return "none" if math.isinf(value) else f"{value:.12g}"
    return "not given" if value is None else str(value)
