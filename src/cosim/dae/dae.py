"""The result of compilation: an index-1 semi-explicit hybrid DAE with few unknowns."""

from __future__ import annotations

from dataclasses import dataclass, field

import casadi as ca

from cosim.dae.constraints import Constraints
from cosim.dae.hybrid import SX, Assignment, Check, Clock, Parameter, Relation, Scalar
from cosim.dae.tearing import Block


@dataclass(frozen=True)
class Unknown:
    """A continuous state or a torn unknown."""

    name: str
    symbol: SX
    start: SX
    """Initial condition or guess, as an expression of parameters."""
    nominal: float


@dataclass(frozen=True)
class Published:
    """A variable that importers see, and its value in terms of the Dae's arguments."""

    scalar: Scalar
    value: SX


@dataclass(frozen=True)
class Computed:
    """An unknown that is computed, its value in terms of the Dae's arguments, and from what, as text."""

    name: str
    value: SX
    remark: str


@dataclass(frozen=True)
class Reset:
    """The state at ``index`` gets ``value`` when ``guard`` is true at an event."""

    index: int
    value: SX
    guard: SX


@dataclass(frozen=True)
class Sizes:
    """How many equations there were at each stage, for ``--explain``."""

    flat: int
    after_aliases: int
    differentiated: int
    index: int


@dataclass
class Dae:
    """dx/dt = derivatives, 0 = residuals, and what happens at events.

    Every expression is in terms of ``time``, the symbols of ``states`` (x) and ``torn`` (z), ``inputs`` (u),
    ``parameters`` (p), ``discretes`` (d) and the relations' truth values (c); those of the discrete part also of
    ``pre``, ``new``, the clocks' ``fired`` and ``initial``.
    """

    name: str
    description: str | None
    time: SX
    initial: SX
    states: list[Unknown]
    torn: list[Unknown]
    parameters: list[Parameter]
    parameter_values: dict[str, float]
    """Default values."""
    inputs: list[Scalar]
    discretes: list[Scalar]
    pre: dict[str, SX]
    new: dict[str, SX]
    derivatives: SX
    residuals: SX
    relations: list[Relation]
    clocks: list[Clock]
    assignments: list[Assignment]
    resets: list[Reset]
    checks: list[Check]
    terminations: list[tuple[SX, str]]
    initial_residuals: SX
    initial_texts: list[str]
    """Each equation of the initial system, with its place in the source."""
    starts_kept: list[bool]
    """For each unknown, whether the initial system says no more of it than that it has its start value."""
    published: list[Published]
    """All variables of the model that are not protected, in the order of declaration, outputs first."""
    aliases: dict[str, str]
    """What each eliminated variable equals, as text."""
    blocks: list[Block]
    equations: list[str]
    """Text and place of the equations after index reduction; blocks refer to them by number."""
    sizes: Sizes
    differentiated: list[tuple[str, int]] = field(default_factory=list)
    """Each equation that had to be differentiated, with its place, and how often."""
    not_chosen: list[str] = field(default_factory=list)
    """Variables whose derivatives occur, and which are not states because constraints give them."""
    constraints: list[Constraints] = field(default_factory=list)
    """Where the choice of states could become wrong."""
    constrained: frozenset[str] = frozenset()
    """Parameters in equations that had to be differentiated, where they were taken to stand still for ever."""
    computed: list[Computed] = field(default_factory=list)
    """Every explicitly computed unknown, in the order of computation."""

    @property
    def unknowns(self) -> list[Unknown]:
        """States, then torn unknowns."""
        return [*self.states, *self.torn]

    @property
    def v(self) -> SX:
        """States and torn unknowns as one column."""
        return ca.vertcat(SX(0, 1), *(u.symbol for u in self.unknowns))

    @property
    def f(self) -> SX:
        """Derivatives and residuals as one column."""
        return ca.vertcat(self.derivatives, self.residuals)

    @property
    def z(self) -> SX:
        """The torn unknowns as one column."""
        return ca.vertcat(SX(0, 1), *(u.symbol for u in self.torn))

    @property
    def coupled_blocks(self) -> list[Block]:
        """The blocks of more than one explicit assignment, numbered from 1 wherever they are mentioned."""
        return [block for block in self.blocks if block.kind != "explicit"]
