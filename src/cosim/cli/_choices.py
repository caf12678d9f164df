"""Options of ``cosim score`` and ``cosim compare``: choices by name, columns by signal; and how it prints tables."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import Field, fields
from pathlib import Path
from typing import Any, TypeVar

from cosim.assessment import Method, Rules
from cosim.comparison import OF_THE_QUANTITY, SIGNALS, Options
from cosim.errors import InputError
from cosim.units import Unit, compatible, convert, parse, quantity

Choices = TypeVar("Choices", Rules, Method, Options)


def choices(kind: type[Choices], settings: Sequence[str]) -> Choices:
    """Return the dataclass with what ``--set name=value`` says; numbers carry units, as in scenario files."""
    known: dict[str, Field[Any]] = {entry.name: entry for entry in fields(kind)}
    given: dict[str, Any] = {}
    # the quantity first, on which the unit of another option depends
    for text in sorted(settings, key=lambda text: text.partition("=")[0].strip() != "quantity"):
        name, sign, value = (part.strip() for part in text.partition("="))
        if not sign or not value:
            raise InputError(f"--set {text}: write name=value, such as --set 'early=50 ms'")
        if name not in known:
            raise InputError(f"--set {text}: there is no '{name}'; accepted are {', '.join(known)}")
        given[name] = _value(known[name], value, text, given)
    try:
        return kind(**given)
    except InputError as error:
        raise InputError(f"--set: {error}") from error


def _unit(entry: Field[Any], given: Mapping[str, object]) -> Unit:
    """The unit of an option; that of ``tube_y`` depends on the quantity."""
    text = entry.metadata["unit"]
    if text == OF_THE_QUANTITY:
        text = SIGNALS.get(str(given.get("quantity", Options.quantity)), SIGNALS[Options.quantity])[1]
    return parse(text)


def _value(entry: Field[Any], value: str, text: str, given: Mapping[str, object]) -> object:
    if isinstance(entry.default, bool):
        if value.lower() not in ("true", "false", "0", "1"):
            raise InputError(f"--set {text}: accepted are true and false")
        return value.lower() in ("true", "1")
    if isinstance(entry.default, tuple):
        return tuple(_plain(part, text) for part in value.split(","))
    if isinstance(entry.default, int):
        return int(_plain(value, text))
    if "unit" not in entry.metadata:
        return value
    if value == "inf":
        return float("inf")
    unit = _unit(entry, given)
    number, found = quantity(value)
    if found.text == "1":
        return number
    if not compatible(found, unit):
        raise InputError(f"--set {text}: {entry.name} is in {unit}")
    return convert(number, found, unit)


def _plain(value: str, text: str) -> float:
    try:
        number, unit = quantity(value)
    except InputError:
        raise InputError(f"--set {text}: '{value}' is not a number") from None
    if unit.text != "1":
        raise InputError(f"--set {text}: write plain numbers, without a unit")
    return number


def aliases(
    columns: Sequence[str],
    known: Collection[str],
    how: str = "--column signal=column, such as --column park=sensor.contact",
) -> dict[str, str]:
    """Read ``--column signal=component.variable``; ``how`` tells in an error how to write it.

    Raises `InputError` for a signal that is not ``known``, since nothing would look at its column.
    """
    option, _, example = how.partition(" ")
    found = {}
    for text in columns:
        signal, sign, column = (part.strip() for part in text.partition("="))
        if not sign or not signal or not column:
            raise InputError(f"{option} {text}: write {example}")
        if signal not in known:
            raise InputError(f"{option} {text}: there is no '{signal}'; accepted are {', '.join(known)}")
        found[signal] = column
    return found


def measured(columns: Sequence[str]) -> dict[str, str]:
    """Read ``--measured-column quantity=name``."""
    how = "--measured-column quantity=name, such as --measured-column torque=M"
    return aliases(columns, ("time", *SIGNALS), how)


def pictures(folder: Path, prefix: str, files: Sequence[Path]) -> list[Path]:
    """Return a picture's path for each file, called after it; files of the same name are numbered."""
    stems = [re.sub(r"[^A-Za-z0-9]+", "_", file.stem).strip("_") or "measurement" for file in files]
    found: list[Path] = []
    for k, stem in enumerate(stems):
        before = sum(other.lower() == stem.lower() for other in stems[:k])
        found.append(folder / f"{prefix}{stem}{f'_{before + 1}' if before else ''}.png")
    return found


def table(head: Sequence[str], rows: Sequence[Sequence[str]], left: Sequence[int] = ()) -> list[str]:
    """Return columns under each other, the first one and those in ``left`` to the left, the others to the right."""
    widths = [max(len(row[k]) for row in [head, *rows]) for k in range(len(head))]
    aligned = [
        [
            cell.ljust(width) if k in (0, *left) else cell.rjust(width)
            for k, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        for row in [head, *rows]
    ]
    return ["  ".join(row).rstrip() for row in aligned]
