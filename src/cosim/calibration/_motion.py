"""A measurement's motion, followed with its derivatives, and how far it is from what was measured."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cosim.calibration._compiled import Sums, Track
from cosim.calibration._problem import REST, Part, Problem
from cosim.calibration._uncertainty import Sensitivity
from cosim.errors import SimulationError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Followed:
    """A measurement's motion for q = [x0; fitted parameters], none of them scaled."""

    q: Array
    track: Track


class LostError(SimulationError):
    """A motion cannot be followed to its end."""


def follow_part(
    problem: Problem, part: Part, x0: Array, theta: Array, near: Followed | None = None, **options: float
) -> Followed:
    """Follow a measurement's motion from its initial state (scaled).

    ``near`` is the same, or the beginning of it, with values nearby; ``options`` are those of `Model.follow`. Raises
    LostError if it cannot be followed.
    """
    model = problem.model
    scale = np.concatenate((model.scales[0], model.scale))
    q = np.concatenate((x0, theta[part.entries])) * scale
    guess = None
    if near is not None:
        guess = near.track.x[1:] + near.track.x_q[1:] @ (q - near.q), near.track.z
    track = model.follow(part.h, part.u, q, guess, **options)
    if not track.whole or not np.isfinite(track.x_q).all():
        raise LostError(_where_lost(problem, part, q, track))
    return Followed(q, track)


def sums_of(problem: Problem, part: Part, followed: Followed, turn: float) -> Sums:
    """Return the sums over a measurement's residuals (over their noise), q = [x0; own theta] scaled."""
    loss = squares = 0.0
    gradient, hessian = np.zeros(len(followed.q)), np.zeros((len(followed.q), len(followed.q)))
    for points, measured in _compared(problem, part, followed):
        found = problem.model.library.gather(part.sampling, points, measured, turn)
        loss, squares = loss + found.loss, squares + found.squares
        gradient += found.gradient
        hessian += found.hessian
    if (rest := _rest(problem, part, followed)) is not None:
        at = problem.model.state("w_crank")
        loss, squares = loss + 0.5 * rest[0] ** 2, squares + rest[0] ** 2
        gradient[at] += rest[0] * rest[1]
        hessian[at, at] += rest[1] ** 2
    return Sums(loss, squares, gradient, hessian)


def sensitivity_of(problem: Problem, part: Part, followed: Followed, total: int) -> Sensitivity:
    """Return how a measurement's residuals change with its initial state, where that is free, and with theta."""
    rows = []
    for points, measured in _compared(problem, part, followed):
        rows.append(part.sampling @ points)
        rows[-1][:, 0] -= measured
    if (rest := _rest(problem, part, followed)) is not None:
        rows.append(np.zeros((1, 1 + len(followed.q))))
        rows[-1][0, [0, 1 + problem.model.state("w_crank")]] = rest
    everything = np.vstack(rows)
    states = followed.track.x.shape[1]
    by_theta = np.zeros((len(everything), total))
    by_theta[:, part.entries] = everything[:, 1 + states :]
    by_state = everything[:, 1 : 1 + (0 if part.data.known is not None else states)]
    return Sensitivity(everything[:, 0], by_state, by_theta)


def _compared(problem: Problem, part: Part, followed: Followed) -> Iterator[tuple[Array, Array]]:
    """For each output that was measured: it at the points with its derivatives by q scaled, and what was measured."""
    model = problem.model
    scale = np.concatenate(([1.0], model.scales[0], model.scale))
    for output, (values, noise) in enumerate(part.data.measured):
        yield model.output(output, followed.track, part.u, followed.q) * (scale / noise), values / noise


def _rest(problem: Problem, part: Part, followed: Followed) -> tuple[float, float] | None:
    """What the speed of a motor counts that begins at rest, and its derivative by that speed scaled."""
    if not part.data.from_rest or part.data.known is not None:
        return None
    speed = problem.model.state("w_crank")
    return float(followed.q[speed]) / REST, float(problem.model.scales[0][speed]) / REST


def _where_lost(problem: Problem, part: Part, q: Array, track: Track) -> str:
    at = part.points[min(track.done, len(part.points) - 1)]
    change = problem.model.first_change(track, part.u, q)
    reason = "" if change is None else f"; at {part.points[change[0]]:.3f} s the relation '{change[1]}' changes"
    return f"{part.data.name}: the motion cannot be followed beyond {at:.3f} s{reason}"
