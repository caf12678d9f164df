"""The types of expressions, as far as they are plain: what may be assigned to what.

The front end checks types of equations; those of assignments that reach us another way are checked here.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal as OneOf

from cosim.modelica.expressions import (
    Array,
    Binary,
    Call,
    Comprehension,
    Expression,
    If,
    Literal,
    Output,
    Reference,
    Unary,
    UserCall,
    render,
)
from cosim.modelica.flat import Assign, FlatModel

Kind = OneOf["Real", "Integer", "Boolean", "Enumeration", "String"]

_INTEGER = frozenset("integer size ndims".split())
_BOOLEAN = frozenset("initial terminal sample edge change".split())
_LIKE_ARGUMENTS = frozenset("pre noEvent min max abs sum product fill cat transpose div mod rem vector scalar".split())
_LOGICAL = frozenset("< <= > >= == <> and or".split())


def check_assignment(flat: FlatModel, action: Assign) -> None:
    """Refuse what cannot be assigned: a Real to an Integer, a number to a Boolean.

    Raises:
        ModelError: the value has another type than the variable.
    """
    target = flat.variables.get(action.target)
    found = kind_of(flat, action.value)
    if target is None or found is None:
        return
    if found == target.type == "Enumeration" and any(t != target.literals for t in _enumerations(flat, action.value)):
        message = (
            f"{action.target} is of an enumeration with {', '.join(target.literals)}; {render(action.value)} is not"
        )
        raise flat.source.error(message, action.at)
    if found == target.type or (found, target.type) == ("Integer", "Real"):
        return
    advice = "; use integer() to round it down" if (found, target.type) == ("Real", "Integer") else ""
    raise flat.source.error(
        f"{action.target} is of type {target.type}, but {render(action.value)} is of type {found}{advice}", action.at
    )


def _enumerations(flat: FlatModel, expression: Expression) -> Iterator[tuple[str, ...]]:
    """The literals of each enumeration that a value may be of."""
    match expression:
        case Reference(name=name) if name in flat.enumeration_values:
            prefix = name.rpartition(".")[0] + "."
            yield tuple(n.removeprefix(prefix) for n in flat.enumeration_values if n.startswith(prefix))
        case Reference(name=name) if name in flat.variables:
            yield flat.variables[name].literals
        case If(branches=branches, otherwise=otherwise):
            for value in (*(value for _, value in branches), otherwise):
                yield from _enumerations(flat, value)
        case Array(elements=elements):
            for element in elements:
                yield from _enumerations(flat, element)


def kind_of(flat: FlatModel, expression: Expression) -> Kind | None:
    """The type of an expression or of its elements; ``None`` if it is not plain."""
    match expression:
        case Literal(value=value):
            names: dict[type, Kind] = {bool: "Boolean", int: "Integer", float: "Real", str: "String"}
            return names[type(value)]
        case Reference(name="time"):
            return "Real"
        case Reference(name=name):
            if name in flat.enumeration_values:
                return "Enumeration"
            variable = flat.variables.get(name)
            return None if variable is None else variable.type
        case Unary(operator=operator, operand=operand):
            return "Boolean" if operator == "not" else kind_of(flat, operand)
        case Binary(operator=operator, left=left, right=right):
            if operator in _LOGICAL:
                return "Boolean"
            return "Real" if operator in ("/", "./", "^", ".^") else _common(flat, (left, right))
        case If(branches=branches, otherwise=otherwise):
            return _common(flat, (*(value for _, value in branches), otherwise))
        case Array(elements=elements):
            return _common(flat, elements)
        case Comprehension(element=element):
            return kind_of(flat, element)
        case Call(function=function, arguments=arguments):
            if function in _INTEGER or function in _BOOLEAN:
                return "Integer" if function in _INTEGER else "Boolean"
            return _common(flat, arguments) if function in _LIKE_ARGUMENTS else None
        case Output(call=UserCall(function=function), position=position):
            return _output(flat, function, position)
        case UserCall(function=function):
            return _output(flat, function, 0)
    return None


def _output(flat: FlatModel, function: str, position: int) -> Kind | None:
    known = flat.functions.get(function)
    if known is None or position >= len(known.outputs):
        return None
    kind = known.outputs[position].type
    return kind if kind in ("Real", "Integer", "Boolean", "String") else None  # type: ignore[return-value]


def _common(flat: FlatModel, expressions: tuple[Expression, ...]) -> Kind | None:
    kinds = {kind_of(flat, expression) for expression in expressions}
    if len(kinds) == 1:
        return kinds.pop()
    return "Real" if kinds == {"Integer", "Real"} else None
