"""Evaluates Modelica expressions to CasADi expressions, making relations, clocks and held integers on the way."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca

from cosim.dae.array_functions import ARRAY_FUNCTIONS
from cosim.dae.event_functions import EVENT_FUNCTIONS
from cosim.dae.functions import call, component, components
from cosim.dae.hybrid import SX, Relation
from cosim.dae.statements import missing, nothing
from cosim.dae.symbolic import evaluate as number_of
from cosim.dae.symbols import Evaluate, Mode, held_previous
from cosim.modelica.expressions import (
    Array,
    Binary,
    Call,
    Comprehension,
    Expression,
    Field,
    If,
    Literal,
    Output,
    Range,
    Reference,
    Unary,
    UserCall,
    render,
)
from cosim.modelica.flat import Variable

_FUNCTIONS: dict[str, Callable[..., SX]] = {
    "sin": ca.sin, "cos": ca.cos, "tan": ca.tan, "asin": ca.asin, "acos": ca.acos, "atan": ca.atan,
    "atan2": ca.atan2, "sinh": ca.sinh, "cosh": ca.cosh, "tanh": ca.tanh, "exp": ca.exp, "log": ca.log,
    "log10": ca.log10, "sqrt": ca.sqrt, "abs": ca.fabs, "sign": ca.sign,
}  # fmt: skip
_RELATIONAL = {"<", "<=", ">", ">="}


@dataclass(frozen=True)
class Evaluator(Evaluate):
    """Evaluates expressions in one mode."""

    def __call__(self, expression: Expression) -> SX:
        """The CasADi value; Booleans are 0 and 1, one-dimensional arrays are columns.

        Raises:
            ModelError: something has no meaning here, by name and place.
        """
        match expression:
            case Literal(value=bool(value)):
                return SX(1.0 if value else 0.0)
            case Literal(value=str()):
                raise self.error("a string has no place in an equation", expression)
            case Literal(value=value):
                return SX(float(value))
            case Reference():
                return self._reference(expression)
            case Unary(operator=operator, operand=operand):
                inner = self(operand)
                if operator == "not":
                    return ca.logic_not(inner)
                return -inner if operator == "-" else inner
            case Binary():
                return self._fitting(self._binary, expression)
            case If(branches=branches, otherwise=otherwise):
                return self._if(branches, otherwise)
            case Call():
                return self._fitting(self._call, expression)
            case UserCall():
                return self._fitting(lambda node: call(self, node), expression)
            case Output(call=node, position=position):
                return self._fitting(lambda node: call(self, node, position), node)
            case Field(record=record, name=name):
                return self.component(record, name)
            case Array(elements=elements):
                values = [self(element) for element in elements]
                if any(v.numel() > 1 and not v.is_column() for v in values):
                    raise self.error(f"{render(expression)}: arrays have at most two dimensions here", expression)
                return ca.vertcat(*(v.T if v.numel() > 1 else v for v in values))
            case Range():
                return SX(ca.DM(self.indices(expression)))
            case Comprehension(element=element, index=index, domain=domain):
                inside = [self.alike(locals={**self.locals, index: SX(k)}) for k in self.indices(domain)]
                return ca.vertcat(*(evaluate(element) for evaluate in inside))

    def _fitting(self, evaluate: Callable[[Any], SX], expression: Binary | Call | UserCall) -> SX:
        try:
            return evaluate(expression)
        except (RuntimeError, NotImplementedError) as error:  # CasADi's, for shapes that do not fit
            raise self.error(f"{render(expression)}: arrays of these shapes do not go together", expression) from error

    def _if(self, branches: tuple[tuple[Expression, Expression], ...], otherwise: Expression) -> SX:
        if not self.symbols.flat.functions:
            result = self(otherwise)
            for condition, branch in reversed(branches):
                result = ca.if_else(self(condition), self(branch), result)
            return result
        # what a function asserts must hold only where it is called
        rest = self
        values: list[tuple[SX, SX]] = []
        for condition, branch in branches:
            holds = rest(condition)
            values.append((holds, rest.alike(path=_both(rest.path, holds))(branch)))
            rest = rest.alike(path=_both(rest.path, ca.logic_not(holds)))
        result = rest(otherwise)
        for holds, value in reversed(values):
            result = ca.if_else(holds, value, result)
        return result

    # names

    def _reference(self, node: Reference) -> SX:
        symbols = self.symbols
        if node.name in self.locals and not (self.reading_pre and node.name in symbols.values):
            value = self.locals[node.name]
        elif node.name in symbols.flat.enumeration_values:
            return SX(symbols.flat.enumeration_values[node.name])
        elif self.function and not self._is_constant(node.name):
            raise self.error(f"{node.name} has no value here, inside the function {self.function[-1]}", node)
        elif node.name == "time":
            value = symbols.system.time
        elif node.name in symbols.values:
            value = self._variable(symbols.flat.variables[node.name], node)
        else:
            raise self.error(f"{node.name} is not known here", node)
        if node.subscripts:
            value = self._subscripted(value, node)
        if self.function and missing(value):
            message = f"{render(node)} is used in the function {self.function[-1]} before it has a value in every case"
            raise self.error(message, node)
        return value

    def _is_constant(self, name: str) -> bool:
        variable = self.symbols.flat.variables.get(name)
        return variable is not None and variable.variability == "constant"

    def _variable(self, variable: Variable, node: Reference) -> SX:
        symbols = self.symbols
        known = variable.variability in ("parameter", "constant")
        if self.mode is Mode.PARAMETER and not known:
            message = f"{node.name} is not a parameter, so it cannot stand in a parameter's value or a start"
            raise self.error(message, node)
        if known or variable.causality == "input" or variable.variability == "continuous":
            # the left limit at the event; reinit() takes effect after the when-clauses
            if self.reading_pre and not known and self.mode is not Mode.SAMPLED:
                raise self.error(
                    f"pre({node.name}): a continuous variable has a value before the event only inside when", node
                )
            return symbols.values[node.name]
        if self.reading_pre:
            return symbols.pre[node.name]
        return symbols.values[node.name] if self.mode is Mode.CONTINUOUS else symbols.new[node.name]

    def _subscripted(self, value: SX, node: Reference) -> SX:
        picks: list[list[int] | SX] = []
        for position, subscript in enumerate(node.subscripts):
            size = value.shape[position]
            if subscript is not None and not isinstance(subscript, Range):
                choice = self(subscript)
                if choice.is_scalar() and not choice.is_constant():
                    picks.append(choice)
                    continue
            indices = range(1, size + 1) if subscript is None else self.indices(subscript)
            for index in indices:
                if not 1 <= index <= size:
                    raise self.error(f"{render(node)}: {node.name} has {size} elements there", node)
            picks.append([index - 1 for index in indices])
        single = [s is not None and not isinstance(s, Range | Array) for s in node.subscripts]
        return _picked(value, picks, single)

    def indices(self, node: Expression) -> list[int]:
        """The integers of a subscript, a size or a loop range, which must be known when compiling.

        Where they follow from parameters, these keep their default values from then on.

        Raises:
            ModelError: they follow from something else.
        """
        if isinstance(node, Range):
            first, last = self.indices(node.start)[0], self.indices(node.end)[0]
            step = 1 if node.step is None else self.indices(node.step)[0]
            return list(range(first, last + (1 if step > 0 else -1), step))
        value = self(node)
        if not value.is_constant():
            value = self._default(value, node)
        return [int(v) for v in ca.DM(value).full().ravel()]

    def _default(self, value: SX, node: Expression) -> SX:
        symbols = self.symbols
        parameters = {p.scalar.name: p for p in symbols.system.parameters}
        numbers: dict[str, float] = {}
        waiting = [s.name() for s in ca.symvar(value)]
        needed: list[str] = []
        while waiting:
            name = waiting.pop()
            if name not in parameters:
                raise self.error(f"the index {render(node)} must be known when the model is compiled", node)
            needed.append(name)
            waiting += [s.name() for s in ca.symvar(parameters[name].value)]
        symbols.structural |= set(needed)
        for name in (name for name in parameters if name in needed):
            numbers[name] = float(number_of(parameters[name].value, numbers))
        return SX(number_of(value, numbers))

    # records

    def components(self, record: Expression) -> list[str] | None:
        """The names of the components, if this is a record; ``None`` if it is not."""
        match record:
            case UserCall():
                return components(self, record)
            case Output(call=node, position=position):
                return components(self, node, position)
            case If(otherwise=otherwise):
                return self.components(otherwise)
            case Reference(name=name, subscripts=()) if name not in self.locals:
                known = (key for key in self.locals if key.startswith(f"{name}."))
                return [key[len(name) + 1 :] for key in known] or None
        return None

    def component(self, record: Expression, name: str) -> SX:
        """The value of a component of a record.

        Raises:
            ModelError: it has none of this name.
        """
        match record:
            case UserCall():
                return component(self, record, name)
            case Output(call=node, position=position):
                return component(self, node, name, position)
            case Reference():
                return self(replace(record, name=f"{record.name}.{name}"))
            case If(branches=branches, otherwise=otherwise):
                parts = tuple((condition, Field(value, name, record.at)) for condition, value in branches)
                return self(replace(record, branches=parts, otherwise=Field(otherwise, name, record.at)))
        raise self.error(f"{render(record)} has no component {name}", record)

    # operators

    def _binary(self, node: Binary) -> SX:
        left, right = self(node.left), self(node.right)
        match node.operator:
            case "+" | ".+":
                return left + right
            case "-" | ".-":
                return left - right
            case "*" if left.is_column() and right.is_column() and left.numel() > 1 and right.numel() > 1:
                return ca.dot(left, right)
            case "*" if left.is_column() and left.numel() > 1 and right.numel() > 1 and right.shape[0] > 1:
                return ca.mtimes(left.T, right).T
            case "*" if left.numel() > 1 and right.numel() > 1:
                return ca.mtimes(left, right)
            case "*" | ".*":
                return left * right
            case "/" | "./":
                return left / right
            case "^" if not left.is_scalar():
                return self._power(left, node)
            case "^" | ".^":
                return left**right
            case "and":
                return ca.logic_and(left, right)
            case "or":
                return ca.logic_or(left, right)
            case "==":
                self._refuse_equality(node, left, right)
                return left == right
            case "<>":
                self._refuse_equality(node, left, right)
                return left != right
        return self._relation(node, left, right)

    def _power(self, matrix: SX, node: Binary) -> SX:
        result = SX.eye(matrix.shape[0])
        for _ in range(self.indices(node.right)[0]):
            result = ca.mtimes(result, matrix)
        return result

    def _refuse_equality(self, node: Binary, left: SX, right: SX) -> None:
        sampled = self.mode in (Mode.PARAMETER, Mode.SAMPLED) or self.function
        if not sampled and self.varies(left - right):
            raise self.error(f"{render(node)}: two Reals can be compared with == only inside when", node)

    def varies(self, value: SX) -> bool:
        """Whether a value can change between events."""
        system = self.symbols.system
        for symbol in ca.symvar(value):
            name = symbol.name()
            if name in system.unknowns or name in system.inputs or name == "time" or name.startswith("der("):
                return True
        return False

    def _relation(self, node: Binary, left: SX, right: SX) -> SX:
        difference = left - right if node.operator in (">", ">=") else right - left
        strict = node.operator in (">", "<")
        events = self.mode in (Mode.CONTINUOUS, Mode.DISCRETE) and not self.no_event
        if not events or not self.varies(difference):
            return difference > 0 if strict else difference >= 0
        return self.event(difference, strict, render(node))

    def event(self, indicator: SX, strict: bool, text: str) -> SX:
        """The truth value of a relation that makes events; the same relation is made only once."""
        # between events a relation sees discrete variables as they are, also in an equation for a new one
        system = self.symbols.system
        news = [symbol for symbol in ca.symvar(indicator) if symbol.name().startswith("new(")]
        if news:
            current = [self.symbols.scalars[symbol.name()[4:-1]].symbol for symbol in news]
            indicator = ca.substitute(indicator, ca.vertcat(*news), ca.vertcat(*current))
        for symbol in (s for s in ca.symvar(indicator) if s.name().startswith("pre(")):
            indicator = ca.substitute(indicator, symbol, held_previous(self.symbols, symbol))
        for relation in system.relations:
            if relation.strict == strict and ca.is_equal(relation.indicator, indicator, 50):
                return relation.symbol
        symbol = SX.sym(f"relation({len(system.relations)})")
        system.relations.append(Relation(symbol, indicator, strict, text))
        return symbol

    # functions

    def _call(self, node: Call) -> SX:
        name = node.function
        if name in _FUNCTIONS:
            return _FUNCTIONS[name](*(self(argument) for argument in node.arguments))
        handler = EVENT_FUNCTIONS.get(name) or ARRAY_FUNCTIONS.get(name)
        if handler is not None:
            return handler(self, node)
        reason = f"is not supported: {UNSUPPORTED[name]}" if name in UNSUPPORTED else "is not known"
        raise self.error(f"{name}() {reason}", node)


def _both(a: SX | None, b: SX) -> SX:
    return b if a is None else ca.logic_and(a, b)


def _picked(value: SX, picks: list[list[int] | SX], single: list[bool]) -> SX:
    """Elements of an array; an index that is not known when compiling chooses among them, and one out of range is NaN.

    Args:
        value: a column or matrix.
        picks: indices from 0, or an expression for one from 1, for each subscript.
        single: for each subscript, whether it is one index and not a list of them.
    """
    known: list[list[int]] = []
    for position, pick in enumerate(picks):
        if not isinstance(pick, SX):
            known.append(pick)
            continue
        choices = [
            _picked(value, [*picks[:position], [k], *picks[position + 1 :]], single)
            for k in range(value.shape[position])
        ]
        result = nothing(*choices[0].shape)
        for k, choice in reversed(list(enumerate(choices, 1))):
            result = ca.if_else(pick == k, choice, result)
        return result
    if len(known) == 1:
        picked = value[known[0], :]
        return picked.T if single[0] and value.shape[1] > 1 else picked
    picked = value[known[0], known[1]]
    # a row taken out of a matrix is a vector, and vectors are columns
    return picked.T if single[0] and picked.numel() > 1 else picked


_CLOCKED = "clocks do not exist here; use when sample(start, interval) and pre()"
UNSUPPORTED = {
    "delay": "the past of a variable is not kept; sample it, or describe the delay with states",
    "spatialDistribution": "the past of a variable is not kept; divide the length into cells, with an equation each",
    "cardinality": "connections cannot be counted here; use a parameter and conditional components",
    "String": "texts have a place in messages only",
    **dict.fromkeys(
        ("clock", "hold", "previous", "firstTick", "interval", "noClock", "subSample", "superSample", "shiftSample",
         "backSample"),
        _CLOCKED,
    ),
}  # fmt: skip
"""What to say about built-in operators that have a name here, and no meaning."""
