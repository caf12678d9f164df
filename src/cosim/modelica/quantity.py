"""What is known of the unit of an expression, and how it goes through products, powers and sums.

An angle is a plain number here: ``rad`` takes no part in the dimensions, because w*r is a velocity and a torque over an
angle is still N.m/rad (see docs/units.md for the whole rule).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache

from cosim.errors import InputError
from cosim.units import BASE, Unit, parse

Powers = tuple[tuple[str, Fraction], ...]
"""Exponents that are not zero, sorted by name: of base units, or of variables without unit."""

_LARGEST = 12
"""Beyond this power a unit's factor to SI is not kept."""

OPAQUE = ""
"""Stands among the unknowns for something of which nothing can be found out."""

_NAMES = (
    "1 m s kg A K mol cd N N.m W Pa V Ohm H F C Wb T S m/s m/s2 1/s 1/s2 m2 m3 kg.m2 N/m kg/s N.s/m N.m.s N.s W/s N/s "
    "kg/m3 m3/s V.s2 V/s A/s A2 V2 V/m A/m 1/m W/K J/K W/(m.K) W/(m2.K) J/(kg.K) K/s K/W 1/A 1/V Ohm/s H/s N.m/A2 N2 "
    "Pa.s Pa/s 1/K 1/kg 1/N m/N m/A m/V A/V2 N.m/s N/A"
).split()
"""How a product of units is written if it has no unit of its own; the first that fits."""


@dataclass(frozen=True)
class Quantity:
    """The unit of an expression, as far as it is known."""

    powers: Powers = ()
    """Of the base units, rad left out; without the part that `unknown` stands for."""
    unknown: Powers = ()
    """Variables without unit that are factors, or `OPAQUE`."""
    literal: bool = False
    """Whether a literal is a factor."""
    measured: bool = False
    """Whether a variable with a declared dimension takes part."""
    factor: float | None = 1.0
    """Value in SI over value in this unit; None if a literal may have converted it."""
    offset: float | None = 0.0
    """Zero of the unit in SI, such as 273.15 for degC; None if a literal may have shifted it."""
    text: str | None = None
    """The unit as it was declared, where the expression is one variable, or a sum of such."""
    inferred: frozenset[str] = frozenset()
    """Variables without unit of their own that take part with the unit that follows from other equations."""

    @property
    def free(self) -> bool:
        """Whether this fits any unit: a literal, or a literal times plain numbers and time."""
        return self.literal and not self.measured

    @property
    def known(self) -> bool:
        """Whether nothing is unknown."""
        return not self.unknown

    def __mul__(self, other: Quantity) -> Quantity:
        """The unit of a product."""
        factor = None if self.factor is None or other.factor is None else self.factor * other.factor
        return Quantity(
            _times(self.powers, other.powers),
            _times(self.unknown, other.unknown),
            literal=self.literal or other.literal,
            measured=self.measured or other.measured,
            factor=factor,
            inferred=self.inferred | other.inferred,
        )

    def __truediv__(self, other: Quantity) -> Quantity:
        """The unit of a quotient."""
        return self * other ** Fraction(-1)

    def __pow__(self, exponent: Fraction) -> Quantity:
        """The unit of a power."""
        return replace(
            self,
            powers=tuple((name, power * exponent) for name, power in self.powers if exponent),
            unknown=tuple((name, power * exponent) for name, power in self.unknown if exponent),
            factor=None if self.factor is None or abs(exponent) > _LARGEST else self.factor ** float(exponent),
            offset=0.0,
            text=None,
        )

    def sum(self, other: Quantity, *, minus: bool = False) -> Quantity:
        """The unit of a sum or difference of two that fit."""
        kept, added = (other, self) if self.free or (not self.known and other.known) else (self, other)
        shifted: float | None = None
        if not self.free and not other.free and self.offset is not None and other.offset is not None:
            if minus and self.offset == other.offset:
                shifted = 0.0
            elif other.offset == 0.0 or (self.offset == 0.0 and not minus):
                shifted = self.offset + other.offset
        return replace(
            kept,
            literal=self.literal and other.literal,
            measured=self.measured or other.measured,
            factor=kept.factor if added.free or kept.factor is not None else added.factor,
            offset=shifted,
            inferred=self.inferred | other.inferred,
        )

    def __str__(self) -> str:
        """The unit, as declared or by a usual name."""
        if self.text is not None:
            return self.text
        name = write(self.powers)
        if self.factor is None or math.isclose(self.factor, 1.0, rel_tol=1e-12):
            return name
        return f"{self.factor:g} {name}" if name != "1" else f"multiples of {self.factor:g}"


