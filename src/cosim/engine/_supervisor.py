"""What the process that has started a worker does: it looks on, gives up what hangs, and says where a worker died."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from typing import NamedTuple

from cosim.engine._execution import Ending, Job, interruption_message
from cosim.engine.fmu._calls import CALLS, LOADING, UNLOADING
from cosim.engine.fmu._log import SILENCE
from cosim.engine.loop._board import Board
from cosim.engine.loop._plan import roles_of
from cosim.engine.loop._record import Record, place_of
from cosim.engine.native._structures import NOWHERE, STACK_OVERFLOW, WRONG_ADDRESS
from cosim.errors import InputError, SimulationError
from cosim.worker import Death, Worker

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


@dataclass
class Supervisor:
    """Looks after one worker, whose record and board these are.

    ``memory`` [bytes] is what the worker may have, ``started`` the reading of the clock when it was asked for.
    """

    job: Job
    record: Record
    board: Board
    limits: Limits
    memory: float
    started: float

    def look_after(self, worker: Worker, progress: Callable[[float], None] | None) -> object:
        """Wait for the end of the worker; return its answer, or how it ended; raises the answer if it is an error."""
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
        if worker.answer is None or (worker.death.code and _succeeded(worker.answer)):
            self._check_place(worker.death)
            return self._failed(worker, *self._end_of(worker.death))
        if progress is not None and _succeeded(worker.answer):
            progress(self.record.now)
        return _content(worker.answer)

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
        answer = _content(worker.answer)
        ending = answer if isinstance(answer, Ending) else Ending(self._statistics())
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
        answer = worker.answer
        ending = answer if isinstance(answer, Ending) else Ending(self._statistics())
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


def _succeeded(answer: object) -> bool:
    """Tell whether an answer is neither an error nor a run that ended before its time."""
    return not (isinstance(answer, BaseException) or (isinstance(answer, Ending) and answer.message is not None))


def _content(answer: object) -> object:
    """Return an answer, or raise it if it is an error."""
    if isinstance(answer, BaseException):
        raise answer
    return answer
