"""A run in a worker: it does everything, this process looks on, and says where it died if it does."""

from __future__ import annotations

import time
from collections.abc import Callable
from ctypes import byref
from dataclasses import dataclass
from functools import partial
from math import inf
from typing import Literal, NamedTuple, TypeGuard, get_args

from cosim.engine._board import Board
from cosim.engine._calls import CALLS, LOADING, UNLOADING, Site
from cosim.engine._execution import Ending, Job, execute, instantiated, interruption_message
from cosim.engine._library import native_library, preload
from cosim.engine._log import SILENCE
from cosim.engine._plan import roles_of
from cosim.engine._record import Record, place_of
from cosim.engine._structures import NOWHERE, STACK_OVERFLOW, WRONG_ADDRESS
from cosim.engine._system import System
from cosim.errors import InputError, SimulationError
from cosim.worker import Answer, Death, Worker, machine_memory

Isolate = Literal["auto", "always", "never"]
"""Whether a run gets a process of its own; "auto" gives it one unless this project has built all its FMUs."""

_LOOK = 0.05
"""Time between two looks at the worker [s]: as often progress is shown."""

_GRACE = 0.5
"""Time [s] after Ctrl-C in which the run may end by itself, before its process is ended."""


@dataclass(frozen=True)
class Limits:
    """What an isolated run may take: ``call`` [s] for one call of an FMU, ``memory`` [bytes]; None: all there is."""

    call: float = 60.0
    memory: float | None = None

    def __post_init__(self) -> None:
        """Refuse what cannot be meant."""
        if not self.call > 0.0:
            raise InputError(f"call_timeout is {self.call:g} s; it must be above 0")
        if self.memory is not None and not self.memory >= _LEAST_MEMORY:
            raise InputError(f"memory_limit is {self.memory:g} bytes; at least {_LEAST_MEMORY:g} are needed")


_LEAST_MEMORY = 1e8
_NULL_PAGE = 0x1000
_FIRST_VERSION = {
    "Instantiate": "InstantiateSlave",
    "Terminate": "TerminateSlave",
    "FreeInstance": "FreeSlaveInstance",
}
"""What functions are called in FMI 1.0."""


def is_isolated(isolate: Isolate, system: System) -> bool:
    """Tell whether a run of this system gets a process of its own. Raises InputError for an unknown choice."""
    if isolate not in get_args(Isolate):
        raise InputError(f"isolate is {isolate!r}; it can be {', '.join(get_args(Isolate))}")
    if isolate != "auto":
        return isolate == "always"
    from cosim.fmu.provenance import is_own

    return not all(is_own(fmu.path, fmu.sha256) for fmu in {component.fmu for component in system.components})


class _HangsError(Exception):
    pass


class _Sight(NamedTuple):
    """What differs between two looks at a run unless it hangs in one call; or makes the same one again and again.

    The native loop does not count its calls, since it has no time to. What it makes again and again at one instant are
    updates of discrete states, 100 at most.
    """

    calls: int = -1
    row: int = 0
    exchanges: int = 0
    now: float = 0.0
    component: int = 0
    function: int = 0


