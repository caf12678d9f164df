"""Time to fit parameters: the collocation problem of cosim.calibration against SciPy's least squares on the FMU.

Both get the same three start-ups of 7 s with the same noise, the same parameters and the same starting values. SciPy
takes its derivatives by finite differences, a simulation for each parameter and measurement; it is given the initial
state, while the collocation has to find it. What is simulated or compiled once for both (the FMUs) is left out; what
the collocation sets up (model, equations, derivatives) is not.

Run: python benchmarks/calibration.py [repetitions]
"""

from __future__ import annotations

import statistics
import sys
import time

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from cosim.calibration import Data, Free, fit, linkage_equations, linkage_model
from cosim.engine import Channel, Component, Fmu, System, simulate
from cosim.fmu import catalogue

Array = NDArray[np.float64]

TRUE = {"d_joint": 0.95, "ext_load": 3.6, "J_rotor": 1.3e-4, "motor.R": 2.1}
START = {"d_joint": 0.8594, "ext_load": 3.0, "J_rotor": 1e-4, "motor.R": 1.91}
SUPPLIES, LENGTH, SAMPLE, NOISE = (21.0, 24.0, 27.0), 7.0, 0.002, 0.04


def run(plant: Fmu, values: dict[str, float], supply: float) -> Array:
    channels = [Channel(("plant", "duty"), [0.0], [1.0]), Channel(("plant", "v_supply"), [0.0], [supply])]
    system = System([Component("plant", plant, dict(values))], channels=channels)
    result = simulate(system, stop=LENGTH, output_interval=SAMPLE, tolerance=1e-7)
    return np.asarray(result.columns["plant.i_motor"], dtype=np.float64)


def by_scipy(plant: Fmu, currents: list[Array]) -> tuple[dict[str, float], int]:
    scale = np.array(list(START.values()))
    runs = 0

    def residuals(theta: Array) -> Array:
        nonlocal runs
        values = dict(zip(START, (theta * scale).tolist(), strict=True))
        runs += len(SUPPLIES)
        pairs = zip(SUPPLIES, currents, strict=True)
        return np.concatenate([(run(plant, values, volts) - measured) / NOISE for volts, measured in pairs])

    found = least_squares(residuals, np.ones(len(scale)), diff_step=1e-4)
    return dict(zip(START, (found.x * scale).tolist(), strict=True)), runs


def by_collocation(dae: object, data: list[Data]) -> tuple[dict[str, float], int]:
    found = fit(linkage_model(list(START), START, dae), [Free(name) for name in START], data)  # type: ignore[arg-type]
    assert found.solved, found.limit
    return {e.name: e.value for e in found.estimates}, found.iterations


def main() -> None:
    repetitions = int(sys.argv[1]) if len(sys.argv) > 1 else 3
    plant = Fmu.read(catalogue.ensure("linkage"))
    dae = linkage_equations()
    linkage_model(list(START), START, dae)
    rng = np.random.default_rng(1)
    currents = [run(plant, TRUE, volts) for volts in SUPPLIES]
    currents = [current + NOISE * rng.standard_normal(len(current)) for current in currents]
    t = SAMPLE * np.arange(len(currents[0]))
    data = [
        Data(f"{volts:g} V", t, np.full(len(t), volts), current, None, (NOISE, 1.0), True)
        for volts, current in zip(SUPPLIES, currents, strict=True)
    ]
    taken: dict[str, list[float]] = {"collocation": [], "SciPy on the FMU": []}
    found: dict[str, tuple[dict[str, float], int]] = {}
    for _ in range(repetitions):
        for name, method in (("collocation", lambda: by_collocation(dae, data)),
                             ("SciPy on the FMU", lambda: by_scipy(plant, currents))):  # fmt: skip
            began = time.perf_counter()
            found[name] = method()
            taken[name].append(time.perf_counter() - began)
    for name, (values, count) in found.items():
        pairs = zip(SUPPLIES, currents, strict=True)
        rms = np.sqrt(np.mean([(run(plant, values, volts) - measured) ** 2 for volts, measured in pairs]))
        errors = ", ".join(f"{key} {value / TRUE[key] - 1.0:+.3%}" for key, value in values.items())
        work = f"{count} iterations" if name == "collocation" else f"{count} simulations"
        print(f"{name}: median {statistics.median(taken[name]):.2f} s, {work}, RMSE {rms:.5f} A; {errors}")
    ratio = statistics.median(taken["SciPy on the FMU"]) / statistics.median(taken["collocation"])
    print(f"SciPy takes {ratio:.2f} times as long")


if __name__ == "__main__":
    main()
