"""The worker as the process that has started it sees it."""

from __future__ import annotations

import atexit
import os
import pickle
import sys
import time
from collections.abc import Callable
from types import TracebackType
from typing import Self

from cosim.worker import _nursery
from cosim.worker._child import working_folder
from cosim.worker._death import Death
from cosim.worker._shared import Shared
from cosim.worker._transport import Transport

_PRELOAD = "cosim.engine._isolation"
"""The module that a worker loads before it gets its job, so that it has no need to then; it has ``get_ready``."""


class Worker:
    """A process of its own for one job; a context manager that leaves nothing of it.

    What it prints goes to stderr. It is in a process group of its own, so that Ctrl-C does not reach it, and ends when
    this process ends.
    """

    def __init__(self) -> None:
        """Start the process."""
        if sys.platform == "win32":
            from cosim.worker._spawned import transport
        else:
            from cosim.worker._posix import transport
        self._shared = Shared()
        self._size = 1
        self._answer: object = None
        try:
            self._transport: Transport = transport(self._shared, _PRELOAD)
        except BaseException:
            self._shared.close()
            raise

    def map(self, size: int) -> memoryview:
        """Return the memory, of this size [bytes], that the job will find; it stays as long as somebody uses it."""
        self._size = size
        return self._shared.map(size)

    def start(self, function: Callable[..., None], *arguments: object, most_memory: float) -> None:
        """Let it call a function of a module with the memory, a function that takes the answer, and these arguments.

        The process may have ``most_memory`` [bytes], where that can be limited; it ends when the function returns.
        """
        job = pickle.dumps((function, self._size, most_memory, arguments))
        self._transport.send(pickle.dumps((dict(os.environ), working_folder(), job)))

    def wait(self, seconds: float) -> bool:
        """Wait for a change, at most so long; tell whether the process has ended."""
        if self._transport.death is None:
            self._transport.wait(seconds)
        return self._transport.death is not None

    @property
    def answer(self) -> object:
        """What the job has answered; None before. What cannot be understood is no answer."""
        if self._answer is None and self._transport.answer is not None:
            try:
                self._answer = pickle.loads(self._transport.answer)
            except Exception:  # an FMU may have written there
                return None
        return self._answer

    @property
    def death(self) -> Death:
        """How it ended, or would if it could be killed: a system call may keep it."""
        return self._transport.death or Death(-9)

    def kill(self) -> None:
        """End it, and what it has started, at once."""
        until = time.perf_counter() + 10.0
        while not self.wait(0.0) and time.perf_counter() < until:
            self._transport.kill()
            self._transport.wait(0.05)

    def __enter__(self) -> Self:
        """Return the worker itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the process if it has not, and give back all that it needed."""
        self.kill()
        self._transport.close()
        self._shared.close()


def prestart() -> None:
    """Let what the first worker needs be loaded while this process does something else."""
    if sys.platform != "win32":
        _nursery.nursery(_PRELOAD)


@atexit.register
def dismiss() -> None:
    """End what workers have been made from; it is started again when needed."""
    _nursery.dismiss()
