"""The co-simulation algorithm: from one instant to the next, in plain Python over the tables of the plan.

At each instant t every continuous component has been stepped to t and its outputs have been read. The discrete ones
that are due then read these outputs, and the channels as they are after their steps at t; what they answer acts on
the continuous components from t on. So nothing is delayed. Points of the output grid at which nothing is due are extra
stops of the continuous components, not exchanges.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from math import inf, isnan

from cosim.engine.fmu._instance import CallError
from cosim.engine.loop._advance import advance_in_steps
from cosim.engine.loop._plan import Plan
from cosim.engine.loop._record import Record
from cosim.engine.system._method import Method
from cosim.engine.system._role import Role
from cosim.engine.system._system import SAME_INSTANT

MOST_ROUNDS = 100
PROGRESS_INTERVAL = 0.05
"""Time between two calls of ``progress`` [s]."""


def run(
    plan: Plan, record: Record, method: Method, progress: Callable[[float], None] | None, pause: float = inf
) -> None:
    """Simulate over the grid of ``record``.

    It goes on from where the plan and the record are, and returns at the first communication point at or after
    ``pause`` [s], its row recorded. Raises CallError, the record holding what was computed until then.
    """
    values = plan.values
    grid = record.grid.tolist()
    stop = grid[-1]
    schedule, discrete = plan.schedule, plan.discrete
    timed = [*discrete, *(p for p in plan.continuous if p.due < inf)]
    undated = [p for p in discrete if p.role is Role.EVENT]
    shown = 0.0
    now = record.now
    if not record.exchanges:
        record.exchanges = 1
        plan.faults.arrive(now)
        exchange(plan, now, recording=True)
        plan.faults.settle(now)
        plan.power.begin(values)
    while True:
        if now >= grid[record.count] - SAME_INSTANT:
            _put_row(plan, record)
            if record.count == len(grid):
                break
        if now >= pause - SAME_INSTANT:
            return
        row = grid[record.count]
        due = min([p.due for p in timed], default=inf)
        change = min(schedule.next, plan.faults.clock.next)
        instant = due if due <= change + SAME_INSTANT else change
        exchanging = instant <= row + SAME_INSTANT
        t = min(instant if exchanging else row, stop)
        recording = t >= row - SAME_INSTANT
        record.exchanges += advance_in_steps(plan, method, now, t, recording) - 1
        for participant in undated:
            if participant.due == inf:
                participant.carry(t)
                exchanging = exchanging or participant.due == t
        record.now = now = t
        plan.faults.arrive(t)
        if exchanging:
            if isnan(sum(values)):
                check_numbers(plan)
            exchange(plan, t, recording)
        plan.faults.settle(t)
        record.exchanges += exchanging or plan.coupled
        if progress is not None and (clock := time.perf_counter()) - shown >= PROGRESS_INTERVAL:
            shown = clock
            progress(now)
    if progress is not None:
        progress(stop)


def _put_row(plan: Plan, record: Record) -> None:
    """Record a row, for which discrete components put out what nobody takes, too."""
    for participant in plan.discrete:
        if participant.stale:
            participant.read()
    if isnan(sum(plan.values)):
        check_numbers(plan)
    record.put(plan.values)


def run_jacobi(
    plan: Plan, record: Record, step: float, progress: Callable[[float], None] | None, pause: float = inf
) -> None:
    """Simulate in macro steps of ``step`` [s], all components stepped with what all have put out at its beginning.

    It begins and pauses as ``run`` does.
    """
    values = plan.values
    grid = record.grid.tolist()
    shown = 0.0
    if not record.exchanges:
        record.exchanges = 1
        plan.faults.arrive(0.0)
        plan.schedule.apply(0.0, values)
        plan.faults.settle(0.0)
        plan.power.begin(values)
    while True:
        if record.now >= grid[record.count] - SAME_INSTANT:
            record.put(values)
            if record.count == len(grid):
                break
        if record.now >= pause - SAME_INSTANT:
            return
        now = record.now
        t = record.exchanges * step
        for line in plan.lines:
            values[line.middle] = line.at(now + 0.5 * step)
        plan.faults.begin_step(now, 0.0)
        for participant in plan.continuous:
            participant.write()
        for participant in plan.continuous:
            participant.step(now, step)
        recording = t >= grid[record.count] - SAME_INSTANT
        for participant in plan.continuous:
            participant.read(recording)
        plan.power.end(values, plan.inputs, step)
        for line in plan.lines:
            values[line.slot] = line.at(t)
        plan.faults.arrive(t)
        plan.schedule.apply(t, values)
        plan.faults.settle(t)
        record.now = t
        record.exchanges += 1
        if isnan(sum(values)):
            check_numbers(plan)
        if progress is not None and (clock := time.perf_counter()) - shown >= PROGRESS_INTERVAL:
            shown = clock
            progress(t)
    if progress is not None:
        progress(grid[-1])


def exchange(plan: Plan, t: float, recording: bool) -> None:
    """Apply the channels and compute the discrete components that are due at t [s], until nothing changes any more."""
    plan.schedule.apply(t, plan.values)
    discrete = plan.discrete
    for _ in range(MOST_ROUNDS):
        quiet = True
        for participant in discrete:
            if participant.due <= t + SAME_INSTANT or (participant.triggers and participant.triggered()):
                quiet = False
                if participant.role is Role.EVENT:
                    participant.event(t, recording)
                else:
                    participant.sample(recording)
        if quiet:
            break
    else:
        raise endless(plan)
    for participant in discrete:
        if participant.in_event_mode:
            participant.leave_event_mode()


def endless(plan: Plan) -> CallError:
    """Return the error for components whose events never come to rest."""
    participant = next(p for p in plan.discrete if p.triggers)
    names = ", ".join(p.instance.name for p in plan.discrete)
    return CallError(
        participant.instance,
        f"the events of {names} set each other off without end",
        "give one of them a sample period or a delay",
    )


def check_numbers(plan: Plan) -> None:
    """Raise CallError for the component that has put NaN into the signals, a continuous one before those it feeds."""
    bad: dict[str, str] = {}
    faulty = {one.slot for one in plan.faults.inputs}
    for slot, ((name, variable), value) in enumerate(zip(plan.ends, plan.values, strict=False)):
        if isnan(value) and slot in faulty:
            bad[name] = f"input {variable}, as its faults make it,"
        elif isnan(value):
            bad.setdefault(name, f"output {variable}")
    for participant in [*plan.continuous, *plan.discrete]:
        name = participant.instance.name
        if name in bad:
            raise CallError(
                participant.instance,
                f"its {bad[name]} is not a number (NaN)",
                "check its parameters and its inputs at that time, or try another tolerance",
            )
