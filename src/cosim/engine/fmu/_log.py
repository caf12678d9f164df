"""What an FMU says through its logger, kept for the message of a failure."""

from __future__ import annotations

import itertools
import re
from collections import deque
from collections.abc import Callable
from ctypes import byref
from weakref import WeakValueDictionary

from fmpy import calloc, free
from fmpy.fmi1 import (
    fmi1CallbackAllocateMemoryTYPE,
    fmi1CallbackFreeMemoryTYPE,
    fmi1CallbackFunctions,
    fmi1CallbackLoggerTYPE,
    printLogMessage,
)
from fmpy.fmi2 import (
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
)
from fmpy.logging import addLoggerProxy

STATUS = ("OK", "Warning", "Discard", "Error", "Fatal", "Pending")
FAILED = 2
"""From this status on, a call has failed."""

_KEPT = 5

SILENCE = "the FMU gave no reason"
"""What is said of an FMU that has said nothing."""

_ASSERTION = re.compile(r"\bassert(?:ion)?\b[^:]*:\s*(?P<reason>.+)", re.IGNORECASE | re.DOTALL)


class Log:
    """The last messages of one FMU that are warnings or worse."""

    def __init__(self, hand_on: Callable[[str], None] | None = None) -> None:
        """Start empty; ``hand_on`` takes what ``str`` gives, whenever that has changed."""
        self._messages: deque[str] = deque(maxlen=_KEPT)
        self._hand_on = hand_on
        self.key = next(_keys)
        _logs[self.key] = self

    def add(self, status: int, message: bytes) -> None:
        """Keep a message if its status is worth it."""
        if status > 0 and message:
            text = message.decode("utf-8", "replace").strip()
            if text and text not in self._messages:
                self._messages.append(text)
                if self._hand_on is not None:
                    self._hand_on(str(self))

    def belongs_to(self, component: int) -> None:
        """Take the messages of an FMI 1.0 instance, which are known by its handle."""
        _logs[component] = self

    @property
    def messages(self) -> tuple[str, ...]:
        """What is kept."""
        return tuple(self._messages)

    @messages.setter
    def messages(self, messages: tuple[str, ...]) -> None:
        if messages != self.messages:
            self._messages.clear()
            self._messages.extend(messages)
            if self._hand_on is not None:
                self._hand_on(str(self))

    @property
    def assertion(self) -> str | None:
        """What the last assertion says that the FMU reports as violated; None if there is none."""
        found = [match for message in self._messages if (match := _ASSERTION.search(message))]
        return str(found[-1]["reason"]) if found else None

    def __str__(self) -> str:
        """Return what the FMU said, as part of a sentence."""
        return f"the FMU says: {' | '.join(self._messages).removesuffix('.')}" if self._messages else SILENCE


_keys = itertools.count(1)
_logs: WeakValueDictionary[int, Log] = WeakValueDictionary()


def _dispatch(environment: int | None, name: bytes, status: int, category: bytes, message: bytes) -> None:
    log = _logs.get(environment or 0)
    if log is not None:
        log.add(status, message)
    else:
        printLogMessage(environment, name, status, category, message)


def fmi2_callbacks(log: Log) -> fmi2CallbackFunctions:
    """Return callback functions for one FMI 2.0 instance, whose messages go to ``log``.

    FMI 2.0 messages are printf formats; fmpy's native proxy formats them and hands them to one Python function per
    process, so that function looks the log up by the environment. Messages of FMUs that others run through fmpy are
    printed, as fmpy does.
    """
    callbacks = fmi2CallbackFunctions()
    callbacks.logger = _logger
    callbacks.allocateMemory = _allocate
    callbacks.freeMemory = _free
    callbacks.componentEnvironment = log.key
    addLoggerProxy(byref(callbacks))
    return callbacks


def fmi1_callbacks() -> fmi1CallbackFunctions:
    """Return callback functions for FMI 1.0; what an instance says before it has a handle is printed."""
    callbacks = fmi1CallbackFunctions()
    callbacks.logger = _logger1
    callbacks.allocateMemory = _allocate1
    callbacks.freeMemory = _free1
    addLoggerProxy(byref(callbacks))
    return callbacks


_logger1 = fmi1CallbackLoggerTYPE(_dispatch)
_allocate1 = fmi1CallbackAllocateMemoryTYPE(calloc)
_free1 = fmi1CallbackFreeMemoryTYPE(free)
_logger = fmi2CallbackLoggerTYPE(_dispatch)
_allocate = fmi2CallbackAllocateMemoryTYPE(calloc)
_free = fmi2CallbackFreeMemoryTYPE(free)
