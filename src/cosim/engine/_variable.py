"""A variable of an FMU as the user sees it: the same five types for FMI 2.0 and 3.0."""

from __future__ import annotations

from dataclasses import dataclass

from fmpy.model_description import ModelVariable

Value = float | int | bool | str
"""A value of a variable: float for Real, int for Integer and Enumeration, bool for Boolean, str for String."""


@dataclass(frozen=True)
class Variable:
    """What the model description says of one scalar variable.

    ``type`` is "Real", "Integer", "Boolean", "Enumeration" or "String", whatever the width in the FMU. ``unit`` is in
    FMI's grammar, None if the FMU gives none. ``literals`` holds the names of an enumeration, literal ``i`` (from 0)
    belonging to the value ``i + 1``; it is None for other types and for an enumeration that is numbered otherwise.
    """

    name: str
    type: str
    causality: str
    variability: str
    unit: str | None
    description: str | None
    start: Value | None
    value_reference: int
    literals: tuple[str, ...] | None


def type_of(fmi_type: str) -> str | None:
    """Return the type of a variable for its FMI type ("Float64", "Int32", ...); None if it has none (Binary, Clock)."""
    if fmi_type in ("Real", "Float32", "Float64"):
        return "Real"
    if fmi_type in ("Boolean", "Enumeration", "String"):
        return fmi_type
    return "Integer" if fmi_type.startswith(("Int", "UInt")) else None


def left_out(described: ModelVariable) -> str | None:
    """Return what a variable is that cannot be exchanged or set: "an array", "a Binary", "a Clock"; else None."""
    if described.shape or described.dimensions:
        return "an array"
    return f"a {described.type}" if type_of(described.type) is None else None


def variable_of(described: ModelVariable) -> Variable | None:
    """Return the variable that fmpy read, or None for what is no scalar (arrays, binaries, clocks)."""
    kind = type_of(described.type)
    if kind is None or left_out(described):
        return None
    declared = described.declaredType
    return Variable(
        name=described.name,
        type=kind,
        causality=described.causality,
        variability=described.variability,
        unit=described.unit or (declared.unit if declared else None),
        description=described.description,
        start=_start_of(kind, described.start),
        value_reference=described.valueReference,
        literals=_literals_of(described) if kind == "Enumeration" else None,
    )


def _start_of(kind: str, text: str | None) -> Value | None:
    if text is None:
        return None
    if kind == "Real":
        return float(text)
    if kind == "Boolean":
        return text in ("true", "1")
    return text if kind == "String" else int(text)


def _literals_of(described: ModelVariable) -> tuple[str, ...] | None:
    items = described.declaredType.items if described.declaredType else []
    names = {int(item.value): str(item.name) for item in items}
    numbers = sorted(names)
    return tuple(names[number] for number in numbers) if numbers == list(range(1, len(items) + 1)) and items else None
