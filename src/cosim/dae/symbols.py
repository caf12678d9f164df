"""The names of a model while it is lowered: the CasADi symbols of each variable, and how an expression is read."""

from __future__ import annotations

import enum
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Self

import casadi as ca

from cosim.dae.hybrid import SX, Check, HybridSystem, Scalar
from cosim.errors import ModelError
from cosim.modelica.expressions import Expression
from cosim.modelica.flat import FlatModel, Type, Variable


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
    """A discrete variable of our own that holds ``value`` between events."""

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
    structural: set[str] = field(default_factory=set)
    """Parameters whose default value has decided the shape of something, so that they cannot be set any more."""


def element_names(name: str, dimensions: tuple[int, ...]) -> list[str]:
    """Names of the elements, columns first as CasADi stores them."""
    if not dimensions:
        return [name]
    if len(dimensions) == 1:
        return [f"{name}[{i + 1}]" for i in range(dimensions[0])]
    rows, columns = dimensions
    return [f"{name}[{i + 1},{j + 1}]" for j in range(columns) for i in range(rows)]


def declare_held(symbols: Symbols, name: str, kind: Type = "Integer") -> None:
    """Make a discrete variable of our own."""
    variable = Variable(
        name=name, type=kind, variability="discrete", causality="local",
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


def held_previous(symbols: Symbols, previous: SX) -> SX:
    """A discrete variable that has the value of ``pre(d)`` also between events, where relations are watched."""
    held = next((h for h in symbols.held if ca.is_equal(h.value, previous)), None)
    if held is None:
        text = previous.name()
        held = Held(f"$pre{len(symbols.held) + 1}", previous, text, 0)
        symbols.held.append(held)
        declare_held(symbols, held.name, "Real")
        symbols.scalars[held.name].start = symbols.scalars[text[4:-1]].start
    return symbols.scalars[held.name].symbol


@dataclass(frozen=True)
class Evaluate(ABC):
    """An evaluator of expressions, as the functions see it that it calls; :class:`Evaluator` is the one there is."""

    symbols: Symbols
    mode: Mode
    no_event: bool = False
    """Relations are plain comparisons, whatever the mode."""
    reading_pre: bool = False
    """Inside pre()."""
    path: SX | None = None
    """The condition under which the value matters; ``None`` if it always does."""
    locals: Mapping[str, SX] = field(default_factory=dict)
    """Values that override variables: what an algorithm has assigned so far, or a loop index."""
    ranks: Mapping[str, int] = field(default_factory=dict)
    """How many dimensions the variables of the function have, in which we are."""
    texts: Mapping[str, str] = field(default_factory=dict)
    """Values of String inputs of that function."""
    function: tuple[str, ...] = ()
    """That function, after the ones that have called it."""
    checks: list[Check] | None = None
    """Where assertions inside functions go; ``None``: they must hold at all times."""

    def alike(self, **changes: Any) -> Self:  # noqa: ANN401 - attributes of any type
        """The same but for the attributes given."""
        return replace(self, **changes)

    def error(self, message: str, expression: Expression) -> ModelError:
        """An error at the place of an expression."""
        return self.symbols.flat.source.error(message, expression.at)

    @abstractmethod
    def __call__(self, expression: Expression) -> SX:
        """The CasADi value of an expression."""

    @abstractmethod
    def varies(self, value: SX) -> bool:
        """Whether a value can change between events."""

    @abstractmethod
    def indices(self, node: Expression) -> list[int]:
        """The integers of a subscript, a size or a loop range, which must be known when compiling."""

    @abstractmethod
    def event(self, indicator: SX, strict: bool, text: str) -> SX:
        """The truth value of a relation that makes events; the same relation is made only once."""

    @abstractmethod
    def components(self, record: Expression) -> list[str] | None:
        """The names of the components, if this is a record; ``None`` if it is not."""

    @abstractmethod
    def component(self, record: Expression, name: str) -> SX:
        """The value of a component of a record."""
