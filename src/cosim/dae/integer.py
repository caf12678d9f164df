"""Finds what equations with integer coefficients say of states alone, which counting variables does not show.

Kirchhoff's laws add up: a coil into a dead end, or two capacitors side by side between other elements, make an equation
between states that shows only after algebraic variables have cancelled. Pantelides' algorithm looks at which variables
stand in which equation and does not see it. So the equations whose coefficients are integers are brought to echelon
form exactly, algebraic variables first. The idea is that of M. Otter, H. Elmqvist, Transformation of Differential
Algebraic Array Equations to Index One Form, Modelica Conference 2017.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeVar

import casadi as ca

from cosim.dae.hybrid import SX, Equation
from cosim.dae.symbolic import is_arithmetic

_LARGEST = 1000
_Key = TypeVar("_Key", str, int)


@dataclass
class _Row:
    """Coefficients by symbol name, and of the given equations that it is the sum of."""

    terms: dict[str, Fraction]
    origin: dict[int, Fraction]


@dataclass(frozen=True)
class Found:
    """What :func:`cancel` finds."""

    replaced: dict[int, Equation]
    """Equations by the position of those whose place they take."""
    repeated: list[int]
    """Positions of equations that add up to nothing."""


def cancel(equations: Sequence[Equation], is_algebraic: Callable[[str], bool]) -> Found:
    """Look for sums of equations in which all algebraic variables cancel.

    Args:
        equations: all equations.
        is_algebraic: whether a symbol is an unknown that is not a state (or a lower derivative).
    """
    symbols: dict[str, SX] = {}
    rows: list[tuple[int, _Row]] = []
    for position, equation in enumerate(equations):
        terms = _integer_terms(equation.residual, symbols)
        if terms is not None:
            rows.append((position, _Row(terms, {position: Fraction(1)})))
    pivots: dict[str, _Row] = {}
    replaced: dict[int, Equation] = {}
    repeated: list[int] = []
    # sparse ones first: they are left as they are
    for position, row in sorted(rows, key=lambda item: (len(item[1].terms), item[0])):
        began_algebraic = any(is_algebraic(name) for name in row.terms)
        while (name := next((n for n in row.terms if is_algebraic(n) and n in pivots), None)) is not None:
            _subtract(row, pivots[name], name)
        own = next((n for n in row.terms if is_algebraic(n)), None)
        if own is not None:
            pivots[own] = row
        elif not row.terms:
            repeated = repeated or sorted(row.origin)
        elif began_algebraic:
            replaced[position] = _equation(row, symbols, equations[position].at)
    return Found(replaced, repeated)


def _integer_terms(residual: SX, symbols: dict[str, SX]) -> dict[str, Fraction] | None:
    """The coefficients of a sum of symbols, or ``None`` if the residual is anything else."""
    involved = ca.symvar(residual)
    if not involved:
        return None
    unknown = ca.vertcat(*involved)
    jacobian = ca.jacobian(residual, unknown)
    if not jacobian.is_constant() or not is_arithmetic(residual):
        return None
    if not ca.simplify(ca.substitute(residual, unknown, ca.DM.zeros(len(involved)))).is_zero():
        return None
    coefficients = ca.DM(ca.densify(jacobian)).full().ravel().tolist()
    if not all(abs(c) <= _LARGEST and c == int(c) for c in coefficients):  # neither may be infinite or NaN
        return None
    symbols |= {s.name(): s for s in involved}
    return {s.name(): Fraction(int(c)) for s, c in zip(involved, coefficients, strict=True) if c != 0}


def _subtract(row: _Row, pivot: _Row, name: str) -> None:
    factor = row.terms[name] / pivot.terms[name]
    _add(row.terms, pivot.terms, -factor)
    _add(row.origin, pivot.origin, -factor)


def _add(mine: dict[_Key, Fraction], theirs: dict[_Key, Fraction], factor: Fraction) -> None:
    for key, value in theirs.items():
        total = mine.get(key, Fraction(0)) + factor * value
        if total:
            mine[key] = total
        else:
            mine.pop(key, None)


def _equation(row: _Row, symbols: dict[str, SX], at: int) -> Equation:
    """The row with its first coefficient made one, and its text."""
    first = next(iter(row.terms.values()))
    residual, text = SX(0.0), ""
    for name, value in row.terms.items():
        factor = value / first
        residual = residual + float(factor) * symbols[name]
        size = "" if abs(factor) == 1 else f"{abs(factor)} * "
        text += (" - " if factor < 0 else " + " if text else "") + size + name
    return Equation(residual, f"{text} = 0", at)
