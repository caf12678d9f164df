"""Evaluates Modelica expressions to CasADi expressions, making relations, clocks and held integers on the way."""

from __future__ import annotations

import enum
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import casadi as ca

from cosim.dae.hybrid import Clock, HybridSystem, Relation, Scalar
from cosim.errors import ModelError
from cosim.modelica.expressions import (
    Array,
    Binary,
    Call,
    Comprehension,
    Expression,
    If,
    Literal,
    Range,
    Reference,
    Unary,
    render,
)
from cosim.modelica.flat import FlatModel, Variable

SX = ca.SX

_FUNCTIONS: dict[str, Callable[..., SX]] = {
    "sin": ca.sin, "cos": ca.cos, "tan": ca.tan, "asin": ca.asin, "acos": ca.acos, "atan": ca.atan,
    "atan2": ca.atan2, "sinh": ca.sinh, "cosh": ca.cosh, "tanh": ca.tanh, "exp": ca.exp, "log": ca.log,
    "log10": ca.log10, "sqrt": ca.sqrt, "abs": ca.fabs, "sign": ca.sign,
}  # fmt: skip
_CONSTRUCTORS: dict[str, Callable[..., SX]] = {
    "diagonal": ca.diag, "cross": ca.cross, "skew": ca.skew, "outerProduct": lambda a, b: ca.mtimes(a, b.T),
}  # fmt: skip
_RELATIONAL = {"<", "<=", ">", ">="}
_NOT_SUPPORTED = {
    "delay", "spatialDistribution", "semiLinear", "terminal", "cardinality", "clock", "hold", "previous", "firstTick",
    "subSample", "superSample", "shiftSample", "backSample", "noClock", "interval", "inStream", "actualStream",
}  # fmt: skip


class Mode(enum.Enum):
    """Where an expression stands, which decides what its names and relations mean."""

    PARAMETER = enum.auto()
    """Only parameters; relations are plain comparisons."""
    CONTINUOUS = enum.auto()
    """An equation between events: relations are held, discrete variables are constant."""
    DISCRETE = enum.auto()
    """An equation for a discrete variable, or a when-condition: relations make events."""
    SAMPLED = enum.auto()
    """Inside when: evaluated once at the event, relations are plain comparisons."""


@dataclass(frozen=True)
class Held:
    """A discrete variable that holds floor(value) between events."""

    name: str
    value: SX
    text: str
    at: int


@dataclass
class Symbols:
    """All names of a model: the declaration and the CasADi symbols of each, array elements in one matrix."""

    flat: FlatModel
    system: HybridSystem
    values: dict[str, SX] = field(default_factory=dict)
    pre: dict[str, SX] = field(default_factory=dict)
    new: dict[str, SX] = field(default_factory=dict)
    scalars: dict[str, Scalar] = field(default_factory=dict)
    held: list[Held] = field(default_factory=list)


def element_names(name: str, dimensions: tuple[int, ...]) -> list[str]:
    """Names of the elements, columns first as CasADi stores them."""
    if not dimensions:
        return [name]
    if len(dimensions) == 1:
        return [f"{name}[{i + 1}]" for i in range(dimensions[0])]
    rows, columns = dimensions
    return [f"{name}[{i + 1},{j + 1}]" for j in range(columns) for i in range(rows)]


