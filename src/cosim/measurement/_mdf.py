"""Reads ASAM MDF 4 files (.mf4) with asammdf."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cosim.errors import InputError
from cosim.measurement._columns import NAMES
from cosim.measurement._measurement import COLUMNS, UNITS, Measurement, Meta, frame_of, some, updated
from cosim.units import linear_map, parse

Array = NDArray[np.float64]


def read_mdf(path: Path, meta: Meta, mapping: Mapping[str, str]) -> Measurement:
    """Return the measurement in an MDF file, at the instants of its torque, or of its current if it has no torque.

    Channels are found by ``mapping`` or by name, as in a CSV file; other channels than the leading one are interpolated
    linearly to its instants.

    Raises `InputError` if asammdf is missing, the file cannot be read, or a channel is missing or of another dimension.
    """
    try:
        from asammdf import MDF
    except ImportError:
        raise InputError("MDF files need the package asammdf: pip install 'wiper-cosim[mdf]'", file=path) from None
    try:
        with MDF(path) as mdf:
            names = [name for name in mdf.channels_db if name not in ("time", "t")]
            chosen = {q: name for q in COLUMNS[1:] if (name := _channel(q, names, mapping, path)) is not None}
            signals = {quantity: mdf.get(name) for quantity, name in chosen.items()}
    except InputError:
        raise
    except Exception as error:  # asammdf does not say what it raises for a damaged file
        raise InputError(f"is no MDF file that can be read ({error})", file=path) from None
    leading = next((q for q in ("torque", "current") if q in signals), None)
    if leading is None:
        raise InputError(f"no channel for the torque or the current among {some(names, 12)}", file=path)
    time = np.asarray(signals[leading].timestamps, dtype=np.float64)
    if len(time) < 2 or not bool((np.diff(time) > 0).all()):
        raise InputError(f"the instants of '{chosen[leading]}' do not increase", file=path)
    columns: dict[str, Array] = {"time": time - time[0]}
    for quantity, signal in signals.items():
        try:
            values = np.asarray(signal.samples, dtype=np.float64)
        except (TypeError, ValueError):
            raise InputError(f"the channel '{chosen[quantity]}' holds no numbers", file=path) from None
        if values.ndim != 1:
            raise InputError(f"the channel '{chosen[quantity]}' holds arrays; a number a sample is expected", file=path)
        if len(values) != len(signal.timestamps) or not len(values):
            raise InputError(f"the channel '{chosen[quantity]}' has no samples", file=path)
        factor, offset = _conversion(str(signal.unit or ""), quantity, chosen[quantity], path)
        values = values * factor + offset
        if quantity != leading:
            values = np.interp(time, signal.timestamps, values, left=np.nan, right=np.nan)
        gaps = np.flatnonzero(np.isnan(values))
        if len(gaps):
            when = some([f"{time[k] - time[0]:g} s" for k in gaps])
            meta["repairs"].append(f"the {quantity} is missing at {when}: not a number there")
        columns[quantity] = values
    return Measurement(frame_of(columns), updated(meta, units=UNITS))


def _channel(quantity: str, names: list[str], mapping: Mapping[str, str], path: Path) -> str | None:
    if quantity in mapping:
        if mapping[quantity] not in names:
            raise InputError(f"no channel '{mapping[quantity]}'; there are {some(names, 12)}", file=path)
        return mapping[quantity]
    return next((n for known in NAMES[quantity] for n in names if n.lower().rpartition(".")[2] == known), None)


def _conversion(text: str, quantity: str, name: str, path: Path) -> tuple[float, float]:
    expected = parse(UNITS[quantity])
    try:
        return linear_map(parse(text) if text else expected, expected)
    except InputError as error:
        raise InputError(f"the channel '{name}' is in {text}: {error}", file=path) from error
