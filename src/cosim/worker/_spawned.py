"""A worker in a new process of its own interpreter, as its parent sees it: where there is no fork."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import threading
import time
from typing import TYPE_CHECKING, NoReturn

from cosim.worker._child import quiet_channels, work
from cosim.worker._death import Death
from cosim.worker._messages import Message, send
from cosim.worker._nursery import interpreter
from cosim.worker._shared import Shared

if TYPE_CHECKING:
    from cosim.worker._transport import Transport

_BOOT = "import sys; sys.path[:] = {{path}}; from cosim.worker._spawned import main; main({reference!r}, {preload!r})"
_NO_ERROR_BOXES = 0x1 | 0x2 | 0x8000


class Spawned:
    """The process and its pipes."""

    def __init__(self, shared: Shared, preload: str) -> None:
        """Start it."""
        self._message = Message()
        self._changed = threading.Event()
        boot = _BOOT.format(reference=shared.reference, preload=preload)
        self._process = subprocess.Popen(
            interpreter(boot),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            bufsize=0,
            pass_fds=shared.inherited,
            creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
        )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._jobs, self._answers = self._process.stdin, self._process.stdout
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    @property
    def answer(self) -> bytes | None:
        """What has been answered."""
        return self._message.content

    @property
    def death(self) -> Death | None:
        """How it has ended."""
        code = self._process.poll()
        if code is None:
            return None
        self._reader.join(timeout=1.0)
        return Death(code)

    def send(self, content: bytes) -> None:
        """Hand over the job."""
        with contextlib.suppress(OSError):  # it is dead; whoever waits for it will see
            send(self._jobs.fileno(), content)

    def wait(self, seconds: float) -> None:
        """Wait for an answer or the end."""
        if not self._reader.is_alive():
            time.sleep(min(seconds, 0.001))  # it is about to end
        elif self._changed.wait(seconds):
            self._changed.clear()

    def kill(self) -> None:
        """End it."""
        with contextlib.suppress(OSError):
            self._process.kill()

    def close(self) -> None:
        """Close the pipes."""
        self._reader.join(timeout=1.0)
        with contextlib.suppress(OSError):
            self._jobs.close()
            self._answers.close()

    def _read(self) -> None:
        """Take the answer, then wait for the end of the channel."""
        channel = self._answers.fileno()
        with contextlib.suppress(OSError):
            while self._message.content is None and self._message.take(channel):
                pass
            self._changed.set()
            os.read(channel, 1)
        self._changed.set()


def transport(shared: Shared, preload: str) -> Transport:
    """Return a new worker."""
    return Spawned(shared, preload)


def main(reference: str, preload: str) -> NoReturn:
    """Begin the life of the worker."""
    import importlib
    import signal

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    jobs, answers, null = os.dup(0), os.dup(1), os.open(os.devnull, os.O_RDWR)
    quiet_channels(null)
    os.close(null)
    if sys.platform == "win32":
        import ctypes

        ctypes.windll.kernel32.SetErrorMode(_NO_ERROR_BOXES)
    importlib.import_module(preload)
    work(reference, jobs, answers)
