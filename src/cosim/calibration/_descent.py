"""Least squares by Gauss, Newton, Levenberg and Marquardt, with bounds, on the normal equations of few unknowns."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_TINY = 1e-10
"""A step that promises to lower the cost by less than this is not taken."""
_FIRST, _LEAST, _MOST = 1e-3, 1e-9, 1e9
"""Damping at first; less than the second is none; with more than the third, no step lowers the cost."""


class Place(Protocol):
    """The cost at some values of the unknowns, its gradient, and its Hessian without the residuals' curvature."""

    @property
    def cost(self) -> float: ...

    @property
    def gradient(self) -> Array: ...

    @property
    def hessian(self) -> Array: ...


P = TypeVar("P", bound=Place)


@dataclass(frozen=True)
class Descent(Generic[P]):
    """Where a descent has ended: unknowns, what `evaluate` gave there, its steps, and what kept it from a minimum."""

    unknowns: Array
    place: P
    steps: int
    limit: str | None


def descend(
    evaluate: Callable[[Array, P | None], P | None],
    start: Array,
    first: P,
    bounds: tuple[Array, Array],
    most_steps: int,
    enough: float,
    tell: Callable[[int, P], None],
) -> Descent[P]:
    """Minimise the cost; see J. J. Moré, The Levenberg-Marquardt algorithm, LNM 630 (1978), for its parts.

    Args:
        evaluate: gives a place, helped by a place nearby, or None where there is none.
        start: the unknowns to begin with, within the bounds.
        first: the place there.
        bounds: of the unknowns.
        most_steps: after so many, tried in vain or not, the descent is given up.
        enough: the descent ends when a step promises to lower the cost by less than this part of it.
        tell: is told the number of each step that lowered the cost, and the place where it led.
    """
    at, place, damping, growth = start, first, _FIRST, 2.0
    scale = np.diag(place.hessian).copy()
    for step in range(1, most_steps + 1):
        scale = np.maximum(scale, np.diag(place.hessian))
        lowest, highest = bounds[0] - at, bounds[1] - at
        newton = bounded_step(place.hessian, place.gradient, lowest, highest)
        if promise(place, newton) <= enough * place.cost + _TINY:
            return Descent(at, place, step - 1, None)
        move = newton
        if damping > _LEAST:
            move = bounded_step(place.hessian + damping * np.diag(scale), place.gradient, lowest, highest)
        trial = evaluate(at + move, place)
        expected = promise(place, move)
        quality = -1.0 if trial is None else (place.cost - trial.cost) / max(expected, 1e-300)
        if trial is not None and quality > 1e-3:
            at, place = np.clip(at + move, *bounds), trial
            tell(step, place)
            # after H. B. Nielsen, Damping parameter in Marquardt's method, IMM-REP-1999-05
            damping *= max(1.0 / 30.0, 1.0 - (2.0 * min(quality, 1.0) - 1.0) ** 3)
            growth = 2.0
        else:
            damping, growth = max(damping, _LEAST) * growth, 2.0 * growth
            if damping > _MOST:
                return Descent(at, place, step, "the steps became too small")
    return Descent(at, place, most_steps, "it took more iterations than allowed")


def promise(place: Place, move: Array) -> float:
    """Return by how much a step lowers the cost if that is as the gradient and the Hessian say."""
    return -float(place.gradient @ move + 0.5 * move @ place.hessian @ move)


def bounded_step(hessian: Array, gradient: Array, lowest: Array, highest: Array) -> Array:
    """Return the step that minimises gradient @ d + d @ hessian @ d / 2 within bounds that contain zero.

    The hessian is positive definite. Unknowns go to the bounds that they would violate, and off those again where that
    is downhill.
    """
    d = np.zeros(len(gradient))
    held = np.zeros(len(gradient), dtype=bool)
    for _ in range(4 * len(gradient) + 1):
        free = ~held
        right = -gradient[free] - hessian[np.ix_(free, held)] @ d[held]
        d[free] = _solved(hessian[np.ix_(free, free)], right)
        outside = free & ((d < lowest) | (d > highest))
        if outside.any():
            d = np.clip(d, lowest, highest)
            held |= outside
            continue
        slope = gradient + hessian @ d
        inward = held & np.where(d <= lowest, slope < 0.0, slope > 0.0) & (lowest < highest)
        if not inward.any():
            return d
        held[int(np.argmax(np.where(inward, np.abs(slope) / np.sqrt(np.diag(hessian)), 0.0)))] = False
    return np.clip(d, lowest, highest)


def _solved(matrix: Array, right: Array) -> Array:
    """The solution of a positive definite system whose unknowns may be of very different sizes."""
    size = np.sqrt(np.diag(matrix))
    size[size == 0.0] = 1.0
    try:
        return np.asarray(np.linalg.solve(matrix / np.outer(size, size), right / size) / size)
    except np.linalg.LinAlgError:
        return np.asarray(np.linalg.lstsq(matrix / np.outer(size, size), right / size)[0] / size)
