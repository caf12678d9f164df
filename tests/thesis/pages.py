"""Compares a page with a fresh one: words to the letter, counts exactly, other numbers within a tolerance."""

from __future__ import annotations

import re

NUMBER = re.compile(r"(?<![\w.])\d+/\d+(?![\w.])|-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")
"""A count such as 9/10, or a number."""
RELATIVE = 0.01
"""Other machines compute the same to solver tolerance; what they round to differs by one of the last place at most."""


def differences(page: str, fresh: str) -> list[str]:
    """Return the lines in which the page differs from the fresh one, with what is to be there."""
    old, new = page.splitlines(), fresh.splitlines()
    found = [f"{a!r} is now {b!r}" for a, b in zip(old, new, strict=False) if not same(a, b)]
    if len(old) != len(new):
        found.append(f"{len(old)} lines are now {len(new)}")
    return found


def same(a: str, b: str) -> bool:
    """Tell whether two lines have the same words and counts, and numbers that agree."""
    if NUMBER.sub("#", a) != NUMBER.sub("#", b):
        return False
    return all(_close(x, y) for x, y in zip(NUMBER.findall(a), NUMBER.findall(b), strict=True))


def _close(a: str, b: str) -> bool:
    if "/" in a or "/" in b:
        return a == b
    x, y = float(a), float(b)
    last = 10.0 ** -len(a.partition("e")[0].partition(".")[2]) * (10.0 ** float(a.partition("e")[2] or 0))
    return abs(x - y) <= max(RELATIVE * abs(x), last) * (1 + 1e-9)
