"""``cosim info``: what an FMU is, and its variables."""

from __future__ import annotations

import math
from dataclasses import asdict
from pathlib import Path

from rich.console import Console
from rich.table import Table

from cosim.cli._builtin import locate
from cosim.cli._screen import Screen, warned
from cosim.engine import Fmu, Variable
from cosim.errors import InputError

_UNLIMITED = 100_000
"""Width of what is read by a program."""
_SHOWN = ("input", "output", "structuralParameter", "parameter")


def show(name: str, screen: Screen) -> None:
    """Print an FMU's description; ``name`` is a path ending in .fmu or the name of a built-in one."""
    path = Path(name)
    if path.suffix.lower() != ".fmu":
        with screen.working(f"getting {name} ready"):
            path = locate(name)
    elif not path.is_file():
        raise InputError("there is no such FMU", file=path)
    with warned(screen):
        fmu = Fmu.read(path)
    variables = [variable for kind in _SHOWN for variable in fmu.variables.values() if variable.causality == kind]
    facts: dict[str, object] = {
        "path": str(path),
        "model": fmu.name,
        "fmi_version": fmu.fmi_version,
        "generation_tool": fmu.generation_tool,
        "sha256": fmu.sha256,
        "variables": len(fmu.variables),
    }
    screen.document(facts | {"capabilities": fmu.capabilities, "interface": [_plain(v) for v in variables]})
    if screen.talks:
        _print(facts | fmu.capabilities, variables)


def _plain(variable: Variable) -> dict[str, object]:
    """Return a variable for JSON, which knows no infinity."""
    start = variable.start
    return asdict(variable) | ({"start": str(start)} if isinstance(start, float) and not math.isfinite(start) else {})


def _print(facts: dict[str, object], variables: list[Variable]) -> None:
    console = Console(highlight=False, markup=False)
    if not console.is_terminal:
        console.width = _UNLIMITED
    about = Table.grid(padding=(0, 2))
    about.add_column(overflow="fold")
    about.add_column(overflow="fold")
    for key, value in facts.items():
        about.add_row(key, ", ".join(map(str, value)) if isinstance(value, list | tuple) else str(value))
    console.print(about)
    table = Table(box=None, padding=(0, 1))
    for heading in ("name", "causality", "type", "unit", "start", "description"):
        table.add_column(heading, overflow="fold")
    for variable in variables:
        literals = f" ({', '.join(variable.literals)})" if variable.literals else ""
        table.add_row(
            variable.name,
            variable.causality,
            variable.type,
            variable.unit or "",
            "" if variable.start is None else str(variable.start),
            (variable.description or "") + literals,
        )
    console.print()
    console.print(table)
