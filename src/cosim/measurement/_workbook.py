"""Reads the supplier's workbooks: the range A1:N50001 of the first sheet."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.archive import Archive
from cosim.errors import InputError
from cosim.measurement._measurement import some
from cosim.measurement._supplier import Supplied

Array = NDArray[np.float64]

LAST_ROW = 50001
LAST_COLUMN = 14
SYNTHETIC_SHEET = "Synthetic"
"""A second sheet of this name marks a workbook whose numbers were computed."""
_LETTERS = "ABCDEFGHIJKLMN"
_MOST_CELLS = 4_000_000
"""Cells from A1 to the last one; the reader takes memory for all, filled or not, and ends the process without it."""
_ROW = re.compile(rb"""r=["'](\d+)["']""")
_CELL = re.compile(rb"""r=["']([A-Z]+)(\d+)["']""")
_WIDE = re.compile(rb"""r=["']([A-Z]{2,})\d+["']""")


def read_workbook(path: Path, repairs: list[str]) -> tuple[Supplied, bool]:
    """Return the columns of a workbook, and whether it is marked as synthetic.

    As MATLAB's xlsread does, rows above the first number and below the last one are left out, and cells inside that
    hold no number are NaN; ``repairs`` tells where.

    Raises `InputError` if the file is no workbook or the columns are not there.
    """
    rows, names = _cells(path)
    if len(rows) > LAST_ROW:
        repairs.append(f"{len(rows) - LAST_ROW} rows below row {LAST_ROW} are not read; the layout ends there")
    beyond = sum(any(cell != "" for cell in row[LAST_COLUMN:]) for row in rows)
    if beyond:
        repairs.append(f"{beyond} rows have cells right of column N, which are not read; the layout ends there")
    rows = [row[:LAST_COLUMN] for row in rows[:LAST_ROW]]
    numeric = [k for k, row in enumerate(rows) if any(_is_number(cell) for cell in row)]
    if not numeric:
        raise InputError(f"the sheet '{names[0]}' has no numbers in A1:N{LAST_ROW}", file=path)
    first, last = numeric[0], numeric[-1]
    body = rows[first : last + 1]
    columns = {letter: _column(body, letter, first + 1, repairs, path) for letter in "ABCG"}
    lines = [_line(body, letter, first + 1, path) for letter in "JM"]
    if lines[0][0] == 0.0:
        raise InputError(f"J{first + 1} is 0; the current per torque [A/(N.m)] is expected there", file=path)
    supplied = Supplied(
        V_meas=columns["A"], XYZ=columns["B"], A_calc=columns["C"], A_avg=columns["G"],
        torque_line=lines[0], speed_line=lines[1], rows=first + 1,
    )  # fmt: skip
    return supplied, SYNTHETIC_SHEET in names[1:]


def _cells(path: Path) -> tuple[list[list[Any]], list[str]]:
    """Return the cells of the first sheet from A1 on, and the names of all sheets."""
    import python_calamine

    _refuse_far_cells(Archive.open(path, "XLSX"), path)
    try:
        book = python_calamine.CalamineWorkbook.from_path(str(path))
        names = list(book.sheet_names)
        if not names:
            raise InputError("has no sheets", file=path)
        return book.get_sheet_by_index(0).to_python(skip_empty_area=False), names
    except InputError:
        raise
    except BaseException as error:
        # a panic of the reader arrives as a BaseException of its own; anything else is not ours to handle
        if not isinstance(error, Exception) and type(error).__name__ != "PanicException":
            raise
        raise InputError(f"is no workbook that can be read ({error})", file=path) from None


def _refuse_far_cells(archive: Archive, path: Path) -> None:
    """Refuse a workbook with a cell so far from A1 that a table up to there does not fit into memory."""
    for name in archive.sizes:
        if not name.startswith("xl/worksheets/") or not name.endswith(".xml"):
            continue
        content = archive.read(name)
        wide = max((_number(letters) for letters in set(_WIDE.findall(content))), default=26)
        rows = max(map(int, _ROW.findall(content)), default=1)
        if wide * rows <= _MOST_CELLS:
            continue
        cells = ((int(row) * _number(letters), letters + row) for letters, row in _CELL.findall(content))
        last = max(cells, default=(0, b"XFD1048576"))[1].decode()
        raise InputError(
            f"{name} has a cell {last}, far from the layout's A1:N{LAST_ROW}; delete the rows and columns "
            "outside of it",
            file=path,
        )


def _number(letters: bytes) -> int:
    """The number of a column, from 1: A is 1, AA 27."""
    number = 0
    for letter in letters:
        number = 26 * number + letter - 64
    return number


def _is_number(cell: object) -> bool:
    return isinstance(cell, int | float) and not isinstance(cell, bool)


def _column(rows: Sequence[Sequence[Any]], letter: str, first: int, repairs: list[str], path: Path) -> Array:
    position = _LETTERS.index(letter)
    cells = [row[position] if position < len(row) else "" for row in rows]
    if set(map(type, cells)) <= {int, float}:
        return np.array(cells, dtype=np.float64)
    values = np.array([cell if _is_number(cell) else np.nan for cell in cells], dtype=np.float64)
    texts = [f"{letter}{first + k} ('{cell}')" for k, cell in enumerate(cells) if cell != "" and not _is_number(cell)]
    if texts:
        repairs.append(f"text where a number is expected, in {some(texts)}: not a number")
    empty = [f"{letter}{first + k}" for k, cell in enumerate(cells) if cell == ""]
    if len(empty) + len(texts) == len(cells):
        seen = (
            f"but text such as {texts[0]}; turn it into numbers in the spreadsheet" if texts
            else "; if it has formulas, save the workbook with a spreadsheet, which computes them"
        )  # fmt: skip
        raise InputError(f"column {letter} has no numbers{' ' if texts else ''}{seen}", file=path)
    if empty:
        repairs.append(f"empty cells in {some(empty)}: not a number")
    return values


def _line(rows: Sequence[Sequence[Any]], letter: str, first: int, path: Path) -> tuple[float, float]:
    """Slope and intercept from the first two numeric rows of column J or M."""
    position = _LETTERS.index(letter)
    what = {"J": "of current over torque", "M": "of speed over torque"}[letter]
    found = []
    for k, part in enumerate(("slope", "intercept")):
        cell = rows[k][position] if k < len(rows) and position < len(rows[k]) else ""
        if not _is_number(cell) or not np.isfinite(cell):
            seen = f"'{cell}'" if cell != "" else "nothing"
            raise InputError(
                f"{letter}{first + k} has {seen}; the {part} {what} is expected there, row {first} being the first one "
                "with a number",
                file=path,
            )
        found.append(float(cell))
    return found[0], found[1]
