"""The equations of a Dae as numeric functions of an operating point, with their exact derivatives."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from cosim.dae import Dae
from cosim.dae.dae import Published
from cosim.dae.hybrid import SX
from cosim.dae.symbolic import evaluate, substitute

Vector = NDArray[np.float64]
_ARGUMENTS = ("time", "x", "z", "u", "p", "d", "c")


@dataclass(frozen=True)
class Point:
    """Values of everything that the equations depend on, in the order of the Dae."""

    time: float
    x: Vector
    """States."""
    z: Vector
    """Torn unknowns."""
    u: Vector
    """Inputs."""
    p: Vector
    """Parameters."""
    d: Vector
    """Discrete variables."""
    c: Vector
    """Truth values of the relations."""


@dataclass(frozen=True)
class Blocks:
    """Values and Jacobian blocks at a point: ``f_z`` is df/dz, and so on; r is zero where the point is consistent."""

    f: Vector
    r: Vector
    h: Vector
    f_x: Vector
    f_z: Vector
    f_u: Vector
    r_x: Vector
    r_z: Vector
    r_u: Vector
    h_x: Vector
    h_z: Vector
    h_u: Vector


class Equations:
    """dx/dt = f, 0 = r, y = h and the indicators of the relations, of (time, x, z, u, p, d, c)."""

    def __init__(self, dae: Dae, outputs: Sequence[Published]) -> None:
        """Prepare the functions; ``outputs`` are the y."""
        self.dae = dae
        columns = {
            "time": dae.time,
            "x": _column(u.symbol for u in dae.states),
            "z": _column(u.symbol for u in dae.torn),
            "u": _column(s.symbol for s in dae.inputs),
            "p": _column(p.scalar.symbol for p in dae.parameters),
            "d": _column(s.symbol for s in dae.discretes),
            "c": _column(r.symbol for r in dae.relations),
        }
        self._arguments = [columns[name] for name in _ARGUMENTS]
        continuous = {"f": dae.derivatives, "r": dae.residuals, "h": _column(o.value for o in outputs)}
        by = {"x": columns["x"], "z": columns["z"], "u": columns["u"]}
        results = dict(continuous)
        for name, expression in continuous.items():
            for argument, symbols in by.items():
                results[f"{name}_{argument}"] = ca.jacobian(expression, symbols)
        self._blocks = self._function(results)
        behind = symbols_behind(dae, _column(continuous.values()))
        self.relevant = [k for k, r in enumerate(dae.relations) if r.symbol.name() in behind]
        """Positions of the relations on which f, r or y depend, directly or through discrete variables."""
        self.held = [k for k, s in enumerate(dae.discretes) if s.name in behind]
        """Positions of the discrete variables on which f, r or y depend."""
        self.sampled = any(clock.fired.name() in behind for clock in dae.clocks)
        """Whether f, r or y depend on what changes at sample times."""
        g = _column(dae.relations[k].indicator for k in self.relevant)
        inside = ca.vertcat(*by.values(), dae.time)
        self._indicators = self._function({"g": g, "dg": ca.jacobian(g, inside)})
        self.depends_on_time = bool(ca.depends_on(_column(continuous.values()), dae.time))

    def blocks(self, point: Point) -> Blocks:
        """Values and Jacobian blocks at a point."""
        values = self._blocks(*_numbers(point))
        return Blocks(**{name: _array(values[name], name) for name in values})

    def indicators(self, point: Point) -> tuple[Vector, Vector]:
        """The relevant relations' indicators, and for each how large what it compares is, to judge its rounding."""
        values = self._indicators(*_numbers(point))
        nominal = np.array([u.nominal for u in self.dae.unknowns])
        inside = np.concatenate([np.maximum(np.abs([*point.x, *point.z]), nominal), np.abs(point.u), [point.time]])
        derivative = values["dg"].full().reshape(len(self.relevant), len(inside))
        return _array(values["g"], "g"), np.abs(derivative) @ inside

    def _function(self, results: dict[str, SX]) -> _Function:
        still = {self.dae.initial.name(): SX(0.0)}
        outputs = [ca.densify(substitute(expression, still)) for expression in results.values()]
        return _Function(ca.Function("linear", self._arguments, outputs), list(results))


class _Function:
    """A CasADi function whose results have names."""

    def __init__(self, function: ca.Function, names: list[str]) -> None:
        self._function = function
        self._names = names

    def __call__(self, *arguments: ca.DM) -> dict[str, ca.DM]:
        return dict(zip(self._names, self._function.call(list(arguments)), strict=True))


def parameter_values(dae: Dae, given: dict[str, float]) -> Vector:
    """Return all parameters, those that depend on given ones worked out."""
    values: dict[str, float] = {}
    for parameter in dae.parameters:
        name = parameter.scalar.name
        values[name] = given[name] if name in given else float(evaluate(parameter.value, values))
    return np.array([*values.values()], dtype=float)


def on_surface(equations: Equations, point: Point) -> list[str]:
    """Return the texts of the relations that switch exactly at a point, where no derivative exists."""
    g, size = equations.indicators(point)
    relations = [equations.dae.relations[k] for k in equations.relevant]
    return [r.text for r, value, scale in zip(relations, g, size, strict=True) if abs(value) <= 1e-8 * scale]


def beyond_surface(equations: Equations, point: Point) -> list[str]:
    """Return the texts of the relations whose truth at a point is not the one that the point carries."""
    g, _ = equations.indicators(point)
    found = []
    for k, value in zip(equations.relevant, g, strict=True):
        relation = equations.dae.relations[k]
        if bool(value > 0 if relation.strict else value >= 0) != bool(point.c[k]):
            found.append(relation.text)
    return found


def with_unknowns(point: Point, x: Vector, z: Vector) -> Point:
    """Return the point with other states and torn unknowns."""
    return replace(point, x=x, z=z)


def symbols_behind(dae: Dae, continuous: SX) -> set[str]:
    """Names of all symbols that the continuous expressions, or the resets of states, may depend on."""
    needed = _names(continuous).union(*(_names(reset.guard) | _names(reset.value) for reset in dae.resets))
    position = {r.symbol.name(): k for k, r in enumerate(dae.relations)}
    plain = {f"{kind}({name})": name for name in (s.name for s in dae.discretes) for kind in ("pre", "new")}
    done: set[str] = set()
    while fresh := {plain.get(name, name) for name in needed} - done:
        done |= fresh
        needed = set()
        for assignment in dae.assignments:
            if fresh & set(assignment.targets):
                needed |= _names(assignment.values) | (set() if assignment.guard is None else _names(assignment.guard))
        for name in fresh & set(position):
            needed |= _names(dae.relations[position[name]].indicator)
    return done


def _names(expression: SX) -> set[str]:
    return {symbol.name() for symbol in ca.symvar(expression)}


def _column(values: Iterable[SX]) -> SX:
    return ca.vertcat(SX(0, 1), *values)


def _numbers(point: Point) -> list[ca.DM]:
    return [ca.DM(getattr(point, name)) for name in _ARGUMENTS]


def _array(value: ca.DM, name: str) -> Vector:
    full: Vector = value.full()
    return full if "_" in name else full.ravel()
