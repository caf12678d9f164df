"""Ctrl-C during native code: noted when it comes, raised when the tables are in order."""

from __future__ import annotations

import signal
import threading
from types import FrameType, TracebackType
from typing import Self


class DeferredInterrupt:
    """A context in which Ctrl-C raises KeyboardInterrupt nowhere but in ``check``.

    Python would raise it in whatever it runs next. That may be the logger that an FMU calls, from which no exception
    comes back through native code: the interrupt would be lost. In other threads, and where somebody else handles
    Ctrl-C, nothing is changed.
    """

    def __init__(self) -> None:
        """Nothing has come yet."""
        self._came = False
        self._replaced = False

    def __enter__(self) -> Self:
        """Take over Ctrl-C if it has Python's own handler."""
        main = threading.current_thread() is threading.main_thread()
        if main and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            signal.signal(signal.SIGINT, self._note)
            self._replaced = True
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Give Ctrl-C back; what came after the last check is raised now."""
        if self._replaced:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        if error is None:
            self.check()

    def _note(self, number: int, frame: FrameType | None) -> None:
        self._came = True

    def check(self) -> None:
        """Raise KeyboardInterrupt if Ctrl-C has been pressed."""
        if self._came:
            self._came = False
            raise KeyboardInterrupt
