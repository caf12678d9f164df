"""Fits by following the motion with its exact derivatives: few unknowns, which are theta and the initial states."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cosim.calibration._compiled import Sums, Track
from cosim.calibration._descent import descend
from cosim.calibration._problem import HUBER, LOOSE, REST, Part, Problem, Solution
from cosim.calibration._progress import Progress
from cosim.calibration._uncertainty import Sensitivity
from cosim.errors import InputError, SimulationError

Array = NDArray[np.float64]
_WINDOWS = (1.0, 2.5)
"""What the first so many seconds tell is found first: over a short while, a wrong speed does not add up to a turn."""
_ROUGH, _FINE = 1e-3, 1e-8
"""A descent ends when a step promises to lower the cost by less than this part; over a window, over all."""
_TURN = 0.3
"""The crank has to get at least so far ahead [rad] in the first window."""
_REMEDY = "Start from values with which the motor runs as it was measured to, or choose another window"


@dataclass(frozen=True)
class Followed:
    """A measurement's motion for q = [x0; fitted parameters], none of them scaled."""

    q: Array
    track: Track


@dataclass(frozen=True)
class Spot:
    """The cost at some unknowns with its derivatives, each part followed there, and what all residuals square to."""

    cost: float
    gradient: Array
    hessian: Array
    parts: tuple[Followed, ...]
    squares: float


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


def solve(
    problem: Problem, robust: bool, most_steps: int, progress: Progress | None
) -> tuple[Solution, list[Followed]]:
    """Find the parameters; see :func:`cosim.calibration.fit`.

    Raises InputError if the motor does not run with the starting values.
    """
    theta, states = problem.start, [problem.initial(part) for part in problem.fitted]
    steps, near = 0, None
    longest = max(part.borders[-1] - part.borders[0] for part in problem.fitted)
    with ThreadPoolExecutor(min(len(states), os.cpu_count() or 1)) as workers:
        for window in (*(w for w in _WINDOWS if w < 0.7 * longest), np.inf):
            search = _Search(problem, [part.first(window) for part in problem.fitted], robust, None, workers)
            unknowns = search.packed(theta, states)
            try:
                spot = search.place(unknowns, near)
            except LostError as error:
                raise InputError(f"{error}. {_REMEDY}") from error
            if near is None:
                _check_running(problem, spot)

            samples = sum(part.samples for part in search.parts)

            def tell(step: int, at: Spot, before: int = steps, count: int = samples) -> None:
                if progress is not None:
                    progress(before + step, float(np.sqrt(at.squares / count)))

            tell(0, spot)
            enough = _FINE if np.isinf(window) else _ROUGH
            found = descend(search.evaluate, unknowns, spot, search.bounds(), most_steps - steps, enough, tell)
            steps += found.steps
            theta, states = search.unpacked(found.unknowns)
            near = found.place
    return Solution(theta, tuple(states), found.limit, steps), list(found.place.parts)


def meet(problem: Problem, part: Part, theta: Array, most_steps: int) -> Followed:
    """Return the motion with given parameters that meets a measurement best: only its initial state is free.

    Raises InputError if there is no such motion.
    """
    search = _Search(problem, [part], False, theta, None)
    unknowns = search.packed(theta, [problem.initial(part)])
    try:
        spot = search.place(unknowns, None)
    except LostError as error:
        raise InputError(f"with the fitted parameters, {error}") from error
    if not len(unknowns):
        return spot.parts[0]
    found = descend(search.evaluate, unknowns, spot, search.bounds(), most_steps, _FINE, lambda _step, _at: None)
    return found.place.parts[0]


def _check_running(problem: Problem, spot: Spot) -> None:
    """Raise InputError if the crank does not turn forward in one of the measurements."""
    angle = problem.model.state("phi_crank")
    for part, each in zip(problem.fitted, spot.parts, strict=True):
        ahead = each.track.x[-1, angle] - each.track.x[0, angle]
        if ahead < _TURN:
            raise InputError(
                f"{part.data.name}: with the starting values the crank turns only {ahead:.2g} rad in the first "
                f"{_WINDOWS[0]:g} s. {_REMEDY}"
            )


