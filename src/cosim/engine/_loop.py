"""The co-simulation algorithm: from one instant to the next, in plain Python over the tables of the plan.

At each instant t every continuous component has been stepped to t and its outputs have been read. The discrete ones
that are due then read these outputs, and the channels as they are after their steps at t; what they answer acts on
the continuous components from t on. So nothing is delayed. Points of the output grid at which nothing is due are extra
stops of the continuous components, not exchanges.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from math import ceil, inf, isnan

import numpy as np
from numpy.typing import NDArray

from cosim.engine._instance import CallError
from cosim.engine._participant import Participant
from cosim.engine._plan import Plan
from cosim.engine._role import Role
from cosim.engine._system import SAME_INSTANT

_MOST_ROUNDS = 100
_PROGRESS_INTERVAL = 0.05


@dataclass
class Record:
    """The rows recorded so far: the first ``count`` of ``rows``, shape (len(grid), recorded signals)."""

    grid: NDArray[np.float64]
    rows: NDArray[np.float64]
    count: int = 0
    now: float = 0.0
    exchanges: int = 0


def output_grid(stop: float, interval: float) -> NDArray[np.float64]:
    """Return the multiples of ``interval`` below ``stop``, and ``stop`` [s].

    If a second is a whole number of intervals, the multiples are quotients of whole numbers, so that they print as
    0.003 and not as 0.0030000000000000001.
    """
    count = ceil((stop - SAME_INSTANT) / interval)
    per_second = round(1.0 / interval)
    ticks = np.arange(count + 1, dtype=np.float64)
    whole = per_second > 0 and abs(per_second * interval - 1.0) < 1e-12
    grid: NDArray[np.float64] = ticks / per_second if whole else ticks * interval
    grid[-1] = stop
    return grid


def run(plan: Plan, record: Record, progress: Callable[[float], None] | None) -> None:
    """Simulate over the grid of ``record``; raises CallError, the record holding what was computed until then."""
    values = plan.values
    signals = memoryview(values)[: plan.recorded]
    rows = record.rows.reshape(-1).data
    width = plan.recorded
    grid = record.grid.tolist()
    stop = grid[-1]
    schedule, discrete = plan.schedule, plan.discrete
    undated = [p for p in discrete if p.role is Role.EVENT]
    shown = 0.0
    now = 0.0
    row = 0
    record.exchanges = 1
    exchange(plan, now)
    while True:
        if now >= grid[row] - SAME_INSTANT:
            if isnan(sum(values)):
                check_numbers(plan)
            rows[row * width : (row + 1) * width] = signals
            row += 1
            record.count = row
            if row == len(grid):
                break
        due = min([p.due for p in discrete], default=inf)
        instant = due if due <= schedule.next + SAME_INSTANT else schedule.next
        exchanging = instant <= grid[row] + SAME_INSTANT
        t = min(instant if exchanging else grid[row], stop)
        advance(plan, now, t)
        for participant in undated:
            if participant.due == inf:
                participant.carry(t)
                exchanging = exchanging or participant.due == t
        record.now = now = t
        if exchanging:
            if isnan(sum(values)):
                check_numbers(plan)
            exchange(plan, t)
        record.exchanges += exchanging or plan.coupled
        if progress is not None and (clock := time.perf_counter()) - shown >= _PROGRESS_INTERVAL:
            shown = clock
            progress(now)
    if progress is not None:
        progress(stop)


def advance(plan: Plan, now: float, t: float) -> None:
    """Step the continuous components from ``now`` to t [s], each with what those before it have just put out.

    Over a step a linear channel acts with its value in the middle: what an integrator makes of it is exact, and the
    error of a state that reacts to it is of second order in the step.
    """
    values = plan.values
    h = t - now
    for line in plan.lines:
        values[line.middle] = line.at(now + 0.5 * h)
    for participant in plan.continuous:
        participant.write()
        participant.step(now, h)
        participant.read()
    for line in plan.lines:
        values[line.slot] = line.at(t)


def exchange(plan: Plan, t: float) -> None:
    """Apply the channels and compute the discrete components that are due at t [s], until nothing changes any more."""
    plan.schedule.apply(t, plan.values)
    discrete = plan.discrete
    for _ in range(_MOST_ROUNDS):
        quiet = True
        for participant in discrete:
            if participant.due <= t + SAME_INSTANT or (participant.triggers and participant.triggered()):
                quiet = False
                if participant.role is Role.EVENT:
                    participant.event(t)
                else:
                    participant.sample()
        if quiet:
            break
    else:
        raise _endless(discrete)
    for participant in discrete:
        if participant.in_event_mode:
            participant.leave_event_mode()


def _endless(discrete: list[Participant]) -> CallError:
    participant = next(p for p in discrete if p.triggers)
    names = ", ".join(p.instance.name for p in discrete)
    return CallError(
        participant.instance,
        f"the events of {names} set each other off without end",
        "give one of them a sample period or a delay",
    )


def check_numbers(plan: Plan) -> None:
    """Raise CallError for the component that has put NaN into the signals, a continuous one before those it feeds."""
    bad: dict[str, str] = {}
    for (name, variable), value in zip(plan.ends, plan.values, strict=False):
        if isnan(value):
            bad.setdefault(name, variable)
    for participant in [*plan.continuous, *plan.discrete]:
        name = participant.instance.name
        if name in bad:
            raise CallError(
                participant.instance,
                f"its output {bad[name]} is not a number (NaN)",
                "check its parameters and its inputs at that time, or try another tolerance",
            )
