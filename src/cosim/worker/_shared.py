"""Memory that two processes see and that is gone with the last of them: it has no name in the file system."""

from __future__ import annotations

import contextlib
import mmap
import os
import secrets
import sys
import tempfile

_AT_ONCE = 2**26
"""Up to this size [bytes] all pages are made at once, which takes a fraction of the time."""


class Shared:
    """A handle of such memory, which has no size until it is mapped; ``reference`` names it to the other process."""

    def __init__(self) -> None:
        """Make one."""
        self.inherited: tuple[int, ...] = ()
        if sys.platform == "win32":
            self.reference = f"wiper-cosim-{secrets.token_hex(16)}"
            return
        if sys.platform == "linux":
            self.inherited = (os.memfd_create("wiper-cosim"),)
        else:
            with tempfile.TemporaryFile() as file:
                self.inherited = (os.dup(file.fileno()),)
        self.reference = str(self.inherited[0])

    def map(self, size: int) -> memoryview:
        """Give the memory its size [bytes], at least 1, and map it; it is unmapped when nothing uses it any more."""
        if self.inherited:
            os.ftruncate(self.inherited[0], size)
        return attach(self.reference, size)

    def close(self) -> None:
        """Close the handle; what is mapped stays."""
        while self.inherited:
            os.close(self.inherited[0])
            self.inherited = self.inherited[1:]


def attach(reference: str, size: int) -> memoryview:
    """Map memory that the other process has made."""
    if sys.platform == "win32":
        return memoryview(mmap.mmap(-1, size, tagname=reference))
    flags = mmap.MAP_SHARED | (getattr(mmap, "MAP_POPULATE", 0) if size <= _AT_ONCE else 0)
    with contextlib.suppress(ValueError):
        return memoryview(mmap.mmap(int(reference), size, flags))
    raise MemoryError(f"{size} bytes of shared memory")
