"""Newton's method for x = g(x), damped, which also tells apart equations without a solution and with too many."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Vector: TypeAlias = NDArray[np.float64]
Matrix: TypeAlias = NDArray[np.float64]

SHARP = 1e-13
"""Relative error of x aimed at; an error of ``_ROUNDING`` times the largest value met on the way counts as none."""

_ROUNDING = 1e-16
_SINGULAR = 1e-8
"""Singular values below it, relative to the largest gain and to 1, count as 0: finite differences blur smaller ones."""

_MOST_STEPS = 40
_LEAST_DAMPING = 2.0**-14


@dataclass(frozen=True)
class Solution:
    """Where the iteration has ended: ``x`` and ``g`` have shape (n,).

    ``free`` is the number of directions in which the equations do not determine x; there it has stayed where it was.
    """

    x: Vector
    g: Vector
    solved: bool
    free: int

    @property
    def residual(self) -> Vector:
        """Return g(x) - x."""
        return self.g - self.x


class Scale:
    """The largest value of each unknown met so far, which tells what is small."""

    def __init__(self, nominal: Vector) -> None:
        """Start with 0; ``nominal`` stands in for an unknown that is always 0."""
        self._largest = np.zeros_like(nominal)
        self._nominal = nominal

    def see(self, *values: Vector) -> None:
        """Take values into account."""
        for value in values:
            self._largest = np.fmax(self._largest, np.abs(value), where=np.isfinite(value), out=self._largest)

    @property
    def size(self) -> Vector:
        """Return the sizes of the unknowns, all positive."""
        return np.where(self._largest > 0.0, self._largest, self._nominal)

    def negligible(self, difference: Vector, x: Vector, relative: float) -> bool:
        """Tell whether a difference of x is as small as rounding, or ``relative`` to x."""
        return bool(np.all(np.abs(difference) <= relative * np.abs(x) + _ROUNDING * self._largest))


def solve(
    g: Callable[[Vector], Vector],
    slope: Callable[[], Matrix],
    start: Vector,
    scale: Scale,
    enough: float,
) -> Solution:
    """Solve x = g(x) from ``start``, of shape (n,); ``slope`` gives g'(x), of shape (n, n), for the last x given to g.

    Steps are halved until the natural monotonicity test holds: Deuflhard, Newton Methods for Nonlinear Problems (2004),
    section 3.3. It does not change with the units of x. NaN in g(x) means that g is not defined there. A slope that
    serves well is kept. If rounding errors keep the iteration from coming as close as ``SHARP``, coming within
    ``enough``, relative to the largest values, will do. Where g' - 1 is singular, the smallest step is taken.
    """
    x, gx = start, g(start)
    scale.see(x, gx)
    inverse, free = _inverse(slope(), scale.size) if np.all(np.isfinite(gx)) else (np.zeros((x.size, x.size)), 0)
    fresh = True
    step = inverse @ (gx - x)
    for _ in range(_MOST_STEPS):
        if not np.all(np.isfinite(step)):
            break
        if _solves(x, gx, step, free, scale):
            return Solution(x, gx, True, free)
        size = _norm(step, scale)
        damping = 1.0
        while True:
            trial = x + damping * step
            g_trial = g(trial)
            correction = inverse @ (g_trial - trial)
            left = _norm(correction, scale)
            if left <= (1.0 - 0.25 * damping) * size:
                break
            damping *= 0.5 if fresh else 0.0
            if damping < _LEAST_DAMPING:
                break
        if damping < _LEAST_DAMPING:
            close = size <= enough and _norm(gx - x, scale) <= enough
            if fresh:
                g(x)  # leave the components as they are there
                return Solution(x, gx, close, free)
            g(x)
            inverse, free = _inverse(slope(), scale.size)
            fresh, step = True, inverse @ (gx - x)
            continue
        x, gx = trial, g_trial
        scale.see(x, gx)
        if _solves(x, gx, correction, free, scale):
            return Solution(x, gx, True, free)
        fresh = left > 1e-3 * size
        if fresh:
            inverse, free = _inverse(slope(), scale.size)
            correction = inverse @ (gx - x)
        step = correction
    return Solution(x, gx, False, free)


def iterate(g: Callable[[Vector], Vector], start: Vector, scale: Scale, most: int) -> Solution:
    """Solve x = g(x) by putting g(x) in the place of x again and again: at most ``most`` times."""
    x, gx = start, g(start)
    for _ in range(most):
        scale.see(x, gx)
        if scale.negligible(gx - x, x, SHARP):
            return Solution(x, gx, True, 0)
        if not np.all(np.isfinite(gx)):
            break
        x, gx = gx, g(gx)
    return Solution(x, gx, False, 0)


def _solves(x: Vector, gx: Vector, step: Vector, free: int, scale: Scale) -> bool:
    """Tell whether x is as good as exact; where directions are free, a small step does not imply a small residual."""
    return scale.negligible(step, x, SHARP) and (free == 0 or scale.negligible(gx - x, x, 10.0 * SHARP))


def _norm(step: Vector, scale: Scale) -> float:
    return float(np.max(np.abs(step) / scale.size))


def _inverse(slope: Matrix, size: Vector) -> tuple[Matrix, int]:
    """Return the inverse of 1 - g', which makes a step of a residual, and how many directions it leaves out."""
    if not np.all(np.isfinite(slope)):
        return np.full_like(slope, np.nan), 0
    if len(size) == 1:
        gap = 1.0 - slope
        regular = abs(gap[0, 0]) > _SINGULAR * max(1.0, abs(slope[0, 0]))
        return (1.0 / gap, 0) if regular else (np.zeros_like(gap), 1)
    scaled = slope * size / size[:, None]
    left, values, right = np.linalg.svd(np.eye(len(size)) - scaled)
    kept = values > _SINGULAR * max(1.0, float(np.max(np.abs(scaled))))
    turned = right.T @ ((left.T / np.where(kept, values, np.inf)[:, None]) / size)
    return turned * size[:, None], int(np.sum(~kept))
