"""A run in a worker, which does everything while this process looks on."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Sequence
from ctypes import byref
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Literal, get_args

from cosim.engine._execution import Ending, Job, execute, instantiated
from cosim.engine._supervisor import Limits, Supervisor
from cosim.engine.checkpoints._resume import written
from cosim.engine.fmu._calls import UNLOADING, Site
from cosim.engine.loop._board import Board
from cosim.engine.loop._record import Record
from cosim.engine.native._library import native_library, preload
from cosim.engine.native._structures import NOWHERE
from cosim.engine.system._system import System
from cosim.errors import InputError
from cosim.worker import Answer, Worker, machine_memory

Isolate = Literal["auto", "always", "never"]
"""Whether a run gets a process of its own; "auto" gives it one unless this project has built all its FMUs."""

Progress = Callable[[float], None]

Task = Callable[[Job, Record, Sequence[Site], Progress, Answer], None]
"""What a worker does: it notes the calls of each component at its site, calls the progress now and then, and answers.

After the answer it may still call FMUs, which is watched, too.
"""


def is_isolated(isolate: Isolate, system: System) -> bool:
    """Tell whether a run of this system gets a process of its own. Raises InputError for an unknown choice."""
    if isolate not in get_args(Isolate):
        raise InputError(f"isolate is {isolate!r}; it can be {', '.join(get_args(Isolate))}")
    if isolate != "auto":
        return isolate == "always"
    from cosim.fmu.catalogue import is_own

    return not all(is_own(fmu.path, fmu.sha256) for fmu in {component.fmu for component in system.components})


def run_isolated(job: Job, width: int, loop: str, limits: Limits, progress: Progress | None) -> tuple[Record, Ending]:
    """Do what ``execute`` does, for ``width`` recorded signals, in a process of its own.

    A process that dies, or hangs, makes an ending with a message, too. Raises what a run here would raise.
    """
    saving = job.saving
    with tempfile.TemporaryDirectory(prefix="cosim-") as folder:
        if saving and saving.at and saving.folder is None:
            saving = replace(saving, folder=Path(folder))
        record, ending = supervised(_simulate, replace(job, saving=saving), width, loop, limits, progress)
        assert isinstance(ending, Ending)
        ending.checkpoints = written(saving, record.now) if saving else []
    return record, ending


def supervised(
    task: Task, job: Job, width: int, loop: str, limits: Limits, progress: Progress | None = None
) -> tuple[Record, object]:
    """Let a worker do a task; return the record as it has left it, and its answer.

    Instead of an answer there is an ``Ending`` with a message if the worker dies, hangs or is interrupted. Raises the
    exception that is the answer.
    """
    started = time.perf_counter()
    with Worker() as worker:
        components = len(job.system.components)
        board: list[Board] = []

        def allocate(n_rows: int) -> Board:
            board.append(Board(worker.map(Board.size(components, n_rows, width)), components, n_rows, width))
            return board[0]

        record = Record.empty(job.stop, job.output_interval, width, loop, allocate)
        record.at.component = NOWHERE
        memory = machine_memory() if limits.memory is None else limits.memory
        supervisor = Supervisor(job, record, board[0], limits, memory, started)
        worker.start(_serve, task, job, loop, len(record.grid), width, most_memory=memory)
        answer = supervisor.look_after(worker, progress)
        return record.apart(), answer


def get_ready() -> None:
    """Load in advance what every worker needs."""
    preload()


def _serve(memory: memoryview, answer: Answer, task: Task, job: Job, loop: str, n_rows: int, width: int) -> None:
    """Run in the worker."""
    board = Board(memory, len(job.system.components), n_rows, width)
    record = Record.empty(job.stop, job.output_interval, width, loop, lambda _: board)
    numbers = range(len(job.system.components))
    sites = [Site(record.at, number, watched=True, say=partial(board.say, number)) for number in numbers]

    def look(_: float) -> None:
        if board.stop:
            raise KeyboardInterrupt

    library = native_library(loop)
    if library is not None:
        library.cosim_note_faults(byref(board.fault))
    task(job, record, sites, look, answer)
    for site, component in zip(sites, job.system.components, strict=True):
        site.enter(UNLOADING)
        component.fmu.close()
        site.leave()


def _simulate(job: Job, record: Record, sites: Sequence[Site], progress: Progress, answer: Answer) -> None:
    with instantiated(job, sites) as plan:
        ending = execute(job, plan, record, progress)
        ending.checkpoints = []  # they are in files
        answer(ending)
