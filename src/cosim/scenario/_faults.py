"""The ``fault`` lines of a scenario: ``controller.i_motor bias 0.5 A from 2 s to 5 s``.

A line is the name of an input, a kind, what it takes, and in any order ``from TIME``, ``to TIME`` and, for ``drop`` and
``noise``, ``seed NUMBER`` and ``every TIME``. An amount has a unit as everywhere; that of a difference (bias, noise,
quantise) counts without the zero of its scale, so that 5 degC are 5 K.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path

from cosim.engine import (
    FAULT_KINDS,
    FAULTS_FOR_ALL_TYPES,
    RANDOM_FAULTS,
    Component,
    Connection,
    Fault,
    FaultKind,
    Variable,
)
from cosim.errors import InputError
from cosim.scenario._model import FaultLine, Scenario, suggestion
from cosim.scenario._names import End, dotted, resolve
from cosim.scenario._values import difference, parameter_value
from cosim.units import convert, parse, quantity

EXAMPLE = (
    "'fault: INPUT KIND AMOUNT from TIME to TIME', for example 'fault: controller.i_motor bias 0.5 A from 2 s to 5 s'"
)

_SECOND = parse("s")
_AMOUNTS: dict[FaultKind, str] = {
    "override": "a value, such as 'override 2.5 A' or 'override 1'",
    "bias": "what it adds, such as 'bias 0.5 A'",
    "scale": "a factor, such as 'scale 1.1' or 'scale 90 %'",
    "delay": "a time, such as 'delay 5 ms'",
    "drop": "a probability, such as 'drop 30 %'",
    "quantise": "a step, such as 'quantise 0.1 A'",
    "noise": "a standard deviation, such as 'noise 0.2 A'",
}
_OPTIONS = ("from", "to", "seed", "every")
_LINE = re.compile(rf"(?P<name>.+?)\s+(?P<kind>{'|'.join(FAULT_KINDS)})(?:\s+(?P<rest>.*))?", re.DOTALL)
_OPTION = re.compile(rf"(?:^|\s)({'|'.join(_OPTIONS)})(?=\s|$)")
_MOST_SEED = 2**63


def parse_fault(text: str, file: Path | str, line: int | None) -> FaultLine:
    """Read a line. Raises `InputError`, with this place, for anything that is none."""
    try:
        return _parsed(text.strip(), file, line)
    except InputError as error:
        raise InputError(str(error), file=file, line=line) from None


def _parsed(text: str, file: Path | str, line: int | None) -> FaultLine:
    match = _LINE.fullmatch(text)
    if match is None:
        raise InputError(_why_no_line(text))
    kind = next(known for known in FAULT_KINDS if known == match["kind"])
    amount, *rest = (part.strip() for part in _OPTION.split(match["rest"] or ""))
    options: dict[str, str] = {}
    for option, value in zip(rest[::2], rest[1::2], strict=True):
        if option in options:
            raise InputError(f"'{option}' is given a second time; it can be given once")
        if not value:
            raise InputError(f"'{option}' has no value; write for example '{_example(option)}'")
        options[option] = value
    for option in ("seed", "every"):
        if option in options and kind not in RANDOM_FAULTS:
            raise InputError(f"'{kind}' takes no '{option}'; only {' and '.join(RANDOM_FAULTS)} do")
    if kind == "freeze" and amount:
        raise InputError(f"'freeze' takes no amount, found '{amount}'; the input keeps the value that it has")
    if kind != "freeze" and not amount:
        raise InputError(f"'{kind}' needs {_AMOUNTS[kind]}")
    start = _time(options["from"], "from") if "from" in options else 0.0
    stop = _time(options["to"], "to") if "to" in options else math.inf
    if stop <= start:
        raise InputError(f"it ends at {stop:g} s, but begins at {start:g} s; 'to' must be after 'from'")
    every = _time(options["every"], "every") if "every" in options else None
    seed = _seed(options["seed"]) if "seed" in options else None
    return FaultLine(match["name"], kind, amount, start, stop, every, seed, file, line)


def _why_no_line(text: str) -> str:
    words = text.split()
    if not words:
        return f"it is empty; write {EXAMPLE}"
    if words[0] in FAULT_KINDS:
        return f"'{text}' names no input; write {EXAMPLE}"
    if len(words) == 1:
        return f"'{text}' has no kind; write {EXAMPLE}"
    near = suggestion(words[1], FAULT_KINDS)
    return f"'{text}' has no kind that is known{near}; kinds are {', '.join(FAULT_KINDS)}"


def _example(option: str) -> str:
    return {"seed": "seed 1", "every": "every 1 ms", "delay": "delay 5 ms"}.get(option, f"{option} 2 s")


def _time(text: str, what: str) -> float:
    try:
        number, unit = quantity(text)
    except InputError as error:
        raise InputError(f"'{what}': {error}") from None
    if dict(unit.exponents) != dict(_SECOND.exponents):
        remedy = f"write {text} s or {text} ms" if unit.text == "1" else f"write for example '{_example(what)}'"
        raise InputError(f"'{what}' is a time, '{text}' is not; {remedy}")
    seconds = convert(number, unit, _SECOND)
    if not 0.0 <= seconds < math.inf:
        raise InputError(f"'{what}' is {text}; a simulation starts at 0 s")
    return seconds


def _seed(text: str) -> int:
    if not re.fullmatch(r"\d{1,19}", text, re.ASCII) or int(text) >= _MOST_SEED:
        raise InputError(f"'seed' is '{text}'; it must be a whole number from 0 on, such as 'seed 1'")
    return int(text)


def assemble_faults(
    scenario: Scenario, components: Sequence[Component], connections: Sequence[Connection]
) -> list[Fault]:
    """Return the faults of a scenario, in the FMUs' units. Raises `InputError` for what does not fit the FMUs."""
    faults: list[Fault] = []
    for line in scenario.faults:
        try:
            end, variable = _target(line.name, components, connections)
            seed = Fault.seed if line.seed is None else line.seed
            fault = Fault(end, line.kind, _amount(line, end, variable), line.start, line.stop, line.every, seed)
            fault.check(variable)
        except InputError as error:
            raise InputError(str(error), file=line.file, line=line.line) from error
        faults.append(fault)
    return faults


