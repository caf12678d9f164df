"""The continuous components, from one instant to the next."""

from __future__ import annotations

from math import inf

from cosim.engine.coupling._adaptive import advance_adaptively
from cosim.engine.coupling._agreement import agree
from cosim.engine.coupling._coupling import Coupling
from cosim.engine.loop._plan import Plan
from cosim.engine.system._method import Method


def advance_in_steps(plan: Plan, method: Method, now: float, t: float, recording: bool) -> int:
    """Step all continuous components from ``now`` to t [s]; return at how many points they have exchanged for that."""
    if plan.coupling is not None:
        return advance_coupled(plan.coupling, now, t, recording)
    steps = method.divisions(t - now)
    begun = now
    for number in range(1, steps):
        until = now + (t - now) * number / steps
        advance(plan, begun, until, recording=False)
        begun = until
    advance(plan, begun, t, recording)
    return 1


def advance(plan: Plan, now: float, t: float, recording: bool) -> None:
    """Step the continuous components from ``now`` to t [s], each with what those before it have just put out.

    Over a step a linear channel acts with its value in the middle: what an integrator makes of it is exact, and the
    error of a state that reacts to it is of second order in the step.
    """
    values = plan.values
    h = t - now
    fixed = [p for p in plan.continuous if p.due < inf]
    for participant in fixed:
        participant.begin_fixed_step(now)
    for line in plan.lines:
        values[line.middle] = line.at(now + 0.5 * h)
    plan.faults.begin_step(now, h)
    for participant in plan.continuous:
        if participant in fixed:
            participant.end_fixed_step(t)
            continue
        participant.write()
        participant.step(now, h)
        participant.read(recording)
    plan.power.end(values, plan.inputs, h)
    for line in plan.lines:
        values[line.slot] = line.at(t)


def advance_coupled(coupling: Coupling, now: float, t: float, recording: bool) -> int:
    """Step all continuous components from ``now`` to t [s]; return into how many macro steps that was divided."""
    values = coupling.values
    for participant in coupling.others:
        if participant.due < inf:
            participant.begin_fixed_step(now)
    coupling.notice()
    if coupling.method.algorithm == "adaptive":
        steps = advance_adaptively(coupling, now, t, recording)
    else:
        steps = _advance_evenly(coupling, now, t, recording)
    for line in coupling.lines:
        values[line.middle] = line.at(now + 0.5 * (t - now))
    coupling.faults.begin_step(now, t - now)
    for participant in coupling.others:
        if participant.due < inf:
            participant.end_fixed_step(t)
        else:
            participant.write()
            participant.step(now, t - now)
            participant.read(recording)
    for line in coupling.lines:
        values[line.slot] = line.at(t)
    return steps


def _advance_evenly(coupling: Coupling, now: float, t: float, recording: bool) -> int:
    """Take macro steps of one length."""
    method = coupling.method
    steps = method.divisions(t - now)
    for number in range(1, steps + 1):
        begin = now + (t - now) * (number - 1) / steps
        end = t if number == steps else now + (t - now) * number / steps
        last = recording and number == steps
        coupling.predict(begin, end - begin)
        if method.algorithm == "iterated":
            agree(coupling, begin, end - begin, last)
        else:
            coupling.take(begin, end - begin, last)
            coupling.correct_again(last)
        coupling.push(begin, end - begin)
        coupling.macro_steps += 1
        coupling.enlarge()
    return steps
