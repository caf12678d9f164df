"""Units of measurement as FMUs write them: parse, compare, convert.

The grammar is that of FMI and Modelica: symbols with an optional prefix and a bare exponent, joined by ``.`` and at
most one ``/`` (``kg.m2``, ``m/s2``, ``V.s/rad``, ``W/(m2.K)``). ``rad`` is a base dimension here, as it is in FMI's
``BaseUnit``: it tells an angular speed in rad/s from a frequency in Hz. A torque is N.m without rad.

Names that are not listed here are looked up with pint, which is imported only then.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from types import MappingProxyType

from cosim.errors import InputError

BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")

ACCEPTED = (
    "accepted are SI symbols with prefixes and bare exponents, joined by '.' and '/', such as "
    "N.m, kg.m2, rad/s, V.s/rad, m/s2, Ohm, ms, deg, rpm, degC, % or 1 for a plain number"
)


@dataclass(frozen=True)
class Unit:
    """A unit of measurement: ``value_in_SI = factor * value + offset``.

    ``text`` is the unit as written, ``exponents`` the power of each base unit of `BASE` that is not zero.
    """

    text: str
    factor: float
    offset: float
    exponents: Mapping[str, int] = field(hash=False)

    def __str__(self) -> str:
        """Return the unit as written."""
        return self.text


_PREFIXES = {
    "Y": 1e24, "Z": 1e21, "E": 1e18, "P": 1e15, "T": 1e12, "G": 1e9, "M": 1e6, "k": 1e3, "h": 1e2, "da": 1e1,
    "d": 1e-1, "c": 1e-2, "m": 1e-3, "u": 1e-6, "\u00b5": 1e-6, "\u03bc": 1e-6, "n": 1e-9, "p": 1e-12, "f": 1e-15,
    "a": 1e-18, "z": 1e-21, "y": 1e-24,
}  # fmt: skip

# symbol: factor to SI, exponents. These take prefixes.
_SCALABLE: dict[str, tuple[float, dict[str, int]]] = {
    "g": (1e-3, {"kg": 1}),
    "m": (1.0, {"m": 1}),
    "s": (1.0, {"s": 1}),
    "A": (1.0, {"A": 1}),
    "K": (1.0, {"K": 1}),
    "mol": (1.0, {"mol": 1}),
    "cd": (1.0, {"cd": 1}),
    "rad": (1.0, {"rad": 1}),
    "sr": (1.0, {"rad": 2}),
    "Hz": (1.0, {"s": -1}),
    "Bq": (1.0, {"s": -1}),
    "N": (1.0, {"kg": 1, "m": 1, "s": -2}),
    "Nm": (1.0, {"kg": 1, "m": 2, "s": -2}),
    "Pa": (1.0, {"kg": 1, "m": -1, "s": -2}),
    "bar": (1e5, {"kg": 1, "m": -1, "s": -2}),
    "J": (1.0, {"kg": 1, "m": 2, "s": -2}),
    "Wh": (3600.0, {"kg": 1, "m": 2, "s": -2}),
    "eV": (1.602176634e-19, {"kg": 1, "m": 2, "s": -2}),
    "W": (1.0, {"kg": 1, "m": 2, "s": -3}),
    "var": (1.0, {"kg": 1, "m": 2, "s": -3}),
    "VA": (1.0, {"kg": 1, "m": 2, "s": -3}),
    "C": (1.0, {"A": 1, "s": 1}),
    "Ah": (3600.0, {"A": 1, "s": 1}),
    "V": (1.0, {"kg": 1, "m": 2, "s": -3, "A": -1}),
    "Ohm": (1.0, {"kg": 1, "m": 2, "s": -3, "A": -2}),
    "ohm": (1.0, {"kg": 1, "m": 2, "s": -3, "A": -2}),
    "S": (1.0, {"kg": -1, "m": -2, "s": 3, "A": 2}),
    "F": (1.0, {"kg": -1, "m": -2, "s": 4, "A": 2}),
    "H": (1.0, {"kg": 1, "m": 2, "s": -2, "A": -2}),
    "Wb": (1.0, {"kg": 1, "m": 2, "s": -2, "A": -1}),
    "T": (1.0, {"kg": 1, "s": -2, "A": -1}),
    "lm": (1.0, {"cd": 1, "rad": 2}),
    "lx": (1.0, {"cd": 1, "rad": 2, "m": -2}),
    "l": (1e-3, {"m": 3}),
    "L": (1e-3, {"m": 3}),
    "t": (1e3, {"kg": 1}),
}

# These do not: "min" is a minute, not a milli-inch.
_FIXED: dict[str, tuple[float, dict[str, int]]] = {
    "%": (1e-2, {}),
    "ppm": (1e-6, {}),
    "min": (60.0, {"s": 1}),
    "h": (3600.0, {"s": 1}),
    "d": (86400.0, {"s": 1}),
    "deg": (math.pi / 180, {"rad": 1}),
    "rev": (2 * math.pi, {"rad": 1}),
    "rpm": (2 * math.pi / 60, {"rad": 1, "s": -1}),
    "degC": (1.0, {"K": 1}),
    "degF": (5 / 9, {"K": 1}),
}
_OFFSETS = {"degC": 273.15, "degF": 459.67 * 5 / 9}

_SPELLINGS = str.maketrans({"\u03a9": "Ohm", "\u2126": "Ohm", "°": "deg", "·": ".", "⋅": ".", "*": ".", "⁻": "-"})
_SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹", "0123456789")
_FACTOR = re.compile(r"([^\W\d]+|%)(?:\^?([+-]?\d{1,2}))?")
_MOST_PARENTHESES = 8
_QUANTITY = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?)(?![\d.,_])\s*(.*)", re.DOTALL | re.ASCII)


@lru_cache(maxsize=1024)
def parse(text: str) -> Unit:
    """Read a unit such as ``N.m`` or ``rad/s``.

    Raises `InputError`, saying what is accepted, if ``text`` is not a unit.
    """
    plain = text.strip().replace("**", "^").translate(_SPELLINGS).translate(_SUPERSCRIPTS)
    if plain == "-":  # engineers' sign for a plain number
        plain = "1"
    if plain in _OFFSETS:
        factor, exponents = _FIXED[plain]
        return Unit(text.strip(), factor, _OFFSETS[plain], MappingProxyType(exponents))
    factor, offset, powers = _expression(plain, text, alone=True)
    if not (0 < factor < math.inf):
        raise _refusal(text)
    ordered = {base: powers[base] for base in BASE if powers.get(base)}
    return Unit(text.strip(), factor, offset, MappingProxyType(ordered))


def compatible(a: Unit, b: Unit) -> bool:
    """Whether values in ``a`` can be converted to ``b``: the same power of every base unit, rad included."""
    return dict(a.exponents) == dict(b.exponents)


def linear_map(source: Unit, target: Unit) -> tuple[float, float]:
    """Factor and offset that take a value in ``source`` to one in ``target``; `InputError` if incompatible."""
    if not compatible(source, target):
        raise InputError(f"cannot convert {source} to {target}: {_difference(source, target)}")
    return source.factor / target.factor, (source.offset - target.offset) / target.factor


def convert(value: float, source: Unit, target: Unit) -> float:
    """Convert ``value`` from ``source`` to ``target``; raises `InputError` if they are not compatible."""
    factor, offset = linear_map(source, target)
    # 35 / 1000 is 0.035, 35 * 0.001 is not: dividing keeps decimal numbers such as sample times as they were written.
    scaled = value * factor if factor >= 1 else value / (target.factor / source.factor)
    return scaled + offset if offset else scaled


def quantity(text: str) -> tuple[float, Unit]:
    """Read a number with its unit, such as ``20 ms`` or ``-3.5e-2 N.m``; a bare number has the unit ``1``.

    Raises `InputError` if the number is not a plain finite decimal or the unit is not one.
    """
    match = _QUANTITY.fullmatch(text.strip())
    if match is None or not math.isfinite(value := float(match[1])):
        raise InputError(f"'{text.strip()}' is not a number with a unit; write it like 20 ms or 4.5 N.m")
    return value, parse(match[2] or "1")


def _refusal(text: str, detail: str = "") -> InputError:
    return InputError(f"'{text.strip()}' is not a unit{detail}; {ACCEPTED}")


def _difference(source: Unit, target: Unit) -> str:
    """Why two units do not fit, in base units."""
    reason = f"{_in_base_units(source)} against {_in_base_units(target)}"
    rest = [{base: power for base, power in unit.exponents.items() if base != "rad"} for unit in (source, target)]
    return f"{reason}, they differ in rad only" if rest[0] == rest[1] else reason


def _in_base_units(unit: Unit) -> str:
    return ".".join(f"{base}{'' if power == 1 else power}" for base, power in unit.exponents.items()) or "1"


def _expression(plain: str, text: str, *, alone: bool) -> tuple[float, float, dict[str, int]]:
    """Factor, offset and exponents of a product or a quotient of two, each of which may be one in parentheses."""
    above, *below = _split_at_division(plain, text)
    factor, offset, powers = _operand(above, text, alone=alone and not below)
    if below:
        divisor, _, lower = _operand(below[0], text, alone=False)
        factor = factor / divisor if divisor else math.inf
        powers = {base: powers.get(base, 0) - lower.get(base, 0) for base in BASE}
    return factor, offset, powers


def _operand(plain: str, text: str, *, alone: bool) -> tuple[float, float, dict[str, int]]:
    if plain.startswith("(") and plain.endswith(")") and plain.count("(") <= _MOST_PARENTHESES:
        return _expression(plain[1:-1].strip(), text, alone=False)
    return _product(plain, text, alone=alone)


def _split_at_division(plain: str, text: str) -> list[str]:
    """Split at the one ``/`` outside parentheses; more, or a product below it without any, would be ambiguous."""
    parts, depth = [""], 0
    for character in plain:
        depth += (character == "(") - (character == ")")
        if character == "/" and depth == 0:
            parts.append("")
        else:
            parts[-1] += character
    parts = [part.strip() for part in parts]
    if len(parts) > 2:
        raise _refusal(text, f" (more than one '/': write {parts[0]}/({'.'.join(parts[1:])}))")
    if len(parts) == 2 and not parts[1].startswith("(") and re.search(r"[.\s]", parts[1]):
        product = ".".join(re.split(r"[.\s]+", parts[1]))
        raise _refusal(text, f" (a product after '/' is ambiguous: write {parts[0]}/({product}))")
    return parts


def _product(plain: str, text: str, *, alone: bool) -> tuple[float, float, dict[str, int]]:
    """Factor, offset and exponents of a product of symbols; the offset counts only where a symbol stands alone."""
    if plain == "1":
        return 1.0, 0.0, {}
    total, offset, powers = 1.0, 0.0, dict[str, int]()
    symbols = re.split(r"\s*\.\s*|\s+", plain)
    for symbol in symbols:
        match = _FACTOR.fullmatch(symbol)
        if match is None:
            raise _refusal(text)
        power = int(match[2] or 1)
        factor, shift, exponents = _symbol(match[1], text)
        try:
            total *= factor**power
        except (OverflowError, ZeroDivisionError):
            raise _refusal(text) from None
        offset = shift if alone and power == 1 and len(symbols) == 1 else 0.0
        for base, exponent in exponents.items():
            powers[base] = powers.get(base, 0) + exponent * power
    return total, offset, powers


def _symbol(name: str, text: str) -> tuple[float, float, dict[str, int]]:
    """Factor, offset and exponents of one symbol with or without a prefix."""
    known = _FIXED.get(name) or _SCALABLE.get(name)
    if known is not None:
        return known[0], _OFFSETS.get(name, 0.0), known[1]
    for length in (1, 2):
        scalable = _SCALABLE.get(name[length:])
        if name[:length] in _PREFIXES and scalable is not None:
            return _PREFIXES[name[:length]] * scalable[0], 0.0, scalable[1]
    return _ask_pint(name, text)


_PINT_BASE = {
    "kilogram": "kg", "meter": "m", "second": "s", "ampere": "A", "kelvin": "K", "mole": "mol", "candela": "cd",
    "radian": "rad",
}  # fmt: skip


def _ask_pint(name: str, text: str) -> tuple[float, float, dict[str, int]]:
    """Look a name up in pint: ``lbf``, ``inch``, ``psi``, ... ."""
    import pint

    registry: pint.UnitRegistry[float] = pint.UnitRegistry()
    try:
        if name not in registry:
            raise _refusal(text)
        at_zero, at_one, at_two = (registry.Quantity(x, name).to_base_units() for x in (0.0, 1.0, 2.0))
    except (pint.errors.PintError, AttributeError, TypeError, ValueError, ArithmeticError) as error:
        raise _refusal(text) from error
    factor = float(at_one.magnitude - at_zero.magnitude)
    if not math.isclose(float(at_two.magnitude - at_one.magnitude), factor, rel_tol=1e-9):
        raise _refusal(text, " that scales linearly")
    exponents = dict[str, int]()
    for base, exponent in at_one.unit_items():
        power = float(str(exponent))
        if base not in _PINT_BASE or not power.is_integer():
            raise _refusal(text)
        exponents[_PINT_BASE[base]] = int(power)
    return factor, float(at_zero.magnitude), exponents
