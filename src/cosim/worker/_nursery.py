"""A process that has loaded all modules and forks itself for each worker: that takes milliseconds.

It is started by the first worker of this process and ends with it. It runs in one thread and calls no FMU, so that a
fork of it is as good as a new process. It also waits for the workers' ends, and tells of them. POSIX only.
"""

from __future__ import annotations

import contextlib
import gc
import importlib
import os
import select
import signal
import socket
import struct
import subprocess
import sys
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

from cosim.errors import InputError
from cosim.worker._child import quiet_channels, work, working_folder

_PACKAGES = str(Path(__file__).parents[2])
_BOOT = "import sys; sys.path[:] = {{path}}; from cosim.worker._nursery import main; main({channel}, {preload!r})"
_SINGLE_THREADED = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")

BORN = struct.Struct("=q")
"""What is told first: the worker's process id."""

ENDED = struct.Struct("=qd")
"""What is told last: the worker's exit code, or minus the signal, and the most memory that it had [bytes]."""


def interpreter(boot: str) -> list[str]:
    """Return the command that starts this interpreter anew, free of its surroundings; ``{path}`` is its path.

    Raises InputError if there is no such command, as where Python is part of another program.
    """
    if not sys.executable:
        raise InputError('there is no Python program to run a worker with; set isolate="never" (--isolate never)')
    path = [_PACKAGES, *(entry or working_folder() for entry in sys.path if isinstance(entry, str))]
    return [sys.executable, "-I", "-c", boot.replace("{path}", repr(path))]


class Nursery:
    """The nursery of this process."""

    def __init__(self, preload: str) -> None:
        """Start it; it is ready to be asked while it is still loading this module and all that it needs."""
        self._owner = os.getpid()
        self._channel, other = socket.socketpair()
        boot = _BOOT.format(channel=other.fileno(), preload=preload)
        with other:
            self._process = subprocess.Popen(
                interpreter(boot),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                pass_fds=(other.fileno(),),
                process_group=0,
                env=os.environ | _SINGLE_THREADED,
            )

    def fork(self, descriptors: Sequence[int]) -> None:
        """Ask for a worker, with these file descriptors; raises OSError if the nursery has died."""
        socket.send_fds(self._channel, [b"!"], descriptors)

    @property
    def usable(self) -> bool:
        """Whether it is this process's, which may have been forked since, and lives."""
        return self._owner == os.getpid() and self._process.poll() is None

    def close(self) -> None:
        """End it, whatever it does: it has nothing to put in order."""
        self._channel.close()
        if self._owner == os.getpid():
            self._process.kill()
            self._process.wait()


_lock = threading.Lock()
_nursery: list[Nursery] = []


def nursery(preload: str) -> Nursery:
    """Return the nursery of this process, started now if there is none."""
    with _lock:
        if _nursery and not _nursery[0].usable:
            _nursery.pop().close()
        if not _nursery:
            _nursery.append(Nursery(preload))
        return _nursery[0]


def dismiss() -> None:
    """End the nursery of this process, if there is one."""
    with _lock:
        while _nursery:
            _nursery.pop().close()


def main(channel: int, preload: str) -> NoReturn:
    """Fork for each request until there come no more, and tell how each worker ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # whoever started this process decides what Ctrl-C means
    module = importlib.import_module(preload)
    module.get_ready()
    gc.collect()
    gc.freeze()  # so that workers do not copy what they only look at
    requests = socket.socket(fileno=channel)
    woken, waker = socket.socketpair()
    waker.setblocking(False)
    signal.set_wakeup_fd(waker.fileno(), warn_on_full_buffer=False)
    signal.signal(signal.SIGCHLD, lambda *_: None)
    statuses: dict[int, int] = {}
    while True:
        ready, _, _ = select.select([requests, woken], [], [])
        if woken in ready:
            woken.recv(4096)
            _tell_ends(statuses)
        if requests in ready:
            request, descriptors, _, _ = socket.recv_fds(requests, 1, 8)
            if not request:
                os._exit(0)
            memory, jobs, answers, status, *errors = descriptors
            worker = os.fork()
            if worker == 0:
                signal.set_wakeup_fd(-1)
                signal.signal(signal.SIGCHLD, signal.SIG_DFL)
                for descriptor in (requests.detach(), woken.detach(), waker.detach(), status, *statuses.values()):
                    os.close(descriptor)
                _become_worker(memory, jobs, answers, errors)
            with contextlib.suppress(OSError):  # it may have done so itself
                os.setpgid(worker, worker)
            for descriptor in (memory, jobs, answers, *errors):
                os.close(descriptor)
            statuses[worker] = status
            _tell(status, BORN.pack(worker))


def _become_worker(memory: int, jobs: int, answers: int, errors: Sequence[int]) -> NoReturn:
    os.setpgid(0, 0)
    for descriptor in errors:
        os.dup2(descriptor, 2)
        os.close(descriptor)
    null = os.open(os.devnull, os.O_RDWR)
    quiet_channels(null)
    os.close(null)
    work(str(memory), jobs, answers)


def _tell_ends(statuses: dict[int, int]) -> None:
    """Tell of all workers that have ended."""
    while statuses:
        worker, ended, usage = os.wait4(-1, os.WNOHANG)
        if not worker:
            return
        code = os.waitstatus_to_exitcode(ended)
        if code:
            with contextlib.suppress(OSError):  # what it has started
                os.killpg(worker, signal.SIGKILL)
        status = statuses.pop(worker)
        _tell(status, ENDED.pack(code, usage.ru_maxrss * (1.0 if sys.platform == "darwin" else 1024.0)))
        os.close(status)


def _tell(status: int, content: bytes) -> None:
    with contextlib.suppress(BrokenPipeError):  # nobody wants to know any more
        os.write(status, content)
