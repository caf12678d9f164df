"""A seeded hand on the load: pulses of braking and accelerating torque, as rows of a scenario's ``tau_disturbance``.

The source's disturbance is made "by braking or accelerating the load manually", periodically (4.2.4, 4.3); size, length
and spacing are not given. Here the pulses take turns, braking first, and each one's size, length and distance to the
next vary evenly around what is asked for. The numbers come from the generator of the model library
(``WiperDrive.Electronics.draw``: P. L'Ecuyer, Communications of the ACM 31 (1988) 742-749), in whole numbers, so that a
seed means the same pulses everywhere.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from cosim.errors import InputError
from cosim.tabular import load

HEADER = "time [s],tau_disturbance [N.m]"


@dataclass(frozen=True)
class Pulses:
    """What the pulses are like; the defaults are assumed."""

    size: float = 5.0
    """Mean torque of a pulse [N.m]; braking pulses get a minus."""
    length: float = 0.3
    """Mean duration of a pulse [s]."""
    spacing: float = 3.0
    """Mean time from the start of a pulse to that of the next, and from 0 to the first [s]."""
    variation: float = 0.2
    """By how much of itself each of these may be off, either way: 0 .. 1."""
    seed: int = 1
    """Begin of the random numbers, from 0 on."""

    def __post_init__(self) -> None:
        """Refuse what makes no pulses, or pulses that would meet."""
        for name, unit in (("size", "N.m"), ("length", "s"), ("spacing", "s")):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise InputError(f"the pulses' {name} is {value:g} {unit}; give a positive one")
        if not 0 <= self.variation < 1:
            raise InputError(
                f"the pulses' variation is {self.variation:g}; give a number from 0 up to, not including, 1"
            )
        if self.seed < 0:
            raise InputError(f"the seed is {self.seed}; give a whole number from 0 on")
        longest, shortest = self.length * (1 + self.variation), self.spacing * (1 - self.variation)
        if longest >= shortest:
            raise InputError(
                f"a pulse may last {longest:g} s, but the next may start after {shortest:g} s; "
                "make the pulses shorter, their spacing larger or their variation smaller"
            )


def numbers(seed: int) -> Iterator[float]:
    """Endless random numbers, evenly distributed between 0 and 1: those of ``WiperDrive.Electronics.draw``."""
    x = 1 + (69069 * seed + 12345) % 2147483562
    y = 1 + (1664525 * seed + 67890) % 2147483398
    while True:
        x, y = 40014 * x % 2147483563, 40692 * y % 2147483399
        yield (x - y if x > y else x - y + 2147483562) / 2147483563


def rows(pulses: Pulses, stop: float) -> list[tuple[float, float]]:
    """(time [s], torque [N.m]) from which each torque holds: a pulse and its end by turns, none after ``stop`` [s].

    Times are whole milliseconds, torques whole hundredths of a newton metre.
    """
    random = numbers(pulses.seed)

    def varied(mean: float) -> float:
        return mean * (1 + pulses.variation * (2 * next(random) - 1))

    found = [(0.0, 0.0)]
    start, sign = 0.0, -1.0
    while True:
        start += varied(pulses.spacing)
        size, length = varied(pulses.size), varied(pulses.length)
        if round(start, 3) >= stop:
            return found
        found.append((round(start, 3), round(sign * size, 2)))
        if round(start + length, 3) < stop:
            found.append((round(start + length, 3), 0.0))
        sign = -sign


def text(pulses: Pulses, stop: float, base: Path | None = None) -> str:
    """A scenario file, or without ``base`` its table alone: the key lines of ``base``, then the pulses.

    Raises:
        InputError: ``base`` has a table already, which these rows would have to be woven into.
    """
    lines = [] if base is None else _key_lines(base)
    lines.append(
        f"## Pulses of {pulses.size:g} N.m for {pulses.length:g} s every {pulses.spacing:g} s, "
        f"each varied by {100 * pulses.variation:g} %, seed {pulses.seed}."
    )
    lines.append(HEADER)
    lines += [f"{time!r},{torque!r}".replace(".0,", ",").removesuffix(".0") for time, torque in rows(pulses, stop)]
    return "\n".join(lines) + "\n"


def _key_lines(base: Path) -> list[str]:
    table = load(base)
    if table.rows or len(table.header) > 1:
        raise InputError(
            "the base scenario has channels or rows of its own; give one whose table is the header 'time [s]' alone",
            file=base,
            line=table.header_line,
        )
    content = base.read_text(encoding="utf-8-sig").splitlines()
    return [line for line in content[: table.header_line - 1] if line.strip()]
