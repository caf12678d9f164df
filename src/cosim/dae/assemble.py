"""Runs the stages in order and assembles the :class:`Dae`."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca

from cosim.dae.alias import eliminate_aliases, plain_chains
from cosim.dae.chains import Chains, Node
from cosim.dae.constraints import constraints_of
from cosim.dae.dae import Computed, Dae, Published, Reset, Sizes, Unknown
from cosim.dae.hybrid import SX, HybridSystem, Relation, Scalar
from cosim.dae.index_reduction import Differentiated, reduce_index
from cosim.dae.initialization import initial_system
from cosim.dae.lower import lower
from cosim.dae.state_selection import Selection, select_states
from cosim.dae.structure import check_structure, deficient, listed, placed, singular
from cosim.dae.symbolic import default_values, evaluate, substitute
from cosim.dae.tearing import Singular, Solution, solve
from cosim.dae.time_events import slope_in_time
from cosim.modelica.flat import FlatModel


def compile_dae(flat: FlatModel) -> Dae:
    """Compile a flat model.

    Raises:
        ModelError: the model uses something unsupported, is structurally singular, or has contradicting states or
            initial conditions; the message says which and where.
    """
    system = lower(flat)
    check_structure(plain_chains(system))
    chains = eliminate_aliases(system)
    after_aliases = len(chains.equations)
    differentiated = reduce_index(chains)
    parameters = default_values(system.parameters)
    selection = select_states(differentiated, _start_point(system, chains, parameters))
    solution = _solve(differentiated, selection, parameters)
    sizes = Sizes(len(system.equations), after_aliases, len(differentiated.equations), differentiated.index)
    return _Assembly(system, differentiated, selection, solution).dae(sizes, parameters)


def _start_point(system: HybridSystem, chains: Chains, parameters: dict[str, float]) -> dict[str, float]:
    """Numbers for the start values that the model gives, and for parameters, inputs and discrete variables."""
    values = dict(parameters)
    for name, scalar in (*system.inputs.items(), *system.discretes.items()):
        values[name] = float(evaluate(scalar.start, parameters)) if scalar.start is not None else 0.0
    for node, members in chains.names.items():
        for scalar, sign in members:
            # rumoca gives every Real a start of zero; only another number says something
            if scalar.start is not None and (start := float(evaluate(scalar.start, parameters))) != 0.0:
                values.setdefault(chains.symbol(node).name(), sign * start)
    return values


def _solve(differentiated: Differentiated, selection: Selection, parameters: dict[str, float]) -> Solution:
    chains = differentiated.chains
    states = set(selection.states)
    unknowns = [chains.symbol(node) for node in selection.unknowns]
    derivatives = {chains.symbol(Node(n.base, n.order + 1)).name() for n in states}
    residuals = [equation.residual for equation in differentiated.equations]
    labels = [chains.label(node) for node in selection.unknowns]
    try:
        solution = solve(residuals, unknowns, derivatives, parameters)
    except Singular as part:
        source, equations = chains.system.source, [differentiated.equations[e] for e in part.equations]
        raise source.error(
            f"{chains.system.name}: these equations depend on each other, so that they do not determine"
            f" {listed([labels[j] for j in part.unknowns])}: {listed([placed(source, e) for e in equations])}",
            equations[0].at,
        ) from None
    if solution is None:
        column = {symbol.name(): j for j, symbol in enumerate(unknowns)}
        incidence = [[column[s.name()] for s in ca.symvar(r) if s.name() in column] for r in residuals]
        names = ", ".join(chains.label(node) for node in selection.states)
        what = f"{chains.system.name}: the states {names} do not determine the rest, choose others with StateSelect"
        raise singular(what, chains, differentiated.equations, labels, deficient(incidence, len(unknowns)))
    return solution


class _Assembly:
    """Puts every expression in terms of the Dae's arguments."""

    def __init__(
        self, system: HybridSystem, differentiated: Differentiated, selection: Selection, solution: Solution
    ) -> None:
        self._system = system
        self._differentiated = differentiated
        self._chains = chains = differentiated.chains
        self._selection = selection
        self._solution = solution
        self._values: dict[str, SX] = {}
        for symbol, value in solution.steps:
            self._values[symbol.name()] = substitute(value, self._values)
        for name, alias in chains.aliases.items():
            self._values[name] = substitute(alias.value, self._values)

    def resolve(self, expression: SX) -> SX:
        return substitute(expression, self._values)

    def _relation(self, relation: Relation) -> Relation:
        indicator = self.resolve(relation.indicator)
        return replace(relation, indicator=indicator, slope=slope_in_time(indicator, self._system))

    def dae(self, sizes: Sizes, parameters: dict[str, float]) -> Dae:
        system, chains = self._system, self._chains
        states = [self._unknown(node) for node in self._selection.states]
        nodes = {chains.symbol(node).name(): node for node in self._selection.unknowns}
        torn = [self._unknown(nodes[symbol.name()]) for symbol in self._solution.torn]
        residuals = ca.vertcat(SX(0, 1), *(self.resolve(r) for r in self._solution.residuals))
        equations = [self._differentiated.equations[e] for e in self._solution.residual_equations]
        texts = [system.source.with_line(e.text, e.at) for e in equations]
        algebraic = list(zip(ca.vertsplit(residuals), texts, strict=True)) if texts else []
        derivatives = ca.vertcat(
            SX(0, 1),
            *(self.resolve(chains.symbol(Node(node.base, node.order + 1))) for node in self._selection.states),
        )
        conditions = self._conditions()
        initial_residuals, initial_texts, kept = initial_system(system, states, torn, algebraic, conditions)
        remarks = self._remarks()
        return Dae(
            name=system.name,
            description=system.description,
            time=system.time,
            initial=system.initial,
            states=states,
            torn=torn,
            parameters=system.parameters,
            parameter_values=parameters,
            inputs=list(system.inputs.values()),
            discretes=list(system.discretes.values()),
            pre=system.pre,
            new=system.new,
            derivatives=derivatives,
            residuals=residuals,
            relations=[self._relation(r) for r in system.relations],
            clocks=system.clocks,
            assignments=[
                replace(a, values=self.resolve(a.values), guard=None if a.guard is None else self.resolve(a.guard))
                for a in system.assignments
            ],
            resets=self._resets(states),
            # errors first: a warning that lasts must not hide an error behind it
            checks=sorted(
                (replace(c, condition=self.resolve(c.condition)) for c in system.checks), key=lambda c: not c.is_error
            ),
            terminations=[(self.resolve(guard), message) for guard, message in system.terminations],
            initial_residuals=initial_residuals,
            initial_texts=initial_texts,
            starts_kept=kept,
            published=self._published(),
            aliases={name: alias.text for name, alias in chains.aliases.items() if name in system.unknowns},
            blocks=self._solution.blocks,
            equations=[system.source.with_line(e.text, e.at) for e in self._differentiated.equations],
            sizes=sizes,
            differentiated=self._differentiated_equations(),
            constrained=self._constrained(),
            not_chosen=[chains.label(Node(node.base, node.order - 1)) for node in self._selection.dummies],
            constraints=constraints_of(self._selection, self._differentiated, self.resolve),
            computed=[Computed(s.name(), self._values[s.name()], remarks[s.name()]) for s, _ in self._solution.steps],
        )

    def _remarks(self) -> dict[str, str]:
        """From what each unknown is computed: its equation, or the number of its block as in ``explain``."""
        remarks: dict[str, str] = {}
        coupled = 0
        for block in self._solution.blocks:
            coupled += block.kind != "explicit"
            equation = self._differentiated.equations[block.equations[0]]
            remark = equation.text if block.kind == "explicit" else f"block {coupled}"
            remarks |= dict.fromkeys(block.unknowns, remark)
        return remarks

    def _constrained(self) -> frozenset[str]:
        """The parameters in equations that have derivatives among the equations."""
        known = {parameter.scalar.name for parameter in self._system.parameters}
        given = self._differentiated
        return frozenset(s.name() for e in given.successor for s in ca.symvar(given.equations[e].residual)) & known

    def _differentiated_equations(self) -> list[tuple[str, int]]:
        given = self._differentiated
        times: dict[int, int] = {}
        for e in range(len(given.equations)):
            if e in given.predecessor and e not in given.successor:
                level, origin = given.level(e), e
                while origin in given.predecessor:
                    origin = given.predecessor[origin]
                times[origin] = level
        return [(placed(self._system.source, given.equations[e]), n) for e, n in sorted(times.items())]

    def _unknown(self, node: Node) -> Unknown:
        """A fixed start value counts most, then the first that says something."""
        names = self._chains.names.get(node, [])
        starts = [(not s.fixed, sign * s.start) for s, sign in names if s.start is not None]
        starts = [(guess, start) for guess, start in starts if not guess or not start.is_zero()]
        start = min(starts, key=lambda item: item[0])[1] if starts else SX(0.0)
        nominal = next((scalar.nominal for scalar, _ in names if scalar.nominal != 1.0), 1.0)
        return Unknown(self._chains.label(node), self._chains.symbol(node), start, nominal)

    def _conditions(self) -> list[tuple[SX, str, int]]:
        """Fixed start values, one for each set of equal variables, and initial equations."""
        found: list[tuple[SX, str, int]] = []
        seen: dict[str, tuple[Scalar, SX]] = {}
        for name, scalar in self._system.unknowns.items():
            if not scalar.fixed:
                continue
            start = scalar.start if scalar.start is not None else SX(0.0)
            value = self.resolve(scalar.symbol)
            if not any(s.name() in self._unknown_names for s in ca.symvar(value)):
                continue  # a constant of the model; there is nothing to choose
            key, condition = str(value), value - start
            if key in seen:
                other, known = seen[key]
                if not ca.is_equal(known, condition, 20):
                    raise self._system.source.error(
                        f"{name} and {other.name} are the same variable but have different fixed start values",
                        scalar.declaration.at,
                    )
                continue
            seen[key] = scalar, condition
            found.append((condition, f"{name} = {start} (fixed start)", scalar.declaration.at))
        for equation in self._system.initial_equations:
            found.append((self.resolve(equation.residual), equation.text, equation.at))
        return found

    @property
    def _unknown_names(self) -> set[str]:
        names = {self._chains.symbol(node).name() for node in self._selection.states}
        return names | {symbol.name() for symbol in self._solution.torn}

    def _resets(self, states: list[Unknown]) -> list[Reset]:
        index = {state.symbol.name(): i for i, state in enumerate(states)}
        resets = []
        for reinit in self._system.reinits:
            value = self.resolve(self._system.unknowns[reinit.name].symbol)
            symbols = ca.symvar(value)
            sign = ca.jacobian(value, symbols[0]) if len(symbols) == 1 else SX(0.0)
            if len(symbols) != 1 or symbols[0].name() not in index or not sign.is_constant():
                raise self._system.source.error(
                    f"reinit({reinit.name}): only a state can be reinitialised; the states are "
                    f"{', '.join(s.name for s in states)}. Give {reinit.name} stateSelect=StateSelect.always",
                    reinit.at,
                )
            resets.append(
                Reset(index[symbols[0].name()], self.resolve(reinit.value) / sign, self.resolve(reinit.guard))
            )
        return resets

    def _published(self) -> list[Published]:
        system = self._system
        scalars: list[Scalar] = [
            *(p.scalar for p in system.parameters),
            *system.inputs.values(),
            *system.unknowns.values(),
            *system.discretes.values(),
        ]
        order = {name: position for position, name in enumerate(system.source_order)}
        scalars = [s for s in scalars if not s.declaration.protected or s.causality == "output"]
        scalars.sort(key=lambda s: (s.causality == "local", order[s.declaration.name]))
        return [Published(s, self.resolve(s.symbol)) for s in scalars]
