"""Finds runs of array elements that are computed alike, so that they become a loop in C instead of a page of lines.

Elements k and k + 1 are alike if their expressions have the same operations, and each leaf is the same expression, the
next element of the same array, or the next number of an arithmetic progression.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from cosim.dae.hybrid import SX
from cosim.fmu.c_expressions import BINARY, UNARY, number

SHORTEST = 16
"""Runs with fewer elements stay straight-line code."""

Place = tuple[str, int]
"""C array and index of a symbol."""


@dataclass(frozen=True)
class Shared:
    """A leaf that is the same for all elements of a run."""

    expression: SX


@dataclass(frozen=True)
class Element:
    """A leaf that is element ``first + k`` of an array."""

    array: str
    first: int


@dataclass(frozen=True)
class Progression:
    """A leaf that is the number ``first + k * step``."""

    first: float
    step: float


@dataclass(frozen=True)
class Operation:
    """An inner node."""

    code: int
    operands: tuple[Pattern, ...]


Pattern = Shared | Element | Progression | Operation


@dataclass(frozen=True)
class Run:
    """``count`` elements from ``start`` on that follow one pattern."""

    start: int
    count: int
    pattern: Pattern


def find_runs(values: Sequence[SX], places: Mapping[str, Place]) -> list[Run]:
    """The runs among the scalar expressions ``values``, in order, each as long as can be.

    Args:
        values: the expressions of consecutive array elements.
        places: where the value of a symbol is found in C, by its name.
    """
    runs: list[Run] = []
    start = 0
    while start + SHORTEST <= len(values):
        pattern = _pattern(values[start], values[start + 1], places)
        count = 1
        if pattern is not None:
            while start + count < len(values) and _matches(pattern, values[start + count], count, places):
                count += 1
        if pattern is not None and count >= SHORTEST:
            runs.append(Run(start, count, pattern))
            start += count
        else:
            start += 1
    return runs


def shared(pattern: Pattern) -> list[SX]:
    """The expressions a loop needs computed before it."""
    match pattern:
        case Shared(expression=expression):
            return [] if expression.is_constant() else [expression]
        case Operation(operands=operands):
            found: dict[int, SX] = {}
            for operand in operands:
                found |= {e.element_hash(): e for e in shared(operand)}
            return list(found.values())
    return []


def c_expression(pattern: Pattern, names: Mapping[int, str]) -> str:
    """The C text of an element, with ``k`` as the loop's index.

    Args:
        pattern: what to print.
        names: C names of the shared expressions, by ``element_hash``.
    """
    match pattern:
        case Shared(expression=expression):
            if expression.is_constant():
                return number(float(expression))
            return names[expression.element_hash()]
        case Element(array=array, first=first):
            return f"{array}[{first} + k]" if first else f"{array}[k]"
        case Progression(first=first, step=step):
            return f"({number(first)} + {number(step)} * k)"
        case Operation(code=code, operands=operands):
            template = BINARY.get(code) or UNARY[code]
            return f"({template.format(*(c_expression(operand, names) for operand in operands))})"


def _pattern(a: SX, b: SX, places: Mapping[str, Place]) -> Pattern | None:
    if a.element_hash() == b.element_hash():
        return Shared(a)
    if a.is_constant() and b.is_constant():
        first, second = float(a), float(b)
        return Shared(a) if first == second else Progression(first, second - first)
    if a.is_symbolic() and b.is_symbolic():
        here, there = places.get(a.name()), places.get(b.name())
        if here is not None and there == (here[0], here[1] + 1):
            return Element(*here)
        return None
    if a.is_leaf() or b.is_leaf() or a.op() != b.op() or not (a.op() in BINARY or a.op() in UNARY):
        return None
    operands = tuple(_pattern(a.dep(i), b.dep(i), places) for i in range(a.n_dep()))
    if any(operand is None for operand in operands):
        return None
    return Operation(a.op(), tuple(operand for operand in operands if operand is not None))


def _matches(pattern: Pattern, value: SX, k: int, places: Mapping[str, Place]) -> bool:
    match pattern:
        case Shared(expression=expression):
            same = value.element_hash() == expression.element_hash()
            return same or (expression.is_constant() and value.is_constant() and float(value) == float(expression))
        case Element(array=array, first=first):
            return value.is_symbolic() and places.get(value.name()) == (array, first + k)
        case Progression(first=first, step=step):
            return value.is_constant() and float(value) == first + step * k
        case Operation(code=code, operands=operands):
            return (
                not value.is_leaf()
                and value.op() == code
                and all(_matches(operand, value.dep(i), k, places) for i, operand in enumerate(operands))
            )
