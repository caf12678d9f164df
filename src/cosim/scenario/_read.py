"""Reading of scenario files: everything that can be refused without the FMUs is refused here."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import cast

from cosim.engine import Algorithm
from cosim.errors import InputError
from cosim.scenario._faults import parse_fault
from cosim.scenario._keys import Keys, missing, override, parse_keys
from cosim.scenario._model import Column, Scenario, Setting, is_structure, suggestion
from cosim.tabular import Table, load
from cosim.units import Unit, compatible, convert, parse

# Two instants closer than this are one.
SAME_INSTANT = 1e-9

_DEFAULTS = {"sample_time": 0.02, "output_interval": 1e-3, "tolerance": 1e-6}
_HEADER = re.compile(r"(?P<name>.*?)\s*\[(?P<unit>[^\[\]]*)\]")
_SECOND = parse("s")


def read(
    path: Path | str,
    settings: Sequence[str] = (),
    parameters: Sequence[Setting] = (),
    faults: Sequence[str] = (),
) -> Scenario:
    """Read a scenario file.

    ``settings`` are ``name=value`` texts that win over the file; a name is a parameter's or one of stop, sample_time,
    output_interval, tolerance, system, controller. ``parameters``, from parameter files, win over the file, too, but
    not over ``settings``. ``faults`` are texts such as ``i_motor bias 0.5 A``, added to those of the file. Raises
    `InputError` with file, line and column for anything wrong; what depends on the FMUs (names, units) is checked by
    `assemble`.
    """
    table = load(Path(path))
    keys = parse_keys(table.path, table.keys, table.plain_decimal)
    keys.settings += parameters
    for option in settings:
        override(keys, option)
    keys.faults += [parse_fault(text, "--fault", None) for text in faults]
    times = _times(table)
    columns = _mark_linear(table, keys, _columns(table, times))
    if "system" not in keys.texts:
        raise table.error(missing("system"))
    if "controller" not in keys.texts and not is_structure(keys.texts["system"]):
        raise table.error(missing("controller"))
    controller = keys.texts.get("controller", "none")
    scenario = Scenario(
        path=table.path,
        title=keys.texts.get("title", ""),
        system=keys.texts["system"],
        controller=None if controller.lower() == "none" else controller,
        stop=_stop(table, keys, times),
        algorithm=cast(Algorithm, keys.texts.get("algorithm", "auto")),
        macro_step=keys.numbers.get("macro_step"),
        extrapolation=int(keys.texts["extrapolation"]) if "extrapolation" in keys.texts else None,
        settings=tuple(keys.settings),
        links=tuple(keys.links),
        powers=tuple(keys.powers),
        columns=columns,
        faults=tuple(keys.faults),
        key_lines=keys.lines,
        **{key: keys.numbers.get(key, default) for key, default in _DEFAULTS.items()},
    )
    for fault in scenario.faults:
        if fault.start > scenario.stop:
            raise InputError(
                f"the fault of '{fault.name}' begins at {fault.start:g} s, after 'stop', {scenario.stop:g} s; "
                "let it begin earlier, or remove it",
                file=fault.file,
                line=fault.line,
            )
    if scenario.output_interval > scenario.stop:
        raise table.error(
            f"'output_interval' {scenario.output_interval} s is longer than the run, which stops at {scenario.stop} s",
            keys.lines.get("output_interval"),
        )
    return scenario


def _stop(table: Table, keys: Keys, times: list[float]) -> float:
    last = times[-1] if times else 0.0
    stop = keys.numbers.get("stop", last)
    if stop <= 0:
        raise table.error(f"{missing('stop')}; it may be left out only if the rows end later than 0 s")
    if last > stop + SAME_INSTANT:
        raise table.error(
            f"the row's time {last:g} s is after 'stop', {stop:g} s; let 'stop' be at least the last row's time",
            table.rows[-1][0],
            1,
        )
    return stop


def _times(table: Table) -> list[float]:
    """Return the rows' times [s], never going back and never more than two alike."""
    unit = _time_unit(table)
    times: list[float] = []
    for line, cells in table.rows:
        if not cells[0]:
            raise table.error("the row has no time; each row starts with one", line, 1)
        time = convert(table.number(cells[0], line, 1), unit, _SECOND)
        if not 0 <= time < float("inf"):
            raise table.error(f"the time {cells[0]} is not in the run, which starts at 0 s", line, 1)
        if times and abs(time - times[-1]) <= SAME_INSTANT:
            time = times[-1]
        elif times and time < times[-1]:
            raise table.error(
                f"the time {cells[0]} goes back: the row above has {table.rows[len(times) - 1][1][0]}", line, 1
            )
        times.append(time)
        if times[-3:] == [time] * 3:
            raise table.error(f"a third row with the time {cells[0]}; two rows with one time are a step", line, 1)
    return times


def _time_unit(table: Table) -> Unit:
    name, unit = _name_and_unit(table, 1)
    if name.lower() != "time" or unit is None or not compatible(unit, _SECOND):
        raise table.error(
            f"the first column is '{table.header[0]}'; it must be 'time [s]' or time in another unit of time",
            table.header_line,
            1,
        )
    return unit


def _name_and_unit(table: Table, position: int) -> tuple[str, Unit | None]:
    """Split a header cell ``name [unit]``; without a blank, ``x[1]`` is an array's element and has no unit."""
    text = table.header[position - 1]
    match = _HEADER.fullmatch(text)
    if match is None or (re.fullmatch(r"[\d,\s]+", match["unit"]) and text[match.end("name")] == "["):
        name, unit = text, None
    else:
        name = match["name"]
        try:
            unit = parse(match["unit"])
        except InputError as error:
            raise table.error(f"column '{text}': {error}", table.header_line, position) from None
    if not name:
        raise table.error("the column has no name; expected 'name [unit]'", table.header_line, position)
    return name, unit


def _columns(table: Table, times: list[float]) -> list[Column]:
    columns: list[Column] = []
    for position in range(2, len(table.header) + 1):
        name, unit = _name_and_unit(table, position)
        if name.lower() == "time" or any(name == column.name for column in columns):
            raise table.error(f"a second column '{name}'; each channel has one column", table.header_line, position)
        cells = [(t, line, row[position - 1]) for t, (line, row) in zip(times, table.rows, strict=True)]
        given = [(t, table.number(cell, line, position), line) for t, line, cell in cells if cell]
        if not given:
            raise table.error(
                f"column '{name}' has no value in any row; give one or remove the column", table.header_line, position
            )
        instants, values, lines = zip(*given, strict=True)
        columns.append(Column(name, unit, position, table.header_line, instants, values, lines))
    return columns


def _mark_linear(table: Table, keys: Keys, columns: list[Column]) -> tuple[Column, ...]:
    names = [column.name for column in columns]
    for name, line in keys.linear:
        if name not in names:
            known = f"the columns are {', '.join(names)}" if names else "there are no columns besides time"
            raise table.error(f"'linear' names '{name}'{suggestion(name, names)}; {known}", line)
    linear = {name for name, _ in keys.linear}
    return tuple(replace(column, linear=column.name in linear) for column in columns)
