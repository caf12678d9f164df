"""Algorithm sections outside when, and initial ones: what they assign becomes equations, values and starts."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca

from cosim.dae.evaluate import Evaluator
from cosim.dae.hybrid import SX, Assignment, Equation
from cosim.dae.statements import State, missing, nothing, run
from cosim.dae.symbols import Mode, Symbols, element_names
from cosim.modelica.flat import Algorithm, targets


def lower_algorithm(symbols: Symbols, algorithm: Algorithm) -> tuple[list[Equation], list[Assignment]]:
    """What an algorithm section computes at all times, as equations and discrete assignments.

    A variable that a branch leaves out keeps its start value, or its value before the event if it is discrete
    (Modelica 11.1.2).

    Raises:
        ModelError: a statement cannot be inlined, or something is assigned that cannot be; by name and place.
    """
    assigned = list(dict.fromkeys(targets(algorithm.statements)))
    for name in assigned:
        variable = symbols.flat.variables.get(name)
        if variable is None or variable.causality == "input" or variable.variability in ("parameter", "constant"):
            raise symbols.flat.source.error(f"{name} is assigned, but is not a variable that can be", algorithm.at)
    discrete = [name for name in assigned if name in symbols.new]
    equations: list[Equation] = []
    assignments: list[Assignment] = []
    if len(discrete) < len(assigned):
        state = {name: symbols.values[name] if name in symbols.new else _start(symbols, name) for name in assigned}
        after = run(Evaluator(symbols, Mode.CONTINUOUS), algorithm.statements, state)
        for name in assigned:
            if name not in symbols.new:
                residual = symbols.values[name] - after[name]
                equations += [Equation(r, f"{name} := ...", algorithm.at) for r in ca.vertsplit(ca.vec(residual))]
    if discrete:
        state = {name: symbols.pre[name] if name in symbols.new else _start(symbols, name) for name in assigned}
        after = run(Evaluator(symbols, Mode.DISCRETE), algorithm.statements, state)
        for name in discrete:
            if Evaluator(symbols, Mode.DISCRETE).varies(after[name]):
                raise symbols.flat.source.error(
                    f"{name} is discrete, but what is assigned to it changes between events; use a relation, integer()"
                    " or when",
                    algorithm.at,
                )
            names = tuple(element_names(name, symbols.flat.variables[name].dimensions))
            assignments.append(Assignment(names, ca.vec(after[name]), None, f"{name} := ...", algorithm.at))
    return equations, assignments


def _start(symbols: Symbols, name: str) -> SX:
    names = element_names(name, symbols.flat.variables[name].dimensions)
    starts = [symbols.scalars[element].start for element in names]
    column = ca.vertcat(*(SX(0.0) if start is None else start for start in starts))
    return ca.reshape(column, *symbols.values[name].shape)


def initial_values(symbols: Symbols, algorithm: Algorithm) -> State:
    """The values that an initial algorithm gives to parameters with ``fixed=false`` and to discrete variables.

    Raises:
        ModelError: they follow from something else than parameters; by name and place.
    """
    state = {name: nothing(*symbols.values[name].shape) for name in targets(algorithm.statements)}
    after = run(Evaluator(symbols, Mode.PARAMETER), algorithm.statements, state)
    for name, value in after.items():
        if missing(value):
            raise symbols.flat.source.error(f"{name} gets no value in every case of this initial algorithm",
                                            algorithm.at)  # fmt: skip
    return after


def start_discretes(symbols: Symbols) -> None:
    """Give discrete variables the start values that initial algorithms assign.

    Raises:
        ModelError: they follow from something else than parameters; by name and place.
    """
    for algorithm in symbols.flat.initial_algorithms:
        for name, value in initial_values(symbols, algorithm).items():
            variable = symbols.flat.variables[name]
            if name in symbols.new:
                set_start(symbols, name, value)
            elif variable.variability != "parameter":
                raise symbols.flat.source.error(
                    f"{name} is assigned in an initial algorithm; only discrete variables and parameters with"
                    " fixed=false can be there, write an initial equation",
                    algorithm.at,
                )


def set_start(symbols: Symbols, name: str, value: SX) -> None:
    """Make ``value`` the initial value of a variable."""
    variable = replace(symbols.flat.variables[name], fixed=True)
    elements = ca.vertsplit(ca.vec(value))
    for position, element in enumerate(element_names(name, variable.dimensions)):
        scalar = symbols.scalars[element]
        scalar.start = elements[position if len(elements) > 1 else 0]
        scalar.declaration = variable
