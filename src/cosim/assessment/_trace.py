"""The recorded signals of one run, found by name and in the unit that is asked for."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cosim.engine import Result
from cosim.errors import InputError
from cosim.units import linear_map, parse

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

_MOST_NAMED = 12


@dataclass(frozen=True)
class Trace:
    """Signals over time: ``time`` [s] of shape (n,), increasing; ``columns`` by name, each of shape (n,).

    ``units`` holds the FMI unit of the columns that have one, ``literals`` the names of an enumeration's values
    1, 2, ..., ``aliases`` the column that stands for a signal whose own name would not find it. ``faulty`` are columns
    of inputs to which a fault was done: they stand for a signal only if nothing else has its name.
    """

    name: str
    time: Array
    columns: Mapping[str, NDArray[Any]]
    units: Mapping[str, str] = field(default_factory=dict)
    literals: Mapping[str, Sequence[str]] = field(default_factory=dict)
    aliases: Mapping[str, str] = field(default_factory=dict)
    complete: bool = True
    faulty: frozenset[str] = frozenset()

    def __post_init__(self) -> None:
        """Check time and aliases; raises `InputError`."""
        if len(self.time) < 2:
            raise InputError(f"{self.name}: {len(self.time)} rows are too few; at least two are needed")
        steps = np.diff(self.time)
        if not bool((steps > 0).all()):  # a NaN is not greater either
            row = int(np.flatnonzero(~(steps > 0))[0]) + 1
            raise InputError(f"{self.name}: time must increase from row to row, but row {row + 1} has {self.time[row]}")
        for signal, column in self.aliases.items():
            if column not in self.columns:
                raise InputError(f"{self.name}: no column '{column}' to take for '{signal}'; {self._there()}")

    def column(self, signal: str) -> str | None:
        """Return the column called ``signal`` or ``component.signal``, None if there is none.

        Raises `InputError` if there are several, of which none has just that name.
        """
        if signal in self.aliases:
            return self.aliases[signal]
        if signal in self.columns:
            return signal
        named = [name for name in self.columns if name.rpartition(".")[2] == signal]
        found = [name for name in named if name not in self.faulty] or named
        if len(found) > 1:
            raise InputError(
                f"{self.name}: several columns are called '{signal}': {', '.join(found)}; "
                f"say which one is meant: --column {signal}={found[0]}"
            )
        return found[0] if found else None

    def has(self, *signals: str) -> bool:
        """Tell whether there is a column for each signal."""
        return all(self.column(signal) is not None for signal in signals)

    def signal(self, signal: str, unit: str) -> Array:
        """Return a signal in ``unit``, shape (n,); a column without a unit is taken to be in it.

        Raises `InputError` if there is no such column, its unit has another dimension, or a value is not finite.
        """
        name = self._required(signal)
        try:
            values = np.asarray(self.columns[name], dtype=np.float64)
        except (TypeError, ValueError):
            raise InputError(f"{self.name}: column '{name}' holds something that is no number") from None
        self._check_finite(name, values)
        source = self.units.get(name)
        if source is None or source == unit:
            return values
        try:
            factor, offset = linear_map(parse(source), parse(unit))
        except InputError as error:
            raise InputError(f"{self.name}: column '{name}' is in {source}, expected is {unit}: {error}") from error
        return values * factor + offset

    def switch(self, signal: str) -> NDArray[np.bool_]:
        """Return an on/off signal, shape (n,): everything above one half is on."""
        name = self._required(signal)
        values = np.asarray(self.columns[name])
        return values if values.dtype == np.bool_ else self.signal(signal, "1") > 0.5

    def labels(self, signal: str) -> NDArray[np.str_]:
        """Return an enumeration as the names of its values, shape (n,), of ``RUN.RUN`` the last part.

        Raises `InputError` if the values are numbers without names.
        """
        name = self._required(signal)
        values = np.asarray(self.columns[name])
        if values.dtype.kind in "OUS":
            names, index = np.unique(values.astype(str), return_inverse=True)
            return np.array([text.rpartition(".")[2] for text in names.tolist()])[index]
        literals = self.literals.get(name)
        if not literals:
            raise InputError(
                f"{self.name}: the values of '{name}' are numbers without names; read the folder that cosim run wrote, "
                "or give the names as texts"
            )
        numbers = self.signal(signal, "1")
        if not bool(np.isin(numbers, np.arange(1, len(literals) + 1)).all()):
            raise InputError(
                f"{self.name}: '{name}' has values other than 1 to {len(literals)}, of its {len(literals)} names"
            )
        return np.array([text.rpartition(".")[2] for text in literals])[numbers.astype(np.int64) - 1]

    def _required(self, signal: str) -> str:
        name = self.column(signal)
        if name is None:
            raise InputError(
                f"{self.name}: no column '{signal}' nor 'component.{signal}'; {self._there()}; "
                f"a column with another name is given by --column {signal}=NAME"
            )
        return name

    def _there(self) -> str:
        names = list(self.columns)
        more = f" and {len(names) - _MOST_NAMED} more" if len(names) > _MOST_NAMED else ""
        return f"there are {', '.join(names[:_MOST_NAMED])}{more}" if names else "there are no columns beside time"

    def _check_finite(self, name: str, values: Array) -> None:
        wrong = ~np.isfinite(values)
        if wrong.any():
            row = int(np.flatnonzero(wrong)[0])
            raise InputError(
                f"{self.name}: column '{name}' is {values[row]} at {self.time[row]:.6g} s, not a finite number"
            )


def trace(
    source: Trace | Result | pd.DataFrame | Path | str,
    *,
    name: str | None = None,
    aliases: Mapping[str, str] | None = None,
) -> Trace:
    """Return the signals of a run, from what `cosim run` wrote, what `simulate` returned, or a table.

    A path is that of a result folder, or of a .parquet or .csv file. The columns of a file or a table are called
    ``component.variable [unit]``, unit and component optional, one of them ``time``; without a unit a column is in the
    SI unit of what it is used for. States are texts, or integers if the names of these are known: in a Parquet file,
    or in the summary.json beside a CSV file.

    Raises:
        InputError: there is no such file, it is no table, or time is missing or does not increase.
    """
    extra = dict(aliases or {})
    if isinstance(source, Trace):
        return source
    if isinstance(source, Result):
        faulty = frozenset(".".join(fault.target) for fault in source.faults)
        return Trace(
            name or "result", source.time, source.columns, source.units, source.literals, extra, source.complete, faulty
        )
    if isinstance(source, (str, Path)):
        return _read(Path(source), name, extra)
    return _from_table(name or "table", {str(key): source[key].to_numpy() for key in source.columns}, {}, extra, {})


def _read(path: Path, name: str | None, aliases: dict[str, str]) -> Trace:
    if path.is_dir():
        files = [path / "results.parquet", path / "results.csv"]
        name = name or path.resolve().name
        path = next((file for file in files if file.is_file()), path)
        if path.is_dir():
            raise InputError("no results.parquet or results.csv in this folder; make it with cosim run", file=path)
    elif not path.is_file():
        raise InputError("no such result; give a folder that cosim run wrote, such as results/x", file=path)
    name = name or path.stem
    try:
        if path.suffix.lower() == ".parquet":
            return _from_parquet(path, name, aliases)
        if path.suffix.lower() == ".csv":
            return _from_csv(path, name, aliases)
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}", file=path) from error
    raise InputError("results are read from .parquet and .csv files, or from the folder with them", file=path)


def _from_parquet(path: Path, name: str, aliases: dict[str, str]) -> Trace:
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        table = pq.read_table(path)
    except pa.ArrowException as error:
        raise InputError(f"not a Parquet file that can be read: {error}", file=path) from error
    literals = {
        entry.name: json.loads(entry.metadata[b"literals"])
        for entry in table.schema
        if entry.metadata and b"literals" in entry.metadata
    }
    content = json.loads((table.schema.metadata or {}).get(b"cosim", b"{}"))
    columns = {entry: table.column(entry).to_numpy() for entry in table.column_names}
    return _from_table(name, columns, literals, aliases, content)


def _from_csv(path: Path, name: str, aliases: dict[str, str]) -> Trace:
    import pandas as pd

    try:
        table = pd.read_csv(path)
    except (ValueError, csv.Error) as error:  # also pandas' own errors, and a wrong encoding
        raise InputError(f"not a CSV table that can be read: {error}", file=path) from error
    columns = {str(key): table[key].to_numpy() for key in table.columns}
    summary: dict[str, Any] = {}
    beside = path.with_name("summary.json")
    if beside.is_file():
        try:
            summary = json.loads(beside.read_text(encoding="utf-8"))
        except ValueError as error:
            raise InputError(f"not a JSON document: {error}", file=beside) from error
    return _from_table(name, columns, summary.get("enumerations", {}), aliases, summary)


def _from_table(
    name: str,
    table: Mapping[str, NDArray[Any]],
    literals: Mapping[str, Sequence[str]],
    aliases: dict[str, str],
    summary: Mapping[str, Any],
) -> Trace:
    """Take the units out of the headers, and time out of the columns; ``summary`` tells what the run was."""
    columns, units = {}, {}
    for header, values in table.items():
        plain, bracket, unit = header.strip().rpartition(" [")
        if not bracket or not unit.endswith("]"):
            plain = header.strip()
        else:
            units[plain] = unit[:-1]
        columns[plain] = values
    named = {header.strip().rpartition(" [")[0] or header: names for header, names in literals.items()}
    if "time" not in columns:
        raise InputError(f"{name}: no column 'time [s]'; there are {', '.join(list(columns)[:_MOST_NAMED])}")
    clock = Trace(name, np.arange(float(len(columns["time"]))), {"time": columns["time"]}, units)
    return Trace(
        name,
        clock.signal("time", "s"),
        {n: v for n, v in columns.items() if n != "time"},
        units,
        named,
        aliases,
        bool(summary.get("complete", True)),
        frozenset(fault["target"] for fault in summary.get("faults", [])),
    )
