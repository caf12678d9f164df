"""A measured torque beside the modelled one in figure 3.6."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cosim.assessment import trace
from cosim.errors import InputError

Array = NDArray[np.float64]

WINDOW = 0.11
"""Length of the moving average [s]: 55 samples of 2 ms [S] B.1.5, line 13, and B.2.3, line 15."""


@dataclass(frozen=True)
class Measured:
    """Torque [N.m] over time [s], averaged as the source plots it, and what the legend calls it."""

    time: Array
    torque: Array
    label: str


def read_measured(path: Path) -> Measured:
    """Read a table with the columns time and torque, with units in brackets or in s and N.m.

    The torque is averaged over the last 0.11 s, and taken to be zero before the first row, as by the source's filter.

    Raises:
        InputError: there is no such file, a column is missing, or holds what is no number; time does not increase.
    """
    if not path.is_file():
        raise InputError(
            "no such file; --measured takes a CSV table with the columns time [s] and torque [N.m]", file=path
        )
    found = trace(path)
    if not found.has("torque"):
        raise InputError(
            f"no column 'torque [N.m]' beside time; there are {', '.join(found.columns) or 'no others'}", file=path
        )
    time, torque = found.time - found.time[0], found.signal("torque", "N.m")
    area = np.concatenate([[0.0], np.cumsum(np.diff(time) * 0.5 * (torque[1:] + torque[:-1]))])
    before = np.interp(time - WINDOW, time, area, left=0.0)
    return Measured(time, (area - before) / WINDOW, f"Measured data, {path.stem}")
