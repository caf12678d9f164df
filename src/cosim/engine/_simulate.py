"""Simulation of a system from instantiation to the result."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

from cosim.engine._arguments import Algorithm, check_arguments, check_step
from cosim.engine._initialize import initialize
from cosim.engine._instance import CallError, Instance, instantiate
from cosim.engine._library import native_library
from cosim.engine._loop import run, run_jacobi
from cosim.engine._native import run_native
from cosim.engine._parameters import parameters_of
from cosim.engine._plan import Plan, make_plan, roles_of
from cosim.engine._record import Record, failure_message
from cosim.engine._result import PartialResultError, Result, SimulationInterrupted
from cosim.engine._role import Role
from cosim.engine._system import System

_COUNTERS = ("steps", "rejected_steps", "rhs_evaluations", "jacobians", "state_events", "time_events")


def simulate(
    system: System,
    *,
    stop: float,
    output_interval: float,
    tolerance: float,
    progress: Callable[[float], None] | None = None,
    algorithm: Algorithm = "gauss-seidel",
    step: float | None = None,
) -> Result:
    """Simulate from 0 to ``stop`` [s] and record every ``output_interval`` [s].

    ``tolerance`` is the relative tolerance handed to the FMUs; ``progress`` is called with the time [s] reached, at
    most 20 times per second of wall time.

    ``algorithm`` "gauss-seidel" computes each component at its own instants (see ``Role``), continuous ones one after
    the other in the order of direct feedthrough. "jacobi" takes macro steps of ``step`` [s], of which
    ``output_interval`` and ``stop`` must be multiples: at each communication point all components put out, then all are
    stepped, without event mode, whatever their role; changes of channels act from the next communication point on.

    The environment variable COSIM_ENGINE chooses the loop: "native" is compiled on first use, "python" gives the same
    numbers, slower, "auto" (the default) is native if there is a library or a compiler, else Python.

    Raises InputError (FmuError) before anything runs if the system, a parameter or a number given here cannot be used,
    or if a component refuses its parameters by an assertion;
    PartialResultError, a SimulationError, if a component fails, and SimulationInterrupted, a KeyboardInterrupt, on
    Ctrl-C: both carry the rows computed until then as ``result``.
    """
    check_arguments(stop, output_interval, tolerance)
    check_step(algorithm, step, stop, output_interval)
    library = native_library()
    system.check()
    parameters = {component.name: parameters_of(component) for component in system.components}
    roles = roles_of(system)
    if step is not None:
        roles = dict.fromkeys(roles, Role.CONTINUOUS)
    instances: dict[str, Instance] = {}
    try:
        for component in system.components:
            event_mode = roles[component.name] is Role.EVENT
            instances[component.name] = instantiate(component.name, component.fmu, event_mode)
        plan = make_plan(system, roles, instances, output_interval)
        record = Record.empty(stop, output_interval, plan.recorded, "native" if library else "python")
        started = time.perf_counter()
        try:
            for name, instance in instances.items():
                instance.set_values(parameters[name])
            initialize(plan, tolerance, stop)
            started = time.perf_counter()
            if library is not None:
                run_native(library, plan, record, step, progress)
            elif step is not None:
                run_jacobi(plan, record, step, progress)
            else:
                run(plan, record, progress)
        except CallError as failure:
            message = failure_message(failure, record)
            raise PartialResultError(message, _result(plan, record, started, message, failure.instance)) from failure
        except KeyboardInterrupt as interruption:
            message = f"the simulation was interrupted at t = {record.now:.9g} s"
            raise SimulationInterrupted(message, _result(plan, record, started, message)) from interruption
        return _result(plan, record, started)
    finally:
        for instance in instances.values():
            instance.free()


def _result(
    plan: Plan, record: Record, started: float, message: str | None = None, broken: Instance | None = None
) -> Result:
    wall = time.perf_counter() - started
    table = record.rows.T if record.count == len(record.grid) else record.rows[: record.count].T.copy()
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
            "loop": record.loop,
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
