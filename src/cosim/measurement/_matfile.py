"""Reads the .mat files that the source's script saves, of MATLAB 5 to 7 and of 7.3 (HDF5)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.errors import InputError
from cosim.measurement._matlab5 import read_matlab5
from cosim.measurement._measurement import Measurement, Meta, frame_of, some, updated

Array = NDArray[np.float64]

_HDF5 = b"\x89HDF\r\n\x1a\n"
_SAMPLES = {
    "time": "t",
    "torque": "T",
    "speed": "S",
    "current": "A_avg",
    "voltage": "V_meas",
    "current_instantaneous": "A_calc",
}
_NEEDED = ("t", "T")


def read_mat(path: Path, meta: Meta) -> Measurement:
    """Return what a .mat file holds: its samples are converted and cut already.

    Raises `InputError` if it is no .mat file, or ``t`` or ``T`` is missing, empty or of another length.
    """
    variables = _variables(path)
    missing = [name for name in _NEEDED if name not in variables]
    if missing:
        there = f"it holds {some(sorted(variables), 12)}" if variables else "it holds no numbers"
        raise InputError(f"no variable {' and '.join(missing)}; {there}", file=path)
    columns = {column: variables[name].ravel() for column, name in _SAMPLES.items() if name in variables}
    count = len(columns["time"])
    if count < 2:
        raise InputError(f"t has {count} samples; at least two are needed", file=path)
    for column, values in columns.items():
        if len(values) != count:
            raise InputError(f"{_SAMPLES[column]} has {len(values)} samples, t has {count}", file=path)
    _check_time(columns["time"], path)
    repairs = meta["repairs"]
    for column in ("torque", "speed"):
        gaps = np.flatnonzero(np.isnan(columns[column])) if column in columns else np.array([])
        if len(gaps):
            repairs.append(f"{_SAMPLES[column]} is not a number at sample {some((gaps + 1).tolist())}: left as it is")
    columns["time"] = columns["time"] - columns["time"][0]
    index = variables.get("XYZ")
    line = _pair(variables, "Tp")
    found = updated(
        meta,
        onset=max(index.size - count, 0) if index is not None else 0,
        onset_method="file",
        current_peak=_scalar(variables, "A_max"),
        torque_line=line,
        torque_at_onset=_at_onset(columns, line),
        speed_line=_pair(variables, "Sp"),
        synthetic=_scalar(variables, "synthetic") == 1.0,
    )
    return Measurement(frame_of(columns), found)


def _at_onset(columns: dict[str, Array], line: tuple[float, float] | None) -> float:
    """The torque [N.m] that the line gives for the first current, where the script has made it zero."""
    if line is None or not line[0] or "current" not in columns:
        return float("nan")
    return float((columns["current"][0] - line[1]) / line[0] - columns["torque"][0])


def _check_time(time: Array, path: Path) -> None:
    steps = np.diff(time)
    if not bool((steps > 0).all()) or not np.isfinite(time).all():
        k = int(np.flatnonzero(~((steps > 0) & np.isfinite(steps)))[0])
        raise InputError(
            f"t does not increase from sample {k + 1} ({time[k]:g}) to {k + 2} ({time[k + 1]:g})", file=path
        )


def _variables(path: Path) -> dict[str, Array]:
    """Return the numeric variables of a file."""
    try:
        with path.open("rb") as file:
            start = file.read(520)
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", file=path) from error
    read = _hdf5 if _HDF5 in (start[:8], start[512:520]) else read_matlab5
    try:
        return read(path)
    except Exception as error:  # h5py does not say what it raises for a damaged file
        raise InputError(f"is no .mat file that can be read ({error})", file=path) from None


def _hdf5(path: Path) -> dict[str, Array]:
    import h5py

    with h5py.File(path) as file:
        arrays = {name: item[()] for name, item in file.items() if isinstance(item, h5py.Dataset)}
    return {name: values for name, value in arrays.items() if (values := _numbers(value)) is not None}


def _numbers(value: Any) -> Array | None:  # noqa: ANN401 - whatever a file may hold
    array = np.asarray(value)
    return array.astype(np.float64) if array.dtype.kind in "fiub" else None


def _scalar(variables: dict[str, Array], name: str) -> float:
    values = variables.get(name)
    return float(values.flat[0]) if values is not None and values.size == 1 else float("nan")


def _pair(variables: dict[str, Array], name: str) -> tuple[float, float] | None:
    values = variables.get(name)
    return (float(values.flat[0]), float(values.flat[1])) if values is not None and values.size == 2 else None