def _target(name: str, components: Sequence[Component], connections: Sequence[Connection]) -> tuple[End, Variable]:
    try:
        return resolve(name, components, "input", "input")
    except InputError:
        fed = [dotted(c.target) for c in connections if name in (dotted(c.source), c.source[1])]
        if fed:
            raise InputError(
                f"'{name}' is an output; a fault is done to an input, such as {' or '.join(fed)}, which it drives"
            ) from None
        raise


def _amount(line: FaultLine, end: End, variable: Variable) -> float:
    """Return the amount in the unit that the engine takes it in."""
    kind, name, text = line.kind, dotted(end), line.amount
    if kind == "freeze":
        return 0.0
    if kind == "delay":
        return _time(text, kind)
    if kind in ("scale", "drop"):
        return _ratio(text, kind)
    if variable.type != "Real" and kind not in FAULTS_FOR_ALL_TYPES:
        raise InputError(
            f"'{kind}' needs a Real, '{name}' is a {variable.type}; it takes {', '.join(FAULTS_FOR_ALL_TYPES)}"
        )
    if kind != "override":
        return difference(text, name, variable)
    value = parameter_value(text, name, variable)
    if isinstance(value, str):
        raise InputError(f"'{name}' is a {variable.type}; a fault changes numbers only")
    return float(value)


def _ratio(text: str, kind: FaultKind) -> float:
    try:
        number, unit = quantity(text)
    except InputError as error:
        raise InputError(f"'{kind}': {error}") from None
    if unit.exponents or unit.offset:
        raise InputError(f"'{kind}' takes {_AMOUNTS[kind]}, not '{text}'")
    return number * unit.factor


def fault_line(fault: Fault, variable: Variable) -> str:
    """Return what a scenario says for a fault: the same numbers, to the bit, in the unit of the FMU."""
    parts = [dotted(fault.target), fault.kind]
    if fault.kind == "delay":
        parts.append(f"{fault.amount!r} s")
    elif fault.kind in ("scale", "drop"):
        parts.append(repr(fault.amount))
    elif variable.type != "Real" and fault.kind == "override":
        parts.append(str(int(fault.amount)))
    elif fault.kind != "freeze":
        parts.append(f"{fault.amount!r} {_known_unit(variable)}".strip())
    if fault.kind in RANDOM_FAULTS:
        parts.append(f"seed {fault.seed}")
        parts += [] if fault.every is None else [f"every {fault.every!r} s"]
    parts += [f"from {fault.start!r} s"] if fault.start > 0.0 else []
    parts += [f"to {fault.stop!r} s"] if fault.stop < math.inf else []
    return " ".join(parts)


def _known_unit(variable: Variable) -> str:
    """Return the FMU's unit; nothing if only its maker understands it, as numbers are taken then."""
    try:
        return variable.unit if variable.unit is not None and parse(variable.unit) else ""
    except InputError:
        return ""
