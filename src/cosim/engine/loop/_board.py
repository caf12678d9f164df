"""The memory of a run that its supervisor shares: where it is, what its FMUs have said, and the rows so far."""

from __future__ import annotations

import ctypes
from ctypes import Structure, c_int32

import numpy as np
from numpy.typing import NDArray

from cosim.engine.native._structures import Engine, Fault

_TEXT = 2048


class _Control(Structure):
    _fields_ = [("fault", Fault), ("stop", c_int32), ("unused", c_int32)]


def _rounded(size: int) -> int:
    return (size + 63) // 64 * 64


_HEADER = _rounded(ctypes.sizeof(Engine))
_CONTROL = _rounded(ctypes.sizeof(_Control))


class Board:
    """A view of such memory; both sides have one.

    ``header`` and ``rows``, shape (number of rows, recorded signals), are those of the ``Record``.
    """

    def __init__(self, memory: memoryview, components: int, n_rows: int, width: int) -> None:
        """Look at memory of the size that ``size`` gives for the same numbers."""
        self.header = memory[:_HEADER]
        self._control = _Control.from_buffer(memory, _HEADER)
        texts = _HEADER + _CONTROL
        self._texts = [memory[texts + i * _TEXT : texts + (i + 1) * _TEXT] for i in range(components)]
        offset = texts + components * _TEXT
        numbers = np.frombuffer(memory, np.float64, n_rows * width, offset)
        self.rows: NDArray[np.float64] = numbers.reshape((n_rows, width), order="F")

    @staticmethod
    def size(components: int, n_rows: int, width: int) -> int:
        """Return how many bytes it needs."""
        return _HEADER + _CONTROL + components * _TEXT + 8 * n_rows * width

    @property
    def fault(self) -> Fault:
        """What has ended the worker."""
        found: Fault = self._control.fault
        return found

    @property
    def stop(self) -> bool:
        """Whether the run is to end early."""
        return bool(self._control.stop)

    @stop.setter
    def stop(self, wanted: bool) -> None:
        self._control.stop = wanted

    def say(self, number: int, text: str) -> None:
        """Keep what the FMU of a component has said, as far as there is room."""
        content = text.encode()[: _TEXT - 1]
        self._texts[number][: len(content) + 1] = content + b"\0"

    def said(self, number: int) -> str:
        """Return that."""
        return bytes(self._texts[number]).partition(b"\0")[0].decode(errors="ignore")
