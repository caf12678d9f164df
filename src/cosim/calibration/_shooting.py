"""Fits by following the motion with its exact derivatives: few unknowns, which are theta and the initial states."""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cosim.calibration._compiled import Sums
from cosim.calibration._descent import Descent, descend
from cosim.calibration._motion import Followed, LostError, follow_part, sums_of
from cosim.calibration._problem import HUBER, LOOSE, Part, Problem, Solution
from cosim.calibration._progress import Progress
from cosim.errors import InputError

Array = NDArray[np.float64]
_SHORT, _LONGER = 1.0, 2.5
"""What the first so many seconds tell is found first: over a short while, a wrong speed does not add up to a turn."""
_WAYS = ((_SHORT,), (_SHORT, _LONGER), ())
"""What comes before the whole. The next way is tried while residuals are not near the noise; the best one counts."""
_ROUGH, _FINE = 1e-3, 1e-8
"""A descent ends when a step promises to lower the cost by less than this part; over a beginning, over all."""
_LOOSELY = 1e-4
"""Newton's method may end with a step of this size beside the nominal sizes over a beginning."""
_PHASES, _FEW = 8, 20
"""So many angles of the crank are tried at the beginning if the motor runs already, with so many steps each."""
_MET = 1.5
"""With residuals below this many times the noise, nothing better is looked for."""
_TURN = 0.3
"""The crank has to get at least so far ahead [rad] in the short beginning."""
_REMEDY = "Start from values with which the motor runs as it was measured to, or choose another window"


@dataclass(frozen=True)
class Spot:
    """The cost at some unknowns with its derivatives, each part followed there, and what all residuals square to."""

    cost: float
    gradient: Array
    hessian: Array
    parts: tuple[Followed, ...]
    squares: float


@dataclass(frozen=True)
class _End:
    """Where a descent over one window after another has ended."""

    theta: Array
    states: list[Array]
    spot: Spot
    chi: float
    steps: int
    limit: str | None


def solve(
    problem: Problem, robust: bool, most_steps: int, progress: Progress | None
) -> tuple[Solution, list[Followed]]:
    """Find the parameters; see :func:`cosim.calibration.fit`.

    Raises InputError if the motor does not run with the starting values.
    """
    begin = _beginning(problem, robust)
    longest = max(part.borders[-1] - part.borders[0] for part in problem.fitted)
    best: _End | None = None
    lost: LostError | None = None
    steps = 0
    with ThreadPoolExecutor(min(len(problem.fitted), os.cpu_count() or 1)) as workers:
        for shorter in _WAYS:
            windows = [*(w for w in shorter if w < 0.7 * longest), np.inf]
            try:
                end = _descend_over(windows, problem, robust, begin, most_steps, workers, steps, progress)
            except LostError as error:
                lost = lost or error
                continue
            steps += end.steps
            if best is None or end.spot.cost < best.spot.cost:
                best = end
            if best.chi < _MET or longest <= _SHORT / 0.7:
                break
    if best is None:
        raise InputError(f"{lost}. {_REMEDY}")
    return Solution(best.theta, tuple(best.states), best.limit, steps), list(best.spot.parts)


def _descend_over(
    windows: Sequence[float], problem: Problem, robust: bool, begin: tuple[Array, list[Array]], most_steps: int,
    workers: Executor, steps_before: int, progress: Progress | None,
) -> _End:  # fmt: skip
    """Descend over each window from where the one before has led. Raises LostError if a motion cannot be followed."""
    theta, states = begin
    steps, near = 0, None
    for window in windows:
        search = _Search(problem, [part.first(window) for part in problem.fitted], robust, None, workers)
        unknowns = search.packed(theta, states)
        spot = search.place(unknowns, near)
        if near is None:
            _check_running(problem, spot)

        def tell(step: int, at: Spot, before: int = steps_before + steps, of: _Search = search) -> None:
            if progress is not None:
                progress(before + step, of.chi(at))

        tell(0, spot)
        enough = _FINE if np.isinf(window) else _ROUGH
        found = descend(search.evaluate, unknowns, spot, search.bounds(), most_steps - steps, enough, tell)
        steps += found.steps
        theta, states = search.unpacked(found.unknowns)
        near = found.place
    return _End(theta, states, found.place, search.chi(found.place), steps, found.limit)


