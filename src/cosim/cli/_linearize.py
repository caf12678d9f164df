"""``cosim linearize``: the linear model at an operating point, its poles, and a Bode picture."""

from __future__ import annotations

import json
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Literal

from cosim.cli._builtin import check_there
from cosim.cli._screen import Screen
from cosim.errors import InputError
from cosim.linear import LinearSystem, Signal, bode, linearize
from cosim.units import compatible, convert, parse, quantity

_MOST_HELD = 12
_WIDEST = 8
"""Matrices with more columns are not printed, only written."""


def linearize_model(
    file: Path,
    model: str,
    screen: Screen,
    *,
    at: str,
    settings: Sequence[str],
    inputs: Sequence[str],
    outputs: Sequence[str],
    steady_except: Sequence[str],
    settle: str | None,
    out: Path | None,
) -> dict[str, object]:
    """Linearize, print, write into ``out`` if it is given; return the content of the JSON document."""
    check_there(file)
    system = linearize(
        file,
        model,
        at=_moment(at),
        parameters=_given(settings, "--set"),
        inputs=_given(inputs, "--input"),
        outputs=list(dict.fromkeys(outputs)) or None,
        steady_except=steady_except,
        settle=None if settle is None else _seconds(settle, "--settle"),
    )
    screen.say(describe(system))
    files = [] if out is None else _write(system, out, screen)
    return system.to_dict() | {"files": [str(path) for path in files]}


def _moment(text: str) -> float | Literal["initial", "steady"]:
    if text == "initial":
        return "initial"
    return "steady" if text == "steady" else _seconds(text, "--at", " or initial or steady")


def _seconds(text: str, option: str, others: str = "") -> float:
    try:
        value, unit = quantity(text)
    except InputError:
        value, unit = -1.0, parse("s")
    if unit.text == "1":
        unit = parse("s")
    if value < 0 or not compatible(unit, parse("s")):
        raise InputError(f"{option} {text}: give a time from 0 on, such as '2.5 s'{others}")
    return convert(value, unit, parse("s"))


def _given(texts: Sequence[str], option: str) -> dict[str, str]:
    """Read ``name=value``; of a name that is given twice the last value counts."""
    given = {}
    for text in texts:
        name, sign, value = text.partition("=")
        if not sign or not name.strip() or not value.strip():
            raise InputError(f"{option} {text}: write name=value, such as {option} 'v_supply=28 V'")
        given[name.strip()] = value.strip()
    return given


def _write(system: LinearSystem, out: Path, screen: Screen) -> list[Path]:
    """Write the JSON document and, if python-control is there, the Bode picture."""
    out.mkdir(parents=True, exist_ok=True)
    name = system.model.rpartition(".")[2]
    numbers = out / f"{name}_linear.json"
    numbers.write_text(json.dumps(system.to_dict(), indent=2, allow_nan=False) + "\n", encoding="utf-8")
    written = [numbers]
    picture = out / f"{name}_bode.png"
    if find_spec("control") is None:
        screen.note("no Bode picture without python-control; install it with: pip install 'wiper-cosim[control]'")
    else:
        try:
            for note in bode(system, picture):
                screen.note(note)
            written.append(picture)
        except InputError as error:
            screen.note(str(error))
    for path in written:
        screen.say(str(path))
    return written


def describe(system: LinearSystem) -> str:
    """Return the text that the command prints: operating point, matrices, poles."""
    where = "in its steady state" if system.at == "steady" else f"at t = {system.time:g} s"
    slopes = [f"{value:.6g}" for value in system.slope]
    lines = [f"{system.model}, linearized {where}", ""]
    lines += _table(
        ["state", "value", "unit", "derivative"],
        [[s.name, f"{s.value:.9g}", s.unit, slope] for s, slope in zip(system.states, slopes, strict=True)],
    )
    for kind, signals in (("input", system.inputs), ("output", system.outputs)):
        if signals:
            lines += ["", *_table([kind, "value", "unit"], [[s.name, f"{s.value:.9g}", s.unit] for s in signals])]
    if not system.outputs:
        lines += ["", "no outputs: the model has no Real output; name variables with --output"]
    if system.held:
        shown = [f"{name} = {value:g}" for name, value in system.held.items()][:_MOST_HELD]
        more = [f"and {len(system.held) - _MOST_HELD} more"] if len(system.held) > _MOST_HELD else []
        lines += ["", "held: " + ", ".join(shown + more)]
    for name, rows, columns in (
        ("A", system.states, system.states),
        ("B", system.states, system.inputs),
        ("C", system.outputs, system.states),
        ("D", system.outputs, system.inputs),
    ):
        lines += _matrix(system, name, rows, columns)
    return "\n".join([*lines, "", *_poles(system)])


def _matrix(system: LinearSystem, name: str, rows: Sequence[Signal], columns: Sequence[Signal]) -> list[str]:
    if not rows or not columns:
        return []
    if len(columns) > _WIDEST:
        return ["", f"{name}: {len(rows)} rows, {len(columns)} columns; --out DIR or --json gives them"]
    values = getattr(system, name)
    body = [[s.name, *(f"{value:.6g}" for value in row)] for s, row in zip(rows, values, strict=True)]
    return ["", *_table([name, *(s.name for s in columns)], body)]


def _poles(system: LinearSystem) -> list[str]:
    rows = []
    for pole in system.poles:
        sign = "-" if pole.imaginary < 0 else "+"
        value = f"{pole.real:.6g}" + (f" {sign} {abs(pole.imaginary):.6g}i" if pole.imaginary else "")
        damping = "" if pole.damping is None else f"{pole.damping:.4g}"
        constant = "" if pole.time_constant is None else f"{pole.time_constant:.4g}"
        frequency = f"{pole.frequency:.6g}"
        hertz = f"{pole.frequency / 6.283185307179586:.6g}"
        rows.append([value, frequency, hertz, damping, constant, "unstable" if pole.real > 0 else ""])
    head = ["pole [1/s]", "natural frequency [rad/s]", "[Hz]", "damping ratio", "time constant [s]", ""]
    return _table(head, rows) if rows else ["no poles: the model has no state"]


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Columns under each other, the first to the left, numbers to the right."""
    widths = [max(len(row[k]) for row in [head, *rows]) for k in range(len(head))]
    return [
        "  ".join([row[0].ljust(widths[0]), *(c.rjust(w) for c, w in zip(row[1:], widths[1:], strict=True))]).rstrip()
        for row in [head, *rows]
    ]
