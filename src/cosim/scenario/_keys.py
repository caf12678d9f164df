"""The ``# key: value`` lines of a scenario."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import get_args

from cosim.engine import LEAST_TOLERANCE, Algorithm
from cosim.errors import InputError
from cosim.scenario._faults import EXAMPLE, parse_fault
from cosim.scenario._model import FaultLine, Link, Power, Setting, suggestion
from cosim.units import Unit, convert, parse, quantity

_TIMES = ("stop", "sample_time", "output_interval", "macro_step")
_SINGLE = ("title", "system", "controller", *_TIMES, "tolerance", "algorithm", "extrapolation")
KEYS = (*_SINGLE, "set", "map", "linear", "fault", "power")
_NUMERIC = (*_TIMES, "tolerance", "set", "fault")
OVERRIDES = (*_TIMES, "tolerance", "controller", "system", "algorithm", "extrapolation")

_SECOND = parse("s")
_END_OF_ARROW = re.compile(r"\s*->\s*")


@dataclass(frozen=True)
class _Place:
    """Where a key stands: a line of the file, or an option."""

    file: Path | str
    line: int | None = None

    def fail(self, message: str) -> InputError:
        return InputError(message, file=self.file, line=self.line)


@dataclass
class Keys:
    """What the key lines (and options in their place) say; ``lines`` tells where (``None``: an option)."""

    texts: dict[str, str] = field(default_factory=dict)
    numbers: dict[str, float] = field(default_factory=dict)
    lines: dict[str, int | None] = field(default_factory=dict)
    settings: list[Setting] = field(default_factory=list)
    links: list[Link] = field(default_factory=list)
    linear: list[tuple[str, int | None]] = field(default_factory=list)
    faults: list[FaultLine] = field(default_factory=list)
    powers: list[Power] = field(default_factory=list)


def parse_keys(path: Path, lines: Iterable[tuple[int, str]], plain_decimal: Callable[[str], str] = str) -> Keys:
    """Read the key lines (line number, text without ``#``); ``plain_decimal`` puts points for decimal commas.

    Raises `InputError` for anything that is not a key line or a comment.
    """
    keys = Keys()
    for number, text in lines:
        place = _Place(path, number)
        entry = _split(text, place)
        if entry is not None:
            key, value = entry
            _take(keys, key, plain_decimal(value) if key in _NUMERIC else value, place)
    return keys


def override(keys: Keys, option: str) -> None:
    """Apply ``--set name=value``, which wins over the file; the name is a parameter's or one of `OVERRIDES`."""
    place = _Place("--set")
    name, value = _assignment(option, place)
    if name in OVERRIDES:
        keys.lines.pop(name, None)
        _take(keys, name, value, place)
        return
    keys.settings = [setting for setting in keys.settings if setting.name != name]
    keys.settings.append(Setting(name, value, "--set"))


def _split(text: str, place: _Place) -> tuple[str, str] | None:
    """Split ``key: value``; ``None`` for a comment, which is a ``##`` line or one that cannot be meant as a key."""
    if not text or text.startswith("#"):
        return None
    key, colon, value = (part.strip() for part in text.partition(":"))
    if not colon:
        first = re.split(r"[\s=]", text, maxsplit=1)[0]
        if first.lower() in KEYS or re.fullmatch(r"\w+\s*=.*", text):
            known = first.lower() if first.lower() in KEYS else "key"
            raise place.fail(f"'{text}' has no ':'; write '# {known}: value', or '##' in front of a comment")
        return None
    if key not in KEYS:
        raise place.fail(
            f"unknown key '{key}'{suggestion(key, KEYS)}; keys are {', '.join(KEYS)}; "
            "a comment that has a ':' starts with '##'"
        )
    return key, value


def _take(keys: Keys, key: str, value: str, place: _Place) -> None:
    if key in _SINGLE:
        if key in keys.lines:
            raise place.fail(f"'{key}' is given a second time, first in line {keys.lines[key]}; it can be given once")
        keys.lines[key] = place.line
    if not value and key != "title":
        raise place.fail(f"'{key}' has no value; {_EXPECTED[key]}")
    if key in _TIMES:
        keys.numbers[key] = _time(key, value, place)
    elif key == "tolerance":
        keys.numbers[key] = _tolerance(value, place)
    elif key in _CHOICES:
        if value not in _CHOICES[key]:
            raise place.fail(f"'{key}' is '{value}'{suggestion(value, _CHOICES[key])}; {_EXPECTED[key]}")
        keys.texts[key] = value
    elif key == "set":
        name, given = _assignment(value, place)
        if (first := next((s.line for s in keys.settings if s.name == name), None)) is not None:
            raise place.fail(f"'{name}' is set a second time, first in line {first}")
        keys.settings.append(Setting(name, given, place.file, place.line))
    elif key == "map":
        keys.links.append(Link(*_arrow(value, place), place.line))
    elif key == "fault":
        keys.faults.append(parse_fault(value, place.file, place.line))
    elif key == "power":
        keys.powers.append(_power(value, place))
    elif key == "linear":
        keys.linear += [(name, place.line) for name in re.split(r"[,;\s]+", value) if name]
    else:
        keys.texts[key] = value


_CHOICES = {"algorithm": get_args(Algorithm), "extrapolation": ("0", "1", "2")}

_EXPECTED = {
    "algorithm": f"write one of {', '.join(get_args(Algorithm))}",
    "extrapolation": "write the order of the polynomials, 0, 1 or 2",
    "macro_step": "write a time such as 0.1 ms",
    "system": "write a built-in plant such as linkage, or the path of an .fmu, .ssp or .ssd",
    "controller": "write voltage_profile, another built-in controller, the path of an .fmu, or none",
    "stop": "write a time such as 25 s",
    "sample_time": "write a time such as 20 ms",
    "output_interval": "write a time such as 1 ms",
    "tolerance": "write a number such as 1e-6",
    "set": "write 'set: component.parameter = value', for example 'set: plant.ext_load = 4 N.m'",
    "map": "write 'map: component.output -> component.input', for example 'map: plant.i_motor -> controller.current'",
    "fault": f"write {EXAMPLE}",
    "linear": "write the names of the columns to interpolate, separated by commas",
    "power": "write 'power: component.effort * component.flow', for example 'power: motor.tau * load.w'",
}


def missing(key: str) -> str:
    """Return what to say where a required key is missing."""
    return f"no '# {key}: ...' line; {_EXPECTED[key]}"


def _quantity(key: str, value: str, place: _Place) -> tuple[float, Unit]:
    try:
        return quantity(value)
    except InputError as error:
        raise place.fail(f"'{key}': {error}; {_EXPECTED[key]}") from None


def _time(key: str, value: str, place: _Place) -> float:
    number, unit = _quantity(key, value, place)
    if dict(unit.exponents) != dict(_SECOND.exponents):
        hint = f"write {value} s or {value} ms" if unit.text == "1" else _EXPECTED[key]
        raise place.fail(f"'{key}' is a time, '{value}' is not; {hint}")
    seconds = convert(number, unit, _SECOND)
    if not 0 < seconds < float("inf"):
        raise place.fail(f"'{key}' must be longer than 0 s, found '{value}'")
    return seconds


def _tolerance(value: str, place: _Place) -> float:
    number, unit = _quantity("tolerance", value, place)
    if unit.exponents or not 0 < number * unit.factor < 1:
        raise place.fail(f"'tolerance' must be a number between 0 and 1 without a unit, found '{value}'; write 1e-6")
    if number * unit.factor < LEAST_TOLERANCE:
        raise place.fail(
            f"'tolerance' is {value}; below {LEAST_TOLERANCE:g} rounding errors count for more than those of the "
            f"method; write {LEAST_TOLERANCE:g} or more"
        )
    return number * unit.factor


def _assignment(text: str, place: _Place) -> tuple[str, str]:
    name, equals, value = (part.strip() for part in text.partition("="))
    if not (name and equals and value):
        raise place.fail(f"'{text}' is not 'name = value'; write for example 'plant.ext_load = 4 N.m'")
    return name, value


def _arrow(text: str, place: _Place) -> tuple[tuple[str, str], tuple[str, str]]:
    ends = [tuple(end.partition(".")[::2]) for end in _END_OF_ARROW.split(text)]
    match ends:
        case [(str(a), str(x)), (str(b), str(y))] if a and x and b and y:
            return (a, x), (b, y)
    raise place.fail(f"'{text}' is not a connection; {_EXPECTED['map']}")


def _power(text: str, place: _Place) -> Power:
    plain = text.removeprefix("-")
    ends = [tuple(end.strip().partition(".")[::2]) for end in plain.split("*")]
    match ends:
        case [(str(a), str(x)), (str(b), str(y))] if a and x and b and y:
            return Power((a, x), (b, y), 1.0 if plain == text else -1.0, place.line)
    raise place.fail(f"'{text}' is not a power; {_EXPECTED['power']}")
