"""Memory of a run that a checkpoint copies."""

from __future__ import annotations

from array import array
from typing import Any, Protocol


class Memory(Protocol):
    """What a part of the engine remembers from one macro step to the next."""

    def to_bytes(self) -> bytes:
        """Return all of it."""

    def from_bytes(self, content: bytes) -> None:
        """Take over what ``to_bytes`` gave in a run of the same system; raises ValueError for what cannot be that."""


class Numbers:
    """Memory that is an array, or a structure of ctypes, of fixed size; it stays where it is."""

    def __init__(self, *places: array[Any] | Any) -> None:  # noqa: ANN401 - ctypes has no type for its structures
        """Keep them: they are what is copied."""
        self._views = [memoryview(place).cast("B") for place in places]

    def to_bytes(self) -> bytes:
        """Return all of it, one place after the other."""
        return b"".join(self._views)

    def from_bytes(self, content: bytes) -> None:
        """Take that over; raises ValueError if it has another size."""
        if len(content) != sum(view.nbytes for view in self._views):
            raise ValueError(f"{len(content)} bytes")
        for view in self._views:
            view[:], content = content[: view.nbytes], content[view.nbytes :]
