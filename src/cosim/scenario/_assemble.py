"""From a scenario to the engine's system: load the FMUs, connect them, resolve channels and parameters."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

from cosim.engine import Channel, Component, Connection, Fmu, PowerConnection, System
from cosim.errors import InputError
from cosim.scenario._faults import assemble_faults
from cosim.scenario._model import Column, Scenario, ScenarioWarning, Setting, is_structure
from cosim.scenario._names import End, dotted, find_end, regrouped, resolve
from cosim.scenario._values import channel_values, check_range, connection_map, parameter_value
from cosim.units import convert, parse

if TYPE_CHECKING:
    from cosim.ssp import Input

Locate = Callable[[str], Path]
"""Takes the name of a built-in plant or controller, gives the path of its FMU; raises `InputError` if unknown."""

_SECOND = parse("s")


def assemble(scenario: Scenario, locate: Locate) -> System:
    """Build the system that a scenario describes: ``plant``, ``controller`` unless none, connections and channels.

    FMUs are named by their path, relative to the scenario's folder, or by a name for ``locate``. Outputs and inputs of
    the same name are connected unless a ``map`` line says otherwise. A system structure (.ssp, .ssd) brings components
    and connections of its own; channels drive its input connectors, or inputs that it leaves free. Channels and
    parameters come out in the FMUs' units. Raises `InputError` with file, line and column for what does not fit the
    FMUs; warns with `ScenarioWarning` about a ``sample_time`` that nothing uses, values of an SSP that set nothing, and
    units of an FMU that are not understood.
    """
    if is_structure(scenario.system):
        return _checked(_assemble_structure(scenario), scenario)
    components = [Component("plant", _load(scenario, "system", scenario.system, locate))]
    if scenario.controller is not None:
        components.append(Component("controller", _load(scenario, "controller", scenario.controller, locate)))
    system = System(components)
    settings = _set_parameters(scenario, components)
    _set_sample_time(scenario, components, settings.get(("controller", "T_sample")))
    system.connections = _connections(scenario, components)
    system.channels = _channels(scenario, components, system.connections)
    system.faults = assemble_faults(scenario, components, system.connections)
    return _checked(system, scenario)


def _assemble_structure(scenario: Scenario) -> System:
    """Return the system that an SSP describes, with the scenario's parameters, connections and channels added to it."""
    from cosim.ssp import read_ssp, start_values  # few scenarios need it, and it takes time to import

    line = scenario.key_lines.get("system")
    if scenario.controller is not None:
        raise InputError(
            f"the components of '{scenario.system}' are all in it; take the 'controller' out",
            file=scenario.path,
            line=scenario.key_lines.get("controller"),
        )
    try:
        imported = read_ssp(_path_of(scenario, "system", scenario.system))
    except InputError as error:
        raise _located(error, scenario, line) from error
    for note in imported.notes:
        warnings.warn(note, ScenarioWarning, stacklevel=3)
    components = imported.components
    settings = _set_parameters(scenario, components)
    if "sample_time" in scenario.key_lines:
        _set_sample_time(scenario, components, settings.get(("controller", "T_sample")))
    connections = [*imported.connections, *_links(scenario, components)]
    channels = _channels(scenario, components, connections, imported.inputs)
    connected = {connection.target for connection in connections}
    faults = assemble_faults(scenario, components, connections)
    return System(components, connections, start_values(imported, channels, connected), faults)


def _checked(system: System, scenario: Scenario) -> System:
    """Return the system with what may follow on its connections, once all of it fits together."""
    try:
        system.check()
    except InputError as error:
        raise _located(error, scenario) from error
    for power in scenario.powers:
        effort, flow = (regrouped(end, system.components) for end in (power.effort, power.flow))
        system.power.append(PowerConnection(effort, flow, power.sign))
        try:
            system.check()
        except InputError as error:
            raise _located(error, scenario, power.line) from error
    return system


def _located(error: InputError, scenario: Scenario, line: int | None = None, column: int | None = None) -> InputError:
    """Return the error with its place in the scenario, unless it has a place already."""
    if error.file is not None:
        return error
    return InputError(str(error), file=scenario.path, line=line, column=column)


