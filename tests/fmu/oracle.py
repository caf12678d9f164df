"""An independent way to a trajectory: CasADi's own index reduction, consistent initialisation and IDAS.

It starts from the equations after our alias elimination and shares nothing with what comes after it: not Pantelides'
algorithm, not the choice of states, not tearing, not the generated C, not the solver.
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import casadi as ca
import numpy as np

from cosim.dae.alias import eliminate_aliases
from cosim.dae.index_reduction import reduce_index
from cosim.dae.lower import lower
from cosim.dae.symbolic import evaluate, substitute
from cosim.modelica import Source, flatten


@dataclass(frozen=True)
class Reduced:
    """A model reduced by CasADi to a semi-explicit DAE, with consistent start values."""

    explicit: dict[str, ca.SX]
    to_original: ca.Function
    start: dict[str, ca.DM]
    names: list[str]
    """Of the original states, then of the algebraic unknowns."""
    aliases: dict[str, tuple[str, float]]
    """What is another unknown times a factor."""

    def integrator(self, grid: np.ndarray, tolerance: float, **options: object) -> ca.Function:
        """IDAS on the grid, to be called with ``start``."""
        options = {"abstol": tolerance, "reltol": tolerance, "max_num_steps": 10**6} | options
        return ca.integrator("oracle", "idas", self.explicit, float(grid[0]), grid.tolist(), options)

    def rows(self, solution: Mapping[str, ca.DM]) -> dict[str, np.ndarray]:
        """The values of all unknowns by their names."""
        x, _, z = (np.array(part) for part in self.to_original(solution["xf"], solution["zf"]))
        rows = dict(zip(self.names, np.vstack([x, z]), strict=True))
        aliases = {name: factor * rows[other] for name, (other, factor) in self.aliases.items() if other in rows}
        return rows | aliases


def trajectories(
    file: Path, model: str, grid: np.ndarray, inputs: dict[str, float], guesses: dict[str, float] | None = None
) -> dict[str, np.ndarray]:
    """Every unknown on the grid; its first time is the start. The other arguments are those of :func:`reduce`."""
    reduced = reduce(file, model, inputs, guesses, float(grid[0]))
    return reduced.rows(reduced.integrator(grid, 1e-10)(**reduced.start))


def reduce(
    file: Path, model: str, inputs: dict[str, float], guesses: dict[str, float] | None = None, begin: float = 0.0
) -> Reduced:
    """Reduce a model while all its relations and discrete variables stay false or zero.

    Args:
        file: the Modelica file or package.
        model: the full name of the class.
        inputs: constant values; the others keep their start value.
        guesses: of unknowns that the model gives no start value for.
        begin: the time of the start.
    """
    system = lower(flatten(Source.read(file), model))
    chains = eliminate_aliases(system)
    values: dict[str, float] = {}
    for parameter in system.parameters:
        values[parameter.scalar.name] = float(evaluate(parameter.value, values))
    parameters = dict(values)
    for name, scalar in system.inputs.items():
        start = 0.0 if scalar.start is None else float(evaluate(scalar.start, parameters))
        values[name] = inputs.get(name, start)
    for symbol in (*(r.symbol for r in system.relations), *(s.symbol for s in system.discretes.values())):
        values[symbol.name()] = 0.0

    residuals = [equation.residual for equation in chains.equations]
    chain_symbols = list(chains.symbols.values())
    while True:  # what is only computed, and enters no other equation, is not CasADi's business; it trips over it
        uses = Counter(s.name() for r in residuals for s in ca.symvar(r))
        only = {c[0].name() for c in chain_symbols if sum(uses[s.name()] for s in c) == 1 and uses[c[0].name()] == 1}
        row = next((i for i, r in enumerate(residuals) if any(s.name() in only for s in ca.symvar(r))), None)
        if row is None:
            break
        dropped = next(s.name() for s in ca.symvar(residuals.pop(row)) if s.name() in only)
        chain_symbols = [chain for chain in chain_symbols if chain[0].name() != dropped]
    # CasADi fails ("complement: out of bounds") where an algebraic unknown must be differentiated, so these get their
    # derivatives as unknowns; which ones is a hint from our Pantelides, and a wrong hint would only make CasADi fail
    reduce_index(chains)
    states, derivatives, algebraics = [], [], []
    for chain in chain_symbols:
        occurs = [k == 0 or uses[s.name()] > 0 for k, s in enumerate(chain)]
        if len(chain) == 1:
            algebraics.append(chain[0])
        for k, (below, above) in enumerate(itertools.pairwise(chain)):
            states.append(below)
            last = k + 2 == len(chain)
            derivatives.append(above if last and occurs[k + 1] else ca.SX.sym(f"d({below.name()})"))
            if derivatives[-1] is not above:
                residuals.append(derivatives[-1] - above)
                if last:
                    algebraics.append(above)
    known = sorted({s.name() for r in residuals for s in ca.symvar(r)} & set(values))
    named = {s.name(): s for r in residuals for s in ca.symvar(r)}
    dae = {
        "x_impl": ca.vertcat(*states),
        "dx_impl": ca.vertcat(*derivatives),
        "z": ca.vertcat(ca.SX(0, 1), *algebraics),
        "alg": ca.vertcat(*residuals),
        "p": ca.vertcat(ca.SX(0, 1), *(named[name] for name in known)),
        "t": system.time,
    }
    reduced, statistics = ca.dae_reduce_index(dae, {"baumgarte_pole": -10})
    assert statistics["index"] >= 1
    explicit, to_original, _ = ca.dae_map_semi_expl(dae, reduced)
    weights, starts = {}, {}
    for node, members in chains.names.items():
        for scalar, sign in members:
            if scalar.start is not None and chains.symbol(node).name() not in weights:
                start = sign * float(evaluate(scalar.start, parameters))
                name = chains.symbol(node).name()
                starts[name], weights[name] = start, -1.0 if scalar.fixed else 1e-2 * (start != 0)
    for equation in system.initial_equations:  # only of the form x = value here
        residual = substitute(equation.residual, {name: alias.value for name, alias in chains.aliases.items()})
        (node,) = chains.nodes_in(residual)
        symbol = chains.symbol(node)
        rest = ca.substitute(residual, symbol, 0) / ca.jacobian(residual, symbol)
        starts[symbol.name()], weights[symbol.name()] = -float(evaluate(rest, parameters)), -1.0
    for name, guess in (guesses or {}).items():
        starts[name], weights[name] = guess, 1e-2
    columns = {"x_impl": states, "dx_impl": derivatives, "z": algebraics}
    weight = {key: ca.DM([weights.get(s.name(), 0.0) for s in symbols]) for key, symbols in columns.items()}
    guess = {key: ca.DM([starts.get(s.name(), 0.0) for s in symbols]) for key, symbols in columns.items()}
    quiet = {"ipopt.print_level": 0, "ipopt.sb": "yes", "print_time": 0, "ipopt.tol": 1e-12}
    initialise = ca.dae_init_gen(dae, reduced, "ipopt", weight, quiet)
    p = ca.DM([values[name] for name in known])
    start = initialise(**guess, p=p, t=begin)
    aliases = {}
    for name, alias in chains.aliases.items():
        symbols = ca.symvar(alias.value)
        if len(symbols) == 1:
            aliases[name] = symbols[0].name(), float(ca.DM(ca.jacobian(alias.value, symbols[0])))
    return Reduced(
        explicit,
        to_original,
        {"x0": start["x0"], "z0": start["z0"], "p": p},
        [s.name() for s in (*states, *algebraics)],
        aliases,
    )
