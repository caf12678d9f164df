"""Finds the unit of every subexpression and compares those that must be the same."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction

from cosim.modelica._declared_units import DeclaredUnits
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
    children,
    render,
)
from cosim.modelica.flat import FlatModel, Function, Variable
from cosim.modelica.quantity import (
    NUMBER,
    OPAQUE,
    PLAIN,
    SECOND,
    TIME,
    UNKNOWN,
    Powers,
    Quantity,
    declared,
    difference,
    write,
)

_NUMERIC_ARGUMENT = {"sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "log", "log10"}
_TRANSPARENT = {
    "pre", "noEvent", "abs", "floor", "ceil", "integer", "transpose", "vector", "scalar", "matrix", "symmetric",
    "diagonal", "skew", "sum", "fill", "delay", "previous", "hold", "inStream", "actualStream",
}  # fmt: skip
"""Functions whose value has the unit of their first argument."""
_ALIKE = {"min": 0, "max": 0, "mod": 0, "rem": 0, "linspace": 0, "homotopy": 0, "cat": 1}
"""Functions whose arguments, from this one on, have one unit, which their value has too; linspace has two."""
_SPECIAL = {
    "der": 1, "sqrt": 1, "atan2": 2, "sign": 1, "div": 2, "smooth": 2, "cross": 2, "outerProduct": 2, "product": 1,
    "semiLinear": 3, "sample": 2,
}  # fmt: skip
"""Functions with a method of their own, and the number of their arguments."""
_COUNTS = {"size", "ndims", "zeros", "ones", "identity", "Integer", "cardinality"}


@dataclass(frozen=True)
class Finding:
    """A mismatch in one expression."""

    problem: str
    units: str
    """The units alone, by which findings in instances of one class are told to be the same."""
    at: int


class Terms:
    """The variables of a model with their units, as declared or inferred, and the comparison of expressions."""

    def __init__(self, flat: FlatModel) -> None:
        """Read the declared units; variables without are open if an equation may settle their unit."""
        self._flat = flat
        self.units = DeclaredUnits(flat.source)
        self._quantities: dict[str, Quantity] = {}
        self._reasons: dict[str, str] = {}
        self.open: set[str] = set()
        self.solved: dict[str, Powers] = {}
        """What the expressions looked at say about open variables."""
        self.findings: list[Finding] = []
        self.scope: Mapping[str, Quantity] = {}
        """Variables of a function and indices of loops, which hide those of the model."""
        for variable in flat.variables.values():
            self._quantities[variable.name] = self._declared(variable)

    def _declared(self, variable: Variable) -> Quantity:
        if variable.type == "Integer":
            return NUMBER
        if variable.type != "Real":
            return UNKNOWN
        if variable.unit:
            return declared(variable.unit) or UNKNOWN
        if variable.variability == "constant" and variable.binding is not None and _number(variable.binding):
            return NUMBER
        if variable.dimensions:
            return UNKNOWN  # its elements may have different units
        self.open.add(variable.name)
        return Quantity(unknown=((variable.name, Fraction(1)),), factor=None)

    def settle(self, name: str, powers: Powers, reason: str) -> None:
        """Give an open variable the unit that an equation leaves it."""
        self.open.discard(name)
        self._reasons[name] = reason
        self._quantities[name] = Quantity(powers, measured=True, factor=None, inferred=frozenset({name}))

    # comparison

    def same(self, left: Expression, right: Expression) -> None:
        """Compare two expressions; a finding for each pair of alternatives or elements that have different units."""
        if isinstance(left, Array) and isinstance(right, Array) and len(left.elements) == len(right.elements):
            for one, other in zip(left.elements, right.elements, strict=True):
                self.same(one, other)
        elif parts := _alternatives(left):
            self._conditions(left)
            for part in parts:
                self.same(part, right)
        elif parts := _alternatives(right):
            self._conditions(right)
            for part in parts:
                self.same(left, part)
        else:
            self._fit(left, self.quantity(left), right, self.quantity(right))

    def _conditions(self, node: Expression) -> None:
        for condition, _ in node.branches if isinstance(node, If) else ():
            self.quantity(condition)

    def _fit(self, left: Expression, a: Quantity, right: Expression, b: Quantity, *, points: bool = True) -> bool:
        """Whether two quantities fit; ``points``: they are values on a scale, whose zeros must agree."""
        self._solve(a, b)
        self._solve(b, a)
        if a.free or b.free or not a.known or not b.known:
            return True
        problem = difference(a, b, points=points)
        if problem is None:
            return True
        text = f"{render(left)} is in {a}, but {render(right)} is in {b}{problem}{self._why(a, b)}"
        self.findings.append(Finding(text, f"{a}|{b}", right.at or left.at))
        return False

    def _solve(self, a: Quantity, b: Quantity) -> None:
        """Note the unit of the one open variable of ``a``, if ``b`` determines it."""
        if len(a.unknown) != 1 or a.free or not b.known or not b.measured:
            return
        ((name, exponent),) = a.unknown
        if name != OPAQUE:
            unit = (Quantity(b.powers) / Quantity(a.powers)) ** (1 / exponent)
            self.solved.setdefault(name, unit.powers)

    def _why(self, *quantities: Quantity) -> str:
        names = sorted(frozenset[str]().union(*(q.inferred for q in quantities)))
        return "".join(
            f"; {name} has no unit, {write(self._quantities[name].powers)} follows from {self._reasons[name]}"
            for name in names
        )

    def _plain(self, node: Expression, q: Quantity, what: str) -> None:
        """Require a plain number or an angle in rad."""
        if not q.known or q.free or (not q.measured and q.factor in (None, 1.0)):
            return
        if q.powers:
            self._found(node, q, f"{what} is in {q}, but must be a number without unit")
        elif q.factor is not None and not math.isclose(q.factor, 1.0, rel_tol=1e-9):
            self._found(node, q, f"{what} is in {q}, but must be a plain number or an angle in rad")

    def _found(self, node: Expression, q: Quantity, problem: str) -> None:
        self.findings.append(Finding(problem + self._why(q), str(q), node.at))

    # functions of the model

    def own(self, function: Function) -> dict[str, Quantity]:
        """The variables of a function with their declared units; without a unit they fit any."""
        variables = (*function.inputs, *function.outputs, *function.locals)
        return {variable.name: self.units.local(variable) for variable in variables}

    def _user_call(self, node: UserCall, position: int) -> Quantity:
        quantities = [self.quantity(argument) for argument in node.arguments]
        function = self._flat.functions.get(node.function)
        if function is None or function.is_constructor or position >= len(function.outputs):
            return UNKNOWN
        for argument, given, declared_input in zip(node.arguments, quantities, function.inputs, strict=False):
            wanted = self.units.local(declared_input)
            self._solve(given, wanted)
            if given.free or not given.known or wanted.free or not wanted.known:
                continue
            problem = difference(given, wanted, points=True)
            if problem is not None:
                text = f"the argument {render(argument)} of {function.name}() is in {given}, but"
                self._found(argument, given, f"{text} the input {declared_input.name} is in {wanted}{problem}")
        return self.units.local(function.outputs[position])

    # expressions

    def quantity(self, node: Expression) -> Quantity:
        """The unit of an expression; what is wrong inside becomes a finding."""
        match node:
            case Literal(value=bool()) | Literal(value=str()):
                return UNKNOWN
            case Literal():
                return self.units.constant(node) or NUMBER
            case Reference(name="time"):
                return TIME
            case Reference(name=name):
                for child in children(node):
                    self.quantity(child)
                return self.scope[name] if name in self.scope else self._quantities.get(name, UNKNOWN)
            case Unary(operator=operator, operand=operand):
                inner = self.units.constant(node) or self.quantity(operand)
                return UNKNOWN if operator == "not" else inner
            case Binary():
                return self.units.constant(node) or self._binary(node)
            case If(branches=branches, otherwise=otherwise):
                for condition, _ in branches:
                    self.quantity(condition)
                return self._all_alike([*(value for _, value in branches), otherwise])
            case Call():
                return self._call(node)
            case Array(elements=elements):
                return self._elements(elements)
            case Range():
                return NUMBER
            case Comprehension(element=element, index=index):
                outside, self.scope = self.scope, {**self.scope, index: NUMBER}
                result = self.quantity(element)
                self.scope = outside
                return result
            case UserCall():
                return self._user_call(node, 0)
            case Output(call=call, position=position):
                return self._user_call(call, position)
            case Field(record=record):
                self.quantity(record)
                return UNKNOWN
        return UNKNOWN

    def _all_alike(self, nodes: list[Expression]) -> Quantity:
        """The unit that all these have."""
        kept, result = nodes[0], self.quantity(nodes[0])
        for node in nodes[1:]:
            q = self.quantity(node)
            fits = self._fit(kept, result, node, q)
            if result.free or not result.known:
                kept = node
            result = result.sum(q) if fits else UNKNOWN
        return result

    def _elements(self, elements: tuple[Expression, ...]) -> Quantity:
        """An array that is a factor or an argument: its elements may have different units, of which none is its own."""
        quantities = [self.quantity(element) for element in elements]
        fixed = [q for q in quantities if q.known and not q.free]
        if not fixed or any(difference(fixed[0], q, points=True) for q in fixed):
            return NUMBER if all(q.free for q in quantities) else UNKNOWN
        return fixed[0] if all(q.known for q in quantities) else UNKNOWN

    def _binary(self, node: Binary) -> Quantity:
        operator = node.operator.removeprefix(".")
        if operator == "^":
            return self._power(node)
        if operator in ("and", "or"):
            self.quantity(node.left)
            self.quantity(node.right)
            return UNKNOWN
        if operator in ("*", "/"):
            left, right = self.quantity(node.left), self.quantity(node.right)
            return left * right if operator == "*" else left / right
        if operator in ("+", "-"):
            left, right = self.quantity(node.left), self.quantity(node.right)
            fits = self._fit(node.left, left, node.right, right, points=False)
            return left.sum(right, minus=operator == "-") if fits else UNKNOWN
        self.same(node.left, node.right)
        return UNKNOWN

    def _power(self, node: Binary) -> Quantity:
        base, exponent = self.quantity(node.left), self.quantity(node.right)
        self._plain(node.right, exponent, f"the exponent {render(node.right)}")
        value = self._value(node.right)
        if value is not None:
            return base ** Fraction(value).limit_denominator(1000)
        return base if base.known and not base.powers else UNKNOWN

    def _value(self, node: Expression) -> float | None:
        """The number of a constant expression."""
        match node:
            case Literal(value=bool()) | Literal(value=str()):
                return None
            case Literal(value=value):
                return float(value)
            case Unary(operator="-", operand=operand):
                inner = self._value(operand)
                return None if inner is None else -inner
            case Binary(operator="+" | "-" | "*" | "/" as operator, left=left, right=right):
                a, b = self._value(left), self._value(right)
                if a is None or b is None or (operator == "/" and b == 0):
                    return None
                return {"+": a + b, "-": a - b, "*": a * b, "/": a / (b or 1.0)}[operator]
            case Reference(name=name, subscripts=()):
                variable = self._flat.variables.get(name)
                if variable is not None and variable.variability == "constant" and variable.binding is not None:
                    return self._value(variable.binding)
        return None

    def _call(self, node: Call) -> Quantity:
        name, arguments = node.function, node.arguments
        if _SPECIAL.get(name) == len(arguments):
            special: Callable[[Call], Quantity] = getattr(self, f"_call_{name}")
            return special(node)
        if name in _ALIKE:
            for argument in arguments[: _ALIKE[name]]:
                self.quantity(argument)
            last = 2 if name == "linspace" else len(arguments)
            return self._all_alike(
                _spread(arguments[_ALIKE[name] : last])
                if name in ("min", "max")
                else list(arguments[_ALIKE[name] : last])
            )
        quantities = [self.quantity(argument) for argument in arguments]
        if name in _NUMERIC_ARGUMENT:
            self._plain(arguments[0], quantities[0], f"the argument {render(arguments[0])} of {name}()")
            return PLAIN
        if name in _TRANSPARENT and quantities:
            return quantities[0]
        if name in _COUNTS:
            return NUMBER
        return UNKNOWN

    def _call_der(self, node: Call) -> Quantity:
        return self.quantity(node.arguments[0]) / SECOND

    def _call_sqrt(self, node: Call) -> Quantity:
        return self.quantity(node.arguments[0]) ** Fraction(1, 2)

    def _call_atan2(self, node: Call) -> Quantity:
        self.same(*node.arguments[:2])
        return PLAIN

    def _call_sign(self, node: Call) -> Quantity:
        self.quantity(node.arguments[0])
        return NUMBER

    def _call_div(self, node: Call) -> Quantity:
        self.same(*node.arguments[:2])
        return NUMBER

    def _call_smooth(self, node: Call) -> Quantity:
        return self.quantity(node.arguments[-1])

    def _call_cross(self, node: Call) -> Quantity:
        left, right = (self.quantity(argument) for argument in node.arguments[:2])
        return left * right

    _call_outerProduct = _call_cross  # noqa: N815 - Modelica's name

    def _call_product(self, node: Call) -> Quantity:
        q = self.quantity(node.arguments[0])
        return q if q.known and not q.powers else UNKNOWN

    def _call_semiLinear(self, node: Call) -> Quantity:  # noqa: N802 - Modelica's name
        x, *slopes = node.arguments
        return self.quantity(x) * self._all_alike(slopes)

    def _call_sample(self, node: Call) -> Quantity:
        for argument in node.arguments:
            self.same(Reference("time", (), argument.at), argument)
        return UNKNOWN


def _number(node: Expression) -> bool:
    """Whether an expression holds literals only."""
    if isinstance(node, Reference):
        return False
    return all(_number(child) for child in children(node))


def _alternatives(node: Expression) -> list[Expression]:
    """The expressions one of which a value is, or all of which are elements of it."""
    match node:
        case If(branches=branches, otherwise=otherwise):
            return [*(value for _, value in branches), otherwise]
        case Array(elements=elements):
            return list(elements)
        case Call(function="noEvent", arguments=(argument,)):
            return [argument]
    return []


def _spread(nodes: tuple[Expression, ...]) -> list[Expression]:
    """The elements of array constructors in place of these."""
    spread: list[Expression] = []
    for node in nodes:
        spread += _spread(node.elements) if isinstance(node, Array) else [node]
    return spread
