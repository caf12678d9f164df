"""The words of modelDescription.xml that the mending needs: types, interfaces, which variability goes with what."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator

from lxml import etree

INTERFACES = ("ModelExchange", "CoSimulation", "ScheduledExecution")
STRUCTURE = ("Unknown", "Output", "ContinuousStateDerivative", "ClockedState", "InitialUnknown", "EventIndicator")
_CONTINUOUS = ("Real", "Float32", "Float64")
_PARAMETERS = ("parameter", "calculatedParameter", "structuralParameter")
_MICROSOFT = {
    "1.#INF": "INF",
    "-1.#INF": "-INF",
    "1.#IND": "NaN",
    "-1.#IND": "NaN",
    "1.#QNAN": "NaN",
    "-1.#QNAN": "NaN",
}
_NUMBER = re.compile(r"([+-]?\d*)[.,]?(\d*)(?:[eEdD]([+-]?\d+))?")


def is_fmi2(root: etree._Element) -> bool:
    """Tell whether variables are ScalarVariable elements with the type inside, and the structure counts from 1."""
    return str(root.get("fmiVersion", "")).startswith("2.")


def variables_of(root: etree._Element) -> Iterator[etree._Element]:
    """Yield the elements that describe variables."""
    yield from root.findall("ModelVariables/*")


def value_of(variable: etree._Element, root: etree._Element) -> etree._Element | None:
    """Return the element with type, start value and unit; None if FMI 1.0 or 2.0 has none."""
    if root.get("fmiVersion", "").startswith("3."):
        return variable
    return next((child for child in variable if child.tag in TYPES or child.tag in ("String", "Enumeration")), None)


def indexed(root: etree._Element) -> set[str]:
    """Return what the model structure can refer to: positions from 1 (FMI 2.0) or value references."""
    if is_fmi2(root):
        return {str(k) for k, _ in enumerate(variables_of(root), 1)}
    return {variable.get("valueReference", "").strip() for variable in variables_of(root)}


def label(element: etree._Element) -> str:
    """Return an element's name and line."""
    return f"{element.get('name', '?')} (line {element.sourceline})"


def is_true_or_false(text: str) -> bool:
    """Tell whether this is a Boolean written with capitals."""
    return text.lower() in ("true", "false") and text != text.lower()


def legal_variability(causality: str, variability: str, type_name: str, *, is_given: bool) -> str | None:
    """Return what a variability that is not allowed with this causality and type must mean; None if it is allowed.

    The allowed combinations are those of FMI 2.0.4, section 2.2.7, and FMI 3.0, section 2.4.7.4.
    """
    if causality in _PARAMETERS:
        return None if variability in ("fixed", "tunable") else "fixed"
    if causality == "independent":
        return None if variability == "continuous" else "continuous"
    by_type = "continuous" if type_name in _CONTINUOUS else "discrete"
    if causality == "input" and variability in ("constant", "fixed", "tunable"):
        return by_type
    if causality == "output" and variability in ("fixed", "tunable"):
        return by_type
    if variability == "continuous" and by_type == "discrete":
        return by_type
    return None if is_given or variability == by_type else by_type


def _real(text: str) -> str:
    if text in _MICROSOFT:
        return _MICROSOFT[text]
    found = _NUMBER.fullmatch(text)
    if found and (found[1].strip("+-") or found[2]) and ("," in text or "d" in text.lower()):
        return f"{found[1]}.{found[2]}" + (f"e{found[3]}" if found[3] else "")
    return text


def _integer(text: str) -> str:
    try:
        value = float(text)
    except ValueError:
        return text
    return text if text.lstrip("+-").isdigit() or not value.is_integer() else str(int(value))


def _boolean(text: str) -> str:
    return text.lower() if is_true_or_false(text) else text


TYPES: dict[str, Callable[[str], str]] = {
    **dict.fromkeys(_CONTINUOUS, _real),
    "Integer": _integer,
    **{f"{sign}Int{bits}": _integer for sign in ("", "U") for bits in (8, 16, 32, 64)},
    "Enumeration": _integer,
    "Boolean": _boolean,
}
"""How a start value of each type is read: a text that the schema allows, or the same text again."""
