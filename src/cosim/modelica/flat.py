"""The flat model: what is left of a Modelica model once inheritance, modification and connections are worked out."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Literal as OneOf

from cosim.modelica.expressions import Expression, references
from cosim.modelica.source import Source

Type = OneOf["Real", "Integer", "Boolean", "Enumeration", "String"]
Variability = OneOf["constant", "parameter", "discrete", "continuous"]
Causality = OneOf["input", "output", "local"]
StateSelect = OneOf["never", "avoid", "default", "prefer", "always"]


@dataclass(frozen=True)
class Variable:
    """A declared variable; an array keeps its dimensions."""

    name: str
    type: Type
    variability: Variability
    causality: Causality
    dimensions: tuple[int, ...]
    start: Expression | None
    fixed: bool | None
    binding: Expression | None
    minimum: Expression | None
    maximum: Expression | None
    nominal: Expression | None
    unit: str | None
    display_unit: str | None
    quantity: str | None
    description: str | None
    state_select: StateSelect
    final: bool
    protected: bool
    literals: tuple[str, ...]
    """Names of an enumeration's values, the first of which is 1."""
    at: int


@dataclass(frozen=True)
class Equation:
    """``residual = 0``; ``origin`` is the component or connection it came from."""

    residual: Expression
    origin: str
    at: int


@dataclass(frozen=True)
class Assign:
    """``target = value`` inside a when-clause, algorithm or function."""

    target: str
    subscripts: tuple[Expression | None, ...]
    value: Expression
    at: int


@dataclass(frozen=True)
class Reinit:
    """``reinit(state, value)``."""

    state: str
    value: Expression
    at: int


@dataclass(frozen=True)
class Conditional:
    """An if inside a when-clause or algorithm; each branch holds actions."""

    branches: tuple[tuple[Expression, tuple[Action, ...]], ...]
    otherwise: tuple[Action, ...]
    at: int


@dataclass(frozen=True)
class Assertion:
    """``assert(condition, message, level)``."""

    condition: Expression
    message: Expression
    is_error: bool
    at: int


@dataclass(frozen=True)
class Terminate:
    """``terminate(message)``."""

    message: Expression
    at: int


@dataclass(frozen=True)
class Assigns:
    """``(a, b) := function(...)``; ``None`` is an output that is left out."""

    targets: tuple[Assign | None, ...]
    at: int


@dataclass(frozen=True)
class Loop:
    """``for index in domain loop``."""

    index: str
    domain: Expression
    body: tuple[Action, ...]
    at: int


@dataclass(frozen=True)
class While:
    """``while condition loop``."""

    condition: Expression
    body: tuple[Action, ...]
    at: int


@dataclass(frozen=True)
class Return:
    """``return``."""

    at: int


Action = Assign | Assigns | Reinit | Conditional | Loop | While | Return | Assertion | Terminate


@dataclass(frozen=True)
class When:
    """A when-clause: the first branch whose condition becomes true acts.

    In an algorithm the actions run one after another and may assign a variable more than once (``sequential``); in an
    equation section they are equations.
    """

    branches: tuple[tuple[Expression, tuple[Action, ...]], ...]
    sequential: bool
    at: int


def targets(actions: tuple[Action | When, ...]) -> Iterator[str]:
    """The variables that are assigned somewhere in ``actions``."""
    for action in actions:
        if isinstance(action, Assign):
            yield action.target
        elif isinstance(action, Assigns):
            yield from (target.target for target in action.targets if target is not None)
        elif isinstance(action, Conditional):
            for body in (*(body for _, body in action.branches), action.otherwise):
                yield from targets(body)
        elif isinstance(action, Loop | While):
            yield from targets(action.body)
        elif isinstance(action, When):
            for _, body in action.branches:
                yield from targets(body)


def reads(actions: tuple[Action | When, ...]) -> Iterator[str]:
    """The variables that are used somewhere in ``actions``."""
    for action in actions:
        match action:
            case Assign(subscripts=subscripts, value=value):
                yield from references(value)
                yield from (name for s in subscripts if s is not None for name in references(s))
            case Assigns(targets=assigned):
                yield from reads(tuple(target for target in assigned if target is not None))
            case Conditional(branches=branches, otherwise=otherwise):
                yield from (name for condition, body in branches for name in (*references(condition), *reads(body)))
                yield from reads(otherwise)
            case When(branches=branches):
                yield from (name for condition, body in branches for name in (*references(condition), *reads(body)))
            case Loop(domain=expression, body=body) | While(condition=expression, body=body):
                yield from (*references(expression), *reads(body))
            case Reinit(value=value):
                yield from references(value)
            case Assertion(condition=condition):
                yield from references(condition)


@dataclass(frozen=True)
class Local:
    """An input, output or protected variable of a function."""

    name: str
    type: str
    """Modelica's predefined type, or the full name of an enumeration or record."""
    dimensions: tuple[Expression | None, ...]
    """``None`` where the argument decides."""
    value: Expression | None
    """Default of an input, initial value of the others."""
    at: int


@dataclass(frozen=True)
class Function:
    """A function of the model, or the constructor of a record, whose fields are the inputs."""

    name: str
    inputs: tuple[Local, ...]
    """A record among them comes as its fields, ``r_x`` and so on."""
    outputs: tuple[Local, ...]
    locals: tuple[Local, ...]
    body: tuple[Action, ...]
    is_constructor: bool
    at: int


@dataclass(frozen=True)
class Algorithm:
    """The statements of an algorithm section."""

    statements: tuple[Action, ...]
    at: int


@dataclass(frozen=True)
class FlatModel:
    """A whole flat model."""

    name: str
    source: Source
    description: str | None
    variables: dict[str, Variable]
    equations: tuple[Equation, ...]
    initial_equations: tuple[Equation, ...]
    whens: tuple[When, ...]
    assertions: tuple[Assertion, ...]
    enumeration_values: dict[str, int]
    """Value of every enumeration literal by its full name."""
    algorithms: tuple[Algorithm, ...] = ()
    initial_algorithms: tuple[Algorithm, ...] = ()
    functions: dict[str, Function] = field(default_factory=dict)
    structural: frozenset[str] = frozenset()
    """Parameters whose value has decided which equations or components there are, or how large an array is."""