def meet(problem: Problem, part: Part, theta: Array, most_steps: int) -> Followed:
    """Return the motion with given parameters that meets a measurement best: only its initial state is free.

    Raises InputError if there is no such motion.
    """
    search = _Search(problem, [part], False, theta, None)
    try:
        x0 = problem.initial(part)
        if _is_running(part):
            _, x0 = _phase(problem, part, False, theta, theta)
        unknowns = search.packed(theta, [x0])
        spot = search.place(unknowns, None)
    except LostError as error:
        raise InputError(f"with the fitted parameters, {error}") from error
    if not len(unknowns):
        return spot.parts[0]
    return search.descend(unknowns, spot, most_steps, _FINE).place.parts[0]


def _beginning(problem: Problem, robust: bool) -> tuple[Array, list[Array]]:
    """Return theta and the initial states to begin with: the start, unless the motor runs already in a measurement.

    Then theta is from the measurement that is met best over its beginning, but for what is local to others.
    """
    theta, states, least = problem.start.copy(), [], np.inf
    own: list[tuple[Part, Array]] = []
    for part in problem.fitted:
        if not _is_running(part):
            states.append(problem.initial(part))
            continue
        try:
            (chi, found), x0 = _phase(problem, part, robust, problem.start, None)
        except LostError as error:
            raise InputError(f"{error}. {_REMEDY}") from error
        states.append(x0)
        own.append((part, found))
        if chi < least:
            least, theta = chi, found
    local = [entry for entry, (_, number) in enumerate(problem.labels) if number is not None]
    theta = theta.copy()
    for part, found in own:
        mine = [entry for entry in local if entry in part.entries]
        theta[mine] = found[mine]
    return theta, states


def _is_running(part: Part) -> bool:
    """Whether the motor runs already when a measurement begins, at an angle that is not known."""
    return not part.data.from_rest and part.data.known is None


def _phase(
    problem: Problem, part: Part, robust: bool, start: Array, given: Array | None
) -> tuple[tuple[float, Array], Array]:
    """Find at which angle a measurement begins: the one with which its beginning is met best.

    Returns the root mean square of the residuals and theta (both of the beginning), and the initial state. Raises
    LostError if no motion can be followed from any angle.
    """
    guess, angle = problem.initial(part), problem.model.state("phi_crank")
    best: tuple[tuple[float, Array], Array] | None = None
    lost: LostError | None = None
    for k in range(_PHASES):
        theta, x0 = start, guess.copy()
        x0[angle] += 2.0 * np.pi * k / _PHASES / problem.model.scales[0][angle]
        near: Spot | None = None
        try:
            for window in (_SHORT, _LONGER):
                search = _Search(problem, [part.first(window)], robust, given, None)
                unknowns = search.packed(theta, [x0])
                found = search.descend(unknowns, search.place(unknowns, near), _FEW, _ROUGH)
                theta, (x0,) = search.unpacked(found.unknowns)
                near = found.place
        except LostError as error:
            lost = error
            continue
        chi = search.chi(found.place)
        if best is None or chi < best[0][0]:
            best = (chi, theta), x0
        if chi < _MET:
            break
    if best is None:
        raise lost or LostError(f"{part.data.name}: no angle to begin with was found")
    return best


def _check_running(problem: Problem, spot: Spot) -> None:
    """Raise InputError if the crank does not turn forward in one of the measurements."""
    angle = problem.model.state("phi_crank")
    for part, each in zip(problem.fitted, spot.parts, strict=True):
        ahead = each.track.x[-1, angle] - each.track.x[0, angle]
        if ahead < _TURN:
            raise InputError(
                f"{part.data.name}: with the starting values the crank turns only {ahead:.2g} rad in the first "
                f"{_SHORT:g} s. {_REMEDY}"
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

    def chi(self, spot: Spot) -> float:
        """Return the root of the mean square of all residuals over their noise."""
        return float(np.sqrt(spot.squares / sum(part.samples for part in self.parts)))

    def descend(self, unknowns: Array, spot: Spot, most_steps: int, enough: float) -> Descent[Spot]:
        """Descend from a place without a word."""
        return descend(self.evaluate, unknowns, spot, self.bounds(), most_steps, enough, lambda _step, _at: None)

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
        rough = {"tolerance": _LOOSELY} if part.is_cut else {}
        followed = follow_part(self._problem, part, x0, theta, near, **rough)
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
