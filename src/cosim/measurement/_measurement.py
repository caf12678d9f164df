"""What a measurement is, whatever file it came from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypedDict, cast

import numpy as np
from numpy.typing import NDArray

from cosim.errors import InputError
from cosim.units import linear_map, parse

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

COLUMNS = ("time", "torque", "speed", "current", "voltage")
"""The columns that every measurement has; those that were not measured hold NaN."""
UNITS = {"time": "s", "torque": "N.m", "speed": "rad/s", "current": "A", "voltage": "V"}
"""Their units; the speed's is that of the file, which the metadata tells."""


class Meta(TypedDict):
    """What is known of a measurement beside its samples.

    ``source`` is the file and ``format`` its kind; ``glass`` ("dry", "wet"), ``motor`` ("cold", "warm") and ``speed``
    ("LS", "HS") the conditions, None where nobody said. ``units`` holds the unit of each column. ``onset`` is the
    number (from 0) of the sample of the file that is the first one here, ``onset_method`` how it was found.
    ``torque_at_onset`` [N.m] is what has been subtracted from the torque so that it begins with zero, NaN if unknown.
    ``current_peak`` [A] is the largest current before the onset was cut off, NaN if unknown. ``torque_line`` is (b, a)
    in current = b torque + a, ``speed_line`` (b, a) in speed = b torque + a, None where the file has none.
    ``synthetic`` tells that it was computed, not measured; ``repairs`` says what was wrong and has been mended.
    """

    source: str
    format: str
    glass: str | None
    motor: str | None
    speed: str | None
    units: dict[str, str]
    onset: int
    onset_method: str
    torque_at_onset: float
    current_peak: float
    torque_line: tuple[float, float] | None
    speed_line: tuple[float, float] | None
    synthetic: bool
    repairs: list[str]


@dataclass(frozen=True)
class Measurement:
    """Samples over time, as ``frame``: time [s], torque [N.m], speed, current [A], voltage [V]; and their metadata.

    Time begins at zero and increases. The torque is that of the gear on its output shaft, the speed that of the shaft
    in ``meta["units"]["speed"]``. A column that was not measured is NaN throughout. More columns may follow.
    """

    frame: pd.DataFrame
    meta: Meta

    @property
    def name(self) -> str:
        """What to call it in a table or legend; a synthetic one says so."""
        conditions = [
            f"{self.meta['glass']} glass" if self.meta["glass"] else "",
            f"{self.meta['motor']} motor" if self.meta["motor"] else "",
            {"LS": "low speed", "HS": "high speed"}.get(self.meta["speed"] or "", ""),
        ]
        known = ", ".join(part for part in conditions if part) or self.meta["source"].replace("\\", "/").split("/")[-1]
        return f"{known} (synthetic)" if self.meta["synthetic"] else known

    @property
    def sample_time(self) -> float:
        """The median distance [s] of two samples."""
        return float(np.median(np.diff(self.values("time"))))

    def values(self, column: str) -> Array:
        """Return a column as it is, shape (n,). Raises `InputError` if there is none of this name."""
        if column not in self.frame.columns:
            raise InputError(f"{self.meta['source']}: no column '{column}'; there are {', '.join(self.frame.columns)}")
        return self.frame[column].to_numpy(dtype=np.float64)

    def has(self, column: str) -> bool:
        """Tell whether a column was measured."""
        return column in self.frame.columns and not bool(np.isnan(self.values(column)).all())

    def speed(self) -> Array:
        """Return the shaft's speed in rad/s, shape (n,)."""
        factor, offset = linear_map(parse(self.meta["units"]["speed"]), parse("rad/s"))
        return self.values("speed") * factor + offset


def updated(meta: Meta, **found: object) -> Meta:
    """Return metadata with what has been found out."""
    return cast("Meta", {**meta, **found})


def frame_of(columns: dict[str, Array]) -> pd.DataFrame:
    """Make the frame of a measurement: the columns that it must have first, NaN where they are missing."""
    import pandas as pd

    count = len(columns["time"])
    ordered = {name: columns.get(name, np.full(count, np.nan)) for name in COLUMNS}
    return pd.DataFrame(ordered | {name: values for name, values in columns.items() if name not in COLUMNS})


def some(items: Sequence[object], most: int = 3) -> str:
    """List the first few of many items."""
    shown = ", ".join(str(item) for item in items[:most])
    return shown if len(items) <= most else f"{shown} and {len(items) - most} more"
