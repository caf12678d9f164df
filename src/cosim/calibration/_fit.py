"""Fits parameters to measurements: all of them in one collocation problem for IPOPT."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from cosim.calibration._collocation import Collocation, collocate
from cosim.calibration._data import Data
from cosim.calibration._ipopt import Progress, solve, why
from cosim.calibration._model import OUTPUTS, Model
from cosim.calibration._uncertainty import Sensitivity, Uncertainty, sensitivity, uncertainty
from cosim.errors import InputError

Array = NDArray[np.float64]
_HUBER = 3.0
"""Residuals beyond this many standard deviations count linearly if the loss is robust."""
_EDGE = 1e-4


@dataclass(frozen=True)
class Free:
    """A parameter to fit: bounds, and what is known of it beforehand (mean and standard deviation), in its unit.

    ``local`` gives each measurement a value of its own.
    """

    name: str
    lower: float | None = None
    upper: float | None = None
    prior: tuple[float, float] | None = None
    local: bool = False


@dataclass(frozen=True)
class Estimate:
    """What was found of a parameter: value and standard error in ``unit``; ``of`` is a measurement if it is local."""

    name: str
    unit: str
    value: float
    error: float
    start: float
    of: str | None
    at_bound: bool


@dataclass(frozen=True)
class Agreement:
    """How well a measurement is met: root of the mean square of the residuals of current [A] and torque [N.m].

    ``held_out`` tells that it was not fitted, but for its initial state.
    """

    name: str
    current_rmse: float
    torque_rmse: float | None
    samples: int
    held_out: bool


@dataclass(frozen=True)
class Fit:
    """Parameters with their uncertainty, and how well each measurement is met by them.

    ``solved`` tells whether IPOPT found a minimum, ``limit`` what kept it from one. ``modelled`` has for each
    measurement the current [A] and torque [N.m] at its instants, shape (2, n).
    """

    estimates: tuple[Estimate, ...]
    uncertainty: Uncertainty
    agreements: tuple[Agreement, ...]
    solved: bool
    limit: str | None
    iterations: int
    chi: float
    notes: tuple[str, ...]
    data: tuple[Data, ...] = field(repr=False)
    modelled: tuple[Array, ...] = field(repr=False)

    def value(self, name: str, of: str | None = None) -> float:
        """Return the value of a parameter, of a measurement if it is local."""
        return next(e.value for e in self.estimates if e.name == name and of in (None, e.of))


@dataclass
class _Part:
    """A measurement inside the problem: its equations, and which entries of theta it uses."""

    data: Data
    collocation: Collocation
    entries: list[int]
    held_out: bool


class Problem:
    """All measurements, and one vector theta of the parameters over their scales.

    ``labels`` tell for each entry which of the free parameters it is, and of which measurement if it is local.
    """

    def __init__(self, model: Model, free: Sequence[Free], data: Sequence[Data], held_out: Sequence[Data] = ()) -> None:
        """Set up the equations; raises InputError if the bounds contradict each other or the starting values."""
        self.model = model
        self.free = list(free)
        self.labels: list[tuple[int, int | None]] = [(k, None) for k, f in enumerate(free) if not f.local]
        self.parts: list[_Part] = []
        everything = [*((d, False) for d in data), *((d, True) for d in held_out)]
        for number, (each, out) in enumerate(everything):
            entries = []
            for k, f in enumerate(free):
                if f.local and not out:
                    self.labels.append((k, number))
                    entries.append(len(self.labels) - 1)
                else:
                    # a local parameter of what is held out is that of the first measurement
                    entries.append(next(i for i, (j, _) in enumerate(self.labels) if j == k))
            self.parts.append(_Part(each, collocate(model, each), entries, out))
        self.scale = np.array([model.scale[k] for k, _ in self.labels])
        self.start = np.array([model.start[k] for k, _ in self.labels]) / self.scale
        self.lower, self.upper = self._bounds()

    @property
    def fitted(self) -> list[_Part]:
        """The measurements that are not held out."""
        return [part for part in self.parts if not part.held_out]

    def _bounds(self) -> tuple[Array, Array]:
        lower, upper = np.full(len(self.labels), -np.inf), np.full(len(self.labels), np.inf)
        for entry, (k, _) in enumerate(self.labels):
            f = self.free[k]
            bounds = [b / self.scale[entry] if b is not None else None for b in (f.lower, f.upper)]
            if self.scale[entry] < 0.0:
                bounds.reverse()
            lower[entry] = bounds[0] if bounds[0] is not None else -np.inf
            upper[entry] = bounds[1] if bounds[1] is not None else np.inf
            if not lower[entry] < upper[entry]:
                raise InputError(f"{f.name}: the lower bound {f.lower:g} is not below the upper one, {f.upper:g}")
            if not lower[entry] <= self.start[entry] <= upper[entry]:
                value = self.start[entry] * self.scale[entry]
                raise InputError(f"{f.name}: the starting value {value:g} is outside its bounds; give another one")
        return lower, upper

    def prior(self, theta: ca.MX | Array) -> list[ca.MX]:
        """Return the deviations of theta from what is known beforehand, over their standard deviations."""
        found = []
        for entry, (k, _) in enumerate(self.labels):
            prior = self.free[k].prior
            if prior is not None:
                found.append((theta[entry] * self.scale[entry] - prior[0]) / prior[1])
        return found

    def residuals(self, part: _Part, outputs: ca.MX) -> ca.MX:
        """Return the residuals of a measurement over their noise, for the outputs at its collocation points."""
        data = part.data
        sampled = [ca.mtimes(part.collocation.sampling, outputs[row, :].T) for row in range(len(OUTPUTS))]
        found = [(sampled[0] - data.current) / data.noise[0]]
        if data.torque is not None:
            found.append((sampled[1] - data.torque) / data.noise[1])
        return ca.vertcat(*found)

    def sensitivities(self, theta: Array, states: Sequence[Array], unknowns: Sequence[Array]) -> list[Sensitivity]:
        """Return for each fitted measurement how its residuals change with its initial state and with theta."""
        found = []
        for part, x0, w in zip(self.fitted, states, unknowns, strict=True):
            q = ca.MX.sym("q", len(x0) + len(part.entries))
            variable = ca.MX.sym("w", len(w))
            r = ca.Function("r", [q, variable], [self.residuals(part, part.collocation.outputs(q, variable))])
            at = np.concatenate((x0, theta[part.entries]))
            found.append(sensitivity(part.collocation.residuals, r, at, w, len(x0), part.entries, len(theta)))
        return found


def fit(
    model: Model,
    free: Sequence[Free],
    data: Sequence[Data],
    *,
    held_out: Sequence[Data] = (),
    robust: bool = False,
    most_iterations: int = 200,
    progress: Progress | None = None,
) -> Fit:
    """Find the parameters with which the plant's current, and torque where it was measured, fit the data best.

    The sum of the squares of all residuals over their noise is minimised, that of the priors included, subject to the
    collocation equations of every measurement; each measurement's initial state is free. ``robust`` lets residuals
    beyond three standard deviations count linearly (pseudo-Huber). Derivatives are exact, first and second.

    Raises:
        InputError: bounds or starting values contradict each other.
        SimulationError: IPOPT failed before it found anything.
    """
    problem = Problem(model, free, data, held_out)
    theta = ca.MX.sym("theta", len(problem.labels))
    variables, starts, lower, upper = [theta], [problem.start], [problem.lower], [problem.upper]
    constraints, losses, count = [], [], 0
    nx = model.sizes[0]
    for part in problem.fitted:
        x0 = ca.MX.sym("x0", nx)
        w = ca.MX.sym("w", len(part.collocation.guess_w))
        q = ca.vertcat(x0, theta[part.entries])
        r = problem.residuals(part, part.collocation.outputs(q, w))
        losses.append(_loss(r, robust))
        count += r.numel()
        constraints.append(part.collocation.residuals(q, w))
        variables += [x0, w]
        starts += [part.collocation.guess_q[:nx], part.collocation.guess_w]
        for size in (nx, len(part.collocation.guess_w)):
            lower.append(np.full(size, -np.inf))
            upper.append(np.full(size, np.inf))
    priors = problem.prior(theta)
    objective = sum(losses, ca.MX(0.0)) + 0.5 * sum((p**2 for p in priors), ca.MX(0.0))
    solution, status, iterations = solve(
        ca.vertcat(*variables), objective, ca.vertcat(*constraints), starts, (lower, upper), most_iterations,
        None if progress is None else lambda k, f: progress(k, float(np.sqrt(max(2.0 * f, 0.0) / count))),
    )  # fmt: skip
    found, states, unknowns = _split(solution, len(problem.labels), problem.fitted, nx)
    sensitivities = problem.sensitivities(found, states, unknowns)
    known = [problem.free[k].prior for k, _ in problem.labels]
    strengths = np.array([0.0 if p is None else abs(s) / p[1] for p, s in zip(known, problem.scale, strict=True)])
    names = [_label(problem, entry) for entry in range(len(problem.labels))]
    modelled = [_modelled(part, np.concatenate((x, found[part.entries])), w)
                for part, x, w in zip(problem.fitted, states, unknowns, strict=True)]  # fmt: skip
    parts = list(problem.fitted)
    for part in problem.parts:
        if part.held_out:
            parts.append(part)
            modelled.append(_hold_out(problem, part, found, most_iterations))
    agreements = [_agreement(part, values) for part, values in zip(parts, modelled, strict=True)]
    spread = uncertainty(names, sensitivities, strengths, found)
    solved = status == "Solve_Succeeded"
    at_bound = (found - problem.lower < _EDGE) | (problem.upper - found < _EDGE)
    estimates = tuple(
        Estimate(
            problem.free[k].name,
            model.units[k],
            float(found[entry] * problem.scale[entry]),
            float(spread.errors[entry] * abs(problem.scale[entry])),
            float(problem.start[entry] * problem.scale[entry]),
            None if number is None else problem.parts[number].data.name,
            bool(at_bound[entry]),
        )
        for entry, (k, number) in enumerate(problem.labels)
    )
    notes = [f"{e.name} ends at its bound, {e.value:g} {e.unit}" for e in estimates if e.at_bound]
    notes += _mode_changes(model, problem, found, states, unknowns)
    return Fit(
        estimates=estimates,
        uncertainty=spread,
        agreements=tuple(agreements),
        solved=solved,
        limit=None if solved else why(status),
        iterations=iterations,
        chi=spread.chi,
        notes=tuple(notes),
        data=tuple(part.data for part in parts),
        modelled=tuple(modelled),
    )


def _loss(r: ca.MX, robust: bool) -> ca.MX:
    if not robust:
        return 0.5 * ca.sumsqr(r)
    return _HUBER**2 * ca.sum1(ca.sqrt(1.0 + (r / _HUBER) ** 2) - 1.0)


def _label(problem: Problem, entry: int) -> str:
    k, number = problem.labels[entry]
    name = problem.free[k].name
    return name if number is None else f"{name} ({problem.parts[number].data.name})"


def _split(solution: Array, parameters: int, parts: Sequence[_Part], nx: int) -> tuple[Array, list[Array], list[Array]]:
    theta, place = solution[:parameters], parameters
    states, unknowns = [], []
    for part in parts:
        states.append(solution[place : place + nx])
        place += nx
        unknowns.append(solution[place : place + len(part.collocation.guess_w)])
        place += len(part.collocation.guess_w)
    return theta, states, unknowns


def _modelled(part: _Part, q: Array, w: Array) -> Array:
    """The OUTPUTS at the instants of the data, shape (2, n)."""
    outputs = part.collocation.outputs(q, w)
    return np.array(ca.mtimes(outputs, part.collocation.sampling.T), dtype=np.float64)


def _hold_out(problem: Problem, part: _Part, theta: Array, most_iterations: int) -> Array:
    """What the fitted parameters say of a measurement that was not fitted: only its initial state is free."""
    nx = problem.model.sizes[0]
    x0, w = ca.MX.sym("x0", nx), ca.MX.sym("w", len(part.collocation.guess_w))
    q = ca.vertcat(x0, ca.DM(theta[part.entries]))
    objective = 0.5 * ca.sumsqr(problem.residuals(part, part.collocation.outputs(q, w)))
    starts = [part.collocation.guess_q[:nx], part.collocation.guess_w]
    free = [np.full(len(s), np.inf) for s in starts]
    solution, _, _ = solve(
        ca.vertcat(x0, w), objective, part.collocation.residuals(q, w), starts, ([-f for f in free], free),
        most_iterations, None,
    )  # fmt: skip
    return _modelled(part, np.concatenate((solution[:nx], theta[part.entries])), solution[nx:])


def _agreement(part: _Part, modelled: Array) -> Agreement:
    data = part.data
    rmse = [
        None if measured is None else float(np.sqrt(np.mean((values - measured) ** 2)))
        for values, measured in zip(modelled, (data.current, data.torque), strict=True)
    ]
    return Agreement(data.name, rmse[0] or 0.0, rmse[1], len(data.time), part.held_out)


def _mode_changes(
    model: Model, problem: Problem, theta: Array, states: Sequence[Array], unknowns: Sequence[Array]
) -> list[str]:
    """Tell where a relation that was held would have changed: the fit is not to be trusted there."""
    notes = []
    x_scale, z_scale = model.scales
    scales = np.concatenate((x_scale, z_scale))
    for part, _, w in zip(problem.fitted, states, unknowns, strict=True):
        columns = w.reshape(-1, len(scales)).T * scales[:, None]
        u = model.input_column(part.data.supply_at(part.collocation.points))
        own = theta[part.entries]
        for k in range(columns.shape[1]):
            x, z = columns[: len(x_scale), k], columns[len(x_scale) :, k]
            changed = model.changed(x, z, u[:, k], own)
            if changed:
                notes.append(
                    f"{part.data.name}: at {part.collocation.points[k]:.3f} s the relation '{changed[0]}' changes, "
                    "which the fit takes to stay as it is; choose another window"
                )
                break
    return notes


def given(values: Mapping[str, float] | None) -> dict[str, float]:
    """Return parameter values by the model's names, without the component's name in front."""
    return {name.removeprefix("plant."): value for name, value in (values or {}).items()}
