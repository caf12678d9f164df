"""Time to fit parameters: cosim.calibration against SciPy's least squares with finite differences on the FMU.

Both get the same three start-ups of 7 s with the same noise, the same parameters, the same starting values and the same
initial state, which is known. What is built once for both and then found by its content is left out (the FMU, the
compiled equations of the fit); finding and loading them is not. SciPy runs in several set-ups, of which the fastest
counts; each ends at the same fit, which is printed. Every FMU run has the native engine. A time is the least of some
repetitions, for other work on the machine only ever adds to it.

Run: python benchmarks/calibration.py [repetitions]
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from cosim.calibration import Data, Free, Method, fit, linkage_model
from cosim.engine import Channel, Component, Fmu, System, simulate
from cosim.fmu import catalogue

Array = NDArray[np.float64]

TRUE = {"d_joint": 0.95, "ext_load": 3.6, "J_rotor": 1.3e-4, "motor.R": 2.1}
START = {"d_joint": 0.8594, "ext_load": 3.0, "J_rotor": 1e-4, "motor.R": 1.91}
SUPPLIES, LENGTH, SAMPLE, NOISE = (21.0, 24.0, 27.0), 7.0, 0.002, 0.04
SETUPS = [("trf", 1e-5, 1e-3), ("trf", 1e-6, 1e-3), ("trf", 1e-7, 1e-4), ("lm", 1e-5, 1e-3), ("lm", 1e-6, 1e-4)]
"""SciPy's method, tolerance of the FMU's solver, relative step of the differences."""


@dataclass(frozen=True)
class Outcome:
    """Parameters, and what was done to find them."""

    values: dict[str, float]
    work: str


def run(plant: Fmu, values: dict[str, float], supply: float, tolerance: float = 1e-9) -> Array:
    channels = [Channel(("plant", "duty"), [0.0], [1.0]), Channel(("plant", "v_supply"), [0.0], [supply])]
    system = System([Component("plant", plant, dict(values))], channels=channels)
    result = simulate(system, stop=LENGTH, output_interval=SAMPLE, tolerance=tolerance)
    return np.asarray(result.columns["plant.i_motor"], dtype=np.float64)


def by_scipy(currents: list[Array], method: str, tolerance: float, step: float) -> Outcome:
    plant = Fmu.read(catalogue.ensure("linkage"))
    scale = np.array(list(START.values()))
    runs = 0

    def residuals(theta: Array) -> Array:
        nonlocal runs
        values = dict(zip(START, (theta * scale).tolist(), strict=True))
        runs += len(SUPPLIES)
        pairs = zip(SUPPLIES, currents, strict=True)
        return np.concatenate([(run(plant, values, volts, tolerance) - measured) / NOISE for volts, measured in pairs])

    found = least_squares(residuals, np.ones(len(scale)), diff_step=step, method=method)
    return Outcome(dict(zip(START, (found.x * scale).tolist(), strict=True)), f"{runs} simulations")


def by_cosim(data: list[Data], method: Method) -> Outcome:
    found = fit(linkage_model(list(START), START), [Free(name) for name in START], data, method=method)
    assert found.solved, found.limit
    return Outcome({e.name: e.value for e in found.estimates}, f"{found.iterations} iterations")


def timed(method: Callable[[], Outcome], repetitions: int) -> tuple[float, float, Outcome]:
    """The least wall time and CPU time [s], and what came of it."""
    walls, cpus = [], []
    for _ in range(repetitions):
        began = time.perf_counter(), time.process_time()
        outcome = method()
        walls.append(time.perf_counter() - began[0])
        cpus.append(time.process_time() - began[1])
    return min(walls), min(cpus), outcome


def main() -> None:
    repetitions = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    plant = Fmu.read(catalogue.ensure("linkage"))
    rng = np.random.default_rng(1)
    currents = [run(plant, TRUE, volts) for volts in SUPPLIES]
    currents = [current + NOISE * rng.standard_normal(len(current)) for current in currents]
    t = SAMPLE * np.arange(len(currents[0]))
    data = [
        Data(f"{volts:g} V", t, np.full(len(t), volts), current, None, (NOISE, 1.0), True, known=(0.0, 0.0, 0.0))
        for volts, current in zip(SUPPLIES, currents, strict=True)
    ]
    by_cosim(data, "shooting")  # compiles what is left out

    def report(name: str, method: Callable[[], Outcome], times: int) -> float:
        wall, cpu, outcome = timed(method, times)
        pairs = zip(SUPPLIES, currents, strict=True)
        rms = np.sqrt(np.mean([(run(plant, outcome.values, volts) - measured) ** 2 for volts, measured in pairs]))
        errors = ", ".join(f"{key} {value / TRUE[key] - 1.0:+.3%}" for key, value in outcome.values.items())
        print(f"{name}: {wall:.3f} s (CPU {cpu:.3f} s), {outcome.work}, RMSE {rms:.6f} A; {errors}", flush=True)
        return wall

    ours = report("cosim, shooting", lambda: by_cosim(data, "shooting"), repetitions)
    unknown = [replace(each, known=None) for each in data]
    report("cosim, initial states not known", lambda: by_cosim(unknown, "shooting"), repetitions)
    report("cosim, collocation by IPOPT, initial states not known", lambda: by_cosim(unknown, "collocation"), 1)
    theirs = []
    for method, tolerance, step in SETUPS:
        name = f"SciPy on the FMU, {method}, tolerance {tolerance:g}, step {step:g}"
        theirs.append(report(name, lambda m=method, e=tolerance, h=step: by_scipy(currents, m, e, h), repetitions))
    print(f"SciPy's fastest takes {min(theirs) / ours:.1f} times as long")


if __name__ == "__main__":
    main()
