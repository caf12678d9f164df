"""The linkage plant at full voltage for 25 s, rows of 1 ms: what its equations, its steps and the whole run cost.

Usage: python benchmarks/solver.py [ROUNDS]

Prints medians of alternating rounds, all from one run: the generated C beside equations derived by hand, microseconds
per solver step, and seconds at the same error beside IDAS (on the system that CasADi reduces, and on the one that this
project's compiler reduces) and rumoca's own solver. Errors are the largest of crank angle, crank speed and motor
current over all rows, each relative to its largest value, against a run at the tolerance 1e-10.
"""

from __future__ import annotations

import os
import statistics
import sys
import tempfile
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import numpy as np
from _solver import minimal
from _solver.curves import Curve, ratio
from _solver.equations import Equations, derived_by_hand, generated
from _solver.plant import LIBRARY, MODEL, Trajectory, casadi_reduced, compiler_reduced, engine, rumoca, unknowns_along

from cosim.fmu import compile_model

STOP = 25.0
RUMOCA_STOP = 2.0
"""Rumoca takes half a minute for each second at 1e-6."""
EVALUATIONS = 200_000
POINTS = 200


def main() -> None:
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 7
    home = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)  # CasADi compiles into the current folder
        try:
            evaluations(Path(folder), rounds)
            steps(rounds)
            peers(rounds)
        finally:
            os.chdir(home)


def evaluations(folder: Path, rounds: int) -> None:
    """Microseconds per evaluation, after a check that both forms mean the same."""
    dae = compile_model(LIBRARY, MODEL)
    names = [unknown.name for unknown in dae.unknowns]
    if names != minimal.UNKNOWNS:
        raise SystemExit(f"the compiled model has other unknowns than minimal.py: {names}")
    u, d = np.array([1.0, 28.0, 0.0]), np.zeros(len(dae.discretes))
    ours, hand = generated(dae, folder / "generated", u, d), derived_by_hand(folder / "hand", u)
    points = unknowns_along(STOP, POINTS)
    a, b = (np.array([rates(equations, v) for v in points]) for equations in (ours, hand))
    differs = float(np.max(np.abs(a - b) / np.abs(b).max(axis=0)))
    print(
        f"derivatives of speed and current, generated against by hand: {differs:.0e} of the largest at {POINTS} points"
    )
    if differs > 1e-10:
        raise SystemExit("the two forms differ")
    print(f"\nmicroseconds per evaluation, median (lowest){'':8} generated             by hand   ratio")
    counts = [function.n_instructions() for function in minimal.functions()]
    for function, label, count in zip(("rhs", "linearise"), ("right-hand side", "and Jacobian"), counts, strict=True):
        forms = [partial(form.seconds, function, points, EVALUATIONS) for form in (ours, hand)]
        a, b = alternate(forms, rounds)
        ratio = statistics.median(a) / statistics.median(b)
        print(
            f"{label:44} {shown(a, 1e6, 3):>17}   {shown(b, 1e6, 3):>17} {ratio:7.2f}   (by hand: {count} operations)"
        )


def alternate(jobs: Sequence[Callable[[], float]], rounds: int) -> list[list[float]]:
    """What each job returns in each of the rounds."""
    results = [[job() for job in jobs] for _ in range(rounds)]
    return [list(column) for column in zip(*results, strict=True)]


def shown(values: Sequence[float], unit: float, digits: int) -> str:
    """Median and lowest."""
    return f"{statistics.median(values) * unit:.{digits}f} ({min(values) * unit:.{digits}f})"


def rates(equations: Equations, v: np.ndarray) -> np.ndarray:
    """Derivatives of speed and current where the balance of torques holds: it is near, so Newton needs a few steps."""
    v = v.copy()
    for _ in range(5):
        v[7] -= equations.rhs(v)[7] / equations.linearise(v)[7, 7]
    return equations.rhs(v)[1:3]


def steps(rounds: int) -> None:
    """Microseconds per step of the solver, with and without rows of 1 ms."""
    print(f"\n{STOP:g} s in the engine         rows   steps  rejected     rhs  ms, median (lowest)  us per step tried")
    settings = [(tolerance, interval) for tolerance in (1e-4, 1e-6, 1e-8) for interval in (STOP, 1e-3)]
    times = alternate([lambda t=t, i=i: engine(STOP, i, t).seconds for t, i in settings], rounds)
    for (tolerance, interval), seconds in zip(settings, times, strict=True):
        run = engine(STOP, interval, tolerance)
        tried = run.counters["steps"] + run.counters["rejected_steps"]
        print(
            f"    tolerance {tolerance:.0e} {len(run.time):11d} {run.counters['steps']:7d} "
            f"{run.counters['rejected_steps']:9d} {run.counters['rhs_evaluations']:7d} "
            f"{shown(seconds, 1e3, 1):>20} {shown(seconds, 1e6 / tried, 2):>18}"
        )


def peers(rounds: int) -> None:
    """Seconds and errors over tolerances, and ratios at the error that this project has at 1e-6."""
    compare(
        STOP,
        {
            "this project": (lambda tolerance: lambda: engine(STOP, 1e-3, tolerance), [1e-5, 1e-6, 1e-7]),
            "IDAS, reduced by CasADi": (lambda tolerance: casadi_reduced(STOP, tolerance), SWEEP),
            "IDAS, reduced as here": (lambda tolerance: compiler_reduced(STOP, tolerance), SWEEP),
        },
        rounds,
    )
    compare(
        RUMOCA_STOP,
        {
            "this project": (lambda tolerance: lambda: engine(RUMOCA_STOP, 1e-3, tolerance), [1e-2, 1e-3, 1e-4]),
            "rumoca's solver": (lambda tolerance: rumoca(RUMOCA_STOP, tolerance), [1e-3, 1e-4, 1e-5]),
        },
        max(1, rounds // 3),
    )


SWEEP = [1e-4, 1e-5, 1e-6, 1e-7, 1e-8]
Methods = dict[str, tuple[Callable[[float], Callable[[], Trajectory]], list[float]]]


def compare(stop: float, methods: Methods, rounds: int) -> None:
    """Print errors and medians of the seconds for each method and tolerance, then the ratios at our errors."""
    exact = engine(stop, 1e-3, 1e-10)
    runs: dict[tuple[str, float], list[Trajectory]] = {}
    ready = {(m, tolerance): prepare(tolerance) for m, (prepare, swept) in methods.items() for tolerance in swept}
    for _ in range(rounds):
        for key, run in list(ready.items()):
            try:
                runs.setdefault(key, []).append(run())
            except RuntimeError as failure:
                print(f"{key[0]} at {key[1]:.0e} failed: {str(failure).strip().splitlines()[-1][:80]}")
                del ready[key]
    curves: dict[str, Curve] = {method: [] for method in methods}
    print(f"\n{stop:g} s, rows of 1 ms        tolerance     error        ms    lowest")
    for method, tolerance in ready:
        found = runs[method, tolerance]
        error, seconds = found[0].error(exact), [r.seconds for r in found]
        curves[method].append((error, statistics.median(seconds)))
        print(f"{method:24} {tolerance:9.0e} {error:9.1e} {curves[method][-1][1] * 1e3:9.1f} {min(seconds) * 1e3:9.1f}")
    own = curves.pop("this project")
    for method, curve in curves.items():
        for error, _ in own:
            print(f"    {method} at our error {error:.1e}: {ratio(curve, own, error)} times our time")


if __name__ == "__main__":
    main()