class _Search:
    """The cost of some measurements as a function of [theta; initial states of those whose is not known]."""

    def __init__(
        self, problem: Problem, parts: Sequence[Part], robust: bool, given: Array | None, workers: Executor | None
    ) -> None:
        """Let theta be an unknown, too, unless it is given; let workers follow the measurements."""
        self._map = map if workers is None else workers.map
        self._problem, self.parts, self._robust, self._given = problem, parts, robust, given
        self._count = len(problem.start) if given is None else 0
        self._scale = problem.model.scales[0]

    def packed(self, theta: Array, states: Sequence[Array]) -> Array:
        free = [x0 for part, x0 in zip(self.parts, states, strict=True) if part.data.known is None]
        return np.concatenate([theta[: self._count], *free])

    def unpacked(self, unknowns: Array) -> tuple[Array, list[Array]]:
        theta = unknowns[: self._count] if self._given is None else self._given
        return theta, [
            unknowns[place] if place else np.array(part.data.known) / self._scale
            for part, place in zip(self.parts, self._places(), strict=True)
        ]

    def bounds(self) -> tuple[Array, Array]:
        wide = np.full(sum(len(place) for place in self._places()), np.inf)
        lower, upper = self._problem.lower[: self._count], self._problem.upper[: self._count]
        return np.concatenate((lower, -wide)), np.concatenate((upper, wide))

    def evaluate(self, unknowns: Array, near: Spot | None) -> Spot | None:
        """Return the place, or None where a motion cannot be followed."""
        try:
            return self.place(unknowns, near)
        except LostError:
            return None

    def place(self, unknowns: Array, near: Spot | None) -> Spot:
        theta, states = self.unpacked(unknowns)
        gradient, hessian = np.zeros(len(unknowns)), np.zeros((len(unknowns), len(unknowns)))
        cost = squares = 0.0
        if self._given is None:
            cost += self._known(theta, gradient, hessian)
        before = near.parts if near is not None else [None] * len(states)
        found = list(self._map(self._followed, self.parts, states, [theta] * len(states), before))
        for (_, sums), part, place in zip(found, self.parts, self._places(), strict=True):
            cost, squares = cost + sums.loss, squares + sums.squares
            columns = [*place, *(part.entries if self._given is None else ())]
            nx = len(self._scale)
            taken = slice(0 if place else nx, None if self._given is None else nx)
            gradient[columns] += sums.gradient[taken]
            hessian[np.ix_(columns, columns)] += sums.hessian[taken, taken]
        return Spot(cost, gradient, hessian, tuple(followed for followed, _ in found), squares)

    def _followed(self, part: Part, x0: Array, theta: Array, near: Followed | None) -> tuple[Followed, Sums]:
        followed = follow_part(self._problem, part, x0, theta, near)
        return followed, sums_of(self._problem, part, followed, HUBER if self._robust else np.inf)

    def _known(self, theta: Array, gradient: Array, hessian: Array) -> float:
        """Add what is known beforehand; return what it costs."""
        cost = 0.0
        start = self._problem.start
        entries = [(entry, float(value), LOOSE) for entry, value in enumerate(start)]
        for entry, mean, deviation in (*entries, *self._problem.priors()):
            residual = (theta[entry] - mean) / deviation
            cost += 0.5 * residual**2
            gradient[entry] += residual / deviation
            hessian[entry, entry] += 1.0 / deviation**2
        return cost

    def _places(self) -> list[list[int]]:
        """For each measurement where its initial state is among the unknowns; nowhere if it is known."""
        places, begin = [], self._count
        for part in self.parts:
            length = 0 if part.data.known is not None else len(self._scale)
            places.append(list(range(begin, begin + length)))
            begin += length
        return places
