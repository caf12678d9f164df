"""A variable of an FMU as the user sees it: the same five types for FMI 2.0 and 3.0."""

from __future__ import annotations

import itertools
import math
import operator
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from fmpy.model_description import ModelVariable

Value = float | int | bool | str
"""A value of a variable: float for Real, int for Integer and Enumeration, bool for Boolean, str for String, and for
Binary a str of two hexadecimal digits a byte, as in a model description."""

OPAQUE = ("String", "Binary")
"""Types that are handed on as they are; they are no columns of a result."""


class BinaryKind(NamedTuple):
    """What is in a Binary, in the words of a MIME type, and how many bytes it may have; None if any number."""

    media_type: str
    most: int | None


class Opaque(NamedTuple):
    """What fmpy does not read of a String or Binary: its start values, and what kind of Binary it is."""

    starts: tuple[str, ...]
    binary: BinaryKind | None


@dataclass(frozen=True)
class Variable:
    """What the model description says of one scalar variable or one element of an array.

    ``type`` is "Real", "Integer", "Boolean", "Enumeration", "String" or "Binary", whatever the width in the FMU;
    ``binary`` says more of the last. ``unit`` is in
    FMI's grammar, None if the FMU gives none. ``literals`` holds the names of an enumeration, literal ``i`` (from 0)
    belonging to the value ``i + 1``; it is None for other types and for an enumeration that is numbered otherwise.
    ``array`` is the name of the array (FMI 3.0) that it is an element of; all elements have its value reference.
    ``minimum`` and ``maximum`` bound the values of a Real, Integer or Enumeration, None where there is no bound;
    ``nominal`` is the size of a Real's typical values, None if the FMU does not say.
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
    array: str | None = None
    minimum: float | None = None
    maximum: float | None = None
    binary: BinaryKind | None = None
    nominal: float | None = None

    def beyond(self, value: float) -> str | None:
        """Tell which bound a value in this unit misses ("below its minimum 0 s"); None if it is within its range.

        A bound that is missed by the rounding of a conversion of units is reached.
        """
        unit = f" {self.unit}" if self.unit not in (None, "1") else ""
        for bound, missed, which in (
            (self.minimum, operator.lt, "below its minimum"),
            (self.maximum, operator.gt, "above its maximum"),
        ):
            if bound is not None and missed(value, bound) and not math.isclose(value, bound, rel_tol=1e-12):
                return f"{which} {bound:.12g}{unit}"
        return None


def type_of(fmi_type: str) -> str | None:
    """Return the type of a variable for its FMI type ("Float64", "Int32", ...); None if it has none (Clock)."""
    if fmi_type in ("Real", "Float32", "Float64"):
        return "Real"
    if fmi_type in ("Boolean", "Enumeration", *OPAQUE):
        return fmi_type
    return "Integer" if fmi_type.startswith(("Int", "UInt")) else None


def left_out(described: ModelVariable) -> str | None:
    """Return what a variable is that can neither be exchanged nor set ("a Clock"); None for the others."""
    return f"a {described.type}" if type_of(described.type) is None else None


def names_of(described: ModelVariable) -> list[str]:
    """Return the name of a scalar, or those of an array's elements: "u[1]", "A[2,1]", the last index running first."""
    if not described.shape:
        return [described.name]
    indices = itertools.product(*(range(1, size + 1) for size in described.shape))
    return [f"{described.name}[{','.join(map(str, index))}]" for index in indices]


def opaque_of(description: bytes) -> dict[str, Opaque]:
    """Return the Binary variables and the texts with <Start> of a modelDescription.xml (FMI 3.0) by name."""
    if b"<Binary" not in description and b"<Start" not in description:
        return {}
    import xml.etree.ElementTree as ET  # few FMUs need it, and it takes time to import

    variables = ET.fromstring(description).find("ModelVariables")
    return {
        element.get("name", ""): Opaque(
            tuple(start.get("value", "") for start in element.iterfind("Start")),
            _binary_kind(element.attrib) if element.tag == "Binary" else None,
        )
        for element in (() if variables is None else variables)
        if element.tag in OPAQUE
    }


def _binary_kind(attributes: Mapping[str, str]) -> BinaryKind:
    most = attributes.get("maxSize")
    return BinaryKind(attributes.get("mimeType", "application/octet-stream"), None if most is None else int(most))


def variables_of(described: ModelVariable, opaque: dict[str, Opaque]) -> list[Variable]:
    """Return the variable that fmpy read, or the elements of an array; none for what is left out."""
    kind = type_of(described.type)
    if kind is None:
        return []
    declared = described.declaredType
    names = names_of(described)
    more = opaque.get(described.name)
    starts: list[str | None] = [described.start]
    if more is not None:
        starts = [*more.starts] or [None]
    elif described.shape and described.start is not None:
        starts = [*described.start.split()]
    if len(starts) == 1:
        starts *= len(names)
    return [
        Variable(
            name=name,
            type=kind,
            causality=described.causality,
            variability=described.variability,
            unit=described.unit or (declared.unit if declared else None),
            description=described.description,
            start=_start_of(kind, start),
            value_reference=described.valueReference,
            literals=_literals_of(described) if kind == "Enumeration" else None,
            array=described.name if described.shape else None,
            minimum=_bound_of(kind, described.min, declared.min if declared else None),
            maximum=_bound_of(kind, described.max, declared.max if declared else None),
            binary=more.binary if more else None,
            nominal=_nominal_of(described.nominal or (declared.nominal if declared else None)),
        )
        for name, start in zip(names, starts, strict=True)
    ]


def _start_of(kind: str, text: str | None) -> Value | None:
    if text is None:
        return None
    if kind == "Real":
        return float(text)
    if kind == "Boolean":
        return text in ("true", "1")
    return text if kind in OPAQUE else int(text)


def _bound_of(kind: str, own: str | None, declared: str | None) -> float | None:
    """Return a variable's own bound, or its type's; None if there is none, or one that is infinite or no number."""
    if kind not in ("Real", "Integer", "Enumeration"):
        return None
    try:
        bound = float(own or declared or "inf")
    except ValueError:
        return None
    return bound if math.isfinite(bound) else None


def _nominal_of(text: str | None) -> float | None:
    try:
        nominal = abs(float(text or "nan"))
    except ValueError:
        return None
    return nominal if math.isfinite(nominal) and nominal > 0.0 else None


def _literals_of(described: ModelVariable) -> tuple[str, ...] | None:
    items = described.declaredType.items if described.declaredType else []
    names = {int(item.value): str(item.name) for item in items}
    numbers = sorted(names)
    return tuple(names[number] for number in numbers) if numbers == list(range(1, len(items) + 1)) and items else None
