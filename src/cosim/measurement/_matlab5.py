"""Reads the numeric arrays of a MATLAB 5 to 7 file.

Format: MathWorks, MAT-File Format, chapter 1 (Level 5). SciPy's reader ends the process with a segmentation fault on
some damaged files, and these come from users; what is needed here is small: real arrays of numbers, compressed or not.
"""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_HEADER = 128
_MATRIX, _COMPRESSED = 14, 15
_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
_NUMERIC_CLASSES = range(6, 16)
_MOST_BYTES = 1 << 30
"""Of one array; a compressed one that would become larger is refused."""


class DamagedError(ValueError):
    """The file contradicts itself; the message says where."""


def read_matlab5(path: Path) -> dict[str, Array]:
    """Return the arrays of numbers in a file, by name; other variables are left out.

    Raises DamagedError if the file is none, or damaged.
    """
    data = path.read_bytes()
    if len(data) < _HEADER or data[126:128] not in (b"IM", b"MI"):
        raise DamagedError("its header is not that of MATLAB 5")
    order = "<" if data[126:128] == b"IM" else ">"
    found: dict[str, Array] = {}
    for kind, content in _elements(data[_HEADER:], order):
        if kind == _COMPRESSED:
            for inner, plain in _elements(_inflated(content), order):
                if inner == _MATRIX:
                    found |= _matrix(plain, order)
        elif kind == _MATRIX:
            found |= _matrix(content, order)
    return found


def _elements(data: bytes, order: str) -> Iterator[tuple[int, bytes]]:
    """Yield the type and content of the data elements that follow each other in ``data``."""
    place = 0
    while place + 8 <= len(data):
        kind, size = struct.unpack_from(f"{order}II", data, place)
        if kind >> 16:  # a small element: size and type share four bytes, the content is in the next four
            kind, size, start = kind & 0xFFFF, kind >> 16, place + 4
            end = place + 8
        else:
            start = place + 8
            end = start + size + (0 if kind == _COMPRESSED else -size % 8)
        if start + size > len(data) or (end == place + 8 and size > 4 and start == place + 4):
            raise DamagedError(f"an element of {size} bytes goes beyond the end")
        yield kind, data[start : start + size]
        place = end


def _inflated(content: bytes) -> bytes:
    inflater = zlib.decompressobj()
    try:
        plain = inflater.decompress(content, _MOST_BYTES)
    except zlib.error as error:
        raise DamagedError(f"an array cannot be decompressed ({error})") from error
    if inflater.unconsumed_tail:
        raise DamagedError(f"an array has more than {_MOST_BYTES} bytes")
    return plain


def _matrix(content: bytes, order: str) -> dict[str, Array]:
    """Return a real array of numbers by name, nothing for another kind of array."""
    parts = _elements(content, order)
    try:
        (_, flags), (_, dimensions), (_, name) = next(parts), next(parts), next(parts)
        if len(flags) < 8 or len(dimensions) % 4:
            raise DamagedError("an array has no flags or no dimensions")
        shape = struct.unpack(f"{order}{len(dimensions) // 4}i", dimensions)
        word = struct.unpack_from(f"{order}I", flags)[0]
        if word & 0xFF not in _NUMERIC_CLASSES or word >> 8 & 0x08:
            return {}
        kind, values = next(parts)
    except StopIteration:
        raise DamagedError("an array ends too early") from None
    if kind not in _TYPES:
        raise DamagedError(f"an array has numbers of the unknown type {kind}")
    dtype = np.dtype(order + _TYPES[kind])
    if min(shape, default=0) < 0 or math.prod(shape) * dtype.itemsize != len(values):
        raise DamagedError(f"an array of {' x '.join(map(str, shape))} numbers has {len(values)} bytes")
    array = np.frombuffer(values, dtype).astype(np.float64).reshape(shape, order="F")
    return {name.decode("ascii", "replace").rstrip("\0"): array}
