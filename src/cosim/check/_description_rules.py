"""Rules on what the model description says that no schema and no other validator looks at."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from typing import Any

from cosim.check._rules import Found, Rules, Severity, shortened
from cosim.check._subject import Subject, place
from cosim.errors import InputError
from cosim.foreign import NAME
from cosim.units import parse

DESCRIPTION_RULES: Rules[Subject] = Rules()
_FMI2_KINDS = {"Enumeration": "Integer"}
_REFERENCES = 1 << 32
_PART = r"(?:[A-Za-z_]\w*|'(?:[^'\\]|\\.)+')(?:\[\d+(?:,\s*\d+)*\])?"
_STRUCTURED = re.compile(rf"{_PART}(?:\.{_PART})*|der\({_PART}(?:\.{_PART})*(?:,\s*\d+)?\)", re.ASCII)
_BASES = ("kg", "m", "s", "A", "K", "mol", "cd")
"""Base units without rad, which some tools count and some do not."""


@DESCRIPTION_RULES("interface.none", Severity.ERROR)
def none(subject: Subject) -> Iterator[Found]:
    """There is an interface: Co-Simulation, Model Exchange or Scheduled Execution."""
    if not subject.interfaces:
        yield Found("has neither CoSimulation nor ModelExchange", NAME, "export the model with an interface")


@DESCRIPTION_RULES("interface.identifier", Severity.ERROR)
def identifier(subject: Subject) -> Iterator[Found]:
    """Each interface has a modelIdentifier that can be the name of a C function and of a file."""
    for name, interface in subject.interfaces.items():
        if not re.fullmatch(r"[A-Za-z_]\w*", interface.modelIdentifier or "", re.ASCII):
            yield Found(
                f"modelIdentifier is {interface.modelIdentifier!r}", name, "take letters, digits and underscores"
            )


@DESCRIPTION_RULES("token", Severity.ERROR)
def token(subject: Subject) -> Iterator[Found]:
    """There is a guid (FMI 2.0) or an instantiationToken (FMI 3.0) that tells the binary what it is described by."""
    attribute = "instantiationToken" if subject.fmi == 3 else "guid"
    if not subject.description.guid:
        yield Found(f"{attribute} is missing or empty", NAME, "export the model again")


@DESCRIPTION_RULES("capabilities", Severity.ERROR)
def capabilities(subject: Subject) -> Iterator[Found]:
    """Claimed capabilities go together: who serializes the state can get and set it, orders are not negative."""
    for name, interface in subject.interfaces.items():
        if getattr(interface, "canSerializeFMUstate", False) and not interface.canGetAndSetFMUstate:
            yield Found("claims to serialize a state that it cannot get and set", name, "claim both or none")
        if int(getattr(interface, "maxOutputDerivativeOrder", 0) or 0) < 0:
            yield Found("maxOutputDerivativeOrder is negative", name, "write 0 or leave it out")


@DESCRIPTION_RULES("references.range", Severity.ERROR)
def reference_range(subject: Subject) -> Iterator[Found]:
    """Value references are whole numbers from 0 to 2^32 - 1."""
    for variable in subject.variables:
        if not 0 <= variable.valueReference < _REFERENCES:
            yield Found(f"has the value reference {variable.valueReference}", place(variable), "take another one")


@DESCRIPTION_RULES("references.duplicate", Severity.ERROR)
def duplicate(subject: Subject) -> Iterator[Found]:
    """FMI 2.0 variables with one type and value reference are aliases, so they have one start value."""
    yield from _aliases_that_differ(subject, "start")


@DESCRIPTION_RULES("references.unit", Severity.WARNING)
def alias_unit(subject: Subject) -> Iterator[Found]:
    """FMI 2.0 variables with one type and value reference are aliases, so they have one unit."""
    yield from _aliases_that_differ(subject, "unit")


def _aliases_that_differ(subject: Subject, attribute: str) -> Iterator[Found]:
    first: dict[tuple[str, int], Any] = {}
    for variable in subject.variables if subject.fmi == 2 else ():
        mine = getattr(variable, attribute)
        if mine is None:
            continue
        key = (_FMI2_KINDS.get(variable.type, variable.type), variable.valueReference)
        other = first.setdefault(key, variable)
        others = getattr(other, attribute)
        if mine != others:
            what = f"has the value reference of {other.name}, but the {attribute} {mine}, not {others}"
            yield Found(what, place(variable), "give it a value reference of its own")


def _number(text: str | None) -> float | None:
    try:
        return None if text is None else float(text)
    except ValueError:
        return None


@DESCRIPTION_RULES("names", Severity.WARNING)
def names(subject: Subject) -> Iterator[Found]:
    """Names follow the naming convention: a.b[1].c or der(a.b) if structured, no line breaks or tabs if flat."""
    is_structured = subject.description.variableNamingConvention == "structured"
    for variable in subject.variables:
        is_wrong = not _STRUCTURED.fullmatch(variable.name) if is_structured else re.search(r"[\t\r\n]", variable.name)
        if is_wrong:
            convention = "structured" if is_structured else "flat"
            yield Found(
                f"is no name of the convention {convention}", place(variable), "rename it, or change the convention"
            )


@DESCRIPTION_RULES("start.text", Severity.ERROR)
def start_text(subject: Subject) -> Iterator[Found]:
    """Start values are of their variable's type, and as many as its elements."""
    for variable in subject.variables:
        if variable.start is None or variable.type in ("String", "Binary", "Clock"):
            continue
        tokens = variable.start.split()
        count = math.prod(variable.shape) if variable.shape else 1
        if len(tokens) not in {1, count}:
            yield Found(
                f"has {len(tokens)} start values for {count} elements", place(variable), "give one each, or one"
            )
        if wrong := [token for token in tokens if not _is_of(variable.type, token)]:
            yield Found(f"the start value {wrong[0]!r} is no {variable.type}", place(variable), "write one that is")


