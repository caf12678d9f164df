"""Lowers a flat model to a hybrid system: scalar symbols, residuals, relations, and discrete assignments in order."""

from __future__ import annotations

import graphlib
from dataclasses import replace

import casadi as ca

from cosim.dae.algorithms import initial_values, lower_algorithm, set_start, start_discretes
from cosim.dae.discrete import lower_discrete, order_discrete
from cosim.dae.evaluate import Evaluator
from cosim.dae.hybrid import SX, Check, Equation, HybridSystem, Parameter, Scalar
from cosim.dae.symbolic import default_values
from cosim.dae.symbolic import evaluate as number
from cosim.dae.symbols import Mode, Symbols, element_names
from cosim.dae.texts import text
from cosim.errors import InputError
from cosim.modelica import flat as fm
from cosim.modelica.expressions import Binary, Call, Expression, Reference, references, render_equation
from cosim.modelica.flat import FlatModel, Variable, reads, targets
from cosim.units import linear_map, parse


def lower(flat: FlatModel) -> HybridSystem:
    """Lower a flat model.

    Raises:
        ModelError: the model uses something that has no meaning here, by name and place.
    """
    time, initial = SX.sym("time"), SX.sym("initial")
    system = HybridSystem(flat.name, flat.description, flat.source, time, initial, list(flat.variables))
    symbols = Symbols(flat, system)
    for variable in flat.variables.values():
        if variable.type == "String":
            if variable.variability not in ("parameter", "constant"):
                raise flat.source.error(
                    f"{variable.name}: a String can be a parameter or constant, for messages; variables cannot",
                    variable.at,
                )
            continue
        if len(variable.dimensions) > 2:
            raise flat.source.error(f"{variable.name}: arrays have at most two dimensions here", variable.at)
        _check_units(symbols, variable)
        _declare(symbols, variable)
    _parameters(symbols)
    _starts(symbols)
    start_discretes(symbols)
    computed = [lower_algorithm(symbols, algorithm) for algorithm in flat.algorithms]
    assignments = [assignment for _, assigned in computed for assignment in assigned]
    assignments, discrete = lower_discrete(symbols, assignments)
    continuous = Evaluator(symbols, Mode.CONTINUOUS)
    for equation in flat.equations:
        if equation in discrete:
            continue
        shown = render_equation(equation.residual)
        residual = continuous(equation.residual)
        system.equations += [Equation(r, shown, equation.at) for r in ca.vertsplit(ca.vec(residual))]
    system.equations += [equation for equations, _ in computed for equation in equations]
    for equation in flat.initial_equations:
        if _is_start(symbols, equation):
            continue
        shown = render_equation(equation.residual)
        residual = continuous(equation.residual)
        system.initial_equations += [Equation(r, shown, equation.at) for r in ca.vertsplit(ca.vec(residual))]
    checking = Evaluator(symbols, Mode.CONTINUOUS, no_event=True)
    for assertion in flat.assertions:
        message = text(checking, assertion.message)
        system.checks.append(Check(checking(assertion.condition), message, assertion.is_error, assertion.at))
    order_discrete(symbols, assignments)
    _freeze(symbols)
    return system


def _is_start(symbols: Symbols, equation: fm.Equation) -> bool:
    """Take an initial equation ``d = value`` or ``pre(d) = value`` of a discrete variable as its start value."""
    residual = equation.residual
    if not isinstance(residual, Binary) or residual.operator != "-":
        return False
    for side, other in ((residual.left, residual.right), (residual.right, residual.left)):
        variable = side.arguments[0] if isinstance(side, Call) and side.function == "pre" else side
        if isinstance(variable, Reference) and not variable.subscripts and variable.name in symbols.new:
            set_start(symbols, variable.name, Evaluator(symbols, Mode.PARAMETER)(other))
            return True
    return False


def _freeze(symbols: Symbols) -> None:
    """Parameters that have decided the shape of something keep their value; what they follow from, too."""
    parameters = symbols.system.parameters
    frozen = set(symbols.structural)
    for parameter in reversed(parameters):
        if parameter.scalar.declaration.name in symbols.flat.structural or parameter.scalar.name in frozen:
            frozen |= {parameter.scalar.name, *(s.name() for s in ca.symvar(parameter.value))}
    symbols.system.parameters = [
        replace(p, independent=p.independent and p.scalar.name not in frozen) for p in parameters
    ]


def _check_units(symbols: Symbols, variable: Variable) -> None:
    try:
        units = [parse(text) for text in (variable.unit, variable.display_unit) if text]
        if len(units) == 2:
            linear_map(*units)
    except InputError as error:
        raise symbols.flat.source.error(f"{variable.name}: {error}", variable.at) from None