def run_isolated(
    job: Job, width: int, loop: str, limits: Limits, progress: Callable[[float], None] | None
) -> tuple[Record, Ending]:
    """Do what ``execute`` does, for ``width`` recorded signals, in a process of its own.

    A process that dies, or hangs, makes an ending with a message, too. Raises what a run here would raise.
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
        supervisor = _Supervisor(job, record, board[0], limits, memory, started)
        worker.start(_serve, job, loop, len(record.grid), width, most_memory=memory)
        ending = supervisor.look_after(worker, progress)
        return record.apart(), ending


def get_ready() -> None:
    """Load in advance what every worker needs."""
    preload()


def _serve(memory: memoryview, answer: Answer, job: Job, loop: str, n_rows: int, width: int) -> None:
    """Run in the worker; the answer is the ending. What can crash after it is still watched."""
    board = Board(memory, len(job.system.components), n_rows, width)
    record = Record.empty(job.stop, job.output_interval, width, loop, lambda _: board)
    names = range(len(job.system.components))
    sites = [Site(record.at, number, watched=True, say=partial(board.say, number)) for number in names]

    def look(_: float) -> None:
        if board.stop:
            raise KeyboardInterrupt

    library = native_library(loop)
    if library is not None:
        library.cosim_note_faults(byref(board.fault))
    with instantiated(job, sites) as plan:
        answer(execute(job, plan, record, look))
    for site, component in zip(sites, job.system.components, strict=True):
        site.enter(UNLOADING)
        component.fmu.close()
        site.leave()


@dataclass
class _Supervisor:
    job: Job
    record: Record
    board: Board
    limits: Limits
    memory: float
    started: float

    def look_after(self, worker: Worker, progress: Callable[[float], None] | None) -> Ending:
        """Wait for the end of the worker; return how the run ended."""
        shown = -inf
        seen, since = _Sight(), time.perf_counter()
        try:
            while not worker.wait(_LOOK):
                at, now = self.record.at, time.perf_counter()
                sight = _Sight(at.calls, at.row, at.exchanges, at.now, at.component, at.function)
                if sight != seen or at.component == NOWHERE:
                    seen, since = sight, now
                elif now - since > self.limits.call:
                    raise _HangsError
                if progress is not None and at.now > shown and worker.answer is None:
                    shown = at.now
                    progress(shown)
        except _HangsError:
            worker.kill()
            self._check_place(worker.death)
            remedy = "if it is only slow, allow its calls more time with --call-timeout"
            what = f"has not come back {self._place('from')} within {self.limits.call:g} s"
            return self._failed(worker, what, remedy)
        except KeyboardInterrupt:
            return self._interrupted(worker)
        if worker.answer is None or (worker.death.code and _finished(worker.answer)):
            self._check_place(worker.death)
            return self._failed(worker, *self._end_of(worker.death))
        if progress is not None and _finished(worker.answer):
            progress(self.record.now)
        return _ending(worker.answer)

    def _interrupted(self, worker: Worker) -> Ending:
        self.board.stop = True
        until = time.perf_counter() + _GRACE
        try:
            while worker.answer is None and time.perf_counter() < until and not worker.wait(_LOOK):
                pass
        except KeyboardInterrupt:
            pass  # twice: at once
        worker.kill()
        if not self._is_credible():
            self.record.at.row = 0
        ending = _ending(worker.answer) if worker.answer else Ending(self._statistics())
        ending.message, ending.interrupted = interruption_message(self.record), True
        return ending

    def _end_of(self, death: Death) -> tuple[str, str]:
        """Return what has happened, and what to do."""
        memory = f", when it had {death.memory / 1e9:.2g} GB of memory" if death.memory > 0.7 * self.memory else ""
        if death.crashed:
            verb = "was ended" if death.killed else "crashed"
            remedy = "try it in another tool, and report it to whoever exported it"
            if memory:
                remedy = (
                    f"it may have {self.memory / 1e9:.2g} GB: give it more with --memory-limit, or let it take less"
                )
            return f"{verb} {self._place('in')}, with {self._cause(death)}{memory}", remedy
        return (
            f"ended its process {self._place('in')}, with exit code {death.code}{memory}",
            "an FMU has to return a status instead: report it to whoever exported it",
        )

    def _is_credible(self) -> bool:
        """Tell whether the position can be one, which an FMU may have written over."""
        at, grid = self.record.at, self.record.grid
        return (
            0 <= at.row <= len(grid)
            and 0.0 <= at.now <= grid[-1]
            and at.exchanges >= 0
            and NOWHERE <= at.component < len(self.job.system.components)
            and 0 <= at.function < len(CALLS)
        )

    def _cause(self, death: Death) -> str:
        """Return the signal, and what it means."""
        fault = self.board.fault
        if fault.kind == STACK_OVERFLOW:
            return f"{death.name} (its stack has overflowed: its calls are nested too deeply)"
        if fault.kind == WRONG_ADDRESS:
            which = "by a null pointer" if fault.address < _NULL_PAGE else f"at address {fault.address:#x}"
            return f"{death.name} ({death.meaning}, {which})"
        return str(death)

    def _place(self, preposition: str) -> str:
        """Return in which call it was, or "from" which."""
        at = self.record.at
        function = CALLS[at.function]
        if function in (LOADING, UNLOADING):
            return f"{'while' if preposition == 'in' else preposition} {function} its binary"
        fmu = self.job.system.components[at.component].fmu
        version = fmu.fmi_version[0]
        if function == "Instantiate" and version == "3":
            function += fmu.interface
        if version == "1":
            return f"{preposition} {fmu.model_identifier}_fmi{_FIRST_VERSION.get(function, function)}"
        return f"{preposition} fmi{version}{function}"

    def _check_place(self, death: Death) -> None:
        """Raise SimulationError if the position is not in a call of an FMU."""
        if not self._is_credible():
            raise SimulationError(
                f"the process of the simulation has ended, with {death}, and what it has written down makes no sense: "
                "an FMU must have written into memory that is not its own; report it to whoever exported it"
            )
        if self.record.at.component == NOWHERE:
            raise SimulationError(
                f"the process of the simulation has ended outside of all FMUs, with {death}; run it again, and report "
                "it as a defect of cosim if that happens again"
            )

    def _failed(self, worker: Worker, what: str, remedy: str) -> Ending:
        at = self.record.at
        component = self.job.system.components[at.component]
        message = (
            f"the simulation failed {place_of(self.record)}: {component.name} ({component.fmu.name}): {what}; "
            f"{self.board.said(at.component) or SILENCE}; {remedy}"
        )
        ending = worker.answer if _finished(worker.answer) else Ending(self._statistics())
        ending.message = message
        return ending

    def _statistics(self) -> dict[str, object]:
        """Return what is known without the worker."""
        roles = {name: role.value for name, role in roles_of(self.job.system).items()}
        return {
            "wall_s": time.perf_counter() - self.started,
            "loop": self.record.loop,
            "exchanges": self.record.exchanges,
            "roles": roles,
            "steps": {},
            "events": {},
            "solver": {},
        }


def _finished(answer: object) -> TypeGuard[Ending]:
    return isinstance(answer, Ending) and answer.message is None


def _ending(answer: object) -> Ending:
    """Return the ending that was answered, or raise the error."""
    if isinstance(answer, BaseException):
        raise answer
    assert isinstance(answer, Ending)
    return answer
