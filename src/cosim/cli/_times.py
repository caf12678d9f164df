"""Times as options give them."""

from __future__ import annotations

from cosim.errors import InputError


def time_of(option: str, text: str) -> float:
    """The time [s] that an option gives, such as "60 s"; `InputError` for anything but a time above 0."""
    from cosim.units import compatible, convert, parse, quantity

    second = parse("s")
    try:
        number, unit = quantity(text)
        fits = compatible(unit, second) and number > 0.0
    except InputError:
        fits = False
    if not fits:
        raise InputError(f"{option} {text}: write a time above 0, such as '60 s' or '5 min'")
    return convert(number, unit, second)
