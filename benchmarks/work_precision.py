"""Error over time and over evaluations: the solver in the FMUs, IDAS, CVODES, and SciPy's Radau and BDF.

Usage: python benchmarks/work_precision.py [ROUNDS]

Prints a table and draws docs/pictures/work_precision.png; times are the shortest of alternating rounds. All solve the
equations that this project's compiler gives, with the same relative tolerance, absolute tolerance (the relative one
times each unknown's nominal value) and exact Jacobians; errors are those at the end against the published solutions.
IDAS and CVODES run through CasADi with their functions compiled by the compiler and flags of the FMUs; SciPy calls
machine code from Python. The amplifier is a DAE, which only two of the five accept.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import matplotlib as mpl
from _solver.curves import ratio
from _solver.problems import Problem, problem
from _solver.solvers import Run, Solver, ours, scipy, sundials

PROBLEMS = {
    "Robertson": "Robertson",
    "VanDerPol": "Van der Pol, mu = 1000",
    "Hires": "HIRES",
    "Pollution": "Pollution",
    "Oregonator": "Oregonator",
    "TransistorAmplifier": "Transistor amplifier (DAE)",
}
TOLERANCES = [10.0**-k for k in range(3, 11)]
OURS = "this project"
# colours of Okabe and Ito, which colour-blind people tell apart; markers for those who print in grey
METHODS: dict[str, tuple[Callable[[Problem, float], Solver], str, str]] = {
    OURS: (ours, "#0072B2", "o"),
    "IDAS": (lambda p, tolerance: sundials(p, tolerance, "idas"), "#D55E00", "s"),
    "CVODES": (lambda p, tolerance: sundials(p, tolerance, "cvodes"), "#E69F00", "D"),
    "Radau (SciPy)": (lambda p, tolerance: scipy(p, tolerance, "Radau"), "#009E73", "^"),
    "BDF (SciPy)": (lambda p, tolerance: scipy(p, tolerance, "BDF"), "#CC79A7", "v"),
}
ONLY_DAE = (OURS, "IDAS")
PICTURE = Path(__file__).parents[1] / "docs" / "pictures" / "work_precision.png"

Point = tuple[float, float, Run]
"""Error, shortest time in seconds, one of the runs."""


def main() -> None:
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 7
    home = Path.cwd()
    found: dict[str, dict[str, list[Point]]] = {}
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)  # CasADi compiles into the current folder
        try:
            for name in PROBLEMS:
                found[name] = measure(problem(name, Path(folder)), rounds)
        finally:
            os.chdir(home)
    draw(found)
    summarise(found)
    print(f"\n{PICTURE}")


def measure(p: Problem, rounds: int) -> dict[str, list[Point]]:
    """Run every method at every tolerance, in alternating rounds; print a line for each."""
    methods = [m for m in METHODS if p.is_ode or m in ONLY_DAE]
    points: dict[str, list[Point]] = {m: [] for m in methods}
    print(f"\n{p.name}\n{'':14} tolerance     error   seconds  evaluations  Jacobians   steps")
    for tolerance in TOLERANCES:
        solvers = {m: METHODS[m][0](p, tolerance) for m in methods}
        for method, runs in alternate(solvers, rounds).items():
            if runs:
                error, seconds = p.error(runs[0].values), min(r.seconds for r in runs)
                points[method].append((error, seconds, runs[0]))
                line = f"{error:9.1e} {seconds:9.2e} {runs[0].rhs:12d} {runs[0].jacobians:10d} {runs[0].steps or '':>7}"
                print(f"{method:14} {tolerance:9.0e} {line}", flush=True)
    return points


def alternate(solvers: dict[str, Solver], rounds: int) -> dict[str, list[Run]]:
    """Run all in turn; those that take more than a second only once."""
    runs: dict[str, list[Run]] = {m: [] for m in solvers}
    for k in range(rounds):
        for method, solve in list(solvers.items()):
            try:
                runs[method].append(solve())
            except RuntimeError as failure:
                print(f"{method:14} failed: {str(failure).splitlines()[-1]}")
                del solvers[method]
                continue
            if k == 0 and runs[method][0].seconds > 1.0:
                del solvers[method]
    return runs


def summarise(found: dict[str, dict[str, list[Point]]]) -> None:
    """Print the other methods' times over ours at the same error."""
    print("\ntimes over this project's, at the same error at the end")
    for error in (1e-4, 1e-6, 1e-8):
        for name, methods in found.items():
            curves = {method: [point[:2] for point in points] for method, points in methods.items()}
            own = curves.pop(OURS)
            ratios = ", ".join(f"{method} {ratio(curve, own, error)}" for method, curve in curves.items())
            print(f"{error:.0e} {PROBLEMS[name]:26} {ratios}")


def draw(found: dict[str, dict[str, list[Point]]]) -> None:
    """Two rows of panels over time, two over evaluations, a panel for each problem."""
    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(4, 3, figsize=(10.5, 12.5), layout="constrained")
    measures: list[tuple[str, Callable[[Point], float]]] = [
        ("seconds", lambda point: point[1]),
        ("evaluations of the right-hand side", lambda point: point[2].rhs),
    ]
    for half, (label, quantity) in enumerate(measures):
        for k, (name, methods) in enumerate(found.items()):
            axis = axes[2 * half + k // 3][k % 3]
            for method, points in methods.items():
                _, colour, marker = METHODS[method]
                axis.loglog(
                    [point[0] for point in points],
                    [quantity(point) for point in points],
                    color=colour,
                    marker=marker,
                    markersize=6 if method == OURS else 4,
                    linewidth=2.2 if method == OURS else 1.2,
                    zorder=3 if method == OURS else 2,
                    label=method,
                )
            axis.invert_xaxis()
            axis.set_title(PROBLEMS[name], loc="left", fontsize=11, fontweight="bold")
            axis.grid(alpha=0.3)
            if k % 3 == 0:
                axis.set_ylabel(label)
            if k // 3 == 1:
                axis.set_xlabel("error at the end")
    handles, labels = axes[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), frameon=False)
    figure.savefig(PICTURE, dpi=110)


if __name__ == "__main__":
    main()
