"""Writes workbooks in the supplier's layout, and does literally what the source's script does with them."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import openpyxl

TP, SP = (0.1375, 0.82), (-0.42, 36.5)
HEADER = ["V_meas", "XYZ", "A_calc", None, None, None, "A_avg", None, None, "Tp", None, None, "Sp"]
Cell = float | str | None


class Columns(NamedTuple):
    """The cells of columns A, B, C and G below the header, and of J and M."""

    V_meas: list[Cell]
    XYZ: list[Cell]
    A_calc: list[Cell]
    A_avg: list[Cell]
    Tp: tuple[Cell, ...] = TP
    Sp: tuple[Cell, ...] = SP


def made_up(count: int = 1200, start: int = 300, seed: int = 1) -> Columns:
    """A motor that stands until sample ``start``, then turns; noisy, and quantised as a logger does it."""
    rng = np.random.default_rng(seed)
    k = np.arange(count)
    torque = np.where(k < start, 0.05, 9.0 * (1 - np.exp(-(k - start) / 40.0)) + 5.0 * np.sin((k - start) / 110.0))
    current = TP[0] * torque + TP[1]
    average = np.round(current + 0.001 * rng.standard_normal(count), 5)
    each = np.round(current + 0.05 * rng.standard_normal(count), 4)
    voltage = np.round(24.0 - 0.3 * current + 0.02 * rng.standard_normal(count), 3)
    return Columns(voltage.tolist(), k.astype(float).tolist(), each.tolist(), average.tolist())


def write(path: Path, columns: Columns, header: list[Any] | None = None) -> Path:
    """One workbook with one sheet."""
    book = openpyxl.Workbook(write_only=True)
    sheet = book.create_sheet("Data")
    if header is None:
        header = HEADER
    if header:
        sheet.append(header)
    for k in range(max(len(c) for c in columns[:4])):
        row: list[Cell] = [None] * 14
        for position, cells in zip((0, 1, 2, 6, 9, 12), columns, strict=True):
            row[position] = cells[k] if k < len(cells) else None
        sheet.append(row)
    book.save(path)
    return path


class Extracted(NamedTuple):
    """What the script saves, and the number (from 0) of the sample it cuts to."""

    V_meas: list[float]
    A_calc: list[float]
    A_max: float
    A_avg: list[float]
    t: list[float]
    T: list[float]
    S: list[float]
    onset: int


def extract_motor(columns: Columns) -> Extracted | None:
    """Appendix B.2.3 line by line, with MATLAB's indices; None where MATLAB stops with an index error.

    ``xlsread`` gives NaN for cells inside the numbers that hold none.
    """

    def numbers(cells: tuple[Cell, ...] | list[Cell]) -> list[float]:
        return [math.nan if cell is None or isinstance(cell, str) else float(cell) for cell in cells]

    V_meas, XYZ, A_calc, A_avg = (numbers(cells) for cells in columns[:4])
    Tp, Sp = numbers(columns.Tp), numbers(columns.Sp)
    A_max = max(a for a in A_calc if not math.isnan(a))  # MATLAB's max leaves NaN out
    t = [xyz * 0.002 for xyz in XYZ]
    T = [(a - Tp[1]) / Tp[0] for a in A_avg]
    S = [Sp[0] * torque + Sp[1] for torque in T]
    sample_len = 100
    T = [0.0 if math.isnan(torque) else torque for torque in T]
    noise_level_T = 0.3
    onset = -1
    for i in range(1, len(T) + 1):
        if i + sample_len > len(T):
            return None  # "Index exceeds the number of array elements"
        window = T[i - 1 : i + sample_len]
        if np.mean(window) >= T[i - 1] + noise_level_T and T[i - 1] != 0.0:
            V_meas, A_calc, A_avg = V_meas[i - 1 :], A_calc[i - 1 :], A_avg[i - 1 :]
            t = [later - t[i - 1] for later in t[i - 1 :]]
            T = [later - T[i - 1] for later in T[i - 1 :]]
            S = S[i - 1 :]
            onset = i - 1
            break
    return Extracted(V_meas, A_calc, A_max, A_avg, t, T, S, onset)
