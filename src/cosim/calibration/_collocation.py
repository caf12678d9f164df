"""A measurement as a collocation problem: Radau IIA of order 5 on intervals that suit the motion."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from cosim.calibration._data import Data
from cosim.calibration._model import Model

Array = NDArray[np.float64]

STAGES = 3
_LONGEST = 0.02
"""Seconds of an interval in steady running."""
_SHORTEST = 0.0005
"""Seconds of the first interval after a start from rest."""
_GROWTH = 1.2


@dataclass(frozen=True)
class Collocation:
    """Equations 0 = g(q, w) with q = [x0; theta] and w the states and unknowns at the collocation points, all scaled.

    ``outputs`` maps (q, w) to the OUTPUTS at the collocation points, shape (2, points); ``sampling`` (samples, points)
    takes them to the instants of the data. g has as many entries as w.
    """

    residuals: ca.Function
    outputs: ca.Function
    sampling: ca.DM
    guess_q: Array
    guess_w: Array
    points: Array


def intervals(start: float, stop: float, from_rest: bool) -> Array:
    """Return the borders of the intervals: short ones after a start from rest, equal ones later."""
    borders = [start]
    h = _SHORTEST if from_rest else _LONGEST
    while borders[-1] < stop - 1e-9:
        borders.append(min(borders[-1] + h, stop))
        h = min(h * _GROWTH, _LONGEST)
    return np.array(borders)


def collocate(model: Model, data: Data) -> Collocation:
    """Set up the equations for the instants of a measurement, and a guess of their solution from it."""
    borders = intervals(data.time[0], data.time[-1], data.from_rest)
    nodes = np.array([0.0, *ca.collocation_points(STAGES, "radau")])
    # slopes[j, r]: derivative of the r-th Lagrange polynomial through the nodes at node j
    slopes = np.array([[_slope(nodes, r, nodes[j]) for r in range(STAGES + 1)] for j in range(1, STAGES + 1)])
    h = np.diff(borders)
    points = (borders[:-1, None] + h[:, None] * nodes[None, 1:]).ravel()
    nx, nz = model.sizes
    count = len(points)
    x_scale, z_scale = model.scales
    q = ca.MX.sym("q", nx + len(model.names))
    w = ca.MX.sym("w", (nx + nz) * count)
    wide = ca.reshape(w, nx + nz, count)
    x = ca.mtimes(ca.diag(x_scale), wide[:nx, :])
    z = ca.mtimes(ca.diag(z_scale), wide[nx:, :])
    theta = ca.repmat(q[nx:], 1, count)
    u = ca.DM(model.input_column(data.supply_at(points)))
    derivative, algebraic, outputs = model.rhs.map(count)(x, z, u, theta)
    begins = ca.horzcat(ca.mtimes(ca.diag(x_scale), q[:nx]), x[:, STAGES - 1 : count - STAGES : STAGES])
    equations = []
    for j in range(STAGES):
        polynomial = slopes[j, 0] * begins
        for r in range(STAGES):
            polynomial += slopes[j, r + 1] * x[:, r::STAGES]
        step = ca.repmat(ca.DM(h).T, nx, 1)
        equations.append(ca.mtimes(ca.diag(1.0 / x_scale), polynomial - step * derivative[:, j::STAGES]))
    g = ca.vertcat(*(ca.vec(e) for e in equations), ca.vec(algebraic))
    guess_q, guess_w = data.guess(model, borders[0], points)
    return Collocation(
        residuals=ca.Function("g", [q, w], [g]),
        outputs=ca.Function("y", [q, w], [outputs]),
        sampling=_sampling(points, data.time),
        guess_q=guess_q,
        guess_w=guess_w,
        points=points,
    )


def _slope(nodes: Array, r: int, at: float) -> float:
    """Derivative of the r-th Lagrange polynomial through the nodes."""
    others = [k for k in range(len(nodes)) if k != r]
    total = 0.0
    for k in others:
        product = 1.0
        for m in others:
            if m != k:
                product *= (at - nodes[m]) / (nodes[r] - nodes[m])
        total += product / (nodes[r] - nodes[k])
    return total


def _sampling(points: Array, times: Array) -> ca.DM:
    """Cubic interpolation through the four points around each instant."""
    first = np.clip(np.searchsorted(points, times) - 2, 0, len(points) - 4)
    rows, columns, values = [], [], []
    for k, (start, t) in enumerate(zip(first.tolist(), times.tolist(), strict=True)):
        near = points[start : start + 4]
        for m in range(4):
            weight = np.prod([(t - near[n]) / (near[m] - near[n]) for n in range(4) if n != m])
            rows.append(k)
            columns.append(start + m)
            values.append(float(weight))
    return ca.DM.triplet(rows, columns, ca.DM(values), len(times), len(points))
