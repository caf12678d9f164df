"""One way to read all kinds of measurement files."""

from __future__ import annotations

import re
import warnings
from collections.abc import Mapping
from pathlib import Path

from cosim.errors import InputError, MeasurementWarning
from cosim.measurement._measurement import UNITS, Measurement, Meta
from cosim.measurement._processing import Onset
from cosim.measurement._supplier import Missing

_SPEED_UNIT = "rpm"
"""[A] The source does not say what unit its speed has; 1/min is usual for such a motor."""


def read(
    path: Path | str,
    *,
    columns: Mapping[str, str] | None = None,
    onset: Onset = "threshold",
    missing: Missing = "zero",
    speed_unit: str = _SPEED_UNIT,
) -> Measurement:
    """Read a measurement: the supplier's .xlsx, the source script's .mat, .csv, or MDF 4 (.mf4).

    Args:
        path: the file; what it is follows from its ending.
        columns: the name of the column (channel) of each quantity: time, torque, speed, current, voltage; for .csv and
            .mf4 only, and only where its own header does not say.
        onset: how the beginning of the motion is found in a workbook: as the source does ("threshold"), by
            correlation with a step, or not at all; time and torque begin there with zero.
        missing: what the torque is where a workbook's current is not a number: zero as in the source, or interpolated.
        speed_unit: the unit of the speed in workbooks and .mat files.

    Warns (`MeasurementWarning`) of everything that is wrong with the file and has been mended; ``meta["repairs"]``
    keeps it. Raises `InputError`, with the place, for what cannot be.
    """
    path = Path(path)
    if not path.is_file():
        raise InputError("there is no such measurement", file=path)
    kind = path.suffix.lower()
    if columns and kind in (".xlsx", ".mat"):
        raise InputError(f"the columns of {kind} files are fixed; choose columns of .csv and .mf4 files", file=path)
    meta = _meta(path, kind, speed_unit)
    match kind:
        case ".xlsx":
            measurement = _workbook(path, meta, onset, missing)
        case ".mat":
            from cosim.measurement._matfile import read_mat

            measurement = read_mat(path, meta)
        case ".csv" | ".txt":
            from cosim.measurement._columns import read_csv

            measurement = read_csv(path, meta, columns or {})
        case ".mf4" | ".mdf":
            from cosim.measurement._mdf import read_mdf

            measurement = read_mdf(path, meta, columns or {})
        case _:
            raise InputError(f"'{kind}' files cannot be read; accepted are .xlsx, .mat, .csv and .mf4", file=path)
    for repair in measurement.meta["repairs"]:
        warnings.warn(f"{path}: {repair}", MeasurementWarning, stacklevel=2)
    return measurement


def _workbook(path: Path, meta: Meta, onset: Onset, missing: Missing) -> Measurement:
    from cosim.measurement._supplier import measurement_of
    from cosim.measurement._workbook import read_workbook

    supplied, synthetic = read_workbook(path, meta["repairs"])
    meta["synthetic"] = synthetic
    try:
        return measurement_of(supplied, meta, onset, missing)
    except InputError as error:
        raise InputError(str(error), file=path) from error


def _meta(path: Path, kind: str, speed_unit: str) -> Meta:
    """What is known before the file is opened: its name tells the conditions, as in "Dry Glass Cold Motor LS.xlsx"."""
    name = path.stem.lower()
    glass, motor, step = (
        re.search(pattern, name)
        for pattern in (r"\b(dry|wet)\W*glass", r"\b(cold|warm)\W*motor", r"\b(ls|hs)(?![a-bd-z])")
    )
    return Meta(
        source=str(path),
        format=kind[1:],
        glass=glass[1] if glass else None,
        motor=motor[1] if motor else None,
        speed=step[1].upper() if step else None,
        units=UNITS | {"speed": speed_unit, "current_instantaneous": "A"},
        onset=0,
        onset_method="none",
        torque_at_onset=0.0,
        current_peak=float("nan"),
        torque_line=None,
        speed_line=None,
        synthetic=False,
        repairs=[],
    )
