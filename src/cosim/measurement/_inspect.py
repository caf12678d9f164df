"""What a measurement file holds, and what difference the ways of processing it make."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cosim.colours import BLUE, RED
from cosim.errors import InputError
from cosim.measurement._measurement import COLUMNS, Measurement
from cosim.measurement._processing import AVERAGE, correlation_onset, moving_average, zero_phase
from cosim.measurement._read import read
from cosim.measurement._supplier import SAMPLE_TIME

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_WINDOW = 4.0
"""Seconds that the lower panel of the picture shows."""


@dataclass(frozen=True)
class Inspection:
    """A measurement, and by how much [s] the onset by correlation is later than the one it was read with.

    ``onset_difference`` is NaN where there is no such onset; ``delay`` [s] is that of the moving average, found by
    correlation with the zero-phase filter.
    """

    measurement: Measurement
    onset_difference: float
    delay: float

    def rows(self) -> dict[str, str]:
        """Return what a table shows, by its label."""
        m = self.measurement
        torque, time = m.values("torque"), m.values("time")
        has = [column for column in COLUMNS if m.has(column)]
        numbers = np.isfinite(torque).any()
        return {
            "samples": str(len(time)),
            "duration [s]": f"{time[-1]:.4g}",
            "sample time [s]": f"{m.sample_time:.4g}",
            "measured": ", ".join(has),
            "torque, mean [N.m]": f"{np.nanmean(torque):.4g}" if numbers else "-",
            "torque, least and largest [N.m]": f"{np.nanmin(torque):.4g} to {np.nanmax(torque):.4g}"
            if numbers
            else "-",
            "onset [sample of the file]": f"{m.meta['onset']} ({m.meta['onset_method']})",
            "onset by correlation, later by [s]": _number(self.onset_difference),
            "moving average, late by [s]": _number(self.delay),
            "mended": str(len(m.meta["repairs"])),
        }

    def to_dict(self) -> dict[str, object]:
        """Return it as a JSON document; what is not a number becomes None."""
        return {
            **{key: _finite(value) for key, value in self.measurement.meta.items()},
            "name": self.measurement.name,
            "samples": len(self.measurement.frame),
            "duration_s": float(self.measurement.values("time")[-1]),
            "sample_time_s": self.measurement.sample_time,
            "onset_difference_s": None if math.isnan(self.onset_difference) else self.onset_difference,
            "moving_average_delay_s": None if math.isnan(self.delay) else self.delay,
        }


def _finite(value: object) -> object:
    """None for what is no finite number, also inside of a pair."""
    if isinstance(value, tuple):
        return [_finite(part) for part in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def inspect(path: Path, columns: Mapping[str, str] | None = None) -> Inspection:
    """Read a measurement and compare the ways of processing it. Takes, warns and raises what ``read`` does."""
    measurement = read(path, columns=columns)
    torque = np.nan_to_num(measurement.values("torque"))
    whole = torque
    if measurement.meta["format"] == "xlsx":
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            whole = np.nan_to_num(read(path, onset="none").values("torque"))
    onset = correlation_onset(whole)
    shift = math.nan if onset is None else (onset - measurement.meta["onset"]) * measurement.sample_time
    return Inspection(measurement, shift, _delay(measurement))


def draw_smoothing(measurement: Measurement, path: Path) -> None:
    """Draw the torque as it is, by the source's moving average, and by the zero-phase filter, as a PNG file.

    Raises `InputError` if there is no torque or the file cannot be written.
    """
    if not measurement.has("torque"):
        raise InputError(f"{measurement.meta['source']}: the torque was not measured; there is nothing to draw")
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 7), layout="constrained")
    upper, lower = figure.subplots(2, 1)
    figure.suptitle(f"{measurement.name}: torque as it is, and smoothed in two ways", fontsize=11)
    _lines(upper, measurement, math.inf)
    _lines(lower, measurement, _WINDOW)
    upper.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, frameon=False, fontsize=9)
    lower.set_xlabel("time [s]")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path, dpi=110)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror or error}", file=path) from error


def _lines(axes: Axes, measurement: Measurement, stop: float) -> None:
    time, torque = measurement.values("time"), np.nan_to_num(measurement.values("torque"))
    length = _length(measurement)
    shown = time <= stop
    for values, colour, width, label in (
        (torque, "0.75", 0.8, "unsmoothed"),
        (moving_average(torque, length), RED, 1.2, f"moving average of {length} samples (the source's)"),
        (zero_phase(torque, length), BLUE, 1.2, "zero-phase filter of the same width"),
    ):
        axes.plot(time[shown], values[shown], color=colour, linewidth=width, label=label)
    axes.set_ylabel("torque [N.m]")
    axes.margins(x=0)
    axes.grid(alpha=0.3)


def _length(measurement: Measurement) -> int:
    """As long as 55 of the supplier's samples."""
    return max(3, round(AVERAGE * SAMPLE_TIME / measurement.sample_time))


def _delay(measurement: Measurement) -> float:
    torque = np.nan_to_num(measurement.values("torque"))
    length = _length(measurement)
    if len(torque) < 20 * length or not np.ptp(torque) > 0.0:
        return math.nan
    late, prompt = moving_average(torque, length)[length:], zero_phase(torque, length)[length:]
    shifts = range(2 * length)
    count = len(late) - 2 * length
    scores = [float(np.corrcoef(late[k : k + count], prompt[:count])[0, 1]) for k in shifts]
    return int(np.argmax(scores)) * measurement.sample_time


def _number(value: float) -> str:
    return "-" if math.isnan(value) else f"{value:.4g}"
