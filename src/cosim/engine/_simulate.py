"""Simulation of a system from a request to the result."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cosim.engine._coupling_error import Companion, Estimate, no_estimate
from cosim.engine._execution import Ending, Job, execute, instantiated, loop_name
from cosim.engine._isolation import Isolate, is_isolated, run_isolated
from cosim.engine._prepare import prepared
from cosim.engine._result import PartialResultError, Result, SimulationInterrupted
from cosim.engine._supervisor import Limits
from cosim.engine.checkpoints._checkpoint import Checkpoint
from cosim.engine.checkpoints._resume import Saving, check_can_save, check_resume, check_times
from cosim.engine.fmu._calls import Site
from cosim.engine.loop._plan import Layout, lay_out
from cosim.engine.loop._record import Record
from cosim.engine.signals._fault_signals import resolved_faults
from cosim.engine.system._fault import Fault
from cosim.engine.system._method import Algorithm
from cosim.engine.system._system import System
from cosim.errors import CosimError, FmuWarning


def simulate(
    system: System,
    *,
    stop: float,
    output_interval: float,
    tolerance: float,
    progress: Callable[[float], None] | None = None,
    algorithm: Algorithm = "auto",
    step: float | None = None,
    extrapolation: int | None = None,
    isolate: Isolate = "never",
    call_timeout: float = Limits.call,
    memory_limit: float | None = Limits.memory,
    coupling_error: bool = True,
    checkpoint_at: Sequence[float] = (),
    checkpoint_to: Path | str | None = None,
    resume: Checkpoint | None = None,
) -> Result:
    """Simulate from 0 to ``stop`` [s] and record every ``output_interval`` [s].

    ``tolerance`` is the relative tolerance handed to the FMUs; ``progress`` is called with the time [s] reached, at
    most 20 times per second of wall time.

    ``algorithm`` says how continuous components that act on each other are stepped; discrete ones act at their own
    instants (see ``Role``). "gauss-seidel": one after the other in the order of direct feedthrough, inputs held.
    "extrapolated": inputs follow polynomials of the order ``extrapolation``. "iterated": the same, repeated until all
    agree at the end of a step. "adaptive": in steps as long as ``tolerance`` allows. "auto" takes the last of these
    where components act on each other, "extrapolated" where an FMU cannot go back to a state, and else "gauss-seidel",
    which is exact then; docs/coupling.md has the details. ``step`` [s] is the longest macro step. "jacobi" takes macro
    steps of ``step``, of which ``output_interval`` and ``stop`` must be multiples: at each communication point all
    components put out, then all are stepped, without event mode, whatever their role; changes of channels act from the
    next communication point on.

    If ``coupling_error``, a run in which continuous components exchange signals is followed by a second one with
    shorter intervals between communication points, which takes two to four times its time and tells how far off it
    was: docs/coupling.md. ``progress`` then starts again. Systems in which nothing continuous is exchanged run once.

    ``isolate`` "always" runs all of it in a process of its own, with the same numbers, so that an FMU that crashes,
    hangs or ends its process ends that one only; "auto" does so unless this project has built all FMUs here; "never"
    runs it here. There one call of an FMU may take ``call_timeout`` [s], and the process have ``memory_limit`` [bytes],
    by default what the machine has. ``docs/isolation.md`` has the details.

    At each time of ``checkpoint_at`` [s], more exactly at the first communication point that is not earlier, the whole
    state is saved: ``Result.checkpoints`` has them, and the folder ``checkpoint_to``, if given, gets a file of each as
    soon as it is made. That changes nothing in the run. ``resume`` goes on from a checkpoint: the result is that of a
    run that was not interrupted, to the bit. All else must be as it was, but that ``stop`` may be earlier, channels may
    be others after that time, and tunable parameters others from it on. ``docs/checkpoints.md`` has the details.

    The environment variable COSIM_ENGINE chooses the loop: "native" is compiled on first use, "python" gives the same
    numbers, slower, "auto" (the default) is native if there is a library or a compiler, else Python.

    Raises InputError (FmuError) before anything runs if the system, a parameter or a number given here cannot be used,
    or if a component refuses its parameters by an assertion;
    PartialResultError, a SimulationError, if a component fails, and SimulationInterrupted, a KeyboardInterrupt, on
    Ctrl-C: both carry the rows computed until then as ``result``.
    """
    loop = loop_name()
    job = prepared(
        system,
        stop=stop,
        output_interval=output_interval,
        tolerance=tolerance,
        algorithm=algorithm,
        step=step,
        extrapolation=extrapolation,
    )
    limits = Limits(call_timeout, memory_limit)
    faults = resolved_faults(system, stop, output_interval)
    layout = lay_out(system)
    if checkpoint_at or resume is not None:
        job = replace(job, saving=_saving(job, checkpoint_at, checkpoint_to, resume))
    isolated = is_isolated(isolate, system)

    def run(job: Job) -> tuple[Record, Ending]:
        if isolated:
            return run_isolated(job, layout.recorded, loop, limits, progress)
        record = Record.empty(stop, output_interval, layout.recorded, loop)
        return record, _run_here(job, record, progress)

    record, ending = run(job)
    for remark in ending.remarks:
        warnings.warn(remark, FmuWarning, stacklevel=2)
    companion = Companion(job)
    estimate = _estimate(companion, layout, record, ending, run) if coupling_error else no_estimate("not asked for")
    ending.statistics["coupling"] = companion.account(layout, estimate)
    result = result_of(layout, record, ending, faults)
    if estimate.interrupted:
        raise SimulationInterrupted("interrupted while the coupling error was estimated, after the run itself", result)
    if ending.interrupted:
        raise SimulationInterrupted(ending.message or "", result)
    if ending.message is not None:
        raise PartialResultError(ending.message, result)
    return result


def _saving(
    job: Job, checkpoint_at: Sequence[float], checkpoint_to: Path | str | None, resume: Checkpoint | None
) -> Saving:
    folder = None if checkpoint_to is None else Path(checkpoint_to)
    at = check_times(checkpoint_at, job.stop, None if resume is None else resume.time)
    if at:
        check_can_save(job.system.components, in_file=True)
    if resume is None:
        return Saving(job.stop, at, folder)
    parameters = check_resume(resume, job.system, job.settings, job.stop)
    return Saving(resume.horizon, at, folder, resume, parameters)


def _run_here(job: Job, record: Record, progress: Callable[[float], None] | None) -> Ending:
    sites = [Site(record.at, number) for number in range(len(job.system.components))]
    with instantiated(job, sites) as plan:
        return execute(job, plan, record, progress)


def _estimate(
    companion: Companion, layout: Layout, record: Record, ending: Ending, run: Callable[[Job], tuple[Record, Ending]]
) -> Estimate:
    """Run a second time if that tells something, and compare."""
    if ending.message is not None:
        return no_estimate("the run has ended early")
    job = companion.job
    if job is None:
        return no_estimate("nothing to tell")
    if job.saving and job.saving.resume:
        return no_estimate("the run was resumed, and what had built up before is not known")
    try:
        fine, second = run(replace(job, saving=None))
    except CosimError as error:
        return no_estimate(f"the second run cannot be made: {error}")
    except KeyboardInterrupt:
        return replace(no_estimate("interrupted"), interrupted=True)
    ending.statistics["second_wall_s"] = second.statistics.get("wall_s")
    return companion.compare(layout, record, fine, second)


def result_of(layout: Layout, record: Record, ending: Ending, faults: Sequence[Fault]) -> Result:
    """Return the rows of a record and how it ended."""
    table = record.rows.T if record.count == len(record.grid) else record.rows[: record.count].T.copy()
    columns: dict[str, NDArray[np.float64] | NDArray[np.int64]] = {}
    for name, slot in layout.columns.items():
        column: NDArray[np.float64] = table[slot]
        columns[name] = column if layout.variables[name].type == "Real" else column.astype(np.int64)
    return Result(
        time=record.grid[: record.count].copy(),
        columns=columns,
        units={name: unit for name in columns if (unit := layout.variables[name].unit) is not None},
        literals={name: names for name in columns if (names := layout.variables[name].literals) is not None},
        statistics=ending.statistics,
        complete=ending.message is None,
        message=ending.message,
        faults=tuple(faults),
        checkpoints=tuple(ending.checkpoints),
    )
