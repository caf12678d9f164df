"""On which knowns each unknown of an FMU depends, and how: what ModelStructure in modelDescription.xml says.

An unknown is computed from knowns (inputs, states and time; in Initialization Mode inputs, parameters and time)
through torn unknowns, relations, discrete variables and dependent parameters. Those in between depend on each other
within blocks, so what an unknown depends on is what can be reached from it. Every dependency that can be is listed; one
that is listed may be zero at a point, or always if terms of several equations cancel.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum

import casadi as ca

from cosim.dae import Dae
from cosim.dae.blocks import triangular
from cosim.dae.hybrid import SX
from cosim.dae.symbolic import without_cancelled
from cosim.fmu.layout import Layout, Slot


class Kind(IntEnum):
    """What the factor of a linear dependency varies with, from the best to the worst; FMI's names in lower case."""

    CONSTANT = 0
    FIXED = 1
    TUNABLE = 2
    DISCRETE = 3
    DEPENDENT = 4


@dataclass(frozen=True)
class Dependency:
    """On the variable with this value reference."""

    reference: int
    kind: Kind


_STEPS = frozenset(
    {ca.OP_FLOOR, ca.OP_CEIL, ca.OP_SIGN, ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE, ca.OP_NOT, ca.OP_AND, ca.OP_OR,
     ca.OP_FMOD, ca.OP_COPYSIGN}
)  # fmt: skip
"""Operations whose derivative says nothing of what they depend on."""


class Dependencies:
    """The dependencies of a model's variables, by value reference."""

    def __init__(self, dae: Dae, layout: Layout) -> None:
        """Look through the equations of a Dae that is laid out as ``layout`` says."""
        self._dae = dae
        self._values = {p.scalar.name: p.value for p in dae.published}
        self._reference = _references(layout)
        self._slots = layout.slots
        tunable = {slot.name for slot in layout.slots if slot.variability == "tunable"}
        self._levels = _levels(dae, tunable)
        self._between = _Between(dae, self._levels)
        self._knowns = self._places("STORE_UNKNOWN", [u.symbol for u in dae.states])
        self._knowns |= self._places("STORE_INPUT", [s.symbol for s in dae.inputs])
        self._knowns[dae.time.name()] = self._reference["STORE_TIME", 0]
        start = {p.scalar.name for p in dae.parameters if p.independent}
        self._initial_knowns = {name: k for name, k in self._knowns.items() if name not in self._between.states}
        self._initial_knowns |= {
            name: k
            for name, k in self._places("STORE_PARAMETER", [p.scalar.symbol for p in dae.parameters]).items()
            if name in start
        }
        self._while_running = _reaching(self._between.links())
        self._at_start = _reaching(_initial_links(dae))

    def of(self, reference: int) -> list[Dependency]:
        """What an output or a state derivative depends on after initialisation: inputs, states, time."""
        expression = self._expression(self._slots[reference])
        reached = self._while_running(_names(expression))
        kinds: dict[str, Kind] = {}
        if self._slots[reference].type == "TYPE_REAL":
            kinds = self._between.kinds(expression)
            # what is held between events jumps at them
            kinds |= dict.fromkeys(self._while_running(self._between.held & kinds.keys()), Kind.DEPENDENT)
        return self._listed(reached, kinds, self._knowns)

    def of_initial(self, reference: int) -> list[Dependency]:
        """What an initial unknown depends on in Initialization Mode: inputs, parameters, time."""
        reached = self._at_start(_names(self._expression(self._slots[reference])))
        return self._listed(reached, {}, self._initial_knowns)

    def _expression(self, slot: Slot) -> SX:
        """The value of a variable in terms of the Dae's arguments."""
        if slot.store == "STORE_DERIVATIVE":
            return self._dae.derivatives[slot.index]
        if slot.store == "STORE_UNKNOWN":
            return self._dae.unknowns[slot.index].symbol
        if slot.store == "STORE_INDICATOR":
            return self._dae.relations[slot.index].indicator
        return self._values[slot.name]

    def _places(self, store: str, symbols: Iterable[SX]) -> dict[str, int]:
        """Value references of the symbols that importers can see."""
        return {
            symbol.name(): self._reference[store, index]
            for index, symbol in enumerate(symbols)
            if (store, index) in self._reference
        }

    def _listed(
        self, reached: Collection[str], kinds: Mapping[str, Kind], knowns: Mapping[str, int]
    ) -> list[Dependency]:
        found = {knowns[name]: self._kind(knowns[name], kinds.get(name)) for name in reached if name in knowns}
        return [Dependency(reference, kind) for reference, kind in sorted(found.items())]

    def _kind(self, known: int, kind: Kind | None) -> Kind:
        real = self._slots[known].type == "TYPE_REAL"
        return kind if kind is not None and real else Kind.DEPENDENT


