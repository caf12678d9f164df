"""The supplier's columns become torque and speed, as the source's ``extract_motor`` does it (appendix B.2.3)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from cosim.errors import InputError
from cosim.measurement._measurement import Measurement, Meta, frame_of, some, updated
from cosim.measurement._processing import LARGEST, WINDOW, Onset, find_onset

Array = NDArray[np.float64]
Missing = Literal["zero", "interpolate"]

SAMPLE_TIME = 0.002
"""Seconds from one sample to the next."""


@dataclass(frozen=True)
class Supplied:
    """The columns of a workbook, each of shape (n,): voltage [V], sample index, current [A] and its average [A].

    ``torque_line`` and ``speed_line`` are (b, a) of current = b torque + a and speed = b torque + a. ``rows`` says
    which row of the sheet the first sample stands in.
    """

    V_meas: Array
    XYZ: Array
    A_calc: Array
    A_avg: Array
    torque_line: tuple[float, float]
    speed_line: tuple[float, float]
    rows: int


def measurement_of(supplied: Supplied, meta: Meta, onset: Onset, missing: Missing) -> Measurement:
    """Convert the columns and cut off what comes before the onset.

    Time and torque start from zero at the onset; the speed does not. Where the current is not a number, the source
    takes a torque of zero and leaves the speed as it is ("zero"); the alternative is to interpolate.

    Raises `InputError` if the samples cannot be used or there is no onset.
    """
    repairs = meta["repairs"]
    _refuse_overflow(supplied)
    index = _checked_index(supplied, repairs)
    _suspect_columns(supplied, repairs)
    current = supplied.A_avg
    gaps = np.flatnonzero(np.isnan(current))
    if len(gaps) == len(current):
        raise InputError("column G has no numbers; the averaged current is expected there")
    if len(gaps):
        rows = some([supplied.rows + int(i) for i in gaps])
        remedy = "a torque of zero is taken there" if missing == "zero" else "interpolated there"
        repairs.append(f"column G (averaged current) is not a number in row {rows}: {remedy}")
        if missing == "interpolate":
            good = np.flatnonzero(~np.isnan(current))
            current = np.interp(np.arange(len(current)), good, current[good])
    b, a = supplied.torque_line
    torque = (current - a) / b
    speed = supplied.speed_line[0] * torque + supplied.speed_line[1]
    torque = np.where(np.isnan(torque), 0.0, torque)
    time = index * SAMPLE_TIME
    first = find_onset(torque, onset)
    cut = slice(first, None)
    with np.errstate(invalid="ignore"):
        peak = float(np.nanmax(supplied.A_calc)) if not np.isnan(supplied.A_calc).all() else np.nan
    frame = frame_of(
        {
            "time": time[cut] - time[first],
            "torque": torque[cut] - torque[first],
            "speed": speed[cut],
            "current": current[cut],
            "voltage": supplied.V_meas[cut],
            "current_instantaneous": supplied.A_calc[cut],
        }
    )
    found = updated(
        meta,
        onset=first,
        onset_method=onset,
        torque_at_onset=float(torque[first]),
        current_peak=peak,
        torque_line=supplied.torque_line,
        speed_line=supplied.speed_line,
    )
    return Measurement(frame, found)


def _refuse_overflow(supplied: Supplied) -> None:
    """Raise `InputError` if a number is so large that sums of squares would have no end."""
    columns = {"A": supplied.V_meas, "B": supplied.XYZ, "C": supplied.A_calc, "G": supplied.A_avg}
    for letter, values in columns.items():
        large = np.flatnonzero(np.abs(values) > LARGEST)
        if len(large):
            k = int(large[0])
            raise InputError(f"{letter}{supplied.rows + k} has {values[k]:g}; no measured value is that large")
    (b, a), (d, c) = supplied.torque_line, supplied.speed_line
    if max(abs(a), abs(c), abs(d)) > LARGEST or abs(b) < 1.0 / LARGEST:
        raise InputError(f"the lines of columns J and M, {b:g} and {a:g}, {d:g} and {c:g}, are not those of a motor")


def _checked_index(supplied: Supplied, repairs: list[str]) -> Array:
    """Return the sample index without gaps; raises `InputError` unless it counts samples."""
    index = supplied.XYZ
    if len(index) <= WINDOW:
        raise InputError(f"has {len(index)} rows of numbers; more than {WINDOW} are needed to find the onset")
    empty = np.flatnonzero(np.isnan(index))
    if len(empty):
        if len(empty) == len(index) or np.isnan(index[[0, -1]]).any():
            raise InputError(
                f"column B has no sample index in row {some([supplied.rows + int(i) for i in empty])}; "
                "delete rows at the beginning or end that are no samples"
            )
        good = np.flatnonzero(~np.isnan(index))
        index = np.interp(np.arange(len(index)), good, index[good])
        rows = some([supplied.rows + int(i) for i in empty])
        repairs.append(f"column B (sample index) is not a number in row {rows}: counted on from its neighbours")
    steps = np.diff(index)
    if float(np.median(steps)) != 1.0:
        raise InputError(
            f"column B steps by {np.median(steps):.6g}; a sample index, which steps by 1, is expected there"
            f"{_swap(supplied)}"
        )
    back = np.flatnonzero(~(steps > 0))
    if len(back):
        k = int(back[0])
        raise InputError(
            f"row {supplied.rows + k + 1}: the sample index in column B goes from {index[k]:g} to {index[k + 1]:g}; it "
            "must increase"
        )
    jumps = np.flatnonzero(steps != 1.0)
    if len(jumps):
        places = some([f"{supplied.rows + int(i) + 1} (by {steps[i]:g})" for i in jumps])
        repairs.append(f"the sample index in column B jumps at row {places}: samples are missing there")
    return index


def _swap(supplied: Supplied) -> str:
    """Tell which other column looks like the sample index."""
    others = {"A": supplied.V_meas, "C": supplied.A_calc, "G": supplied.A_avg}
    for letter, values in others.items():
        steps = np.diff(values)
        if len(steps) and float(np.median(steps)) == 1.0:
            return f"; column {letter} does: are the columns swapped?"
    return ""


def _suspect_columns(supplied: Supplied, repairs: list[str]) -> None:
    """Note columns that look as if they were swapped: an average that is rougher, a current above the voltage."""
    rough = [float(np.nanstd(np.diff(values, 2))) for values in (supplied.A_calc, supplied.A_avg)]
    if rough[1] > 2.0 * rough[0] > 0.0:
        repairs.append("column G, the averaged current, is rougher than column C, the current: they may be swapped")
    voltage, current = (float(np.nanmedian(np.abs(v))) for v in (supplied.V_meas, supplied.A_calc))
    if current > 15.0 > voltage:
        repairs.append(
            f"column C, the current, is about {current:.3g} A and column A, the voltage, {voltage:.3g} V: "
            "they may be swapped"
        )