def _load(scenario: Scenario, key: str, name: str, locate: Locate) -> Fmu:
    line = scenario.key_lines.get(key)
    try:
        if is_structure(name):
            raise InputError(f"'{name}' is a whole system; give it as 'system', without a controller")
        if Path(name).suffix.lower() != ".fmu":
            return Fmu.read(locate(name))
        path = _path_of(scenario, key, name)
        if not path.is_file():
            raise InputError(f"there is no FMU '{path}'")
        return Fmu.read(path)
    except InputError as error:
        raise _located(error, scenario, line) from error


def _path_of(scenario: Scenario, key: str, name: str) -> Path:
    """Return the path that a key gives: one in the file is meant from the file, one in an option from where we are."""
    return (Path() if scenario.key_lines.get(key) is None else scenario.path.parent) / Path(name).expanduser()


def _set_parameters(scenario: Scenario, components: list[Component]) -> dict[End, Setting]:
    """Set the components' parameters; return what set each of them."""
    lines: dict[End, Setting] = {}
    for setting in scenario.settings:
        try:
            end, variable = resolve(setting.name, components, "parameter")
            first = lines.get(end)
            if first is not None and first.line is not None and setting.line is not None:
                raise InputError(f"'{dotted(end)}' is set a second time, first in line {first.line}")
            lines[end] = setting
            value = parameter_value(setting.value, dotted(end), variable)
        except InputError as error:
            raise InputError(str(error), file=setting.file, line=setting.line) from error
        component = next(component for component in components if component.name == end[0])
        component.parameters[end[1]] = value
        component.origins[end[1]] = setting.origin or _origin(setting.line)
    return lines


def _origin(line: int | None) -> str:
    """Return where a value comes from by the line it has in the scenario; None is an option."""
    return "set by --set" if line is None else "set by the scenario"


def _set_sample_time(scenario: Scenario, components: list[Component], setting: Setting | None) -> None:
    """Hand the sample time to the controller as ``T_sample``, which must be a multiple of its ``T_compute``.

    ``setting`` is what has set ``T_sample`` by its name; of both that which is an option wins.
    """
    controller = next((component for component in components if component.name == "controller"), None)
    sample = controller.fmu.variables.get("T_sample") if controller else None
    given = "sample_time" in scenario.key_lines
    line = scenario.key_lines.get("sample_time")
    if controller is None or sample is None or sample.causality != "parameter":
        if given:
            reason = "the controller has no parameter T_sample" if controller else "there is no controller"
            warnings.warn(f"{scenario.path}: 'sample_time' has no effect, {reason}", ScenarioWarning, stacklevel=3)
        return
    if given and setting is not None and (line is None) == (setting.line is None):
        raise InputError(
            "'sample_time' and 'controller.T_sample' are both given; keep one of them",
            file=setting.file,
            line=line,
        )
    if setting is None or (given and line is None):
        value = convert(scenario.sample_time, _SECOND, parse(sample.unit or "s"))
        try:
            check_range(value, "controller.T_sample", sample)
        except InputError as error:
            raise InputError(f"'sample_time': {error}", file=scenario.path, line=line) from None
        controller.parameters["T_sample"] = value
        controller.origins["T_sample"] = _origin(line) if given else "set by the scenario's default sample_time"
    compute = controller.fmu.variables.get("T_compute")
    period = controller.parameters.get("T_compute", compute.start) if compute else None
    if compute is None or not isinstance(period, float | int) or period <= 0:
        return
    compute_time = convert(period, parse(compute.unit or "s"), _SECOND)
    sample_time = convert(float(controller.parameters["T_sample"]), parse(sample.unit or "s"), _SECOND)
    ratio = sample_time / compute_time
    if round(ratio) < 1 or abs(ratio - round(ratio)) > 1e-9 * ratio:
        raise InputError(
            f"the sample time {sample_time:g} s is not a multiple of the controller's T_compute, {compute_time:g} s; "
            "change 'sample_time' or set controller.T_compute",
            file=scenario.path,
            line=line,
        )