def _references(layout: Layout) -> dict[tuple[str, int], int]:
    """The variable by which a place is known: of several equal ones the input, parameter or state, else the first."""
    found: dict[tuple[str, int], int] = {}
    for reference, slot in enumerate(layout.slots):
        place = slot.store, slot.index
        if place not in found or slot.causality in ("input", "parameter"):
            found[place] = reference
    states = (slot.derivative_of for slot in layout.slots if slot.derivative_of is not None)
    return found | {(layout.slots[reference].store, layout.slots[reference].index): reference for reference in states}


class _Between:
    """What stands between knowns and unknowns after initialisation."""

    def __init__(self, dae: Dae, levels: Mapping[str, Kind]) -> None:
        self._dae = dae
        self._levels = levels
        self.states = {u.symbol.name() for u in dae.states}
        self.held = {r.symbol.name() for r in dae.relations} | {s.symbol.name() for s in dae.discretes}
        self._torn: dict[str, dict[str, Kind]] = {}
        """For each torn unknown, the kind of its dependency on knowns and on what is held."""
        self._blocks: list[tuple[list[int], list[int]]] = _blocks(dae.residuals, [u.symbol for u in dae.torn])
        for rows, columns in self._blocks:
            self._solve(rows, [dae.torn[j].symbol for j in columns])

    def links(self) -> dict[str, set[str]]:
        """For each symbol in between, the symbols that it is computed from at the same instant."""
        links = _discrete_links(self._dae)
        for rows, columns in self._blocks:
            names = _names(self._dae.residuals[rows])
            links |= {self._dae.torn[j].symbol.name(): names for j in columns}
        return links

    def kinds(self, expression: SX) -> dict[str, Kind]:
        """How an expression depends on knowns, as far as relations and discrete variables keep their values."""
        return self._through(_factors(expression, self._levels))

    def _solve(self, rows: list[int], unknowns: list[SX]) -> None:
        """The solution of a block: the factors of its unknowns turn up in the inverse of its matrix."""
        own = {unknown.name() for unknown in unknowns}
        factors: dict[str, Kind] = {}
        for row in rows:
            for name, kind in _factors(self._dae.residuals[row], self._levels).items():
                factors[name] = max(kind, factors.get(name, kind))
        within = max((kind for name, kind in factors.items() if name in own), default=Kind.CONSTANT)
        outside = {name: max(kind, within) for name, kind in factors.items() if name not in own}
        solved = self._through(outside)
        self._torn |= dict.fromkeys(own, solved)

    def _through(self, factors: Mapping[str, Kind]) -> dict[str, Kind]:
        """Factors of torn unknowns replaced by what these depend on."""
        result: dict[str, Kind] = {}
        for name, kind in factors.items():
            for known, inner in self._torn.get(name, {name: Kind.CONSTANT}).items():
                worst = max(kind, inner)
                result[known] = max(worst, result.get(known, worst))
        return result


def _levels(dae: Dae, tunable: Collection[str]) -> dict[str, Kind]:
    """What a factor that contains a symbol varies with."""
    levels: dict[str, Kind] = {}
    for parameter in dae.parameters:
        name = parameter.scalar.name
        own = Kind.TUNABLE if name in tunable else Kind.FIXED
        levels[name] = max([own, *(levels.get(n, Kind.FIXED) for n in _names(parameter.value))])
    levels |= dict.fromkeys((s.symbol.name() for s in dae.discretes), Kind.DISCRETE)
    return levels | dict.fromkeys((r.symbol.name() for r in dae.relations), Kind.DISCRETE)