@dataclass(frozen=True)
class Evaluator:
    """Evaluates expressions in one mode.

    ``locals`` are values that override variables: what an algorithm has assigned so far, or a loop index.
    """

    symbols: Symbols
    mode: Mode
    no_event: bool = False
    reading_pre: bool = False
    locals: Mapping[str, SX] = field(default_factory=dict)

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
                result = self(otherwise)
                for condition, branch in reversed(branches):
                    result = ca.if_else(self(condition), self(branch), result)
                return result
            case Call():
                return self._fitting(self._call, expression)
            case Array(elements=elements):
                values = [self(element) for element in elements]
                return ca.vertcat(*(v.T if v.numel() > 1 and v.is_column() else v for v in values))
            case Range():
                return SX(ca.DM(self._indices(expression)))
            case Comprehension(element=element, index=index, domain=domain):
                inside = [replace(self, locals={**self.locals, index: SX(k)}) for k in self._indices(domain)]
                return ca.vertcat(*(evaluate(element) for evaluate in inside))

    def error(self, message: str, expression: Expression) -> ModelError:
        """An error at the place of an expression."""
        return self.symbols.flat.source.error(message, expression.at)

    def _fitting(self, evaluate: Callable[[Any], SX], expression: Binary | Call) -> SX:
        try:
            return evaluate(expression)
        except (RuntimeError, NotImplementedError) as error:  # CasADi's, for shapes that do not fit
            raise self.error(f"{render(expression)}: arrays of these shapes do not go together", expression) from error

    # names

    def _reference(self, node: Reference) -> SX:
        symbols = self.symbols
        if node.name in self.locals and not (self.reading_pre and node.name in symbols.values):
            value = self.locals[node.name]
        elif node.name == "time":
            value = symbols.system.time
        elif node.name in symbols.values:
            value = self._variable(symbols.flat.variables[node.name], node)
        elif node.name in symbols.flat.enumeration_values:
            return SX(symbols.flat.enumeration_values[node.name])
        else:
            raise self.error(f"{node.name} is not known here", node)
        return self._subscripted(value, node) if node.subscripts else value

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
        picks = []
        for position, subscript in enumerate(node.subscripts):
            size = value.shape[position]
            indices = range(1, size + 1) if subscript is None else self._indices(subscript)
            for index in indices:
                if not 1 <= index <= size:
                    raise self.error(f"{render(node)}: {node.name} has {size} elements there", node)
            picks.append([index - 1 for index in indices])
        if len(picks) == 1:
            return value[picks[0], :]
        picked = value[picks[0], picks[1]]
        # a row taken out of a matrix is a vector, and vectors are columns
        row = node.subscripts[0] is not None and not isinstance(node.subscripts[0], Range) and len(picks[0]) == 1
        return picked.T if row and picked.numel() > 1 else picked

    def _indices(self, node: Expression) -> list[int]:
        """The integers of a subscript or a loop range, which must be known when compiling."""
        if isinstance(node, Range):
            first, last = self._indices(node.start)[0], self._indices(node.end)[0]
            step = 1 if node.step is None else self._indices(node.step)[0]
            return list(range(first, last + (1 if step > 0 else -1), step))
        value = self(node)
        if not value.is_constant():
            raise self.error(f"the index {render(node)} must be known when the model is compiled", node)
        return [int(v) for v in ca.DM(value).full().ravel()]

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
            case "*" if left.is_column() and left.numel() > 1 and right.numel() > 1:
                return ca.mtimes(left.T, right).T
            case "*" if left.numel() > 1 and right.numel() > 1:
                return ca.mtimes(left, right)
            case "*" | ".*":
                return left * right
            case "/" | "./":
                return left / right
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

    def _refuse_equality(self, node: Binary, left: SX, right: SX) -> None:
        if self.mode in (Mode.CONTINUOUS, Mode.DISCRETE) and self._varies(left - right):
            raise self.error(f"{render(node)}: two Reals can be compared with == only inside when", node)

    def _varies(self, value: SX) -> bool:
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
        if not events or not self._varies(difference):
            return difference > 0 if strict else difference >= 0
        return self._event(difference, strict, render(node))

    def _event(self, indicator: SX, strict: bool, text: str) -> SX:
        # between events a relation sees discrete variables as they are, also in an equation for a new one
        system = self.symbols.system
        news = [symbol for symbol in ca.symvar(indicator) if symbol.name().startswith("new(")]
        if news:
            current = [self.symbols.scalars[symbol.name()[4:-1]].symbol for symbol in news]
            indicator = ca.substitute(indicator, ca.vertcat(*news), ca.vertcat(*current))
        for relation in system.relations:
            if relation.strict == strict and ca.is_equal(relation.indicator, indicator, 50):
                return relation.symbol
        symbol = SX.sym(f"relation({len(system.relations)})")
        system.relations.append(Relation(symbol, indicator, strict, text))
        return symbol

    # functions

    def _call(self, node: Call) -> SX:
        name, arguments = node.function, node.arguments
        handler = getattr(self, f"_call_{name}", None)
        if handler is not None:
            return handler(node)  # type: ignore[no-any-return]
        if name in _FUNCTIONS:
            return _FUNCTIONS[name](*(self(argument) for argument in arguments))
        if name in ("noEvent", "smooth"):
            return replace(self, no_event=True)(arguments[-1])
        if name in ("homotopy", "vector", "scalar"):
            return self(arguments[0])
        if name in ("min", "max"):
            pick = ca.fmin if name == "min" else ca.fmax
            values = [element for argument in arguments for element in ca.vertsplit(ca.vec(self(argument)))]
            return _reduce(pick, values)
        if name == "sum":
            return ca.sum1(ca.vec(self(arguments[0])))
        if name == "product":
            return _reduce(lambda a, b: a * b, ca.vertsplit(ca.vec(self(arguments[0]))))
        if name == "transpose":
            return self(arguments[0]).T
        if name in _CONSTRUCTORS:
            return _CONSTRUCTORS[name](*(self(argument) for argument in arguments))
        if name in ("zeros", "ones", "fill"):
            sizes = arguments[1:] if name == "fill" else arguments
            shape = [self._indices(size)[0] for size in sizes]
            value = self(arguments[0]) if name == "fill" else SX(0.0 if name == "zeros" else 1.0)
            return ca.repmat(value, *shape)
        reason = "is not supported" if name in _NOT_SUPPORTED else "is not known"
        raise self.error(f"{name}() {reason}", node)

    def _call_size(self, node: Call) -> SX:
        array = node.arguments[0]
        if isinstance(array, Reference) and not array.subscripts and array.name in self.symbols.flat.variables:
            sizes: tuple[int, ...] = self.symbols.flat.variables[array.name].dimensions
        else:
            value = self(array)
            sizes = (value.shape[0],) if value.is_column() else value.shape
        if len(node.arguments) == 1:
            return ca.vertcat(SX(0, 1), *sizes)
        dimension = self._indices(node.arguments[1])[0]
        if not 1 <= dimension <= len(sizes):
            raise self.error(f"{render(node)}: there is no such dimension", node)
        return SX(sizes[dimension - 1])

    def _call_identity(self, node: Call) -> SX:
        return SX.eye(self._indices(node.arguments[0])[0])

    def _call_linspace(self, node: Call) -> SX:
        first, last = self(node.arguments[0]), self(node.arguments[1])
        count = self._indices(node.arguments[2])[0]
        return ca.vertcat(*(first + (last - first) * k / (count - 1) for k in range(count)))

    def _call_cat(self, node: Call) -> SX:
        dimension = self._indices(node.arguments[0])[0]
        parts = [self(argument) for argument in node.arguments[1:]]
        return ca.vertcat(*parts) if dimension == 1 else ca.horzcat(*parts)

    def _call_der(self, node: Call) -> SX:
        if self.mode is Mode.PARAMETER:
            raise self.error("der() has no place in a parameter's value or a start", node)
        system = self.symbols.system
        value = self(node.arguments[0])
        result = ca.jacobian(ca.vec(value), system.time)
        for symbol in ca.symvar(value):
            name = symbol.name()
            if name in system.unknowns:
                result = result + ca.jacobian(ca.vec(value), symbol) * system.derivative(name)
            elif name in system.inputs:
                raise self.error(f"{render(node)} needs the derivative of the input {name}, which is not known", node)
            elif name.startswith("der("):
                raise self.error(f"{render(node)}: give {name} a name of its own and differentiate that", node)
        return ca.simplify(ca.reshape(result, *value.shape))

    def _call_pre(self, node: Call) -> SX:
        if self.mode in (Mode.PARAMETER, Mode.CONTINUOUS):
            raise self.error("pre() has no place in a continuous equation", node)
        return replace(self, reading_pre=True)(node.arguments[0])

    def _call_edge(self, node: Call) -> SX:
        return ca.logic_and(self(node.arguments[0]), ca.logic_not(self._call_pre(node)))

    def _call_change(self, node: Call) -> SX:
        return self(node.arguments[0]) != self._call_pre(node)

    def _call_initial(self, node: Call) -> SX:
        return self.symbols.system.initial

    def _call_sample(self, node: Call) -> SX:
        if self.mode is not Mode.DISCRETE:
            raise self.error("sample() can stand only in a when-condition", node)
        parameter = replace(self, mode=Mode.PARAMETER)
        start, interval = (parameter(argument) for argument in node.arguments)
        clocks = self.symbols.system.clocks
        for clock in clocks:
            if ca.is_equal(clock.start, start, 10) and ca.is_equal(clock.interval, interval, 10):
                return clock.fired
        clocks.append(Clock(SX.sym(f"fired({len(clocks)})"), start, interval))
        return clocks[-1].fired

    def _call_floor(self, node: Call) -> SX:
        return self._floor(self(node.arguments[0]), node)

    _call_integer = _call_floor

    def _call_ceil(self, node: Call) -> SX:
        return -self._floor(-self(node.arguments[0]), node)

    def _call_mod(self, node: Call) -> SX:
        x, y = (self(argument) for argument in node.arguments)
        return x - self._floor(x / y, node) * y

    def _call_div(self, node: Call) -> SX:
        x, y = (self(argument) for argument in node.arguments)
        if self._varies(x / y) and not self.no_event and self.mode is not Mode.SAMPLED:
            raise self.error("div() and rem() of continuous quantities are not supported; use mod() or floor()", node)
        quotient = x / y
        return ca.if_else(quotient >= 0, ca.floor(quotient), ca.ceil(quotient))

    def _call_rem(self, node: Call) -> SX:
        x, y = (self(argument) for argument in node.arguments)
        return x - self._call_div(node) * y

    def _floor(self, value: SX, node: Call) -> SX:
        """floor(value): between events it is a held integer, and leaving [k, k+1) is the event (Modelica 3.7.2)."""
        if self.mode in (Mode.PARAMETER, Mode.SAMPLED) or self.no_event or not self._varies(value):
            return ca.floor(value)
        symbols, text = self.symbols, render(node)
        name = next((h.name for h in symbols.held if ca.is_equal(h.value, value, 50)), None)
        if name is None:
            name = f"$floor{len(symbols.held) + 1}"
            symbols.held.append(Held(name, value, text, node.at))
            declare_held(symbols, name)
            held = symbols.values[name]
            self._event(value - held, False, f"{text} steps down")
            self._event(held + 1 - value, True, f"{text} steps up")
        return symbols.values[name] if self.mode is Mode.CONTINUOUS else symbols.new[name]


