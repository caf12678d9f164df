"""The rows of the result while they are computed, and the times that they are for."""

from __future__ import annotations

import ctypes
from array import array
from collections.abc import Callable
from dataclasses import dataclass
from math import ceil

import numpy as np
from numpy.typing import NDArray

from cosim.engine.fmu._instance import CallError
from cosim.engine.loop._board import Board
from cosim.engine.native._structures import Engine, Position
from cosim.engine.system._system import SAME_INSTANT
from cosim.errors import InputError
from cosim.worker import machine_memory


@dataclass
class Record:
    """The rows recorded so far: the first ``count`` of ``rows``, shape (len(grid), recorded signals).

    ``loop`` is "native" or "python", ``now`` [s] the last instant reached, ``exchanges`` the number of those at which
    values were handed over. All three are kept at the beginning of ``header``, memory with room for an ``Engine``.
    """

    grid: NDArray[np.float64]
    rows: NDArray[np.float64]
    loop: str
    header: bytearray | memoryview

    def __post_init__(self) -> None:
        """Look at the position in the header."""
        self.at = Position.from_buffer(self.header)

    def apart(self) -> Record:
        """Return a copy of what was recorded in memory of its own: a shared one takes a file descriptor each."""
        return Record(self.grid, self.rows[: self.count].copy(order="F"), self.loop, bytearray(self.header))

    @property
    def count(self) -> int:
        """Number of rows recorded."""
        return self.at.row

    @property
    def now(self) -> float:
        """The last instant reached [s]."""
        return self.at.now

    @now.setter
    def now(self, t: float) -> None:
        self.at.now = t

    @property
    def exchanges(self) -> int:
        """Number of instants at which values were handed over."""
        return self.at.exchanges

    @exchanges.setter
    def exchanges(self, count: int) -> None:
        self.at.exchanges = count

    @classmethod
    def empty(
        cls, stop: float, interval: float, width: int, loop: str, allocate: Callable[[int], Board] | None = None
    ) -> Record:
        """Return a record without rows; each column of ``rows`` lies in one piece, as the result needs it.

        ``allocate`` gives memory for so many rows that is shared with another process; without it they lie in memory of
        this one. Raises InputError if the rows do not fit into the memory of this machine.
        """
        rows = (stop - SAME_INSTANT) / interval + 1.0
        size = 8.0 * rows * (width + 1)
        refusal = InputError(
            f"the result would have {rows:.3g} rows of {width + 1} columns, which take {size / 1e9:.3g} GB of memory, "
            "more than there is; set a longer output_interval or an earlier stop"
        )
        if size > machine_memory():
            raise refusal
        try:
            grid = output_grid(stop, interval)
            if allocate is not None:
                board = allocate(len(grid))
                return cls(grid, board.rows, loop, board.header)
            return cls(grid, np.empty((len(grid), width), order="F"), loop, bytearray(ctypes.sizeof(Engine)))
        except MemoryError as error:
            raise refusal from error

    def put(self, values: array[float]) -> None:
        """Append a row: the first of these values."""
        self.rows[self.count] = values[: self.rows.shape[1]]
        self.at.row += 1


def output_grid(stop: float, interval: float) -> NDArray[np.float64]:
    """Return the multiples of ``interval`` below ``stop``, and ``stop`` [s].

    If a second is a whole number of intervals, the multiples are quotients of whole numbers, so that they print as
    0.003 and not as 0.0030000000000000001.
    """
    count = ceil((stop - SAME_INSTANT) / interval)
    per_second = round(1.0 / interval)
    ticks = np.arange(count + 1, dtype=np.float64)
    whole = per_second > 0 and abs(per_second * interval - 1.0) < 1e-12
    grid: NDArray[np.float64] = ticks / per_second if whole else ticks * interval
    grid[-1] = stop
    return grid


def failure_message(failure: CallError, record: Record) -> str:
    """Return what the user reads of a failure: when, which component, what, and what to try.

    Raises InputError instead if a component could not be initialised because it does not take what it was given.
    """
    instance = failure.instance
    if not _started(record) and (reason := failure.refusal):
        raise InputError(
            f"{instance.name} ({instance.fmu.name}) refuses its parameters or inputs: {reason.rstrip('.')}; change them"
        ) from failure
    return f"the simulation failed {place_of(record)}: {failure}"


def place_of(record: Record) -> str:
    """Return where a run has ended, as part of a sentence."""
    if record.count == len(record.grid):
        return f"after its last row, at t = {record.now:.9g} s"
    return f"at t = {record.now:.9g} s" if _started(record) else "during initialisation"


def _started(record: Record) -> bool:
    return bool(record.exchanges or record.now)
