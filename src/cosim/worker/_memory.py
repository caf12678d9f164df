"""How much memory there is, and that a process takes no more of it than it may."""

from __future__ import annotations

import contextlib
import os
import sys
from math import inf
from pathlib import Path

_CONTROL_GROUP = ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes")


def machine_memory() -> float:
    """Return the memory [bytes] of this machine, or of the container that this process is in; infinite if unknown."""
    found = inf
    with contextlib.suppress(AttributeError, OSError, ValueError):
        found = float(os.sysconf("SC_PAGE_SIZE")) * os.sysconf("SC_PHYS_PAGES")
    for name in _CONTROL_GROUP:
        with contextlib.suppress(OSError, ValueError):
            found = min(found, float(Path(name).read_text(encoding="ascii")))
    return found


def limit_memory(most: float) -> None:
    """Let this process have at most so much memory [bytes] of its own: asking for more fails, as if there were none.

    If the machine runs out of memory nevertheless, this is the process that the system ends. Linux only.
    """
    if sys.platform != "linux":
        return
    import resource

    if most < inf:
        _, hard = resource.getrlimit(resource.RLIMIT_DATA)
        most = min(most, inf if hard == resource.RLIM_INFINITY else hard)
        resource.setrlimit(resource.RLIMIT_DATA, (int(most), hard))
    with contextlib.suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text("1000", encoding="ascii")
