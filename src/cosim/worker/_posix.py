"""A worker forked from the nursery, as its parent sees it."""

from __future__ import annotations

import contextlib
import os
import select
import signal
from typing import TYPE_CHECKING

from cosim.worker._death import Death
from cosim.worker._messages import Message, send
from cosim.worker._nursery import BORN, ENDED, nursery
from cosim.worker._shared import Shared

if TYPE_CHECKING:
    from cosim.worker._transport import Transport


class Forked:
    """The pipes of such a worker."""

    def __init__(self, shared: Shared, preload: str) -> None:
        """Ask the nursery for it; it may still be loading its modules."""
        self.death: Death | None = None
        self._pid = 0
        self._message = Message()
        jobs, self._jobs = os.pipe()
        self._answers, answers = os.pipe()
        self._status, status = os.pipe()
        try:
            errors = []
            with contextlib.suppress(OSError):  # there may be no stderr
                errors.append(os.dup(2))
            descriptors = (*shared.inherited, jobs, answers, status, *errors)
            try:
                nursery(preload).fork(descriptors)
            except OSError:  # it has just died
                nursery(preload).fork(descriptors)
            finally:
                for descriptor in errors:
                    os.close(descriptor)
        except BaseException:
            self.close()
            raise
        finally:
            for descriptor in (jobs, answers, status):
                os.close(descriptor)

    @property
    def answer(self) -> bytes | None:
        """What has been answered."""
        return self._message.content

    def send(self, content: bytes) -> None:
        """Hand over the job."""
        with contextlib.suppress(BrokenPipeError):  # it is dead; whoever waits for it will see
            send(self._jobs, content)

    def wait(self, seconds: float) -> None:
        """Wait for an answer or the end."""
        channels = [self._status] if self._answers < 0 else [self._status, self._answers]
        ready, _, _ = select.select(channels, [], [], seconds)
        if self._answers in ready:
            self._take_answer()
        if self._status in ready:
            self._take_status()

    def kill(self) -> None:
        """End it and what it has started."""
        if self._pid:
            with contextlib.suppress(OSError):
                os.killpg(self._pid, signal.SIGKILL)
        elif self._jobs >= 0:
            os.close(self._jobs)  # it has not begun
            self._jobs = -1

    def close(self) -> None:
        """Close the pipes."""
        for descriptor in (self._jobs, self._answers, self._status):
            if descriptor >= 0:
                os.close(descriptor)
        self._jobs = self._answers = self._status = -1

    def _take_answer(self) -> None:
        if not self._message.take(self._answers) or self._message.content is not None:
            os.close(self._answers)
            self._answers = -1

    def _take_status(self) -> None:
        if not self._pid and (told := os.read(self._status, BORN.size)):
            self._pid = BORN.unpack(told)[0]
            return
        told = os.read(self._status, ENDED.size)
        self.death = Death(*ENDED.unpack(told)) if told else Death(1)
        while self._answers >= 0 and select.select([self._answers], [], [], 0.0)[0]:
            self._take_answer()


def transport(shared: Shared, preload: str) -> Transport:
    """Return a new worker."""
    return Forked(shared, preload)
