"""IPOPT through CasADi: progress, and in words how it ended."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from cosim.calibration._progress import Progress
from cosim.errors import SimulationError

Array = NDArray[np.float64]

_STRAIGHT = 1e6
"""A loss that turns here is quadratic."""
_LIMITS = {
    "Maximum_Iterations_Exceeded": "it took more iterations than allowed",
    "Infeasible_Problem_Detected": "no motion satisfies the equations within the bounds",
    "Restoration_Failed": "no motion that satisfies the equations could be found from the starting values",
    "Invalid_Number_Detected": "the equations gave no finite number",
    "Search_Direction_Becomes_Too_Small": "the steps became too small",
    "Diverging_Iterates": "the parameters grow without bound",
    "Solved_To_Acceptable_Level": "it came only near a solution",
}


def why(status: str) -> str:
    """Return in words what IPOPT's return status says of a fit that did not end at a minimum."""
    return _LIMITS.get(status, status.replace("_", " ").lower())


class _Watch(ca.Callback):
    """Tells of each iteration of IPOPT."""

    def __init__(self, size: int, equations: int, tell: Progress) -> None:
        ca.Callback.__init__(self)
        self._size, self._equations, self._tell = size, equations, tell
        self.iterations = 0
        self.construct("watch", {})

    def get_n_in(self) -> int:
        return int(ca.nlpsol_n_out())

    def get_n_out(self) -> int:
        return 1

    def get_sparsity_in(self, i: int) -> ca.Sparsity:
        sizes = {"x": self._size, "lam_x": self._size, "g": self._equations, "lam_g": self._equations, "f": 1}
        return ca.Sparsity.dense(sizes.get(ca.nlpsol_out(i), 0), 1 if sizes.get(ca.nlpsol_out(i), 0) else 0)

    def eval(self, arguments: Sequence[ca.DM]) -> list[int]:
        f = float(arguments[list(ca.nlpsol_out()).index("f")])
        self._tell(self.iterations, f)
        self.iterations += 1
        return [0]


def solve(
    x: ca.MX,
    r: ca.MX,
    g: ca.MX,
    turns: Array,
    starts: Sequence[Array],
    bounds: tuple[Sequence[Array], Sequence[Array]],
    most_iterations: int,
    progress: Progress | None,
) -> tuple[Array, str, int]:
    """Minimise the loss of the residuals r(x) subject to g(x) = 0 and bounds, with the Hessian of Gauss and Newton.

    Without the curvature of r and g it is positive semidefinite, so that every step goes downhill, and cheap. The loss
    of a residual is r^2/2, but from about ``turns`` on linear, as pseudo-Huber: t^2 (sqrt(1 + (r/t)^2) - 1).

    Returns x, IPOPT's word for how it ended, and its iterations.

    Raises:
        SimulationError: there is no finite solution.
    """
    options: dict[str, Any] = {
        "print_time": False,
        "error_on_fail": False,
        "ipopt": {"print_level": 0, "sb": "yes", "max_iter": most_iterations, "tol": 1e-7},
    }
    watch = _Watch(x.numel(), g.numel(), progress) if progress is not None else None
    if watch is not None:
        options["iteration_callback"] = watch
    if np.isinf(turns).all():
        loss, weights = 0.5 * ca.sumsqr(r), None
    else:
        finite = np.minimum(turns, _STRAIGHT)
        root = ca.sqrt(1.0 + (r / finite) ** 2)
        loss, weights = ca.dot(finite**2, root - 1.0), 1.0 / root
    slope = ca.jacobian(r, x)
    f_scale, p = ca.MX.sym("f_scale"), ca.MX.sym("p", 0)
    weighted = slope if weights is None else ca.mtimes(ca.diag(weights), slope)
    options["hess_lag"] = ca.Function(
        "curvature", [x, p, f_scale, ca.MX.sym("lam", g.numel())], [ca.triu(f_scale * ca.mtimes(slope.T, weighted))],
        ["x", "p", "lam_f", "lam_g"], ["triu_hess_gamma_x_x"],
    )  # fmt: skip
    problem: dict[str, Any] = {"x": x, "f": loss, "g": g}
    solver = ca.nlpsol("fit", "ipopt", problem, options)
    result = solver(
        x0=np.concatenate(starts), lbg=0.0, ubg=0.0,
        lbx=np.concatenate(bounds[0]), ubx=np.concatenate(bounds[1]),
    )  # fmt: skip
    statistics = solver.stats()
    found = np.array(result["x"], dtype=np.float64).ravel()
    if not np.isfinite(found).all():
        raise SimulationError("the fit found no finite parameters; start from values with which the model runs")
    return found, str(statistics["return_status"]), int(statistics["iter_count"])