def _declare(symbols: Symbols, variable: Variable) -> None:
    system = symbols.system
    names = element_names(variable.name, variable.dimensions)
    elements = [SX.sym(name) for name in names]
    shape = (*variable.dimensions, 1, 1)[:2]
    symbols.values[variable.name] = ca.reshape(ca.vertcat(*elements), *shape) if elements else SX(*shape)
    known = variable.variability in ("parameter", "constant") or variable.causality == "input"
    discrete = variable.variability == "discrete" and not known
    for name, element in zip(names, elements, strict=True):
        scalar = Scalar(name, variable, element, None, 1.0)
        symbols.scalars[name] = scalar
        if discrete:
            system.discretes[name] = scalar
            system.pre[name] = SX.sym(f"pre({name})")
            system.new[name] = SX.sym(f"new({name})")
        elif variable.causality == "input":
            system.inputs[name] = scalar
        elif not known:
            system.unknowns[name] = scalar
    if discrete and names:
        symbols.pre[variable.name] = ca.reshape(ca.vertcat(*(system.pre[n] for n in names)), *shape)
        symbols.new[variable.name] = ca.reshape(ca.vertcat(*(system.new[n] for n in names)), *shape)


def _parameters(symbols: Symbols) -> None:
    """Order the parameters so that each comes after the ones its value uses; literals are the independent ones.

    Constants are replaced by their values.
    """
    flat = symbols.flat
    declared = {
        v.name: v for v in flat.variables.values()
        if v.variability in ("parameter", "constant") and v.type != "String"
    }  # fmt: skip
    computed = {name: a for a in flat.initial_algorithms for name in targets(a.statements)}
    uses: dict[str, set[str]] = {}
    expressions: dict[str, Expression] = {}
    for variable in declared.values():
        expression = variable.binding if variable.binding is not None else variable.start
        if variable.name in computed:
            used = set(reads(computed[variable.name].statements))
            uses[variable.name] = {name for name in used if name in declared and name not in computed}
            continue
        if variable.fixed is False:
            raise flat.source.error(
                f"the parameter {variable.name} has fixed=false, but initial equations cannot find parameters here;"
                " give it a value",
                variable.at,
            )
        if expression is None:
            raise flat.source.error(f"the parameter {variable.name} has no value; give it one", variable.at)
        expressions[variable.name] = expression
        uses[variable.name] = {name for name in references(expression) if name in declared}
    constants = {name for name, v in declared.items() if v.variability == "constant"}
    try:
        order = list(graphlib.TopologicalSorter(uses).static_order())
    except graphlib.CycleError as error:
        ring = " -> ".join(error.args[1])
        raise flat.source.error(
            f"these parameters depend on each other in a ring: {ring}", declared[error.args[1][0]].at
        ) from None
    evaluate = Evaluator(symbols, Mode.PARAMETER)
    for name in order:
        variable = declared[name]
        value = initial_values(symbols, computed[name])[name] if name in computed else evaluate(expressions[name])
        names = element_names(name, variable.dimensions)
        values = ca.vertsplit(ca.vec(value)) if names else []
        if len(values) == 1 and len(names) > 1:
            values = values * len(names)
        if len(values) != len(names):
            raise flat.source.error(f"{name} has {len(names)} elements but its value has {len(values)}", variable.at)
        if variable.variability == "constant":
            shape = symbols.values[name].shape
            symbols.values[name] = ca.reshape(ca.vertcat(*values), *shape)
            continue
        independent = uses[name] <= constants and not variable.final and name not in computed
        for element, element_value in zip(names, values, strict=True):
            symbols.system.parameters.append(Parameter(symbols.scalars[element], element_value, independent))


def _starts(symbols: Symbols) -> None:
    evaluate = Evaluator(symbols, Mode.PARAMETER)
    defaults = default_values(symbols.system.parameters)
    for variable in symbols.flat.variables.values():
        names = element_names(variable.name, variable.dimensions)
        if variable.nominal is not None:
            nominal = ca.vertsplit(ca.vec(evaluate(variable.nominal)))
            for position, name in enumerate(names):
                size = float(number(nominal[position if len(nominal) > 1 else 0], defaults))
                symbols.scalars[name].nominal = abs(size) or 1.0
        if variable.variability in ("parameter", "constant") or variable.start is None:
            continue
        start = ca.vertsplit(ca.vec(evaluate(variable.start)))
        for position, name in enumerate(names):
            symbols.scalars[name].start = start[position if len(start) > 1 else 0]
