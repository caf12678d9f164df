"""Radau IIA of order 5 on intervals that suit the motion, and what takes its points to the instants of the data."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

Array = NDArray[np.float64]

STAGES = 3
NODES = np.array([0.0, (4.0 - np.sqrt(6.0)) / 10.0, (4.0 + np.sqrt(6.0)) / 10.0, 1.0])
"""Where an interval begins, and its collocation points (Hairer and Wanner, Solving ODEs II, 2nd ed., table IV.5.6)."""
_LONGEST = 0.02
"""Seconds of an interval in steady running."""
_SHORTEST = 0.0005
"""Seconds of the first interval after a start from rest."""
_GROWTH = 1.2


def intervals(start: float, stop: float, from_rest: bool) -> Array:
    """Return the borders of the intervals: short ones after a start from rest, equal ones later."""
    borders = [start]
    h = _SHORTEST if from_rest else _LONGEST
    while borders[-1] < stop - 1e-9:
        borders.append(min(borders[-1] + h, stop))
        h = min(h * _GROWTH, _LONGEST)
    return np.array(borders)


def points_of(borders: Array) -> Array:
    """Return the instants of the collocation points, STAGES of them for each interval."""
    return np.asarray((borders[:-1, None] + np.diff(borders)[:, None] * NODES[None, 1:]).ravel())


def slopes() -> Array:
    """Return L of shape (STAGES, STAGES + 1): the derivative of the r-th Lagrange polynomial at the j-th point."""
    return np.array([[_slope(r, NODES[j]) for r in range(STAGES + 1)] for j in range(1, STAGES + 1)])


def sampling(points: Array, times: Array) -> csr_array:
    """Return the matrix (times, points) that interpolates by the cubic through the four points around each instant."""
    first = np.clip(np.searchsorted(points, times) - 2, 0, len(points) - 4)
    columns = first[:, None] + np.arange(4)[None, :]
    near = points[columns]
    weights = np.ones_like(near)
    for m in range(4):
        for n in range(4):
            if n != m:
                weights[:, m] *= (times - near[:, n]) / (near[:, m] - near[:, n])
    rows = 4 * np.arange(len(times) + 1)
    return csr_array((weights.ravel(), columns.ravel(), rows), shape=(len(times), len(points)))


def _slope(r: int, at: float) -> float:
    """Derivative of the r-th Lagrange polynomial through the nodes."""
    others = [k for k in range(len(NODES)) if k != r]
    total = 0.0
    for k in others:
        product = 1.0
        for m in others:
            if m != k:
                product *= (at - NODES[m]) / (NODES[r] - NODES[m])
        total += product / (NODES[r] - NODES[k])
    return total
