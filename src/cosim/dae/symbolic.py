"""Small helpers on CasADi expressions that several stages need."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import casadi as ca

from cosim.dae.hybrid import SX, Parameter

_ARITHMETIC = {ca.OP_CONST, ca.OP_INPUT, ca.OP_OUTPUT, ca.OP_ASSIGN, ca.OP_ADD, ca.OP_SUB, ca.OP_NEG, ca.OP_TWICE,
               ca.OP_MUL, ca.OP_DIV}  # fmt: skip


def substitute(expression: SX, values: Mapping[str, SX]) -> SX:
    """Put values in for the symbols of these names."""
    symbols = [s for s in ca.symvar(expression) if s.name() in values]
    if not symbols:
        return expression
    return ca.substitute(expression, ca.vertcat(*symbols), ca.vertcat(*(values[s.name()] for s in symbols)))


def is_arithmetic(expression: SX) -> bool:
    """Whether an expression has no operations but the four basic ones.

    Only of such an expression do derivatives tell everything: those of a condition or of floor() are zero.
    """
    function = ca.Function("f", [ca.vertcat(SX(0, 1), *ca.symvar(expression))], [expression])
    return all(function.instruction_id(k) in _ARITHMETIC for k in range(function.n_instructions()))


def without_cancelled(expression: SX) -> SX:
    """The same without the symbols that cancel, as y does in x + y - y."""
    symbols = ca.symvar(expression)
    slopes = ca.densify(ca.jacobian(expression, ca.vertcat(SX(0, 1), *symbols)))
    cancelled = [symbol for k, symbol in enumerate(symbols) if slopes[k].is_zero()]
    if not cancelled or not is_arithmetic(expression):
        return expression
    return ca.simplify(ca.substitute(expression, ca.vertcat(*cancelled), ca.DM.zeros(len(cancelled))))


def evaluate(expression: SX, values: Mapping[str, float]) -> ca.DM:
    """The number, or matrix of numbers, that an expression has for values of its symbols."""
    if expression.is_constant():
        return ca.DM(expression)
    symbols = ca.symvar(expression)
    function = ca.Function("value", [ca.vertcat(SX(0, 1), *symbols)], [expression])
    return function(ca.DM([values[s.name()] for s in symbols]))


def default_values(parameters: Iterable[Parameter]) -> dict[str, float]:
    """What parameters are if nobody sets them; each comes after the ones that it depends on."""
    values: dict[str, float] = {}
    for parameter in parameters:
        values[parameter.scalar.name] = float(evaluate(parameter.value, values))
    return values


def depends(expression: SX, on: SX) -> bool:
    """Whether an expression contains any of these symbols."""
    return bool(ca.depends_on(expression, on)) if expression.nnz() else False