def _links(scenario: Scenario, components: list[Component]) -> list[Connection]:
    """Return the connections of the ``map`` lines."""
    connections: list[Connection] = []
    for link in scenario.links:
        source_end, target_end = (regrouped(end, components) for end in (link.source, link.target))
        try:
            source = find_end(source_end, components, "output")
            target = find_end(target_end, components, "input")
            if any(target_end == connection.target for connection in connections):
                raise InputError(f"'{dotted(target_end)}' is connected a second time; an input has one source")
            factor, offset = connection_map(dotted(source_end), source, dotted(target_end), target)
        except InputError as error:
            raise InputError(str(error), file=scenario.path, line=link.line) from error
        connections.append(Connection(source_end, target_end, factor, offset))
    return connections


def _connections(scenario: Scenario, components: list[Component]) -> list[Connection]:
    connections = _links(scenario, components)
    mapped = {connection.target for connection in connections}
    for source_end, target_end in _same_names(components):
        if target_end in mapped:
            continue
        source = find_end(source_end, components, "output")
        target = find_end(target_end, components, "input")
        try:
            factor, offset = connection_map(dotted(source_end), source, dotted(target_end), target)
        except InputError as error:
            raise InputError(f"{error}; connect it otherwise with a 'map' line", file=scenario.path) from error
        connections.append(Connection(source_end, target_end, factor, offset))
    if len(components) > 1 and not connections:
        plant, controller = components
        raise InputError(
            "nothing connects plant and controller, no output has the name of an input; "
            f"plant has {_listed(plant)}, controller has {_listed(controller)}; add '# map: ...' lines",
            file=scenario.path,
            line=scenario.key_lines.get("controller"),
        )
    return connections


def _same_names(components: list[Component]) -> Iterable[tuple[End, End]]:
    """Pairs of an output and another component's input that have the same name."""
    for target in components:
        for source in components:
            for name, variable in target.fmu.variables.items():
                other = source.fmu.variables.get(name)
                if source is not target and variable.causality == "input" and other and other.causality == "output":
                    yield (source.name, name), (target.name, name)


def _listed(component: Component) -> str:
    """Return a component's outputs and inputs as a user reads them."""
    names = [
        f"{causality}s {', '.join(v.name for v in component.fmu.variables.values() if v.causality == causality) or '-'}"
        for causality in ("output", "input")
    ]
    return " and ".join(names)


def _channels(
    scenario: Scenario,
    components: list[Component],
    connections: list[Connection],
    inputs: Mapping[str, Input] = MappingProxyType({}),
) -> list[Channel]:
    """Return the columns as channels; ``inputs`` are connectors of the whole system, which may drive several each."""
    driven: dict[End, str] = {connection.target: f"by {dotted(connection.source)}" for connection in connections}
    channels: list[Channel] = []
    for column in scenario.columns:
        try:
            if column.name in inputs:
                from cosim.scenario._connectors import connector_channels

                found = connector_channels(scenario.path, column, inputs[column.name], components, driven)
            else:
                found = [_channel(scenario, column, components, driven)]
        except InputError as error:
            raise _located(error, scenario, column.line, column.position) from error
        channels += found
        driven |= {channel.target: f"in column {column.position}" for channel in found}
    return channels


def _missing_blank(name: str, components: list[Component]) -> str:
    """Return advice on a header such as ``duty[1]``, which means an element of an array, where there is no array."""
    plain = name.removesuffix("[1]")
    if plain == name:
        return ""
    try:
        resolve(plain, components, "input")
    except InputError:
        return ""
    return f"; if [1] is the unit, write '{plain} [1]'"


def _channel(scenario: Scenario, column: Column, components: list[Component], driven: dict[End, str]) -> Channel:
    try:
        end, variable = resolve(column.name, components, "input")
    except InputError as error:
        raise InputError(f"{error}{_missing_blank(column.name, components)}") from error
    if end in driven:
        remedy = "remove the column" if scenario.controller is None else "remove the column or the controller"
        raise InputError(f"column '{column.name}': '{dotted(end)}' is driven already {driven[end]}; {remedy}")
    values = channel_values(scenario.path, column, dotted(end), variable)
    return Channel(end, list(column.times), values, column.linear)
