"""A process that has loaded all modules and forks itself for each worker: that takes milliseconds.

It is started by the first worker of this process and ends with it. It runs in one thread and calls no FMU, so that a
fork of it is as good as a new process. Between it and the worker stands another fork, the guardian, which waits for the
worker's end and tells of it. POSIX only.
"""

from __future__ import annotations

import contextlib
import importlib
import os
import signal
import socket
import struct
import subprocess
import sys
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

from cosim.worker._child import quiet_channels, work

_PACKAGES = str(Path(__file__).parents[2])
_BOOT = "import sys; sys.path[:] = {path!r}; from cosim.worker._nursery import main; main({channel}, {preload!r})"
_SINGLE_THREADED = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")

BORN = struct.Struct("=q")
"""What a guardian tells first: the worker's process id."""

ENDED = struct.Struct("=qd")
"""What it tells last: the worker's exit code, or minus the signal, and the most memory that it had [bytes]."""


def boot_path() -> list[str]:
    """Return where a new interpreter finds the modules that this one has."""
    return [_PACKAGES, *(entry or str(Path.cwd()) for entry in sys.path if isinstance(entry, str))]


class Nursery:
    """The nursery of this process."""

    def __init__(self, preload: str) -> None:
        """Start it; it is ready to be asked while it is still loading this module and all that it needs."""
        self._owner = os.getpid()
        self._channel, other = socket.socketpair()
        boot = _BOOT.format(path=boot_path(), channel=other.fileno(), preload=preload)
        with other:
            self._process = subprocess.Popen(
                [sys.executable, "-I", "-c", boot],
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
        """End it."""
        self._channel.close()
        if self._owner == os.getpid():
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._process.wait(timeout=2.0)
                return
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
    """Fork for each request until there come no more."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # whoever started this process decides what Ctrl-C means
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # nobody waits for guardians
    importlib.import_module(preload)
    requests = socket.socket(fileno=channel)
    while True:
        request, descriptors, _, _ = socket.recv_fds(requests, 1, 8)
        if not request:
            os._exit(0)
        if os.fork() == 0:
            _guard(channel, descriptors)
        for descriptor in descriptors:
            os.close(descriptor)


def _guard(requests: int, descriptors: Sequence[int]) -> NoReturn:
    """Fork once more, and tell how that ends."""
    memory, jobs, answers, status, *errors = descriptors
    os.close(requests)
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    child = os.fork()
    if child == 0:
        os.setpgid(0, 0)
        os.close(status)
        for descriptor in errors:
            os.dup2(descriptor, 2)
            os.close(descriptor)
        null = os.open(os.devnull, os.O_RDWR)
        quiet_channels(null)
        os.close(null)
        work(str(memory), jobs, answers)
    with contextlib.suppress(OSError):  # it may have done so itself
        os.setpgid(child, child)
    for descriptor in (memory, jobs, answers, *errors):
        os.close(descriptor)
    os.write(status, BORN.pack(child))
    _, ended, usage = os.wait4(child, 0)
    code = os.waitstatus_to_exitcode(ended)
    if code:
        with contextlib.suppress(OSError):  # what it has started
            os.killpg(child, signal.SIGKILL)
    os.write(status, ENDED.pack(code, usage.ru_maxrss * (1.0 if sys.platform == "darwin" else 1024.0)))
    os._exit(0)
