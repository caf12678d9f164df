"""The same problem solved at once by IPOPT: the states at all collocation points are unknowns, too."""

from __future__ import annotations

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from cosim.calibration import _ipopt
from cosim.calibration._grid import STAGES, slopes
from cosim.calibration._model import Model
from cosim.calibration._problem import HUBER, LOOSE, REST, Part, Problem, Solution
from cosim.calibration._progress import Progress
from cosim.errors import InputError

Array = NDArray[np.float64]


def solve(problem: Problem, robust: bool, most_iterations: int, progress: Progress | None) -> Solution:
    """Find the parameters; see :func:`cosim.calibration.fit`.

    The motion that IPOPT starts from is guessed from the data, not followed from the starting values.

    Raises InputError if an initial state is known, SimulationError if IPOPT found nothing finite.
    """
    theta = ca.MX.sym("theta", len(problem.labels))
    variables, starts, lower, upper = [theta], [problem.start], [problem.lower], [problem.upper]
    residuals: list[ca.MX] = [(theta - problem.start) / LOOSE]
    residuals += [(theta[entry] - mean) / deviation for entry, mean, deviation in problem.priors()]
    known = sum(each.numel() for each in residuals)
    constraints = []
    for part in problem.fitted:
        if part.data.known is not None:
            raise InputError(f"{part.data.name}: its initial state is known; only the method shooting takes that")
        guess_q, guess_w = part.data.guess(problem.model, part.borders[0], part.points)
        start = guess_q[: problem.model.sizes[0]]
        x0, w = ca.MX.sym("x0", len(start)), ca.MX.sym("w", len(guess_w))
        g, outputs = _equations(problem.model, part, x0, theta[part.entries], w)
        residuals.append(_residuals(problem, part, x0, outputs))
        constraints.append(g)
        for variable, guess in ((x0, start), (w, guess_w)):
            variables.append(variable)
            starts.append(guess)
            lower.append(np.full(len(guess), -np.inf))
            upper.append(np.full(len(guess), np.inf))
    r = ca.vertcat(*residuals)
    turns = np.full(r.numel(), HUBER if robust else np.inf)
    turns[:known] = np.inf
    count = r.numel() - known
    found, status, iterations = _ipopt.solve(
        ca.vertcat(*variables), r, ca.vertcat(*constraints), turns, starts, (lower, upper), most_iterations,
        None if progress is None else lambda k, f: progress(k, float(np.sqrt(max(2.0 * f, 0.0) / count))),
    )  # fmt: skip
    theta_found, *rest = np.split(found, np.cumsum([len(start) for start in starts])[:-1])
    limit = None if status == "Solve_Succeeded" else _ipopt.why(status)
    return Solution(theta_found, tuple(rest[::2]), limit, iterations)


def _equations(model: Model, part: Part, x0: ca.MX, theta: ca.MX, w: ca.MX) -> tuple[ca.MX, ca.MX]:
    """Return 0 = g for the states and unknowns w at the collocation points, all scaled, and the outputs there."""
    nx, nz = model.sizes
    count = len(part.points)
    x_scale, z_scale = model.scales
    wide = ca.reshape(w, nx + nz, count)
    x = ca.mtimes(ca.diag(x_scale), wide[:nx, :])
    z = ca.mtimes(ca.diag(z_scale), wide[nx:, :])
    derivative, algebraic, outputs = model.rhs.map(count)(x, z, ca.DM(part.u.T), ca.repmat(theta, 1, count))
    begins = ca.horzcat(ca.mtimes(ca.diag(x_scale), x0), x[:, STAGES - 1 : count - STAGES : STAGES])
    equations: list[ca.MX] = []
    step = ca.repmat(ca.DM(part.h).T, nx, 1)
    for j, row in enumerate(slopes()):
        polynomial = row[0] * begins
        for r in range(STAGES):
            polynomial += row[r + 1] * x[:, r::STAGES]
        equations.append(ca.mtimes(ca.diag(1.0 / x_scale), polynomial - step * derivative[:, j::STAGES]))
    return ca.vertcat(*(ca.vec(e) for e in equations), ca.vec(algebraic)), outputs


def _residuals(problem: Problem, part: Part, x0: ca.MX, outputs: ca.MX) -> ca.MX:
    """Return the residuals of a measurement over their noise, and its speed at the start if that is from rest."""
    data = part.data
    matrix = part.sampling.tocoo()
    rows, columns = ([int(k) for k in each] for each in matrix.coords)
    sampling = ca.DM.triplet(rows, columns, ca.DM(matrix.data), *matrix.shape)
    current, torque = (ca.mtimes(sampling, outputs[row, :].T) for row in range(2))
    found = [(current - data.current) / data.noise[0]]
    if data.torque is not None:
        found.append((torque - data.torque) / data.noise[1])
    if data.from_rest:
        speed = problem.model.state("w_crank")
        found.append(x0[speed] * problem.model.scales[0][speed] / REST)
    return ca.vertcat(*found)
