"""The flat model: what is left of a Modelica model once inheritance, modification and connections are worked out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal as OneOf

from cosim.modelica.expressions import Expression
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
    """``target = value`` inside a when-clause or algorithm."""

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
    message: str
    is_error: bool
    at: int


@dataclass(frozen=True)
class Terminate:
    """``terminate(message)``."""

    message: str
    at: int


Action = Assign | Reinit | Conditional | Assertion | Terminate


@dataclass(frozen=True)
class When:
    """A when-clause: the first branch whose condition becomes true acts.

    In an algorithm the actions run one after another and may assign a variable more than once (``sequential``); in an
    equation section they are equations.
    """

    branches: tuple[tuple[Expression, tuple[Action, ...]], ...]
    sequential: bool
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