def declare_held(symbols: Symbols, name: str, kind: str = "Integer") -> None:
    """Make a discrete variable of our own."""
    variable = Variable(
        name=name, type="Integer" if kind == "Integer" else "Boolean", variability="discrete", causality="local",
        dimensions=(), start=None, fixed=None, binding=None, minimum=None, maximum=None, nominal=None, unit=None,
        display_unit=None, quantity=None, description=None, state_select="default", final=False, protected=True,
        literals=(), at=0,
    )  # fmt: skip
    symbols.flat.variables[name] = variable
    symbols.values[name] = SX.sym(name)
    symbols.pre[name] = SX.sym(f"pre({name})")
    symbols.new[name] = SX.sym(f"new({name})")
    scalar = Scalar(name, variable, symbols.values[name], SX(0.0), 1.0)
    symbols.scalars[name] = scalar
    symbols.system.discretes[name] = scalar
    symbols.system.pre[name] = symbols.pre[name]
    symbols.system.new[name] = symbols.new[name]


def _reduce(operation: Callable[[SX, SX], SX], values: list[SX]) -> SX:
    """Fold in a balanced tree, so that a long chain does not become a long dependence in the generated code."""
    while len(values) > 1:
        paired = [operation(a, b) for a, b in zip(values[::2], values[1::2], strict=False)]
        values = paired + ([values[-1]] if len(values) % 2 else [])
    return values[0]