def _is_of(kind: str, token: str) -> bool:
    if kind == "Boolean":
        return token in ("true", "false", "0", "1")
    if kind in ("Real", "Float32", "Float64"):
        return _number(token) is not None
    return re.fullmatch(r"[+-]?\d+", token) is not None


@DESCRIPTION_RULES("start.range", Severity.WARNING)
def start_range(subject: Subject) -> Iterator[Found]:
    """Start values lie between min and max, and enumerations start at one of their literals."""
    for variable in subject.variables:
        declared = variable.declaredType
        if variable.start is None or variable.type in ("String", "Binary", "Clock", "Boolean"):
            continue
        values = [number for text in variable.start.split() if (number := _number(text)) is not None]
        low = _number(variable.min or (declared.min if declared else None))
        high = _number(variable.max or (declared.max if declared else None))
        if any((low is not None and value < low) or (high is not None and value > high) for value in values):
            bounds = f"{'-INF' if low is None else f'{low:g}'} to {'INF' if high is None else f'{high:g}'}"
            yield Found(
                f"starts at {variable.start}, outside {bounds}", place(variable), "change the start or the bounds"
            )
        if variable.type == "Enumeration" and declared is not None and declared.items:
            known = {_number(item.value) for item in declared.items}
            if any(value not in known for value in values):
                yield Found(f"starts at {variable.start}, which is no literal", place(variable), "start at a literal")


@DESCRIPTION_RULES("units", Severity.WARNING)
def units(subject: Subject) -> Iterator[Found]:
    """Each unit can be read in FMI's grammar, and its base units, where given, are those it stands for."""
    users: dict[str, list[str]] = {}
    for variable in subject.variables:
        unit = variable.unit or (variable.declaredType.unit if variable.declaredType else None)
        if unit is not None:
            users.setdefault(unit, []).append(variable.name)
    bases = {unit.name: unit.baseUnit for unit in subject.description.unitDefinitions}
    for unit, names in users.items():
        where = f"unit of {shortened(names, 3)}"
        try:
            parsed = parse(unit)
        except InputError as error:
            yield Found(str(error), where, "write the unit as FMI does: N.m, m/s2, kg.m2")
            continue
        base = bases.get(unit)
        if base is None:
            continue
        given = {name: int(power) for name in _BASES if (power := getattr(base, name))}
        meant = {name: power for name, power in parsed.exponents.items() if name != "rad"}
        same_factor = math.isclose(float(base.factor), parsed.factor, rel_tol=1e-9)
        if given != meant or not same_factor:
            yield Found(f"'{unit}' has another base unit than it stands for", where, "correct the BaseUnit or the name")


@DESCRIPTION_RULES("experiment", Severity.WARNING)
def experiment(subject: Subject) -> Iterator[Found]:
    """The default experiment makes sense: numbers, the stop after the start, tolerance and step size above 0."""
    given = subject.description.defaultExperiment
    if given is None:
        return
    texts = {name: getattr(given, name) for name in ("startTime", "stopTime", "tolerance", "stepSize")}
    numbers = {name: _number(text) for name, text in texts.items() if text is not None}
    for name, number in numbers.items():
        if number is None or not math.isfinite(number) or (name in ("tolerance", "stepSize") and number <= 0.0):
            yield Found(f"{name} is {texts[name]}", "DefaultExperiment", "correct it or leave it out")
    start, stop = numbers.get("startTime") or 0.0, numbers.get("stopTime")
    if stop is not None and stop <= start:
        yield Found(f"ends at {stop:g} s, but starts at {start:g} s", "DefaultExperiment", "correct or leave it out")


@DESCRIPTION_RULES("interface.unsupported", Severity.NOTE)
def unsupported(subject: Subject) -> Iterator[Found]:
    """FMI 1.0 and Scheduled Execution are looked at, but not run."""
    if subject.fmi == 1:
        yield Found("is an FMI 1.0 FMU: the check does not run it", NAME, "")
    if "ScheduledExecution" in subject.interfaces:
        yield Found("has a Scheduled Execution interface, which is not run", NAME, "")
