"""Saving a run at its communication points, and going on from there: what has to agree, and what may be changed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cosim.engine.checkpoints._checkpoint import Checkpoint
from cosim.engine.checkpoints._snapshot import in_order, put_back, take
from cosim.engine.fmu._fmu_state import FmuState, why_not_saved, why_not_written
from cosim.engine.fmu._instance import CallError
from cosim.engine.fmu._variable import Value
from cosim.engine.loop._loop import exchange
from cosim.engine.loop._plan import Layout, Plan, lay_out
from cosim.engine.loop._record import Record, output_grid
from cosim.engine.loop._setup import Setting, describe, differences, tuned
from cosim.engine.signals._participant import Participant
from cosim.engine.system._role import Role
from cosim.engine.system._system import SAME_INSTANT, Component, System
from cosim.errors import FmuError, InputError

Parameters = Mapping[str, Mapping[str, Value]]
"""By component: parameters that are set where a run goes on."""


@dataclass(frozen=True)
class Saving:
    """What a run is to save, and from where it goes on.

    ``at`` [s] in rising order; ``folder``, if there is one, gets a file of each; ``horizon`` [s] is the stop time that
    the FMUs are told, infinite for none; ``parameters`` are those that are set at the beginning of the resumed run.
    """

    horizon: float
    at: tuple[float, ...] = ()
    folder: Path | None = None
    resume: Checkpoint | None = None
    parameters: Parameters | None = None


def check_times(at: Sequence[float], stop: float, begin: float | None) -> tuple[float, ...]:
    """Return the times [s] of checkpoints in rising order; raises InputError for one outside of the run."""
    for time in at:
        if not 0.0 <= time <= stop + SAME_INSTANT:
            raise InputError(f"a checkpoint at {time:g} s: the run goes from 0 to {stop:g} s only")
        if begin is not None and time <= begin + SAME_INSTANT:
            raise InputError(f"a checkpoint at {time:g} s: the run goes on from {begin:.9g} s; give a later time")
    return tuple(sorted(set(at)))


def check_can_save(components: Sequence[Component], *, in_file: bool) -> None:
    """Raise FmuError for a component whose FMU cannot save its state, or cannot write it down if that is needed."""
    for component in components:
        who = f"{component.name} ({component.fmu.name})"
        if (reason := why_not_saved(component.fmu)) is not None:
            raise FmuError(
                f"no checkpoint can be made: {who} {reason}; run the system without checkpoints, from 0 on",
                file=component.fmu.path,
            )
        if in_file and (reason := why_not_written(component.fmu)) is not None:
            raise FmuError(
                f"no checkpoint can be made: {who} {reason}; it can keep it in memory: cosim.engine.warm_up "
                "lets many runs branch from one state",
                file=component.fmu.path,
            )


def check_resume(checkpoint: Checkpoint, system: System, settings: dict[str, Setting], stop: float) -> Parameters:
    """Return the parameters to be set where a checked system goes on; raises InputError if it cannot go on there."""
    time, saved = checkpoint.time, checkpoint.setup
    place = f"cannot go on from the checkpoint at {time:.9g} s"
    check_can_save(system.components, in_file=True)
    found = differences(saved, describe(system, settings, checkpoint.horizon, time))
    if found:
        more = f"; and {len(found) - 3} more" if len(found) > 3 else ""
        raise InputError(f"{place}: {'; '.join(found[:3])}{more}; use what it was made with, or make a new one")
    if stop > checkpoint.horizon + SAME_INSTANT:
        raise InputError(
            f"{place} to {stop:g} s: the FMUs were told that the simulation ends at {checkpoint.horizon:g} s; stop "
            "there or earlier, or make the checkpoint in a run with a later stop, or with cosim.engine.warm_up"
        )
    grid = output_grid(stop, float(settings["output_interval"] or 0.0))
    if stop < time - SAME_INSTANT or (stop < time + SAME_INSTANT and len(checkpoint.rows) != len(grid)):
        raise InputError(f"{place} to {stop:g} s; give a later stop")
    _check_shape(checkpoint, lay_out(system), grid)
    return tuned(saved, system)


def _check_shape(checkpoint: Checkpoint, layout: Layout, grid: np.ndarray) -> None:
    """Refuse what no run can have written, before it is made use of."""
    snapshot, (rows, columns) = checkpoint.snapshot, checkpoint.rows.shape
    complete = (
        columns == layout.recorded
        and rows == np.searchsorted(grid, checkpoint.time + SAME_INSTANT, side="right")
        and len(snapshot.values) >= 8 * (layout.total + 1)
        and len(snapshot.components) == len(checkpoint.setup.components) == len(checkpoint.states)
        and (
            checkpoint.setup.settings.get("algorithm") == "jacobi"
            or all(progress.due > checkpoint.time + SAME_INSTANT for progress in snapshot.components)
        )
    )
    if not complete:
        raise _unfit()


def _unfit() -> InputError:
    return InputError(
        "the checkpoint does not fit this system: it is damaged, or another version of cosim has written it; make it "
        "again"
    )


class NotWrittenError(Exception):
    """The file of a checkpoint cannot be written; the text says which, and why."""


def forget(saving: Saving) -> None:
    """Remove the files that a run is to write, so that none of an earlier run is taken for its own."""
    if saving.folder is None:
        return
    for at in saving.at:
        with suppress(OSError):  # of which there will be more when the file is to be written
            (saving.folder / Checkpoint.file_name(at)).unlink(missing_ok=True)


def save(
    plan: Plan, record: Record, system: System, settings: dict[str, Setting], saving: Saving, at: float
) -> Checkpoint:
    """Return the checkpoint asked for ``at`` [s], of a run that is there, between two steps; write its file.

    Raises CallError if an FMU fails to save its state, NotWrittenError.
    """
    states = []
    for participant in in_order(plan):
        state = FmuState(participant.instance)
        states.append(state.to_bytes())
        state.free()
    setup = describe(system, settings, saving.horizon, record.now)
    checkpoint = Checkpoint(setup, take(plan, record), tuple(states), record.rows[: record.count].copy())
    if saving.folder is not None:
        try:
            checkpoint.save(saving.folder / Checkpoint.file_name(at))
        except InputError as error:
            raise NotWrittenError(str(error)) from error
    return checkpoint


def restore(checkpoint: Checkpoint, plan: Plan, record: Record, tolerance: float) -> None:
    """Put instances that were just made, a plan and a record to where the checkpoint was.

    Raises FmuError if an FMU refuses its state, InputError if the checkpoint does not belong to this plan.
    """
    try:
        put_back(checkpoint.snapshot, plan, record)
    except ValueError as error:
        raise _unfit() from error
    for participant, content in zip(in_order(plan), checkpoint.states, strict=True):
        instance = participant.instance
        try:
            state = FmuState(instance, content)
            state.restore()
            state.free()
            instance.go_on(tolerance)
        except CallError as error:
            raise FmuError(
                f"{instance.name} ({instance.fmu.name}) refuses its state in the checkpoint: {error.what}; "
                f"{instance.log}; make the checkpoint again",
                file=instance.fmu.path,
            ) from error
    record.rows[: len(checkpoint.rows)] = checkpoint.rows
    record.at.row = len(checkpoint.rows)


def apply(parameters: Parameters, plan: Plan, record: Record, step: float | None) -> None:
    """Set parameters between two steps, and let what follows from them and from channels happen at once.

    A component with Event Mode gets an event for it. ``step`` [s] is that of the Jacobi algorithm, None for the default
    one. Raises CallError.
    """
    touched = False
    for participant in in_order(plan):
        values = dict(parameters.get(participant.instance.name, {}))
        if values:
            touched = True
            _tune(participant, values, record.now)
    if plan.schedule.next <= record.now + SAME_INSTANT or touched:
        record.exchanges += step is None
        exchange(plan, record.now, recording=True)
        plan.faults.settle(record.now)


def _tune(participant: Participant, values: dict[str, Value], now: float) -> None:
    instance = participant.instance
    if participant.role is Role.EVENT:
        participant.carry(now)
        instance.check("EnterEventMode", instance.enter_event())
        participant.in_event_mode = True
        participant.due = now
    instance.set_values(values)


def written(saving: Saving, reached: float) -> list[Checkpoint]:
    """Return the checkpoints whose files a run has written that came to ``reached`` [s]."""
    assert saving.folder is not None or not saving.at
    files = [
        saving.folder / Checkpoint.file_name(at) for at in saving.at if saving.folder and at <= reached + SAME_INSTANT
    ]
    return [Checkpoint.load(file) for file in files if file.is_file()]
