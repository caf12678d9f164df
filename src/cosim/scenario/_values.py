"""Values of a scenario in the units and types of the FMUs' variables."""

from __future__ import annotations

import math
import re
import warnings
from dataclasses import replace
from pathlib import Path

from cosim.engine import Variable
from cosim.errors import InputError
from cosim.scenario._model import Column, ScenarioWarning, suggestion
from cosim.units import Unit, compatible, convert, linear_map, parse, quantity

_BOOLEANS = {"0": False, "1": True, "false": False, "true": True}


def parameter_value(text: str, name: str, variable: Variable) -> float | int | bool | str:
    """Read the value of a ``set`` line for a parameter, in the FMU's unit. Raises `InputError` if it does not fit."""
    value = _parameter_value(text, name, variable)
    if not isinstance(value, str):
        check_range(value, name, variable)
    return value


def difference(text: str, name: str, variable: Variable) -> float:
    """Read an amount by which a Real changes, in the FMU's unit: 5 degC is 5 K. Raises `InputError`."""
    try:
        value, unit = quantity(text)
    except InputError as error:
        raise InputError(f"'{name}': {error}") from None
    remedy = f"write for example {value:g} {variable.unit}"
    converted = _to_variable(
        value, unit, name, variable, found=f"'{text}' is in {unit}", remedy=remedy, difference=True
    )
    if not math.isfinite(converted):
        raise InputError(f"'{name}': '{text}' is too large a number")
    return converted


def check_range(value: float, name: str, variable: Variable) -> None:
    """Raise `InputError` if a value, in the FMU's unit, is outside the range that the FMU declares."""
    if missed := variable.beyond(value):
        unit = f" {variable.unit}" if variable.unit not in (None, "1") else ""
        raise InputError(f"{name} = {value:.12g}{unit} is {missed}")


def _parameter_value(text: str, name: str, variable: Variable) -> float | int | bool | str:
    match variable.type:
        case "String" | "Binary":
            return text
        case "Boolean":
            if text.lower() not in _BOOLEANS:
                raise InputError(f"'{name}' is a Boolean, '{text}' is not; write 0 or 1")
            return _BOOLEANS[text.lower()]
        case "Enumeration":
            return _literal(text, name, variable)
        case "Integer":
            if not re.fullmatch(r"[+-]?\d{1,18}", text, re.ASCII):
                raise InputError(f"'{name}' is an Integer, '{text}' is not; write a whole number")
            return int(text)
    try:
        value, unit = quantity(text)
    except InputError as error:
        raise InputError(f"'{name}': {error}") from None
    remedy = f"write for example {value:g} {variable.unit}"
    converted = _to_variable(value, unit, name, variable, found=f"'{text}' is in {unit}", remedy=remedy)
    if not math.isfinite(converted):
        raise InputError(f"'{name}': '{text}' is too large a number")
    return converted


def channel_values(path: Path, column: Column, name: str, variable: Variable) -> list[float]:
    """Return a column's values in the input's unit. Raises `InputError` for a unit or a value that does not fit."""
    header = f"column '{column.name}'"
    if variable.type == "Real":
        unit = column.unit or parse("1")
        found = f"{header} is in {unit}" if column.unit else f"{header} has no unit"
        remedy = f"write '{column.name} [{variable.unit}]'"
        values = [_to_variable(value, unit, name, variable, found=found, remedy=remedy) for value in column.values]
        accepted = "a finite number"
    else:
        if variable.type in ("String", "Binary"):
            raise InputError(f"{header}: '{name}' is a {variable.type}; a column drives numbers only")
        if column.unit is not None and (column.unit.exponents or column.unit.factor != 1):
            raise InputError(f"{header} is in {column.unit}, '{name}' is {variable.type}; write '{column.name} [1]'")
        if column.linear:
            raise InputError(f"{header} cannot be linear: '{name}' is {variable.type}; take it out of 'linear'")
        values = list(column.values)
        accepted = _accepted(variable)
    for value, line in zip(values, column.lines, strict=True):
        if not _fits(value, variable):
            raise InputError(
                f"{value:g} in {header}: '{name}' takes {accepted}", file=path, line=line, column=column.position
            )
        try:
            check_range(value, name, variable)
        except InputError as error:
            raise InputError(str(error), file=path, line=line, column=column.position) from None
    return values


def connection_map(source_name: str, source: Variable, target_name: str, target: Variable) -> tuple[float, float]:
    """Factor and offset from an output to an input; (1, 0) where a unit is not given or both are the same text.

    Raises `InputError` for units of different dimensions; warns if one is not understood, and so not converted.
    """
    if source.unit == target.unit or source.unit is None or target.unit is None:
        return 1.0, 0.0
    source_unit, target_unit = _unit_of(source), _unit_of(target)
    if source_unit is None or target_unit is None:
        unknown = source.unit if source_unit is None else target.unit
        warnings.warn(
            f"{source_name} [{source.unit}] drives {target_name} [{target.unit}] without conversion, "
            f"the unit '{unknown}' of the FMU is not understood",
            ScenarioWarning,
            stacklevel=4,
        )
        return 1.0, 0.0
    try:
        return linear_map(source_unit, target_unit)
    except InputError as error:
        raise InputError(
            f"{source_name} [{source.unit}] cannot drive {target_name} [{target.unit}]: {error}"
        ) from error


def _to_variable(
    value: float, unit: Unit, name: str, variable: Variable, *, found: str, remedy: str, difference: bool = False
) -> float:
    target = _unit_of(variable)
    if difference:
        unit = replace(unit, offset=0.0)
        target = target and replace(target, offset=0.0)
    if target is None:
        if unit.factor != 1 or unit.offset:
            what = "no unit" if variable.unit is None else f"the unit '{variable.unit}', which is not understood,"
            raise InputError(f"{found}, but the FMU gives {what} for '{name}'; write the number as the FMU takes it")
        return value
    if not compatible(unit, target):
        raise InputError(f"{found}, '{name}' is in {variable.unit}; {remedy}")
    return convert(value, unit, target)


def _unit_of(variable: Variable) -> Unit | None:
    """Return the unit that the FMU gives; None if it gives none, or one that only its maker understands."""
    try:
        return None if variable.unit is None else parse(variable.unit)
    except InputError:
        return None


def _literal(text: str, name: str, variable: Variable) -> int:
    literals = variable.literals or ()
    if text in literals:
        return literals.index(text) + 1
    if re.fullmatch(r"[+-]?\d{1,9}", text, re.ASCII) and _fits(int(text), variable):
        return int(text)
    raise InputError(
        f"'{name}' has no value '{text}'{suggestion(text, literals)}; it takes {_accepted(variable)}"
        + (f" or one of {', '.join(literals)}" if literals else "")
    )


def _fits(value: float, variable: Variable) -> bool:
    if not math.isfinite(value):
        return False
    match variable.type:
        case "Boolean":
            return value in (0, 1)
        case "Enumeration" if variable.literals:
            return value in range(1, len(variable.literals) + 1)
        case "Integer" | "Enumeration":
            return value == int(value)
    return True


def _accepted(variable: Variable) -> str:
    if variable.type == "Boolean":
        return "0 and 1"
    if variable.literals:
        return f"whole numbers from 1 to {len(variable.literals)}"
    return "whole numbers"
