"""Tells when the components of a system are computed, what travels on its connections, and how late it arrives."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack, suppress
from functools import partial
from itertools import pairwise

from cosim.engine._execution import Ending, Job
from cosim.engine._isolation import Isolate, Progress, is_isolated, supervised
from cosim.engine._prepare import prepared
from cosim.engine._probe import probe
from cosim.engine._supervisor import Limits
from cosim.engine._trace import Component, Enough, Trace, TracedParticipant, Travel
from cosim.engine.exchange._instances import instantiate
from cosim.engine.fmu._calls import Site
from cosim.engine.fmu._instance import CallError
from cosim.engine.loop._initialize import initialize
from cosim.engine.loop._loop import run, run_jacobi
from cosim.engine.loop._plan import Plan, lay_out, make_plan, roles_of
from cosim.engine.loop._record import Record, failure_message
from cosim.engine.signals._fault_signals import resolved_faults
from cosim.engine.system._connection import dotted
from cosim.engine.system._fault import described
from cosim.engine.system._graph import Phase, loops
from cosim.engine.system._method import Algorithm, Method
from cosim.engine.system._parameters import parameters_of
from cosim.engine.system._role import Role, period_of
from cosim.engine.system._system import SAME_INSTANT, System
from cosim.errors import SimulationError
from cosim.worker import Answer

_WANTED = 12
_SHOWN = 4


def explain_timing(
    system: System,
    *,
    stop: float,
    output_interval: float,
    tolerance: float = 1e-6,
    algorithm: Algorithm = "auto",
    step: float | None = None,
    isolate: Isolate = "never",
    call_timeout: float = Limits.call,
    memory_limit: float | None = Limits.memory,
) -> str:
    """Return a text on when things happen in this system; the arguments are those of ``simulate``.

    For each component it gives the instants at which it is computed (period and phase, or a list), for each connection
    the first values that travel on it and the delay: the time from the instant for which the source has put a value
    out to that from which it acts at the target. It is found by running the loop over its tables, for about a dozen
    instants of each discrete component. A component that is sampled without an event mode is also probed alone for the
    delay inside it. Raises as ``simulate`` does, SimulationError without a partial result.
    """
    job = prepared(
        system,
        stop=stop,
        output_interval=output_interval,
        tolerance=tolerance,
        algorithm=algorithm,
        step=step,
        extrapolation=None,
    )
    limits = Limits(call_timeout, memory_limit)
    width = lay_out(system).recorded
    if not is_isolated(isolate, system):
        record = Record.empty(stop, output_interval, width, "python")
        return _explain(job, record, [Site(record.at, number) for number in range(len(system.components))])
    _, explanation = supervised(_explain_there, job, width, "python", limits)
    if isinstance(explanation, Ending):
        if explanation.interrupted:
            raise KeyboardInterrupt(explanation.message)
        raise SimulationError(explanation.message)
    return str(explanation)


def _explain_there(job: Job, record: Record, sites: Sequence[Site], _: Progress, answer: Answer) -> None:
    answer(_explain(job, record, sites))


def _explain(job: Job, record: Record, sites: Sequence[Site]) -> str:
    system, step, output_interval = job.system, job.step, job.output_interval
    trace = Trace(_WANTED)
    plan = _traced(job, trace, record, sites)
    lines = [
        _heading(trace, output_interval, job.method),
        "",
        "Components, in the order in which an instant computes them:",
    ]
    order = [*plan.continuous, *plan.discrete]
    width = max(len(participant.instance.name) for participant in order)
    for participant in order:
        name = participant.instance.name
        any_step = bool(participant.instance.fmu.capabilities["canHandleVariableCommunicationStepSize"])
        lines.append(f"  {name:{width}}  {_component(trace.components[name], trace.roles[name], step, any_step)}")
        if trace.roles[name] is Role.SAMPLED:
            number = [component.name for component in system.components].index(name)
            component = system.components[number]
            period = step or period_of(component, output_interval)
            lines.append(f"  {'':{width}}  {probe(component, period, sites[number])}")
    faulty = {fault.target for fault in system.faults}
    for title, ends in (("Connections", _connections(system)), ("Channels", _channels(system))):
        if ends:
            lines += ["", f"{title}:"]
        for target, text in ends.items():
            lines.append(f"  {text}")
            if target in faulty:
                lines.append("    what arrives, and when, is up to its faults")
            else:
                lines += _travels(trace.travels.get(_input(plan, target), []), text.startswith("channel"))
    found = loops(system, trace.roles, Phase.TIME)
    if found:
        lines += ["", "Algebraic loops while components are stepped:", *(f"  {loop}" for loop in found)]
    if system.faults:
        lines += ["", "Faults, in the order in which they act:", *(f"  {text}" for text in _faults(job))]
    return "\n".join(lines) + "\n"


def _traced(job: Job, trace: Trace, record: Record, sites: Sequence[Site]) -> Plan:
    """Run the loop until the trace has seen enough; return the plan that it ran over."""
    system, step = job.system, job.step
    parameters = {component.name: parameters_of(component) for component in system.components}
    trace.roles = roles_of(system)
    trace.components = {name: Component() for name in trace.roles}
    roles = trace.roles if step is None else dict.fromkeys(trace.roles, Role.CONTINUOUS)
    with ExitStack() as stack:
        instances = {}
        for component, site in zip(system.components, sites, strict=True):
            instance = instantiate(component.name, component.fmu, roles[component.name] is Role.EVENT, site)
            stack.callback(instance.free)
            instances[component.name] = instance
        plan = make_plan(
            system, roles, instances, job.output_interval, job.stop, partial(TracedParticipant, trace=trace)
        )
        trace.begin(plan, {channel.target: channel.times for channel in system.channels})
        try:
            for name, instance in instances.items():
                instance.set_values(parameters[name])
            initialize(plan, system, job.tolerance, job.stop)
            with suppress(Enough):
                if step is not None:
                    run_jacobi(plan, record, step, None)
                else:
                    run(plan, record, Method("gauss-seidel"), None)
        except CallError as failure:
            raise SimulationError(failure_message(failure, record)) from failure
    return plan


def _heading(trace: Trace, output_interval: float, method: Method) -> str:
    together = (
        f" Components that act on each other continuously are stepped together by the algorithm {method.algorithm} in "
        "a run; here they hold what they are given."
        if method.is_coupled
        else ""
    )
    how = (
        "Gauss-Seidel: each component at its own instants, in the order of direct feedthrough"
        if not method.is_fixed
        else f"Jacobi: all components in macro steps of {method.step:g} s, with what all have put out at their "
        "beginning"
    )
    return f"{how}. Rows every {output_interval:g} s. Observed from 0 s to {trace.until:.9g} s.{together}"


def _component(seen: Component, role: Role, step: float | None, any_step: bool) -> str:
    if role is Role.CONTINUOUS or step is not None:
        shortest, longest = min(seen.steps, default=0.0), max(seen.steps, default=0.0)
        alike = longest - shortest <= SAME_INSTANT
        lengths = f"of {longest:.9g} s" if alike else f"of {shortest:.9g} s to {longest:.9g} s"
        if step is not None:
            return f"{role.value}: macro steps {lengths}"
        if not any_step:
            return f"continuous: steps {lengths}, the only ones it takes; its outputs hold in between"
        return f"continuous: steps {lengths}, each to the next instant or row"
    what = "samples" if role is Role.SAMPLED else "events of its own"
    text = f"{role.value}: {what} {_instants(seen.own)}"
    return f"{text}; events that its inputs cause {_instants(seen.caused)}" if seen.caused else text


def _instants(times: list[float]) -> str:
    """Return period and phase of these instants [s] if they have one, else the first of them."""
    if not times:
        return "never"
    periods = [b - a for a, b in pairwise(times)]
    if len(periods) > 1 and max(periods) - min(periods) <= SAME_INSTANT:
        return f"every {periods[0]:.9g} s, the first at {times[0]:.9g} s"
    shown = ", ".join(f"{t:.9g} s" for t in times[:_SHOWN])
    return f"at {shown}{', ...' if len(times) > _SHOWN else ''}"


def _connections(system: System) -> dict[tuple[str, str], str]:
    texts = {}
    for connection in system.connections:
        text = f"{dotted(connection.source)} -> {dotted(connection.target)}"
        if connection.factor != 1.0 or connection.offset != 0.0:
            text += f" = {connection.factor:g} * source + {connection.offset:g}"
        if connection.table:
            text += f" = {', '.join(f'{target:g} for {source:g}' for source, target in connection.table)}"
        texts[connection.target] = text
    return texts


def _channels(system: System) -> dict[tuple[str, str], str]:
    held = "held between entries"
    interpolated = "interpolated (over a step with the value in its middle) between entries"
    return {
        channel.target: f"channel {dotted(channel.target)}, {interpolated if channel.linear else held} "
        f"{_instants(channel.times)}"
        for channel in system.channels
    }


def _faults(job: Job) -> list[str]:
    faults = resolved_faults(job.system, job.stop, job.output_interval)
    units = {(c.name, v.name): v.unit for c in job.system.components for v in c.fmu.variables.values()}
    return [f"{dotted(fault.target)} {described(fault, units[fault.target])}" for fault in faults]


def _input(plan: Plan, target: tuple[str, str]) -> int:
    """Return the number of an input in the tables."""
    name, variable = target
    for participant in [*plan.continuous, *plan.discrete]:
        for group in participant.input_groups:
            for wire, wired in zip(group.wires, group.names, strict=True):
                if (participant.instance.name, wired) == (name, variable):
                    return wire.target
    raise KeyError(target)


def _travels(travels: list[Travel], from_channel: bool) -> list[str]:
    """Return the lines on one connection: its delay, and the first values with their instants."""
    if not travels:
        return ["    nothing travelled while it was observed"]
    delays = [travel.acts - travel.born for travel in travels if not travel.initial] or [0.0]
    lines = [f"    delay {_delay(delays)}; {len(travels)} values"]
    if min(delays) < -SAME_INSTANT:
        lines[0] += "; the source is stepped first, and what it puts out at the end acts over the whole step"
    for travel in travels[:_SHOWN]:
        source = "entered" if from_channel else "put out by initialisation" if travel.initial else "put out"
        value = travel.value if isinstance(travel.value, str) else f"{travel.value:.9g}"
        lines.append(f"    {value}: {source} at {travel.born:.9g} s, acts from {travel.acts:.9g} s on")
    return lines


def _delay(delays: list[float]) -> str:
    low, high = (0.0 if abs(delay) <= SAME_INSTANT else delay for delay in (min(delays), max(delays)))
    return f"{high:.9g} s" if high - low <= SAME_INSTANT else f"{low:.9g} s to {high:.9g} s"
