"""Fits parameters to measurements: all of them in one collocation problem for IPOPT."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cosim.calibration._data import Data, distinct
from cosim.calibration._ipopt import Progress, why
from cosim.calibration._model import Model
from cosim.calibration._problem import Free, Motion, Part, Problem, Solution
from cosim.calibration._results import Agreement, Estimate, Fit
from cosim.calibration._uncertainty import Uncertainty

Array = NDArray[np.float64]
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
    most_iterations: int = 200,
    progress: Progress | None = None,
) -> Fit:
    """Find the parameters with which the plant's current, and torque where it was measured, fit the data best.

    The sum of the squares of all residuals over their noise is minimised, that of the priors included, subject to the
    collocation equations of every measurement; each measurement's initial state is free. Derivatives are exact, first
    and second.

    Args:
        model: the plant, with the same parameters free in the same order.
        free: the parameters; their starting values are those of the model.
        data: what to fit to.
        held_out: what to predict with the fitted parameters; only its initial state is found from it.
        robust: let residuals beyond three standard deviations count linearly (pseudo-Huber).
        most_iterations: of IPOPT.
        progress: is told each iteration and the root of the mean square of all residuals over their noise.

    Raises:
        InputError: bounds, priors or starting values contradict each other.
        SimulationError: IPOPT found nothing finite.
    """
    named = distinct([*data, *held_out])
    problem = Problem(model, free, named[: len(data)], named[len(data) :])
    solution = problem.solve(robust, most_iterations, progress)
    predicted = [problem.follow(part, solution.theta, most_iterations) for part in problem.parts if part.held_out]
    motions: list[Motion] = [*solution.motions, *predicted]
    modelled = [problem.modelled(p, solution.theta, m) for p, m in zip(problem.parts, motions, strict=True)]
    spread = problem.uncertainty(solution)
    solved = solution.status == "Solve_Succeeded"
    estimates = _estimates(problem, solution, spread)
    return Fit(
        estimates=estimates,
        uncertainty=spread,
        agreements=tuple(_agreement(part, values) for part, values in zip(problem.parts, modelled, strict=True)),
        solved=solved,
        limit=None if solved else why(solution.status),
        iterations=solution.iterations,
        notes=(*_notes(problem, estimates, spread), *problem.mode_changes(solution)),
        data=tuple(part.data for part in problem.parts),
        modelled=tuple(modelled),
    )


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