NUMBER = Quantity(literal=True, factor=None)
"""A literal, or what counts like one: it fits any unit, and is a plain number where it is a factor."""
UNKNOWN = Quantity(unknown=((OPAQUE, Fraction(1)),), factor=None)
"""Something of which nothing is known: it fits any unit, alone and as a factor."""
PLAIN = Quantity()
"""A number without unit that is no literal, such as the value of sin()."""
TIME = Quantity(powers=(("s", Fraction(1)),), text="s")
SECOND = replace(TIME, text=None)


def declared(text: str) -> Quantity | None:
    """The quantity of a variable that is declared with this unit; None if that is not a unit."""
    try:
        unit = parse(text)
    except InputError:
        return None
    powers = _powers(unit)
    return Quantity(powers, measured=bool(powers), factor=unit.factor, offset=unit.offset, text=unit.text)


def difference(a: Quantity, b: Quantity, *, points: bool) -> str | None:
    """None if two known quantities fit; else what to add to their units in the message."""
    if a.powers != b.powers:
        return ""
    if a.text and b.text:
        for one, other in ((a.text, b.text), (b.text, a.text)):
            if _is_angular(one) and _is_frequency(other):
                return ": a factor of 2*pi is missing"
    if a.factor is None or b.factor is None:
        return None
    ratio = max(a.factor / b.factor, b.factor / a.factor)
    if not math.isclose(ratio, 1.0, rel_tol=1e-9):
        return f": a factor of {ratio:.6g} is missing"
    if points and a.offset is not None and b.offset is not None and a.offset != b.offset:
        return f": their zeros differ by {abs(a.offset - b.offset) / a.factor:g} {a}"
    return None


def write(powers: Powers) -> str:
    """The usual name of a unit; else the product of base units, such as ``kg.m2/(s3.K)``."""
    known = _usual_names().get(powers)
    if known is not None:
        return known
    order = {base: position for position, base in enumerate(BASE)}
    factors = sorted(powers, key=lambda item: order[item[0]])
    above = ".".join(_factor(base, power) for base, power in factors if power > 0)
    below = [_factor(base, -power) for base, power in factors if power < 0]
    if not below:
        return above or "1"
    return f"{above or '1'}/{below[0] if len(below) == 1 else '(' + '.'.join(below) + ')'}"


def _is_angular(text: str) -> bool:
    """Whether a unit counts an angle, such as rad/s."""
    return parse(text).exponents.get("rad", 0) > 0


def _is_frequency(text: str) -> bool:
    """Whether a unit counts cycles, such as Hz or kHz."""
    return text.strip().endswith("Hz")


def _factor(base: str, power: Fraction) -> str:
    if power == 1:
        return base
    return f"{base}{power}" if power.denominator == 1 else f"{base}^({power})"


@lru_cache(maxsize=1)
def _usual_names() -> Mapping[Powers, str]:
    names: dict[Powers, str] = {}
    for name in _NAMES:
        names.setdefault(_powers(parse(name)), name)
    return names


def _powers(unit: Unit) -> Powers:
    return tuple(sorted((base, Fraction(power)) for base, power in unit.exponents.items() if base != "rad"))


def _times(a: Powers, b: Powers) -> Powers:
    if not a or not b:
        return a or b
    total = dict(a)
    for name, power in b:
        total[name] = total.get(name, Fraction(0)) + power
    # what is opaque stays so: two unknown units need not be the same
    return tuple(sorted((name, power) for name, power in total.items() if power or name == OPAQUE))
