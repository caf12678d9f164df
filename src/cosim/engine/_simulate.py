"""Simulation of a system from instantiation to the result."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

from cosim.engine._instance import CallError, Instance, instantiate
from cosim.engine._loop import Record, check_numbers, output_grid, run
from cosim.engine._parameters import parameters_of
from cosim.engine._participant import Participant
from cosim.engine._plan import Plan, make_plan, roles_of
from cosim.engine._result import PartialResultError, Result, SimulationInterrupted
from cosim.engine._role import Role
from cosim.engine._system import System
from cosim.errors import InputError

_MOST_PASSES = 50
_COUNTERS = ("steps", "rejected_steps", "rhs_evaluations", "jacobians", "state_events", "time_events")


def simulate(
    system: System,
    *,
    stop: float,
    output_interval: float,
    tolerance: float,
    progress: Callable[[float], None] | None = None,
) -> Result:
    """Simulate from 0 to ``stop`` [s] and record every ``output_interval`` [s].

    ``tolerance`` is the relative tolerance handed to the FMUs; ``progress`` is called with the time [s] reached, at
    most 20 times per second of wall time.

    Raises InputError (FmuError) before anything runs if the system, a parameter or a number given here cannot be used;
    PartialResultError, a SimulationError, if a component fails, and SimulationInterrupted, a KeyboardInterrupt, on
    Ctrl-C: both carry the rows computed until then as ``result``.
    """
    _check_arguments(stop, output_interval, tolerance)
    system.check()
    parameters = {component.name: parameters_of(component) for component in system.components}
    roles = roles_of(system)
    instances: dict[str, Instance] = {}
    try:
        for component in system.components:
            event_mode = roles[component.name] is Role.EVENT
            instances[component.name] = instantiate(component.name, component.fmu, event_mode)
        plan = make_plan(system, instances, output_interval)
        grid = output_grid(stop, output_interval)
        record = Record(grid, np.empty((len(grid), plan.recorded)))
        started = time.perf_counter()
        try:
            for name, instance in instances.items():
                for parameter, value in parameters[name].items():
                    instance.set_value(parameter, value)
            _initialize(plan, tolerance, stop)
            started = time.perf_counter()
            run(plan, record, progress)
        except CallError as failure:
            message = _message(failure, record)
            raise PartialResultError(message, _result(plan, record, started, message, failure.instance)) from failure
        except KeyboardInterrupt as interruption:
            message = f"the simulation was interrupted at t = {record.now:.9g} s"
            raise SimulationInterrupted(message, _result(plan, record, started, message)) from interruption
        return _result(plan, record, started)
    finally:
        for instance in instances.values():
            instance.free()


def _check_arguments(stop: float, output_interval: float, tolerance: float) -> None:
    for name, value, unit in (
        ("stop", stop, " s"),
        ("output_interval", output_interval, " s"),
        ("tolerance", tolerance, ""),
    ):
        if not (math.isfinite(value) and value > 0.0):
            raise InputError(f"{name} is {value:g}{unit}; it must be above 0")
    if output_interval < 1e-8:
        raise InputError(f"output_interval is {output_interval:g} s; it must be at least 1e-08 s")


def _initialize(plan: Plan, tolerance: float, stop: float) -> None:
    """Bring all components to t = 0, their connections fulfilled.

    Only continuous components are told the stop time: one that is sampled at stop must be allowed to step past it.
    """
    participants = [*plan.continuous, *plan.discrete]
    for participant in participants:
        continuous = participant.role is Role.CONTINUOUS
        participant.instance.enter_initialization(tolerance, stop if continuous else None)
    for passes in range(_MOST_PASSES):
        before = list(plan.values)
        for participant in participants:
            participant.write(force=passes == 0)
            participant.read()
        check_numbers(plan)
        if _agree(before, plan.values.tolist()):
            break
    else:
        raise CallError(
            _unsettled(participants).instance,
            f"inputs and outputs do not agree after {_MOST_PASSES} passes of initialisation",
            "break the algebraic loop between the components",
        )
    for participant in participants:
        participant.instance.exit_initialization()
    for participant in plan.continuous:
        participant.read()


def _agree(before: list[float], after: list[float]) -> bool:
    return all(abs(a - b) <= 1e-12 * max(abs(a), abs(b)) or a == b for a, b in zip(before, after, strict=True))


def _unsettled(participants: list[Participant]) -> Participant:
    return next(participant for participant in participants if participant.input_groups)


def _message(failure: CallError, record: Record) -> str:
    instance = failure.instance
    where = f"at t = {record.now:.9g} s" if record.exchanges or record.now else "during initialisation"
    return (
        f"the simulation failed {where}: {instance.name} ({instance.fmu.name}): {failure.what}; {instance.log}; "
        f"{failure.remedy}"
    )


def _result(
    plan: Plan, record: Record, started: float, message: str | None = None, broken: Instance | None = None
) -> Result:
    wall = time.perf_counter() - started
    table = np.ascontiguousarray(record.rows[: record.count].T)
    columns: dict[str, NDArray[np.float64] | NDArray[np.int64]] = {}
    for name, slot in plan.columns.items():
        column: NDArray[np.float64] = table[slot]
        columns[name] = column if plan.variables[name].type == "Real" else column.astype(np.int64)
    participants = [*plan.discrete, *plan.continuous]
    return Result(
        time=record.grid[: record.count].copy(),
        columns=columns,
        units={name: unit for name in columns if (unit := plan.variables[name].unit) is not None},
        literals={name: names for name in columns if (names := plan.variables[name].literals) is not None},
        statistics={
            "wall_s": wall,
            "exchanges": record.exchanges,
            "roles": {p.instance.name: p.role.value for p in participants},
            "steps": {p.instance.name: p.steps for p in participants},
            "events": {p.instance.name: p.events for p in participants if p.role is Role.EVENT},
            "solver": {p.instance.name: _counters(p.instance) for p in participants if p.instance is not broken},
        },
        complete=message is None,
        message=message,
    )


def _counters(instance: Instance) -> dict[str, int]:
    """Return the solver counters that an FMU publishes and, after a failure elsewhere, is still able to give."""
    published = [name for name in _COUNTERS if f"solver.{name}" in instance.fmu.variables]
    with suppress(CallError):
        return {name: int(instance.get_value(f"solver.{name}")) for name in published}
    return {}
