"""The hybrid system: the flat model's scalar equations in CasADi symbols, its discrete part in a fixed order.

Symbols and their names:

====================  =====================================================================================
``x``                 a continuous unknown, an input, a parameter, or a discrete variable as it stands
                      between events
``der(x)``            time derivative of a continuous unknown
``pre(b)``            value of a discrete variable before the event
``new(b)``            value of a discrete variable after the event
``relation(k)``       truth value of a relation, held between events
``fired(k)``          1 while sample clock k ticks
``initial``           1 during initialisation
====================  =====================================================================================
"""

from __future__ import annotations

from dataclasses import dataclass, field

import casadi as ca

from cosim.modelica.flat import Causality, StateSelect, Type, Variability, Variable
from cosim.modelica.source import Source

SX = ca.SX


@dataclass
class Scalar:
    """One scalar variable, with the attributes of its declaration worked out."""

    name: str
    declaration: Variable
    symbol: SX
    start: SX | None
    """Start value as an expression of parameters; ``None`` if the model gives none."""
    nominal: float

    @property
    def type(self) -> Type:
        """Modelica's predefined type."""
        return self.declaration.type

    @property
    def variability(self) -> Variability:
        """How often the value may change."""
        return self.declaration.variability

    @property
    def causality(self) -> Causality:
        """Input, output or local of the whole model."""
        return self.declaration.causality

    @property
    def fixed(self) -> bool:
        """Whether the start value is an initial condition, not only a guess."""
        return bool(self.declaration.fixed)

    @property
    def state_select(self) -> StateSelect:
        """The modeller's wish."""
        return self.declaration.state_select


@dataclass(frozen=True)
class Equation:
    """``residual = 0`` with its text and its place in the source."""

    residual: SX
    text: str
    at: int


@dataclass(frozen=True)
class Relation:
    """A condition on continuous quantities: true where the indicator is > 0 (strict) or >= 0.

    ``slope`` is the rate of an indicator that varies with time alone between events, at this constant rate, so that its
    change is known beforehand: a time event. It is 0 for all others.
    """

    symbol: SX
    indicator: SX
    strict: bool
    text: str
    slope: float = 0.0


@dataclass(frozen=True)
class Clock:
    """A periodic sample: ticks at start + k interval; or, if ``terminal``, once, when the simulation ends."""

    fired: SX
    start: SX
    interval: SX
    terminal: bool = False


@dataclass(frozen=True)
class Parameter:
    """A parameter; ``value`` is an expression of other parameters where it is dependent."""

    scalar: Scalar
    value: SX
    independent: bool


@dataclass(frozen=True)
class Assignment:
    """``new(targets) = values``, done while ``guard`` is true; otherwise the targets keep their pre-values.

    ``guard`` is ``None`` for equations that always hold.
    """

    targets: tuple[str, ...]
    values: SX
    guard: SX | None
    text: str
    at: int


@dataclass(frozen=True)
class Reinit:
    """``x`` gets ``value`` when ``guard`` is true at an event."""

    name: str
    value: SX
    guard: SX
    at: int


@dataclass(frozen=True)
class Check:
    """An assertion; ``condition`` must be true."""

    condition: SX
    message: str
    is_error: bool
    at: int


@dataclass
class HybridSystem:
    """Everything the structural stages work on."""

    name: str
    description: str | None
    source: Source
    time: SX
    initial: SX
    source_order: list[str]
    """Names of the declared variables in the order of the source."""
    parameters: list[Parameter] = field(default_factory=list)
    """Each after the ones it depends on."""
    inputs: dict[str, Scalar] = field(default_factory=dict)
    unknowns: dict[str, Scalar] = field(default_factory=dict)
    discretes: dict[str, Scalar] = field(default_factory=dict)
    derivatives: dict[str, SX] = field(default_factory=dict)
    """Symbol of der(x) by the name of x, for the unknowns whose derivative appears."""
    pre: dict[str, SX] = field(default_factory=dict)
    new: dict[str, SX] = field(default_factory=dict)
    equations: list[Equation] = field(default_factory=list)
    initial_equations: list[Equation] = field(default_factory=list)
    relations: list[Relation] = field(default_factory=list)
    clocks: list[Clock] = field(default_factory=list)
    assignments: list[Assignment] = field(default_factory=list)
    """In an order in which each uses only new values of the ones before."""
    reinits: list[Reinit] = field(default_factory=list)
    checks: list[Check] = field(default_factory=list)
    terminations: list[tuple[SX, str]] = field(default_factory=list)

    def derivative(self, name: str) -> SX:
        """The symbol of der(name), made when it is first asked for."""
        if name not in self.derivatives:
            self.derivatives[name] = SX.sym(f"der({name})")
        return self.derivatives[name]
