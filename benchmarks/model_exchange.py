"""Model Exchange by this project's solver, beside CVode and beside the same FMU in Co-Simulation: error, work, time.

Usage: python benchmarks/model_exchange.py [ROUNDS]

Errors of the stiff problems are those at the end against the published solutions, those of the linkage plant the
largest over rows every 10 ms, each signal relative to its largest value, against a run in Co-Simulation at 1e-11.
Evaluations are those of the derivatives, each direction of a Jacobian counted as one; CVode gets its Jacobians by
differences. Times are those of the loop, the lowest of alternating rounds; CVode is stepped from Python.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from _solver.curves import ratio
from _solver.problems import Problem, problem

from cosim.engine import Channel, Component, Fmu, Interface, Result, System, simulate
from cosim.errors import CosimError
from cosim.fmu import catalogue

PROBLEMS = ("Robertson", "VanDerPol", "Hires", "Pollution", "Oregonator")
TOLERANCES = [10.0**-k for k in range(3, 11)]
STOP = 25.0
SIGNALS = ("phi_crank", "w_crank", "i_motor", "tau_crank")

KINDS: dict[str, tuple[Interface, str]] = {
    "ours": ("ModelExchange", "native"),
    "CVode": ("ModelExchange", "python"),
    "Co-Simulation": ("CoSimulation", "native"),
}


class Point(NamedTuple):
    """One run: error, evaluations, seconds."""

    error: float
    evaluations: int
    seconds: float


def main() -> None:
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    with tempfile.TemporaryDirectory() as folder:
        for name in PROBLEMS:
            stiff(problem(name, Path(folder)))
    linkage(rounds)


def stiff(p: Problem) -> None:
    """Print error and evaluations of one stiff problem."""

    def error(result: Result) -> float:
        return p.error(np.array([result.columns[f"m.{name}"][-1] for name in p.components]))

    print(f"\n{p.name}\n{'':14} tolerance     error  evaluations")
    curves: dict[str, list[tuple[float, float]]] = {}
    for kind in ("ours", "CVode"):
        interface, loop = KINDS[kind]
        with Fmu.read(p.fmu, interface) as fmu:
            system = System([Component("m", fmu)], [])
            for tolerance in TOLERANCES:
                try:
                    point = run(system, fmu, loop, p.stop, p.stop, tolerance, error)
                except CosimError as failure:
                    print(f"{kind:14} {tolerance:9.0e} failed: {failure}")
                    continue
                curves.setdefault(kind, []).append((point.error, float(point.evaluations)))
                print(f"{kind:14} {tolerance:9.0e} {point.error:9.1e} {point.evaluations:12d}", flush=True)
    for level in (1e-4, 1e-6, 1e-8):
        times = ratio(curves["CVode"], curves["ours"], level)
        print(f"CVode's evaluations over ours at an error of {level:.0e}: {times}")


def linkage(rounds: int) -> None:
    """Print error, evaluations and time of the linkage plant, with rows every 10 ms and every 1 ms, and none."""
    path = catalogue.ensure("linkage")
    fmus = {kind: Fmu.read(path, interface) for kind, (interface, _) in KINDS.items()}
    systems = {
        kind: System([Component("m", fmu)], channels=[Channel(("m", "duty"), [0.0], [1.0])])
        for kind, fmu in fmus.items()
    }
    exact = once(systems["Co-Simulation"], "native", STOP, 0.01, 1e-11)
    sizes = {name: np.abs(exact.columns[f"m.{name}"]).max() for name in SIGNALS}

    def error(result: Result) -> float:
        columns = ((result.columns[f"m.{name}"] - exact.columns[f"m.{name}"]) / sizes[name] for name in SIGNALS)
        return float(max(np.abs(column).max() for column in columns))

    print(f"\nLinkagePlant, {STOP:g} s at full voltage\n{'':14} tolerance     error  evaluations        ms")
    curves: dict[str, list[tuple[float, float]]] = {}
    for tolerance in TOLERANCES[:-2]:
        points: dict[str, list[Point]] = {kind: [] for kind in KINDS}
        for k in range(rounds):
            for kind in KINDS if k == 0 else ("ours", "Co-Simulation"):
                points[kind].append(run(systems[kind], fmus[kind], KINDS[kind][1], STOP, 0.01, tolerance, error))
        for kind, found in points.items():
            seconds = min(point.seconds for point in found)
            curves.setdefault(kind, []).append((found[0].error, seconds))
            line = f"{found[0].error:9.1e} {found[0].evaluations:12d} {seconds * 1e3:9.2f}"
            print(f"{kind:14} {tolerance:9.0e} {line}", flush=True)
    for level in (1e-4, 1e-6, 1e-8):
        for kind in ("ours", "CVode"):
            times = ratio(curves[kind], curves["Co-Simulation"], level)
            print(f"time of {kind} over Co-Simulation's at an error of {level:.0e}: {times}")
    for interval in (STOP, 1e-3):
        seconds = {kind: [] for kind in ("ours", "Co-Simulation")}
        for _ in range(rounds):
            for kind, times in seconds.items():
                times.append(wall(once(systems[kind], "native", STOP, interval, 1e-6)))
        own, other = (min(times) for times in seconds.values())
        print(f"1e-6, rows every {interval:g} s: {own * 1e3:.2f} ms, {own / other:.2f} times Co-Simulation")
    for fmu in fmus.values():
        fmu.close()


def run(
    system: System,
    fmu: Fmu,
    loop: str,
    stop: float,
    interval: float,
    tolerance: float,
    error: Callable[[Result], float],
) -> Point:
    """Simulate once."""
    result = once(system, loop, stop, interval, tolerance)
    counts = result.statistics["solver"]["m"]  # type: ignore[index]
    directions = len(fmu.states.owners()) if fmu.interface == "ModelExchange" else 1
    evaluations = counts["rhs_evaluations"] + directions * counts.get("jacobians", 0)
    return Point(error(result), evaluations, wall(result))


def once(system: System, loop: str, stop: float, interval: float, tolerance: float) -> Result:
    os.environ["COSIM_ENGINE"] = loop
    return simulate(system, stop=stop, output_interval=interval, tolerance=tolerance, isolate="never")


def wall(result: Result) -> float:
    return float(str(result.statistics["wall_s"]))


if __name__ == "__main__":
    main()
