"""Lowers a flat model to a hybrid system: scalar symbols, residuals, relations, and discrete assignments in order."""

from __future__ import annotations

import graphlib

import casadi as ca

from cosim.dae.discrete import lower_discrete, order_discrete
from cosim.dae.evaluate import Evaluator, Mode, Symbols, element_names
from cosim.dae.hybrid import SX, Check, Equation, HybridSystem, Parameter, Scalar
from cosim.errors import InputError
from cosim.modelica.expressions import Expression, Reference, children, render_equation
from cosim.modelica.flat import FlatModel, Variable
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
            raise flat.source.error(f"{variable.name}: String variables are not supported yet", variable.at)
        if len(variable.dimensions) > 2:
            raise flat.source.error(f"{variable.name}: arrays have at most two dimensions here", variable.at)
        _check_units(symbols, variable)
        _declare(symbols, variable)
    _parameters(symbols)
    _starts(symbols)
    assignments, discrete = lower_discrete(symbols)
    continuous = Evaluator(symbols, Mode.CONTINUOUS)
    for equation in flat.equations:
        if equation in discrete:
            continue
        text = render_equation(equation.residual)
        residual = continuous(equation.residual)
        system.equations += [Equation(r, text, equation.at) for r in ca.vertsplit(ca.vec(residual))]
    for equation in flat.initial_equations:
        text = render_equation(equation.residual)
        residual = continuous(equation.residual)
        system.initial_equations += [Equation(r, text, equation.at) for r in ca.vertsplit(ca.vec(residual))]
    checking = Evaluator(symbols, Mode.CONTINUOUS, no_event=True)
    for assertion in flat.assertions:
        system.checks.append(Check(checking(assertion.condition), assertion.message, assertion.is_error, assertion.at))
    order_discrete(symbols, assignments)
    return system


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
    declared = {v.name: v for v in flat.variables.values() if v.variability in ("parameter", "constant")}
    uses: dict[str, set[str]] = {}
    expressions: dict[str, Expression] = {}
    for variable in declared.values():
        expression = variable.binding if variable.binding is not None else variable.start
        if variable.fixed is False:
            raise flat.source.error(
                f"the parameter {variable.name} has fixed=false, but initial equations cannot find parameters here;"
                " give it a value",
                variable.at,
            )
        if expression is None:
            raise flat.source.error(f"the parameter {variable.name} has no value; give it one", variable.at)
        expressions[variable.name] = expression
        uses[variable.name] = {name for name in _names(expression) if name in declared}
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
        value = evaluate(expressions[name])
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
        independent = uses[name] <= constants and not variable.final
        for element, element_value in zip(names, values, strict=True):
            symbols.system.parameters.append(Parameter(symbols.scalars[element], element_value, independent))


def _starts(symbols: Symbols) -> None:
    evaluate = Evaluator(symbols, Mode.PARAMETER)
    for variable in symbols.flat.variables.values():
        names = element_names(variable.name, variable.dimensions)
        if variable.nominal is not None:
            nominal = evaluate(variable.nominal)
            if nominal.is_constant():
                for name in names:
                    symbols.scalars[name].nominal = abs(float(ca.DM(nominal[0]))) or 1.0
        if variable.variability in ("parameter", "constant") or variable.start is None:
            continue
        start = ca.vertsplit(ca.vec(evaluate(variable.start)))
        for position, name in enumerate(names):
            symbols.scalars[name].start = start[position if len(start) > 1 else 0]


def _names(expression: Expression) -> set[str]:
    found = {expression.name} if isinstance(expression, Reference) else set()
    for child in children(expression):
        found |= _names(child)
    return found
