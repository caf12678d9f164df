"""A measured torque beside the modelled one in figure 3.6."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cosim.errors import InputError
from cosim.measurement import read

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
    """Read a measurement in any form that `cosim.measurement.read` knows, a CSV table with time and torque among them.

    The torque is averaged over the last 0.11 s, and taken to be zero before the first row, as by the source's filter.
    Rows without a torque are left out.

    Raises:
        InputError: there is no such file, it cannot be read, or has no torque.
    """
    found = read(path)
    if not found.has("torque"):
        raise InputError(
            "has no torque, which --measured draws into figure 3.6; there must be time and torque", file=path
        )
    torque = found.values("torque")
    known = np.isfinite(torque)
    time, torque = found.values("time")[known], torque[known]
    area = np.concatenate([[0.0], np.cumsum(np.diff(time) * 0.5 * (torque[1:] + torque[:-1]))])
    before = np.interp(time - WINDOW, time, area, left=0.0)
    there = found.meta["torque_at_onset"]
    # so it is in the source's figure, too; by the workbook's own line of current over torque it is not
    shifted = f"\n(made zero at its onset; {there:.2g} N.m there by its line)" if np.isfinite(there) and there else ""
    return Measured(time, (area - before) / WINDOW, f"Measured data, {found.name}{shifted}")
