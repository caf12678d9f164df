"""Many runs from one state: the instances are made once, and put back to it for each."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from typing import cast

import numpy as np
from numpy.typing import NDArray

from cosim.engine._execution import (
    Clock,
    Ending,
    Job,
    begin,
    instantiated,
    interruption_message,
    loop_name,
    simulate_to,
    statistics,
)
from cosim.engine._prepare import prepared
from cosim.engine._result import PartialResultError, Result, SimulationInterrupted
from cosim.engine._simulate import result_of
from cosim.engine.checkpoints._checkpoint import Checkpoint
from cosim.engine.checkpoints._resume import Saving, apply, check_can_save, check_resume, save
from cosim.engine.checkpoints._snapshot import in_order, put_back, take
from cosim.engine.fmu._calls import Site
from cosim.engine.fmu._fmu_state import FmuState
from cosim.engine.fmu._instance import CallError, Instance
from cosim.engine.fmu._variable import Value
from cosim.engine.loop._plan import Layout, Plan, lay_out
from cosim.engine.loop._record import Record, failure_message, output_grid
from cosim.engine.signals._fault_signals import resolved_faults
from cosim.engine.system._arguments import check_arguments
from cosim.engine.system._channels import Schedule
from cosim.engine.system._connection import dotted
from cosim.engine.system._fault import RANDOM
from cosim.engine.system._method import Algorithm
from cosim.engine.system._parameters import parameters_of
from cosim.engine.system._system import SAME_INSTANT, Channel, Component, System
from cosim.errors import FmuError, InputError, SimulationError


class Branches:
    """Runs that begin at ``time`` [s], all from the same state: call it for each. Not for several threads at once."""

    def __init__(self, job: Job, plan: Plan, record: Record, layout: Layout) -> None:
        """Begin where plan and record are, of a run that is between two steps; raises CallError."""
        self.time = record.now
        self._job = job
        self._saving = job.saving or Saving(job.stop)
        self._plan, self._record, self._layout = plan, record, layout
        self._rows = record.count
        self._instances = [participant.instance for participant in in_order(plan)]
        self._on_row = record.count > 0 and abs(record.grid[record.count - 1] - self.time) <= SAME_INSTANT
        for instance in self._instances:
            instance.no_return.value = 0
        if not self._on_row:
            for participant in in_order(plan):
                participant.read()
        self._states = [FmuState(instance) for instance in self._instances]
        self._start = take(plan, record)
        self._schedule = plan.schedule
        self._lines = [(line.times, line.values) for line in plan.lines]
        self._grids: dict[float, NDArray[np.float64]] = {}
        self._faults = resolved_faults(job.system, job.stop, job.output_interval)

    @property
    def horizon(self) -> float:
        """Up to where [s] a branch may go: the stop time that the FMUs were told, infinite if none."""
        return self._saving.horizon

    def checkpoint(self) -> Checkpoint:
        """Return the state as a checkpoint, with the rows up to it.

        Raises FmuError if an FMU can keep its state in memory only, SimulationError if one fails to write it down.
        """
        check_can_save(self._job.system.components, in_file=True)
        try:
            self._go_back(self._record)
            self._record.at.row = self._rows
            return save(self._plan, self._record, self._job.system, self._job.settings, self._saving, self.time)
        except CallError as failure:
            raise SimulationError(failure_message(failure, self._record)) from failure

    def __call__(
        self,
        *,
        stop: float,
        channels: Sequence[Channel] = (),
        parameters: Mapping[tuple[str, str], Value] | None = None,
    ) -> Result:
        """Simulate from ``time`` to ``stop`` [s]; the first row of the result is that of the state itself.

        ``channels`` take the place of those of the system with the same targets, from ``time`` on: their entries are
        not earlier, and before the first the input keeps the value that it has, or goes from there in a line.
        ``parameters`` by (component, variable), which must be tunable, are set at ``time``. Counts in the statistics
        are from 0 s on. Raises as ``simulate`` does.
        """
        self._check_stop(stop)
        values = self._tuned(parameters or {})
        self._check_channels(channels)
        grid = self._grid(stop)
        rows = np.empty((len(grid), self._plan.recorded), order="F")
        record = Record(grid, rows, self._record.loop, self._record.header)
        ending, clock, broken = Ending({}), Clock(), None
        try:
            self._go_back(record)
            record.at.row = 0
            record.put(self._plan.values)
            clock.start()
            if channels:
                self._drive(channels)
            if values or channels:
                apply(values, self._plan, record, self._job.step)
            simulate_to(math.inf, self._job, self._plan, record)
        except CallError as failure:
            broken = failure.instance
            ending.message = failure_message(failure, record)
        except KeyboardInterrupt:
            ending.message, ending.interrupted = interruption_message(record), True
        clock.stop()
        return self._result(record, ending, clock.seconds, broken)

    def free(self) -> None:
        """Give the memory of the states back; there are no branches any more."""
        for state in self._states:
            with suppress(CallError):
                state.free()
        self._states = []

    def _result(self, record: Record, ending: Ending, wall: float, broken: Instance | None) -> Result:
        ending.statistics = statistics(self._plan, record, wall, broken) | {"resumed_at_s": self.time}
        result = result_of(self._layout, record, ending, self._faults)
        if ending.interrupted:
            raise SimulationInterrupted(ending.message or "", result)
        if ending.message is not None:
            raise PartialResultError(ending.message, result)
        return result

    def _go_back(self, record: Record) -> None:
        if not self._states:
            raise InputError("there are no branches any more, since the with statement has ended; run them within it")
        for instance, state in zip(self._instances, self._states, strict=True):
            if instance.is_broken:
                raise CallError(instance, "has declared itself broken in an earlier branch", "begin the branches anew")
            state.restore()
        self._plan.schedule = self._schedule
        for line, (times, values) in zip(self._plan.lines, self._lines, strict=True):
            line.times, line.values = times, values
        put_back(self._start, self._plan, record)

    def _grid(self, stop: float) -> NDArray[np.float64]:
        """Return the times of the rows: the beginning, and what follows of the grid of a run from 0."""
        if stop not in self._grids:
            grid = output_grid(stop, self._job.output_interval)
            first = int(np.searchsorted(grid, self.time + SAME_INSTANT, side="right"))
            begin = grid[first - 1] if self._on_row else self.time
            self._grids = {stop: np.concatenate(([begin], grid[first:]))}
        return self._grids[stop]

    def _check_stop(self, stop: float) -> None:
        if not self.time + 2.0 * SAME_INSTANT < stop < math.inf:
            raise InputError(f"stop is {stop:g} s; the branches begin at {self.time:.9g} s, so give a later one")
        if stop > self.horizon + SAME_INSTANT:
            raise InputError(
                f"stop is {stop:g} s, but the FMUs were told that the simulation ends at {self.horizon:g} s; give an "
                "earlier one, or a later stop where the branches are made from"
            )
        step = self._job.step
        if step is not None and abs(stop - round(stop / step) * step) > 0.5 * SAME_INSTANT:
            raise InputError(f"stop is {stop:g} s; it must be a multiple of the macro step, {step:g} s")

    def _tuned(self, parameters: Mapping[tuple[str, str], Value]) -> dict[str, dict[str, Value]]:
        """Return the parameters by component, each in the type of its variable."""
        found: dict[str, dict[str, Value]] = {}
        by_name = {component.name: component for component in self._job.system.components}
        for (name, variable), value in parameters.items():
            if name not in by_name:
                there = ", ".join(by_name)
                raise InputError(f"{dotted((name, variable))}: there is no component {name}; there are {there}")
            checked = parameters_of(Component(name, by_name[name].fmu, {variable: value}))
            if by_name[name].fmu.variables[variable].variability != "tunable":
                raise FmuError(f"{dotted((name, variable))}: is fixed; it cannot change while a simulation runs")
            found.setdefault(name, {}).update(checked)
        return found

    def _check_channels(self, channels: Sequence[Channel]) -> None:
        known = {channel.target: channel for channel in self._job.system.channels}
        for channel in channels:
            name = dotted(channel.target)
            if channel.target not in known:
                raise InputError(
                    f"channel {name}: no channel has driven it up to {self.time:.9g} s; there are "
                    f"{', '.join(map(dotted, known)) or 'none'}; give the whole system one, with its start value"
                )
            if channel.linear != known[channel.target].linear:
                kind = "interpolated" if known[channel.target].linear else "held"
                raise InputError(f"channel {name}: up to {self.time:.9g} s it was {kind}; it has to remain so")
            if channel.times and channel.times[0] < self.time - SAME_INSTANT:
                raise InputError(
                    f"channel {name}: its first entry is at {channel.times[0]:.9g} s; the branches begin at "
                    f"{self.time:.9g} s"
                )
        if channels:
            replace(self._job.system, channels=list(channels), connections=[], faults=[]).check()

    def _drive(self, channels: Sequence[Channel]) -> None:
        """Let these channels act from now on, and the others go on."""
        plan, system, given = self._plan, self._job.system, {channel.target: channel for channel in channels}
        holds = []
        for channel in system.channels:
            slot = self._layout.signals[channel.target]
            line = next((line for line in plan.lines if line.slot == slot), None)
            new = given.get(channel.target)
            if line is None:
                holds.append((new or _later(channel, self.time), slot))
            elif new is not None:
                line.times = [self.time, *new.times]
                line.values = [plan.values[slot], *new.values]
                plan.values[slot] = line.at(self.time)
        plan.schedule = Schedule([hold for hold in holds if hold[0].times], plan.lines)
        if not any(channel.times[0] <= self.time + SAME_INSTANT for channel in channels):
            plan.schedule.skip(self.time)  # nothing but corners of lines in the past


@contextmanager
def branches(checkpoint: Checkpoint, system: System) -> Iterator[Branches]:
    """Give runs that go on from a checkpoint: ``with branches(checkpoint, system) as run: result = run(stop=8.0)``.

    The system has to agree with the checkpoint as for ``simulate(resume=...)``; tunable parameters that differ are set
    for all branches. They run in this process. Raises InputError (FmuError) if one of both cannot be used.
    """
    interval, step = (_number(checkpoint, name) for name in ("output_interval", "step"))
    tolerance, order = (_number(checkpoint, name) for name in ("tolerance", "extrapolation"))
    algorithm = checkpoint.setup.settings.get("algorithm")
    recorded = min(checkpoint.horizon, max(1, len(checkpoint.rows)) * (interval or math.nan))
    stop = checkpoint.horizon if math.isfinite(checkpoint.horizon) else recorded
    job = prepared(
        system,
        stop=stop,
        output_interval=interval or 0.0,
        tolerance=tolerance or 0.0,
        algorithm=cast(Algorithm, algorithm),
        step=step,
        extrapolation=None if order is None or algorithm in ("gauss-seidel", "jacobi") else int(order),
    )
    parameters = check_resume(checkpoint, system, job.settings, recorded)
    saving = Saving(checkpoint.horizon, resume=checkpoint, parameters=parameters)
    with _begun(replace(job, saving=saving), recorded) as begun:
        yield begun


def _number(checkpoint: Checkpoint, name: str) -> float | None:
    value = checkpoint.setup.settings.get(name)
    return float(value) if isinstance(value, int | float) else None


@contextmanager
def warm_up(
    system: System,
    *,
    until: float,
    output_interval: float,
    tolerance: float,
    stop: float | None = None,
    algorithm: Algorithm = "auto",
    step: float | None = None,
    extrapolation: int | None = None,
) -> Iterator[Branches]:
    """Simulate to the first communication point at or after ``until`` [s], and give runs that go on from there.

    The FMUs need to keep their states in memory only. They are told ``stop`` [s], where every branch ends at latest;
    None tells them of no end, which a solver may take as leave to step on. The other arguments are those of
    ``simulate``, and all runs in this process. Raises as ``simulate`` does.
    """
    horizon = math.inf if stop is None else stop
    if not 0.0 < until < horizon:
        raise InputError(f"until is {until:g} s; it must be above 0 and before the stop, {horizon:g} s")
    check_arguments(until, output_interval, tolerance)
    recorded = min(horizon, (math.ceil(until / output_interval) + 1) * output_interval)
    job = prepared(
        system,
        stop=horizon if stop is not None else recorded,
        output_interval=output_interval,
        tolerance=tolerance,
        algorithm=algorithm,
        step=step,
        extrapolation=extrapolation,
    )
    check_can_save(system.components, in_file=False)
    with _begun(replace(job, saving=Saving(horizon)), recorded, until) as begun:
        yield begun


@contextmanager
def _begun(job: Job, recorded: float, until: float | None = None) -> Iterator[Branches]:
    """Give the branches of a job that begins where it says, and goes on ``until`` [s], with rows up to ``recorded``."""
    if job.saving and math.isinf(job.saving.horizon) and any(fault.kind in RANDOM for fault in job.system.faults):
        raise InputError(f"faults that draw lots ({', '.join(RANDOM)}) need to know the end: give warm_up a stop")
    if job.saving and math.isinf(job.saving.horizon) and job.method.algorithm == "adaptive":
        raise InputError(
            "the algorithm adaptive divides the tolerance among the seconds of the run, and needs to know the end: "
            "give warm_up a stop"
        )
    layout = lay_out(job.system)
    record = Record.empty(recorded, job.output_interval, layout.recorded, loop_name())
    sites = [Site(record.at, number) for number in range(len(job.system.components))]
    with instantiated(job, sites) as plan:
        begun: Branches | None = None
        try:
            begin(job, plan, record)
            if until is not None:
                simulate_to(until, job, plan, record)
            begun = Branches(job, plan, record, layout)
        except CallError as failure:
            message = failure_message(failure, record)
            raise PartialResultError(message, result_of(layout, record, Ending({}, message), ())) from failure
        try:
            yield begun
        finally:
            begun.free()


def _later(channel: Channel, time: float) -> Channel:
    first = sum(1 for t in channel.times if t <= time + SAME_INSTANT)
    return replace(channel, times=channel.times[first:], values=channel.values[first:])
