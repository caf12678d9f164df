"""Each solver runs a problem from its start to its end once: values, seconds, and what it has evaluated."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca
import numpy as np
from _solver.problems import FLAGS, Problem
from scipy.integrate import solve_ivp

from cosim.engine import Component, Fmu, System, simulate
from cosim.fmu.toolchain import compiler


@dataclass(frozen=True)
class Run:
    """One solution."""

    values: np.ndarray
    """The published components at the end."""
    seconds: float
    rhs: int
    """Evaluations of the right-hand side or residual, without those for Jacobians."""
    jacobians: int
    steps: int


Solver = Callable[[], Run]


def ours(problem: Problem, tolerance: float) -> Solver:
    """The FMU in the engine: the time is that of the co-simulation loop, with a row at the end."""
    system = System([Component("m", Fmu.read(problem.fmu))], [])

    def solve() -> Run:
        result = simulate(system, stop=problem.stop, output_interval=problem.stop, tolerance=tolerance)
        counters = result.statistics["solver"]["m"]  # type: ignore[index]
        return Run(
            np.array([result.columns[f"m.{name}"][-1] for name in problem.components]),
            float(str(result.statistics["wall_s"])),
            counters["rhs_evaluations"],
            counters["jacobians"],
            counters["steps"],
        )

    return solve


def sundials(problem: Problem, tolerance: float, plugin: str, *, machine_code: bool = True) -> Solver:
    """CVODES or IDAS through CasADi, with exact Jacobians; the time is that of the call of the integrator."""
    t, v = ca.SX.sym("t"), ca.SX.sym("v", len(problem.start))
    n_x = problem.n_x
    f = problem.symbolic(t, v)
    equations = {"t": t, "x": v[:n_x], "z": v[n_x:], "ode": f[:n_x], "alg": f[n_x:]}
    options: dict[str, object] = {"abstol": tolerance, "reltol": tolerance, "max_num_steps": 10**7}
    if plugin == "idas":
        # else IDACalcIC fails on fast transients: its guess of the derivatives is zero
        options["init_xdot"] = np.array(problem.f(0.0, problem.start)).ravel()[:n_x].tolist()
        options["first_time"] = 1e-12
    if machine_code:
        options |= in_machine_code()
    integrator = ca.integrator("integrator", plugin, equations, 0.0, [problem.stop], options)
    start = {"x0": ca.DM(problem.start[:n_x]), "z0": ca.DM(problem.start[n_x:])}

    def solve() -> Run:
        began = time.perf_counter()
        solution = integrator(**start)
        seconds = time.perf_counter() - began
        found = ca.vertcat(solution["xf"], solution["zf"])
        counted = integrator.stats()
        values = np.array(problem.outputs(problem.stop, found)).ravel()
        return Run(values, seconds, counted["nfevals"], counted["nlinsetups"], counted["nsteps"])

    return solve


def in_machine_code() -> dict[str, object]:
    """Options of a CasADi integrator that has its functions compiled. Its files go to the current folder."""
    command = " ".join(compiler())
    return {
        "jit": True,
        "compiler": "shell",
        "jit_options": {"compiler": command, "linker": command, "flags": list(FLAGS)},
    }


def scipy(problem: Problem, tolerance: float, method: str) -> Solver:
    """A solver of SciPy with machine code for the right-hand side and its Jacobian, called from Python."""
    f, jacobian = _caller(problem.f), _caller(problem.jacobian)
    n = len(problem.start)

    def solve() -> Run:
        began = time.perf_counter()
        solution = solve_ivp(
            lambda t, v: f(t, v).ravel(),
            (0.0, problem.stop),
            problem.start,
            method=method,
            rtol=tolerance,
            atol=tolerance,
            jac=lambda t, v: jacobian(t, v).reshape((n, n), order="F"),
            t_eval=[problem.stop],
        )
        seconds = time.perf_counter() - began
        if not solution.success:
            raise RuntimeError(solution.message)
        values = np.array(problem.outputs(problem.stop, solution.y[:, -1])).ravel()
        return Run(values, seconds, solution.nfev, solution.njev, 0)

    return solve


def _caller(function: ca.Function) -> Callable[[float, np.ndarray], np.ndarray]:
    """The function through fixed buffers: calling CasADi's own way costs more than most solvers do."""
    buffer, evaluate = function.buffer()
    t, v = np.zeros(1), np.zeros(function.nnz_in(1))
    result = np.zeros(function.nnz_out(0))
    buffer.set_arg(0, memoryview(t))
    buffer.set_arg(1, memoryview(v))
    buffer.set_res(0, memoryview(result))

    def call(at: float, values: np.ndarray) -> np.ndarray:
        t[0], v[:] = at, values
        evaluate()
        return result.copy()

    call.buffer = buffer  # type: ignore[attr-defined] # evaluate() does not keep it alive
    return call
