"""The plant's equations as functions of what is fitted, in one mode: forward running, with all relations held."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi as ca

from cosim.dae import Dae
from cosim.dae.blocks import triangular
from cosim.dae.hybrid import SX
from cosim.dae.symbolic import substitute
from cosim.dae.tearing import solve_linear
from cosim.errors import InputError

OUTPUTS = ("i_motor", "tau_crank")
"""What can be measured: motor current [A] and torque on the gear's output shaft [N.m]."""
SUPPLY, SUPPLY_DROP = "v_supply", "supply_drop"
"""The input, and by how much [V] it is lower than measured: a parameter of the measurement, not of the plant."""


@dataclass(frozen=True)
class Equations:
    """Functions of x, z, u and p: states, torn unknowns, inputs, and all parameters as in the Dae, then SUPPLY_DROP.

    ``rhs`` gives dx/dt, the residuals 0 = r and the OUTPUTS. ``value`` gives z after one Newton step of each block of
    0 = r, then dx/dt with it; ``point`` also its derivatives by q = [x; fitted parameters] along 0 = r. ``outputs`` are
    functions for one of the OUTPUTS each, with its derivatives. ``relations`` gives the indicators of what is held,
    ``parameters`` all p from the independent ones.
    """

    rhs: ca.Function
    value: ca.Function
    point: ca.Function
    outputs: tuple[ca.Function, ...]
    relations: ca.Function
    parameters: ca.Function


def equations(dae: Dae, names: Sequence[str], held: Mapping[str, float], watched: Sequence[str]) -> Equations:
    """Return the equations with discrete variables and relations held.

    Args:
        dae: the plant.
        names: the parameters to fit.
        held: values by the name of the symbol.
        watched: names of the relations' symbols that `relations` is to tell.

    Raises:
        InputError: the plant is none of the wiper drive, or depends on something else than these arguments.
    """
    parameters, values = _parameters(dae, names)
    drop = SX.sym(SUPPLY_DROP)
    known = {name: SX(value) for name, value in held.items()} | {dae.initial.name(): SX(0.0)} | values
    known |= {s.symbol.name(): s.symbol - drop for s in dae.inputs if s.name == SUPPLY}
    f, r, y = (substitute(e, known) for e in (dae.derivatives, dae.residuals, outputs_of(dae)))
    indicators = {relation.symbol.name(): relation.indicator for relation in dae.relations}
    g = substitute(_column([indicators[name] for name in watched]), known)
    x, u = _column([s.symbol for s in dae.states]), _column([s.symbol for s in dae.inputs])
    symbols = {each.scalar.name: each.scalar.symbol for each in dae.parameters} | {SUPPLY_DROP: drop}
    p = _column(list(symbols.values()))
    arguments = [x, dae.z, u, p]
    free = {s.name() for s in ca.symvar(ca.vertcat(f, r, y, g))}
    extra = free - {s.name() for a in arguments for s in ca.symvar(a)}
    if extra:
        raise InputError(f"{dae.name} depends on {', '.join(sorted(extra))} in a way that cannot be fitted")
    independent = _column([*(each.scalar.symbol for each in dae.parameters if each.independent), drop])
    q = ca.vertcat(x, *(symbols[name] for name in names))
    there = _along(f, r, y, dae.z, q)
    return Equations(
        rhs=_function("rhs", arguments, [f, r, y]),
        value=_function("value", arguments, there[:2]),
        point=_function("point", arguments, there[:3]),
        outputs=tuple(_function(n, arguments, [there[3][k], there[4][k, :]]) for k, n in enumerate(OUTPUTS)),
        relations=_function("relations", arguments, [g]),
        parameters=_function("parameters", [independent], [ca.vertcat(parameters, drop)]),
    )


def _along(f: SX, r: SX, y: SX, z: SX, q: SX) -> list[SX]:
    """Return z after a Newton step of each block, f there, df/dq along 0 = r, y and dy/dq."""
    slopes = ca.jacobian(r, z)
    pattern = slopes.sparsity()
    count = z.numel()
    blocks = triangular([[j for j in range(count) if pattern.has_nz(i, j)] for i in range(count)], count)
    if blocks is None:
        raise InputError("the plant's algebraic equations are singular in this mode, so that nothing can be fitted")
    swept, by_q, direct = SX(z), SX(count, q.numel()), ca.jacobian(r, q)
    for rows, columns in blocks:
        right, matrix, by_z, slope = ca.substitute(
            [r[rows], ca.densify(slopes[rows, columns]), slopes[rows, :], direct[rows, :]], [z], [swept]
        )
        slope += ca.mtimes(by_z, by_q)  # through the blocks before: by_q is zero for the others
        # a division costs several products
        inverse = ca.horzcat(*(solve_linear(matrix, unit) for unit in ca.horzsplit(SX.eye(len(rows)))))
        swept[columns] -= ca.mtimes(inverse, right)
        by_q[columns, :] = -ca.mtimes(inverse, slope)
    found = [swept]
    for value in (f, y):
        there, by_z, slope = ca.substitute([value, ca.jacobian(value, z), ca.jacobian(value, q)], [z], [swept])
        found += [there, slope + ca.mtimes(by_z, by_q)]
    return found


def _parameters(dae: Dae, names: Sequence[str]) -> tuple[SX, dict[str, SX]]:
    """Return all parameters in terms of the independent ones, and those that depend on what is fitted."""
    values: dict[str, SX] = {}
    follow: dict[str, SX] = {}
    fitted = [each.scalar.symbol for each in dae.parameters if each.scalar.name in names]
    for parameter in dae.parameters:
        name = parameter.scalar.name
        values[name] = parameter.scalar.symbol if parameter.independent else substitute(parameter.value, values)
        if not parameter.independent and fitted and ca.depends_on(values[name], _column(fitted)):
            follow[name] = values[name]
    return _column(list(values.values())), follow


def outputs_of(dae: Dae) -> SX:
    """Return the OUTPUTS in terms of the Dae's arguments; raises InputError if it has them not."""
    published = {p.scalar.name: p.value for p in dae.published}
    missing = [name for name in OUTPUTS if name not in published]
    if missing:
        raise InputError(f"{dae.name} has no variable {' and '.join(missing)}; a plant of the wiper drive is needed")
    return _column([published[name] for name in OUTPUTS])


def _function(name: str, arguments: Sequence[SX], results: Sequence[SX]) -> ca.Function:
    sizes = [0]
    for result in results:
        sizes.append(sizes[-1] + result.numel())
    column = ca.vertcat(*(ca.vec(ca.densify(result)) for result in results))
    parts = ca.vertsplit(ca.cse(column), sizes)
    return ca.Function(name, list(arguments), [
        ca.reshape(part, *result.shape) for part, result in zip(parts, results, strict=True)
    ])  # fmt: skip


def _column(values: Sequence[SX]) -> SX:
    return ca.vertcat(SX(0, 1), *values)
