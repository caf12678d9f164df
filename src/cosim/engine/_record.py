"""The rows of the result while they are computed, and the times that they are for."""

from __future__ import annotations

from array import array
from dataclasses import dataclass
from math import ceil

import numpy as np
from numpy.typing import NDArray

from cosim.engine._instance import CallError
from cosim.engine._system import SAME_INSTANT


@dataclass
class Record:
    """The rows recorded so far: the first ``count`` of ``rows``, shape (len(grid), recorded signals).

    ``loop`` is "native" or "python", ``now`` [s] the last instant reached, ``exchanges`` the number of those at which
    values were handed over.
    """

    grid: NDArray[np.float64]
    rows: NDArray[np.float64]
    loop: str
    count: int = 0
    now: float = 0.0
    exchanges: int = 0

    @classmethod
    def empty(cls, grid: NDArray[np.float64], width: int, loop: str) -> Record:
        """Return a record without rows; each column of ``rows`` lies in one piece, as the result needs it."""
        return cls(grid, np.empty((len(grid), width), order="F"), loop)

    def put(self, values: array[float]) -> None:
        """Append a row: the first of these values."""
        self.rows[self.count] = values[: self.rows.shape[1]]
        self.count += 1


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
    """Return what the user reads of a failure: when, which component, what, and what to try."""
    instance = failure.instance
    where = f"at t = {record.now:.9g} s" if record.exchanges or record.now else "during initialisation"
    return (
        f"the simulation failed {where}: {instance.name} ({instance.fmu.name}): {failure.what}; {instance.log}; "
        f"{failure.remedy}"
    )
