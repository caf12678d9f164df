"""Which column of a file is which quantity, by option, by key line or by name."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cosim.errors import InputError
from cosim.measurement._measurement import COLUMNS, UNITS, Measurement, Meta, frame_of, some, updated
from cosim.tabular import Table, load
from cosim.units import linear_map, parse

Array = NDArray[np.float64]

NAMES: dict[str, tuple[str, ...]] = {
    "time": ("time", "t"),
    "torque": ("torque", "tau_crank", "t_motor", "motor torque"),
    "speed": ("speed", "w_crank", "s"),
    "current": ("current", "i_motor", "i", "a_avg"),
    "voltage": ("voltage", "v_supply", "v_motor", "v_meas"),
}
"""Names by which a column is known if nobody says which it is; ``plant.i_motor`` is known by its last part."""
_CONDITIONS: dict[str, tuple[str, dict[str, object]]] = {
    "glass": ("glass", {"dry": "dry", "wet": "wet"}),
    "motor": ("motor", {"cold": "cold", "warm": "warm"}),
    "speed_step": ("speed", {"ls": "LS", "hs": "HS"}),
    "synthetic": ("synthetic", {"true": True, "false": False}),
}
"""The ``#`` lines about a measurement: which metadata they give, and what they may say."""
_HEADER = re.compile(r"(?P<name>.*?)\s*(\[(?P<unit>[^\]]*)\])?")


def read_csv(path: Path, meta: Meta, mapping: Mapping[str, str]) -> Measurement:
    """Return the measurement in a CSV file.

    Its ``#`` lines may say ``# torque: NAME OF THE COLUMN`` for each column, and ``# glass: dry``, ``# motor: cold``,
    ``# speed_step: LS``, ``# synthetic: true``. ``mapping`` wins over them. Columns without a unit are in SI units.

    Raises `InputError` with file, line and column for what cannot be used.
    """
    table = load(path, "measurement", "not measured", "torque [N.m]")
    keys = _keys(table)
    wanted = {column: keys[column] for column in COLUMNS if column in keys} | dict(mapping)
    heads = [_HEADER.fullmatch(head) for head in table.header]
    names = [match["name"] if match else head for head, match in zip(table.header, heads, strict=True)]
    units = [match["unit"] if match else None for match in heads]
    chosen = choose(names, wanted, path)
    columns: dict[str, Array] = {}
    for column, position in chosen.items():
        factor, offset = _conversion(units[position], column, table, position)
        values = _values(table, position, column, meta["repairs"])
        columns[column] = values * factor + offset
    _check_time(table, columns["time"], names[chosen["time"]])
    columns["time"] = columns["time"] - columns["time"][0]
    found = updated(meta, **_conditions(table, keys), units=UNITS)
    return Measurement(frame_of(columns), found)


def _conditions(table: Table, keys: Mapping[str, str]) -> dict[str, object]:
    """Return what the ``#`` lines say of the measurement; raises `InputError` for what they may not say."""
    found: dict[str, object] = {}
    for name, (entry, known) in _CONDITIONS.items():
        if name not in keys:
            continue
        if keys[name].lower() not in known:
            line = next(number for number, text in table.keys if text.partition(":")[0].strip().lower() == name)
            raise table.error(f"{name}: there is no '{keys[name]}'; accepted are {', '.join(known)}", line)
        found[entry] = known[keys[name].lower()]
    return found


def choose(names: Sequence[str], wanted: Mapping[str, str], path: Path) -> dict[str, int]:
    """Return the position of each quantity's column.

    Raises `InputError` if a name is not there, fits several columns, or there is no time or no torque and no current.
    """
    for quantity in wanted:
        if quantity not in COLUMNS:
            raise InputError(f"there is no quantity '{quantity}'; there are {', '.join(COLUMNS)}", file=path)
    chosen: dict[str, int] = {}
    for quantity in COLUMNS:
        accepted = (wanted[quantity],) if quantity in wanted else NAMES[quantity]
        fits = [k for name in accepted for k, head in enumerate(names) if _is_called(head, name, quantity in wanted)]
        if len(set(fits)) > 1 and quantity in wanted:
            raise InputError(f"several columns are called '{wanted[quantity]}'", file=path)
        if len(set(fits)) > 1 and len({names[k].lower().rpartition(".")[2] for k in fits}) == 1:
            there = " and ".join(f"'{names[k]}'" for k in dict.fromkeys(fits))
            raise InputError(f"{there} may both be the {quantity}; {_remedy(quantity, names[fits[0]])}", file=path)
        if fits:
            chosen[quantity] = fits[0]
        elif quantity in wanted:
            raise InputError(
                f"no column '{wanted[quantity]}' for the {quantity}; there are {some(names, 12)}", file=path
            )
    if "time" not in chosen or not {"torque", "current"} & set(chosen):
        lacking = "time" if "time" not in chosen else "torque or current"
        raise InputError(
            f"no column for the {lacking} among {some(names, 12)}; "
            + _remedy("torque" if lacking != "time" else "time", names[0]),
            file=path,
        )
    return chosen


def _remedy(quantity: str, name: str) -> str:
    return f"say which it is: write '# {quantity}: {name}' above the header, or --measured-column '{quantity}={name}'"


def _is_called(head: str, name: str, exactly: bool) -> bool:
    if exactly:
        return head == name
    return name in (head.lower(), head.lower().rpartition(".")[2])


def _keys(table: Table) -> dict[str, str]:
    pairs = (text.partition(":") for _, text in table.keys)
    return {name.strip().lower(): value.strip() for name, colon, value in pairs if colon}


def _conversion(text: str | None, column: str, table: Table, position: int) -> tuple[float, float]:
    """Factor and offset from the unit in the header to the SI unit."""
    expected = parse(UNITS[column])
    try:
        return linear_map(parse(text) if text else expected, expected)
    except InputError as error:
        raise table.error(f"the {column} is in {text}: {error}", table.header_line, position + 1) from error


def _values(table: Table, position: int, column: str, repairs: list[str]) -> Array:
    cells = [(line, row[position]) for line, row in table.rows]
    empty = [line for line, cell in cells if not cell or cell.lower() == "nan"]
    if empty and column != "time":
        repairs.append(f"the {column} is missing in line {some(empty)}: not a number there")
    return np.array([
        table.number(cell, line, position + 1) if cell and (cell.lower() != "nan" or column == "time") else np.nan
        for line, cell in cells
    ])  # fmt: skip


def _check_time(table: Table, time: Array, name: str) -> None:
    if len(time) < 2:
        raise table.error(f"{len(time)} rows are too few; at least two are needed", table.header_line)
    for k, (line, _) in enumerate(table.rows):
        if np.isnan(time[k]) or (k and not time[k] > time[k - 1]):
            what = "has no time" if np.isnan(time[k]) else f"has the time {time[k]:g} s after {time[k - 1]:g} s"
            raise table.error(f"the row {what}; '{name}' must increase from row to row", line)
