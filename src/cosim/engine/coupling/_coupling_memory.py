"""What the coupling of components remembers from one macro step to the next."""

from __future__ import annotations

import struct
from array import array
from math import isfinite

from cosim.engine.coupling._coupling import Coupling

_SCALARS = struct.Struct("<6q3d")


class CouplingMemory:
    """All of it for one run: the polynomials, the magnitudes, the matrix of the iteration, and the next step."""

    def __init__(self, coupling: Coupling) -> None:
        """Keep the coupling."""
        self._coupling = coupling
        observed = [member.observed.scale for member in coupling.members if member.observed is not None]
        self._arrays: list[array[float]] = [
            *(coupling.last, coupling.before, coupling.times, coupling.scale, coupling.was, coupling.matrix),
            *observed,
        ]

    def to_bytes(self) -> bytes:
        """Return the numbers by link and the others, one after the other."""
        c = self._coupling
        counts = (c.known, c.has_matrix, c.macro_steps, c.rejected, c.repeated, c.forced)
        return _SCALARS.pack(*counts, c.wanted, c.usual, c.error) + b"".join(a.tobytes() for a in self._arrays)

    def from_bytes(self, content: bytes) -> None:
        """Take that over; raises ValueError if it cannot be that of such a system."""
        sizes = [len(numbers) * numbers.itemsize for numbers in self._arrays]
        if len(content) != _SCALARS.size + sum(sizes):
            raise ValueError("of another size")
        known, has_matrix, *counted, wanted, usual, error = _SCALARS.unpack_from(content)
        if known not in (0, 1, 2) or not all(isfinite(x) and x > 0.0 for x in (wanted, usual, error)):
            raise ValueError("no state of a coupling")
        c = self._coupling
        c.known, c.has_matrix = known, bool(has_matrix)
        c.macro_steps, c.rejected, c.repeated, c.forced = counted
        c.wanted, c.usual, c.error = wanted, usual, error
        place = _SCALARS.size
        for numbers, size in zip(self._arrays, sizes, strict=True):
            memoryview(numbers).cast("B")[:] = content[place : place + size]
            place += size
