"""The expressions of a flat model: a small tree, each node with its byte offset in the source text."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Literal:
    """A number, Boolean or string."""

    value: float | bool | int | str
    at: int


@dataclass(frozen=True)
class Reference:
    """A variable, an element of one, or an enumeration literal."""

    name: str
    subscripts: tuple[Expression | None, ...]
    """``None`` is a bare colon."""
    at: int


@dataclass(frozen=True)
class Unary:
    """``-x``, ``+x`` or ``not x``."""

    operator: str
    operand: Expression
    at: int


@dataclass(frozen=True)
class Binary:
    """An arithmetic, relational or logical operation; ``operator`` is the Modelica token."""

    operator: str
    left: Expression
    right: Expression
    at: int


@dataclass(frozen=True)
class If:
    """An if-expression."""

    branches: tuple[tuple[Expression, Expression], ...]
    otherwise: Expression
    at: int


@dataclass(frozen=True)
class Call:
    """A built-in operator or function, by its Modelica name."""

    function: str
    arguments: tuple[Expression, ...]
    at: int


@dataclass(frozen=True)
class UserCall:
    """A call of one of the model's own functions, or of a record's constructor; no argument is left out."""

    function: str
    arguments: tuple[Expression, ...]
    at: int


@dataclass(frozen=True)
class Output:
    """One of the outputs of a function that has several, counted from 0."""

    call: UserCall
    position: int
    at: int


@dataclass(frozen=True)
class Field:
    """A component of what a function or constructor of records gives; ``name`` may be a path with dots."""

    record: Expression
    name: str
    at: int


@dataclass(frozen=True)
class Array:
    """An array constructor ``{...}``."""

    elements: tuple[Expression, ...]
    at: int


@dataclass(frozen=True)
class Range:
    """``start : step : end``."""

    start: Expression
    step: Expression | None
    end: Expression
    at: int


@dataclass(frozen=True)
class Comprehension:
    """``{element for index in domain}``."""

    element: Expression
    index: str
    domain: Expression
    at: int


Expression = (
    Literal | Reference | Unary | Binary | If | Call | UserCall | Output | Field | Array | Range | Comprehension
)


def children(expression: Expression) -> Iterator[Expression]:
    """The direct subexpressions."""
    match expression:
        case Literal():
            return
        case Reference(subscripts=subscripts):
            yield from (subscript for subscript in subscripts if subscript is not None)
        case Unary(operand=operand):
            yield operand
        case Binary(left=left, right=right):
            yield from (left, right)
        case If(branches=branches, otherwise=otherwise):
            for condition, value in branches:
                yield from (condition, value)
            yield otherwise
        case Call(arguments=arguments) | UserCall(arguments=arguments):
            yield from arguments
        case Output(call=call):
            yield call
        case Field(record=record):
            yield record
        case Array(elements=elements):
            yield from elements
        case Range(start=start, step=step, end=end):
            yield start
            if step is not None:
                yield step
            yield end
        case Comprehension(element=element, domain=domain):
            yield from (element, domain)


def references(expression: Expression) -> Iterator[str]:
    """The names of variables and literals in an expression, as often as they are there."""
    if isinstance(expression, Reference):
        yield expression.name
    for child in children(expression):
        yield from references(child)


def put_in(expression: Expression, values: Mapping[str, Expression]) -> Expression:
    """Put expressions in for the plain references of these names."""

    def walk(node: Expression) -> Expression:
        match node:
            case Literal():
                return node
            case Reference(name=name, subscripts=()) if name in values:
                return values[name]
            case Reference(subscripts=subscripts):
                return replace(node, subscripts=tuple(None if s is None else walk(s) for s in subscripts))
            case Unary(operand=operand):
                return replace(node, operand=walk(operand))
            case Binary(left=left, right=right):
                return replace(node, left=walk(left), right=walk(right))
            case If(branches=branches, otherwise=otherwise):
                return replace(node, branches=tuple((walk(c), walk(v)) for c, v in branches), otherwise=walk(otherwise))
            case Call(arguments=arguments) | UserCall(arguments=arguments):
                return replace(node, arguments=tuple(walk(a) for a in arguments))
            case Output(call=call):
                return replace(node, call=replace(call, arguments=tuple(walk(a) for a in call.arguments)))
            case Field(record=record):
                return replace(node, record=walk(record))
            case Array(elements=elements):
                return replace(node, elements=tuple(walk(e) for e in elements))
            case Range(start=start, step=step, end=end):
                return replace(node, start=walk(start), step=None if step is None else walk(step), end=walk(end))
            case Comprehension(element=element, domain=domain):
                return replace(node, element=walk(element), domain=walk(domain))

    return walk(expression)


def calls(expression: Expression, function: str) -> Iterator[Call]:
    """All calls of one function in an expression, outermost first."""
    if isinstance(expression, Call) and expression.function == function:
        yield expression
    for child in children(expression):
        yield from calls(child, function)


_PRECEDENCE = {
    "or": 1, "and": 2, "<": 4, "<=": 4, ">": 4, ">=": 4, "==": 4, "<>": 4,
    "+": 5, "-": 5, ".+": 5, ".-": 5, "*": 6, "/": 6, ".*": 6, "./": 6, "^": 7, ".^": 7,
}  # fmt: skip


def render(expression: Expression, above: int = 0) -> str:
    """Modelica text of an expression, for messages and comments."""
    match expression:
        case Literal(value=bool(value)):
            return "true" if value else "false"
        case Literal(value=str(value)):
            return f'"{value}"'
        case Literal(value=value):
            return f"{value:g}" if isinstance(value, float) else str(value)
        case Reference(name=name, subscripts=subscripts):
            inside = ",".join(":" if s is None else render(s) for s in subscripts)
            return f"{name}[{inside}]" if inside else name
        case Unary(operator=operator, operand=operand):
            text = ("not " if operator == "not" else operator) + render(operand, 6)
            return f"({text})" if above > 5 else text
        case Binary(operator=operator, left=left, right=right):
            level = _PRECEDENCE[operator]
            text = f"{render(left, level)} {operator} {render(right, level + 1)}"
            return f"({text})" if level < above else text
        case If(branches=branches, otherwise=otherwise):
            tests = " elseif ".join(f"{render(c)} then {render(v)}" for c, v in branches)
            text = f"if {tests} else {render(otherwise)}"
            return f"({text})" if above else text
        case Call(function=function, arguments=arguments) | UserCall(function=function, arguments=arguments):
            return f"{function}({', '.join(render(a) for a in arguments)})"
        case Output(call=call, position=position):
            return f"{render(call)}, output {position + 1}"
        case Field(record=record, name=name):
            return f"{render(record)}.{name}"
        case Array(elements=elements):
            return "{" + ", ".join(render(e) for e in elements) + "}"
        case Range(start=start, step=step, end=end):
            return ":".join(render(part, 6) for part in (start, step, end) if part is not None)
        case Comprehension(element=element, index=index, domain=domain):
            return f"{{{render(element)} for {index} in {render(domain)}}}"


def render_equation(residual: Expression) -> str:
    """Text of ``residual = 0``, written the way an equation is."""
    if isinstance(residual, Binary) and residual.operator == "-":
        return f"{render(residual.left)} = {render(residual.right)}"
    return f"0 = {render(residual)}"