def _factors(expression: SX, levels: Mapping[str, Kind]) -> dict[str, Kind]:
    """The kind of each dependency of an expression, on what varies continuously or is held between events."""
    expression = without_cancelled(expression)
    symbols = ca.symvar(expression)
    names = [s.name() for s in symbols]
    fixed = {Kind.FIXED, Kind.TUNABLE}
    varying = [k for k, name in enumerate(names) if levels.get(name) not in fixed]
    moving = {k for k, name in enumerate(names) if name not in levels}
    if _steps(ca.Function("f", [ca.vertcat(SX(0, 1), *symbols)], [expression]), moving):
        return {names[k]: Kind.DEPENDENT for k in varying}
    slopes = ca.densify(ca.jacobian(expression, ca.vertcat(SX(0, 1), *symbols)))
    result: dict[str, Kind] = {}
    for k in varying:
        inside = (levels.get(name, Kind.DEPENDENT) for name in _names(slopes[:, k]))
        result[names[k]] = max(inside, default=Kind.CONSTANT)
    return result


def _steps(function: ca.Function, moving: Collection[int]) -> bool:
    """Whether a function takes such steps of something that varies between events: of these entries of its argument."""
    moves: dict[int, bool] = {}
    for k in range(function.n_instructions()):
        operation, reads = function.instruction_id(k), function.instruction_input(k)
        if operation == ca.OP_OUTPUT:
            continue
        if operation == ca.OP_INPUT:
            moved = reads[1] in moving
        else:
            moved = operation != ca.OP_CONST and any(moves[register] for register in reads)
            if moved and operation in _STEPS:
                return True
        moves[function.instruction_output(k)[0]] = moved
    return False


def _blocks(residuals: SX, unknowns: Sequence[SX]) -> list[tuple[list[int], list[int]]]:
    """Which residuals give which unknowns, in the order of computation; all together if that cannot be told."""
    column = {unknown.name(): j for j, unknown in enumerate(unknowns)}
    incidence = [sorted(column[n] for n in _names(residuals[i]) & column.keys()) for i in range(len(unknowns))]
    everything = list(range(len(unknowns)))
    found = triangular(incidence, len(unknowns))
    return found if found is not None else [(everything, everything)]


def _discrete_links(dae: Dae) -> dict[str, set[str]]:
    """What relations, discrete variables and ticks are computed from; at an event, pre-values change as well."""
    links = {r.symbol.name(): _names(r.indicator) for r in dae.relations}
    for assignment in dae.assignments:
        names = _names(assignment.values) | (set() if assignment.guard is None else _names(assignment.guard))
        for target in assignment.targets:
            links[f"new({target})"] = links.get(f"new({target})", set()) | names
    for scalar in dae.discretes:
        new = f"new({scalar.name})"
        links[scalar.symbol.name()] = {new}
        links[dae.pre[scalar.name].name()] = {new}
    return links | {clock.fired.name(): {dae.time.name()} for clock in dae.clocks}


def _initial_links(dae: Dae) -> dict[str, set[str]]:
    """What everything is computed from in Initialization Mode."""
    links = _discrete_links(dae)
    for scalar in dae.discretes:
        if scalar.start is not None:
            links[scalar.symbol.name()] |= _names(scalar.start)
            links[dae.pre[scalar.name].name()] |= _names(scalar.start)
    for clock in dae.clocks:
        links[clock.fired.name()] |= _names(clock.start) | _names(clock.interval)
    for rows, columns in _blocks(dae.initial_residuals, [u.symbol for u in dae.unknowns]):
        names = _names(dae.initial_residuals[rows])
        # a guess decides which of several solutions is found
        links |= {dae.unknowns[j].symbol.name(): names | _names(dae.unknowns[j].start) for j in columns}
    for reset in dae.resets:
        links[dae.states[reset.index].symbol.name()] |= _names(reset.value) | _names(reset.guard)
    return links | {p.scalar.name: _names(p.value) for p in dae.parameters if not p.independent}


def _reaching(links: Mapping[str, set[str]]) -> Callable[[Iterable[str]], set[str]]:
    """A function that finds all that can be reached from symbols along links."""

    def reached(names: Iterable[str]) -> set[str]:
        found: set[str] = set()
        fresh = set(names)
        while fresh:
            found |= fresh
            fresh = set().union(*(links.get(name, set()) for name in fresh)) - found
        return found

    return reached


def _names(expression: SX) -> set[str]:
    return {symbol.name() for symbol in ca.symvar(expression)}
