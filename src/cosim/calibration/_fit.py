"""Fits parameters to measurements, and tells how certain they are."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from cosim.calibration import _collocation, _shooting
from cosim.calibration._data import Data, distinct
from cosim.calibration._equations import OUTPUTS
from cosim.calibration._model import Model
from cosim.calibration._motion import Followed, follow_part, sensitivity_of
from cosim.calibration._problem import Free, Part, Problem, Solution
from cosim.calibration._progress import Progress
from cosim.calibration._results import Agreement, Estimate, Fit
from cosim.calibration._uncertainty import Uncertainty, uncertainty

Array = NDArray[np.float64]
Method = Literal["shooting", "collocation"]
_EDGE = 1e-4
"""A parameter ends at its bound if it is this near to it, relative to its starting value."""
_FITS = 1.5
"""Residuals of more than this many times the noise show a model that is not that of the measurement."""


def fit(
    model: Model,
    free: Sequence[Free],
    data: Sequence[Data],
    *,
    held_out: Sequence[Data] = (),
    robust: bool = False,
    method: Method = "shooting",
    most_iterations: int = 200,
    progress: Progress | None = None,
) -> Fit:
    """Find the parameters with which the plant's current, and torque where it was measured, fit the data best.

    The sum of the squares of all residuals over their noise is minimised, that of the priors included; each
    measurement's initial state is free unless it is known. Derivatives are exact. Both methods solve the same equations
    by the same discretisation: "shooting" follows the motion from its initial state, with damped Gauss-Newton steps,
    over a short window first; "collocation" makes the motion at all points an unknown, and leaves it to IPOPT.

    Args:
        model: the plant, with the same parameters free in the same order.
        free: the parameters; their starting values are those of the model.
        data: what to fit to.
        held_out: what to predict with the fitted parameters; only its initial state is found from it.
        robust: let residuals beyond three standard deviations count linearly (pseudo-Huber).
        method: how to search.
        most_iterations: after so many, the search is given up.
        progress: is told each iteration and the root of the mean square of all residuals over their noise.

    Raises:
        InputError: bounds, priors or starting values contradict each other, or the motor does not run with these.
        SimulationError: nothing finite was found.
    """
    named = distinct([*data, *held_out])
    problem = Problem(model, free, named[: len(data)], named[len(data) :])
    if method == "shooting":
        solution, followed = _shooting.solve(problem, robust, most_iterations, progress)
    else:
        solution = _collocation.solve(problem, robust, most_iterations, progress)
        pairs = zip(problem.fitted, solution.states, strict=True)
        followed = [follow_part(problem, part, x0, solution.theta) for part, x0 in pairs]
    held = [_shooting.meet(problem, part, solution.theta, most_iterations) for part in problem.parts if part.held_out]
    everything = zip(problem.parts, [*followed, *held], strict=True)
    modelled = [_modelled(problem.model, part, each) for part, each in everything]
    spread = _uncertainty(problem, solution, followed)
    estimates = _estimates(problem, solution, spread)
    return Fit(
        estimates=estimates,
        uncertainty=spread,
        agreements=tuple(_agreement(part, values) for part, values in zip(problem.parts, modelled, strict=True)),
        solved=solution.limit is None,
        limit=solution.limit,
        iterations=solution.iterations,
        notes=(*_notes(problem, estimates, spread), *_mode_changes(problem, followed)),
        data=tuple(part.data for part in problem.parts),
        modelled=tuple(modelled),
    )


def _modelled(model: Model, part: Part, followed: Followed) -> Array:
    """The OUTPUTS at the instants of the data."""
    columns = [model.output(k, followed.track, part.u, followed.q)[:, 0] for k in range(len(OUTPUTS))]
    return np.array([part.sampling @ column for column in columns])


def _uncertainty(problem: Problem, solution: Solution, followed: Sequence[Followed]) -> Uncertainty:
    strengths = np.zeros(len(solution.theta))
    for entry, _, deviation in problem.priors():
        strengths[entry] = 1.0 / deviation
    names = [problem.label(entry) for entry in range(len(solution.theta))]
    parts = [
        sensitivity_of(problem, part, each, len(names)) for part, each in zip(problem.fitted, followed, strict=True)
    ]
    return uncertainty(names, parts, strengths, solution.theta)


def _mode_changes(problem: Problem, followed: Sequence[Followed]) -> list[str]:
    """Tell where a relation that is held would have changed: the fit is not to be trusted there."""
    notes = []
    for part, each in zip(problem.fitted, followed, strict=True):
        change = problem.model.first_change(each.track, part.u, each.q)
        if change is not None:
            point, text = change
            notes.append(
                f"{part.data.name}: at {part.points[point]:.3f} s the relation '{text}' changes, "
                "which the fit takes to stay as it is; choose another window"
            )
    return notes


def _estimates(problem: Problem, solution: Solution, spread: Uncertainty) -> tuple[Estimate, ...]:
    theta = solution.theta
    at_bound = (theta - problem.lower < _EDGE) | (problem.upper - theta < _EDGE)
    return tuple(
        Estimate(
            name=problem.free[k].name,
            unit=problem.model.units[k],
            value=float(theta[entry] * problem.scale[entry]),
            error=float(spread.errors[entry] * abs(problem.scale[entry])),
            start=float(problem.start[entry] * problem.scale[entry]),
            of=None if number is None else problem.parts[number].data.name,
            at_bound=bool(at_bound[entry]),
        )
        for entry, (k, number) in enumerate(problem.labels)
    )


def _agreement(part: Part, modelled: Array) -> Agreement:
    data = part.data
    current = float(np.sqrt(np.mean((modelled[0] - data.current) ** 2)))
    torque = None if data.torque is None else float(np.sqrt(np.mean((modelled[1] - data.torque) ** 2)))
    return Agreement(data.name, current, torque, data.noise[0], len(data.time), part.held_out)


def _notes(problem: Problem, estimates: Sequence[Estimate], spread: Uncertainty) -> list[str]:
    notes = [note for part in problem.parts for note in part.data.notes]
    notes += [f"{e.name} ends at its bound, {e.value:.6g} {e.unit}" for e in estimates if e.at_bound]
    if spread.chi > _FITS:
        notes.append(
            f"the residuals are {spread.chi:.3g} times the noise: the model differs from what was measured by more "
            "than its parameters, so the standard errors are too small"
        )
    return notes
