"""Modelica's functions of arrays: constructors, reductions, products, sizes. Vectors are columns."""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca

from cosim.dae.hybrid import SX
from cosim.dae.symbols import Evaluate
from cosim.modelica.expressions import Call, Reference, render


def reduce(operation: Callable[[SX, SX], SX], values: list[SX]) -> SX:
    """Fold in a balanced tree, so that a long chain does not become a long dependence in the generated code."""
    while len(values) > 1:
        paired = [operation(a, b) for a, b in zip(values[::2], values[1::2], strict=False)]
        values = paired + ([values[-1]] if len(values) % 2 else [])
    return values[0]


def _extremum(pick: Callable[[SX, SX], SX]) -> Callable[[Evaluate, Call], SX]:
    def extremum(evaluate: Evaluate, node: Call) -> SX:
        values = [element for argument in node.arguments for element in ca.vertsplit(ca.vec(evaluate(argument)))]
        if not values:
            raise evaluate.error(f"{render(node)}: an empty array has no such element", node)
        return reduce(pick, values)

    return extremum


def _plain(function: Callable[..., SX]) -> Callable[[Evaluate, Call], SX]:
    return lambda evaluate, node: function(*(evaluate(argument) for argument in node.arguments))


def _product(evaluate: Evaluate, node: Call) -> SX:
    values = ca.vertsplit(ca.vec(evaluate(node.arguments[0])))
    return reduce(lambda a, b: a * b, values) if values else SX(1.0)


def _filled(evaluate: Evaluate, node: Call) -> SX:
    sizes = node.arguments[1:] if node.function == "fill" else node.arguments
    if not 1 <= len(sizes) <= 2:
        raise evaluate.error(f"{render(node)}: arrays have at most two dimensions here", node)
    shape = [evaluate.indices(size)[0] for size in sizes]
    value = evaluate(node.arguments[0]) if node.function == "fill" else SX(0.0 if node.function == "zeros" else 1.0)
    return ca.repmat(value, *shape)


def _symmetric(evaluate: Evaluate, node: Call) -> SX:
    matrix = evaluate(node.arguments[0])
    return ca.triu(matrix) + ca.triu(matrix, False).T


def sizes(evaluate: Evaluate, node: Call) -> tuple[int, ...]:
    """The dimensions of the first argument."""
    array = node.arguments[0]
    if isinstance(array, Reference) and not array.subscripts and array.name not in evaluate.locals:
        declared = evaluate.symbols.flat.variables.get(array.name)
        if declared is not None:
            return declared.dimensions
    value = evaluate(array)
    rank = evaluate.ranks.get(array.name) if isinstance(array, Reference) and not array.subscripts else None
    if rank is not None:
        return tuple(value.shape)[:rank]
    return (value.shape[0],) if value.is_column() else tuple(value.shape)


def _size(evaluate: Evaluate, node: Call) -> SX:
    found = sizes(evaluate, node)
    if len(node.arguments) == 1:
        return ca.vertcat(SX(0, 1), *found)
    dimension = evaluate.indices(node.arguments[1])[0]
    if not 1 <= dimension <= len(found):
        raise evaluate.error(f"{render(node)}: there is no such dimension", node)
    return SX(found[dimension - 1])


def _linspace(evaluate: Evaluate, node: Call) -> SX:
    first, last = evaluate(node.arguments[0]), evaluate(node.arguments[1])
    count = evaluate.indices(node.arguments[2])[0]
    if count < 2:
        raise evaluate.error(f"{render(node)}: needs at least two points", node)
    return ca.vertcat(*(first + (last - first) * k / (count - 1) for k in range(count)))


def _cat(evaluate: Evaluate, node: Call) -> SX:
    dimension = evaluate.indices(node.arguments[0])[0]
    parts = [evaluate(argument) for argument in node.arguments[1:]]
    if dimension not in (1, 2):
        raise evaluate.error(f"{render(node)}: arrays have at most two dimensions here", node)
    return ca.vertcat(*parts) if dimension == 1 else ca.horzcat(*parts)


ARRAY_FUNCTIONS: dict[str, Callable[[Evaluate, Call], SX]] = {
    "min": _extremum(ca.fmin),
    "max": _extremum(ca.fmax),
    "sum": lambda evaluate, node: ca.sum1(ca.vec(evaluate(node.arguments[0]))),
    "product": _product,
    "transpose": _plain(lambda a: a.T),
    "symmetric": _symmetric,
    "diagonal": _plain(ca.diag),
    "cross": _plain(ca.cross),
    "skew": _plain(ca.skew),
    "outerProduct": _plain(lambda a, b: ca.mtimes(a, b.T)),
    "identity": lambda evaluate, node: SX.eye(evaluate.indices(node.arguments[0])[0]),
    "zeros": _filled,
    "ones": _filled,
    "fill": _filled,
    "linspace": _linspace,
    "cat": _cat,
    "size": _size,
    "ndims": lambda evaluate, node: SX(len(sizes(evaluate, node))),
    "vector": lambda evaluate, node: ca.vec(evaluate(node.arguments[0])),
    "scalar": lambda evaluate, node: evaluate(node.arguments[0]),
    "matrix": lambda evaluate, node: evaluate(node.arguments[0]),
}
"""By Modelica name."""
