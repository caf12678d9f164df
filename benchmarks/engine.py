"""What the engine adds to the FMUs' own work: microseconds per macro step, and wall time of shipped scenarios.

Usage: python benchmarks/engine.py [ROUNDS]

The rounds alternate between what is compared; medians are printed, with the quartiles in brackets.
"""

from __future__ import annotations

import ctypes
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from cosim.engine import Algorithm, Component, Connection, Fmu, Result, System, simulate
from cosim.fmu import catalogue
from cosim.fmu.toolchain import compiler
from cosim.scenario import assemble, read

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests" / "fmus"))
from fmu_builder import INTEGRATOR, SAMPLER, build  # noqa: E402

STOP = 25.0
FLAGS = ("-std=c11", "-O2", "-shared", "-fPIC")
Timer = Callable[[], float]


def main() -> None:
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 11
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        floor = compile_floor(folder)
        for fmi in (2, 3):
            plant, controller = (Fmu.read(build(model, fmi, folder)) for model in (INTEGRATOR, SAMPLER))
            with plant, controller:
                for step in (1e-3, 1e-4):
                    macro_steps(floor, plant, controller, step, rounds)
    for scenario in ("linkage_20ms", "linkage_full_voltage"):
        scenario_wall(scenario, rounds)


def macro_steps(floor: ctypes.CDLL, plant: Fmu, controller: Fmu, step: float, rounds: int) -> None:
    """Print microseconds per macro step for the two test FMUs, connected in a loop, with rows every 10 ms."""
    system = feedback(plant, controller, step)
    steps = round(STOP / step)

    def engine(loop: str, algorithm: Algorithm) -> Timer:
        macro = step if algorithm == "jacobi" else None
        return lambda: wall(run(loop, system, STOP, 0.01, step=macro))

    timers: dict[str, Timer] = {
        "floor (doSteps only, C)": lambda: time_floor(floor, plant, controller, step, steps),
        "native, jacobi": engine("native", "jacobi"),
        "native, gauss-seidel": engine("native", "gauss-seidel"),
    }
    slow: dict[str, Timer] = {
        "python, jacobi": engine("python", "jacobi"),
        "python, gauss-seidel": engine("python", "gauss-seidel"),
    }
    times = alternate(timers, rounds)
    times |= alternate(slow, min(rounds, 3))
    print(f"\nsampler and integrator, FMI {plant.fmi_version}, macro step {step:g} s, {STOP:g} s; us per macro step")
    lowest = statistics.median(times["floor (doSteps only, C)"])
    for name, seconds in times.items():
        median = statistics.median(seconds)
        above = (median - lowest) / steps * 1e6
        best = (min(seconds) - min(times["floor (doSteps only, C)"])) / steps * 1e6
        print(
            f"  {name:24} {median / steps * 1e6:8.4f} {spread(seconds, 1e6 / steps, 4)}  "
            f"above the floor {above:8.4f} (lowest against lowest {best:.4f}), {median / lowest:.2f} times"
        )


def feedback(plant: Fmu, controller: Fmu, period: float) -> System:
    return System(
        [
            Component("plant", plant, {"x0": 1.0}),
            Component("controller", controller, {"T_compute": period, "K": -1.0}),
        ],
        [Connection(("plant", "x"), ("controller", "u")), Connection(("controller", "y"), ("plant", "u"))],
    )


def scenario_wall(name: str, rounds: int) -> None:
    """Print the engine's wall time for a scenario, and what was called how often."""
    scenario = read(ROOT / "scenarios" / f"{name}.csv")
    system = assemble(scenario, catalogue.ensure)
    last: dict[str, Result] = {}

    def timer(loop: str) -> Timer:
        def once() -> float:
            last[loop] = run(loop, system, scenario.stop, scenario.output_interval)
            return wall(last[loop])

        return once

    times = alternate({loop: timer(loop) for loop in ("native", "python")}, max(3, rounds // 2))
    print(f"\n{name}: {scenario.stop:g} s, rows every {scenario.output_interval:g} s, tolerance 1e-6")
    for loop, seconds in times.items():
        print(f"  {loop:24} {statistics.median(seconds) * 1e3:8.1f} ms {spread(seconds, 1e3, 1)}")
    counted = last["native"].statistics
    for key in ("exchanges", "steps", "events", "solver"):
        print(f"  {key}: {counted[key]}")
    for component in system.components:
        component.fmu.close()


def run(loop: str, system: System, stop: float, interval: float, *, step: float | None = None) -> Result:
    """Run with one of the loops; with a macro step by the Jacobi algorithm."""
    os.environ["COSIM_ENGINE"] = loop
    algorithm: Algorithm = "gauss-seidel" if step is None else "jacobi"
    return simulate(
        system,
        stop=stop,
        output_interval=interval,
        tolerance=1e-6,
        algorithm=algorithm,
        step=step,
        coupling_error=False,
    )


def wall(result: Result) -> float:
    return float(str(result.statistics["wall_s"]))


def alternate(timers: dict[str, Timer], rounds: int) -> dict[str, list[float]]:
    times: dict[str, list[float]] = {name: [] for name in timers}
    for _ in range(rounds):
        for name, timer in timers.items():
            times[name].append(timer())
    return times


def spread(seconds: list[float], unit: float, digits: int) -> str:
    low, _, high = statistics.quantiles(seconds, n=4)
    return f"[{low * unit:.{digits}f} .. {high * unit:.{digits}f}]"


def compile_floor(folder: Path) -> ctypes.CDLL:
    library = folder / "floor.so"
    subprocess.run(
        [
            *compiler(),
            "-std=c11",
            "-O2",
            "-shared",
            "-fPIC",
            "-o",
            str(library),
            str(Path(__file__).parent / "floor.c"),
        ],
        check=True,
    )
    return ctypes.CDLL(str(library))


def time_floor(floor: ctypes.CDLL, plant: Fmu, controller: Fmu, step: float, steps: int) -> float:
    """Return the wall time [s] of the doSteps alone, of instances that fmpy has initialised."""
    slaves = [plant.slave(), controller.slave()]
    version = plant.fmi_version[0]
    for slave in slaves:
        slave.instantiate()
        if version == "2":
            slave.setupExperiment(startTime=0.0)
        slave.enterInitializationMode()
        slave.exitInitializationMode()
    instances = (ctypes.c_void_p * 2)(*(slave.component for slave in slaves))
    functions = (ctypes.c_void_p * 2)(
        *(ctypes.cast(slave.dll[f"fmi{version}DoStep"], ctypes.c_void_p).value for slave in slaves)
    )
    call = floor[f"floor{version}"]
    started = time.perf_counter()
    status = call(instances, functions, ctypes.c_long(steps), ctypes.c_double(step))
    elapsed = time.perf_counter() - started
    for slave in slaves:
        slave.dll[f"fmi{version}FreeInstance"](ctypes.c_void_p(slave.component))
    if status:
        raise SystemExit("a doStep has failed")
    return elapsed


if __name__ == "__main__":
    main()
