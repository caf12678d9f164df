"""Small helpers on CasADi expressions that several stages need."""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca

from cosim.dae.hybrid import SX


def substitute(expression: SX, values: Mapping[str, SX]) -> SX:
    """Put values in for the symbols of these names."""
    symbols = [s for s in ca.symvar(expression) if s.name() in values]
    if not symbols:
        return expression
    return ca.substitute(expression, ca.vertcat(*symbols), ca.vertcat(*(values[s.name()] for s in symbols)))


def evaluate(expression: SX, values: Mapping[str, float]) -> ca.DM:
    """The number, or matrix of numbers, that an expression has for values of its symbols."""
    if expression.is_constant():
        return ca.DM(expression)
    symbols = ca.symvar(expression)
    function = ca.Function("value", [ca.vertcat(SX(0, 1), *symbols)], [expression])
    return function(ca.DM([values[s.name()] for s in symbols]))


def depends(expression: SX, on: SX) -> bool:
    """Whether an expression contains any of these symbols."""
    return bool(ca.depends_on(expression, on)) if expression.nnz() else False
