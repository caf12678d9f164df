"""How a process has ended, in words."""

from __future__ import annotations

import signal
import sys
from dataclasses import dataclass

_SIGNALS = {
    "SIGSEGV": "it used memory that it does not have",
    "SIGBUS": "it used memory in a way that this computer cannot",
    "SIGABRT": "it gave up by abort() or a failed assertion",
    "SIGFPE": "an arithmetic fault such as an integer division by 0",
    "SIGILL": "an instruction that this processor does not have",
    "SIGSYS": "a system call that is forbidden",
    "SIGXCPU": "its processor time was used up",
    "SIGKILL": "it was ended from outside, as the system does when memory runs out",
    "SIGTERM": "it was ended from outside",
}
_WINDOWS = {
    0xC0000005: ("an access violation", "it used memory that it does not have"),
    0xC00000FD: ("a stack overflow", "its calls are nested too deeply"),
    0xC0000094: ("an integer division by 0", "an arithmetic fault"),
    0xC000001D: ("an illegal instruction", "one that this processor does not have"),
    0xC0000374: ("heap corruption", "it wrote beyond memory of its own"),
    0xC0000409: ("a fast failure", "it gave up by abort() or found its stack overwritten"),
    0xC0000017: ("a lack of memory", "more was asked for than there is"),
    0xC000013A: ("Ctrl-C", "it was ended from outside"),
}


@dataclass(frozen=True)
class Death:
    """How a process ended without an answer.

    ``code`` is its exit code; minus the number of the signal that ended it, or a code of an exception in Windows.
    ``memory`` [bytes] is the most that it had, 0 if unknown.
    """

    code: int
    memory: float = 0.0

    @property
    def crashed(self) -> bool:
        """Whether it did not end itself by exit()."""
        return self.code < 0 or self.code & 0xFFFFFFFF in _WINDOWS

    @property
    def killed(self) -> bool:
        """Whether it was ended from outside."""
        return sys.platform != "win32" and self.code in (-signal.SIGKILL, -signal.SIGTERM)

    @property
    def name(self) -> str:
        """What ended it: "SIGSEGV", "exit code 7"."""
        if self.code & 0xFFFFFFFF in _WINDOWS:
            return _WINDOWS[self.code & 0xFFFFFFFF][0]
        if self.code >= 0:
            return f"exit code {self.code}"
        try:
            return signal.Signals(-self.code).name
        except ValueError:
            return f"signal {-self.code}"

    @property
    def meaning(self) -> str:
        """What that means: "it used memory that it does not have"; empty if nothing is known."""
        if self.code & 0xFFFFFFFF in _WINDOWS:
            return _WINDOWS[self.code & 0xFFFFFFFF][1]
        return _SIGNALS.get(self.name, "")

    def __str__(self) -> str:
        """Return both: "SIGSEGV (it used memory that it does not have)"."""
        return f"{self.name} ({self.meaning})" if self.meaning else self.name
