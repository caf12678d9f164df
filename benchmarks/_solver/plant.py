"""The linkage plant at full voltage from rest, by this project, by IDAS on two reductions, and by rumoca's solver."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache

import casadi as ca
import numpy as np
from _solver.problems import ROOT, unknowns_only
from _solver.solvers import in_machine_code

from cosim.dae import Dae
from cosim.engine import System, simulate
from cosim.fmu import catalogue, compile_model
from cosim.scenario import assemble, read

sys.path[:0] = [str(ROOT / "tests" / "fmu"), str(ROOT / "tests")]
from oracle import Reduced, reduce  # noqa: E402

from reference.geometry import catalogue_linkage  # noqa: E402

LIBRARY = ROOT / "modelica" / "WiperDrive"
MODEL = "WiperDrive.Systems.LinkagePlant"
COMPARED = ("phi_crank", "w_crank", "i_motor")
FULL_VOLTAGE = {"duty": 1.0, "v_supply": 28.0, "tau_disturbance": 0.0}


@dataclass(frozen=True)
class Trajectory:
    """Rows of the compared variables, and the seconds that they took."""

    time: np.ndarray
    rows: dict[str, np.ndarray]
    seconds: float
    counters: dict[str, int] = field(default_factory=dict)

    def error(self, exact: Trajectory) -> float:
        """Largest difference of any variable at any row, relative to the variable's largest value."""
        return max(
            float(np.abs(self.rows[name] - exact.rows[name]).max() / np.abs(exact.rows[name]).max())
            for name in COMPARED
        )


@cache
def _system() -> System:
    return assemble(read(ROOT / "scenarios" / "linkage_full_voltage.csv"), catalogue.ensure)


def engine(stop: float, interval: float, tolerance: float) -> Trajectory:
    """The FMU in the engine: the time is that of the co-simulation loop."""
    result = simulate(_system(), stop=stop, output_interval=interval, tolerance=tolerance)
    rows = {name: result.columns[f"plant.{name}"] for name in COMPARED}
    counters = result.statistics["solver"]["plant"]  # type: ignore[index]
    return Trajectory(result.time, rows, float(str(result.statistics["wall_s"])), counters)


def unknowns_along(stop: float, points: int) -> np.ndarray:
    """The compiled model's unknowns at instants of a run, shape (points, 8); the last one by its difference quotient.

    The instants leave out the start, where the drive stands still.
    """
    run = engine(stop, 1e-3, 1e-8)
    rows = np.linspace(100, len(run.time) - 2, points).astype(int)
    phi, w, i = (run.rows[name] for name in COMPARED)
    linkage = catalogue_linkage()
    angles = [angle(phi[rows]) for side in (linkage.ds, linkage.ps) for angle in (side.rocker, side.coupler)]
    acceleration = (w[rows + 1] - w[rows - 1]) / 2e-3
    return np.ascontiguousarray(np.column_stack([phi[rows], w[rows], i[rows], *angles, acceleration]))


@cache
def _reduced() -> Reduced:
    return reduce(LIBRARY, MODEL, FULL_VOLTAGE)


@cache
def _dae() -> Dae:
    return compile_model(LIBRARY, MODEL)


def casadi_reduced(stop: float, tolerance: float) -> Callable[[], Trajectory]:
    """IDAS on the DAE that casadi.dae_reduce_index leaves, its functions in machine code."""
    grid = _grid(stop)
    reduced = _reduced()
    integrator = reduced.integrator(grid, tolerance, **in_machine_code())

    def run() -> Trajectory:
        began = time.perf_counter()
        solution = integrator(**reduced.start)
        seconds = time.perf_counter() - began
        rows = reduced.rows(solution)
        return Trajectory(grid, {name: rows["bridge.i" if name == "i_motor" else name] for name in COMPARED}, seconds)

    return run


def compiler_reduced(stop: float, tolerance: float) -> Callable[[], Trajectory]:
    """IDAS on the DAE of this project's compiler, its functions in machine code."""
    dae, grid = _dae(), _grid(stop)
    t, v, (f, start) = unknowns_only(dae, [dae.f, ca.vertcat(*(u.start for u in dae.unknowns))])
    held = [s.symbol for s in dae.inputs] + [s.symbol for s in dae.discretes] + [r.symbol for r in dae.relations]
    values = ca.DM([FULL_VOLTAGE.get(s.name(), 0.0) for s in held])
    f = ca.cse(ca.densify(ca.substitute(f, ca.vertcat(*held), values)))
    n_x = len(dae.states)
    equations = {"t": t, "x": v[:n_x], "z": v[n_x:], "ode": f[:n_x], "alg": f[n_x:]}
    residual = ca.Function("residual", [v[n_x:], v[:n_x]], [ca.substitute(f[n_x:], t, 0.0)])
    linkage = catalogue_linkage()
    angles = [float(a(0.0)) for side in (linkage.ds, linkage.ps) for a in (side.rocker, side.coupler)]
    x0 = ca.evalf(start)[:n_x]
    z0 = ca.rootfinder("z", "newton", residual)(ca.DM([*angles, 0.0]), x0)
    options = {"abstol": tolerance, "reltol": tolerance, "max_num_steps": 10**6, **in_machine_code()}
    integrator = ca.integrator("integrator", "idas", equations, 0.0, grid.tolist(), options)
    names = [u.name for u in dae.states]

    def run() -> Trajectory:
        began = time.perf_counter()
        solution = integrator(x0=x0, z0=z0)
        seconds = time.perf_counter() - began
        x = dict(zip(names, np.array(solution["xf"]), strict=True))
        rows = {"phi_crank": x["phi_crank"], "w_crank": x["w_crank"], "i_motor": x["bridge.i"]}
        return Trajectory(grid, rows, seconds)

    return run


def rumoca(stop: float, tolerance: float) -> Callable[[], Trajectory]:
    """Rumoca's BDF on its own reduction, from the same Modelica text; the time of a run over one row is taken off."""
    import rumoca

    bound = ", ".join(f"{name}={value!r}" for name, value in FULL_VOLTAGE.items())
    text = f'model Wrapper "Wrapper"\n  {MODEL} plant({bound}) "Plant";\nend Wrapper;'
    session = rumoca.Session(roots=[str(LIBRARY.parent)])
    model = session.loads(text, model="Wrapper", filename="Wrapper.mo")
    grid = _grid(stop)
    config = rumoca.SimConfig(solver="bdf", rtol=tolerance, atol=tolerance)

    def seconds(end: float) -> tuple[object, float]:
        began = time.perf_counter()
        result = model.simulate(end, dt=1e-3, config=config)
        return result, time.perf_counter() - began

    seconds(1e-3)  # the first run takes longer

    def run() -> Trajectory:
        _, before = seconds(1e-3)
        result, whole = seconds(stop)
        found = {name: np.asarray(result[f"plant.{name}"], dtype=float) for name in COMPARED}  # type: ignore[index]
        # it adds rows at events
        at = np.asarray(result.time, dtype=float)  # type: ignore[attr-defined]
        rows = {name: np.interp(grid, at, values) for name, values in found.items()}
        return Trajectory(grid, rows, whole - before)

    return run


def _grid(stop: float) -> np.ndarray:
    return np.arange(round(stop / 1e-3) + 1) * 1e-3
