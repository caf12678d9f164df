"""Runs a job in this project's engine. Variants: "jacobi", "gauss-seidel", and:

"end only" is Jacobi without rows but the first and the last, "floor" the doSteps alone in a C loop, "ring" the doSteps
and one number each way in a C loop (FMI 2.0).
"""

from __future__ import annotations

import ctypes
import subprocess
import sys
import time
from functools import cache
from pathlib import Path

from _worker import Answer, Job, names, serve

from cosim.engine import Component, Connection, Fmu, System, simulate
from cosim.fmu.toolchain import compiler

sys.path.insert(0, str(Path(__file__).parents[1]))

from engine import compile_floor, time_floor

library = cache(compile_floor)


@cache
def opened(path: str) -> Fmu:
    return Fmu.read(Path(path))


def run(job: Job) -> Answer:
    if job["variant"] == "floor":
        return {"seconds": floor(job), "rows": {}}
    if job["variant"] == "ring":
        return {"seconds": ring(job), "rows": {}}
    components = [Component(part["name"], opened(part["path"]), dict(part["parameters"])) for part in job["parts"]]
    connections = [Connection((a, out), (b, into)) for a, out, b, into in job["connections"]]
    jacobi = job["variant"] != "gauss-seidel"
    result = simulate(
        System(components, connections),
        stop=job["stop"],
        output_interval=job["stop"] if job["variant"] == "end only" else job["step"] * job["every"],
        tolerance=1e-6,
        algorithm="jacobi" if jacobi else "gauss-seidel",
        step=job["step"] if jacobi else None,
        coupling_error=False,  # no peer estimates its own
    )
    rows = {"time": result.time.tolist()} | {name: result.columns[name].tolist() for name in names(job)}
    if job["variant"] == "end only":
        rows = {name: column[-1:] for name, column in rows.items()}
    return {"seconds": float(str(result.statistics["wall_s"])), "rows": rows}


def floor(job: Job) -> float:
    """Return the wall time [s] of the doSteps of two FMUs with their start values."""
    first, second = (opened(part["path"]) for part in job["parts"])
    return time_floor(library(Path(job["folder"])), first, second, job["step"], round(job["stop"] / job["step"]))


def ring(job: Job) -> float:
    """Return the wall time [s] of the least loop that exchanges values between two FMUs."""
    folder = Path(job["folder"])
    path = folder / "loop.so"
    if not path.exists():
        source = Path(__file__).parent / "loop.c"
        command = [*compiler(), "-std=c11", "-O2", "-shared", "-fPIC", "-o", str(path), str(source)]
        subprocess.run(command, check=True)
    slaves = []
    for part in job["parts"]:
        fmu = opened(part["path"])
        slave = fmu.slave()
        slave.instantiate()
        slave.setupExperiment(startTime=0.0)
        values = part["parameters"]
        slave.setReal([fmu.variables[name].value_reference for name in values], list(values.values()))
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        slaves.append((part["name"], fmu, slave))

    def references(component: int, variable: int) -> ctypes.Array[ctypes.c_uint]:
        found = {c[component]: c[variable] for c in job["connections"]}
        return (ctypes.c_uint * 2)(*(fmu.variables[found[name]].value_reference for name, fmu, _ in slaves))

    def functions(name: str) -> ctypes.Array[ctypes.c_void_p]:
        return (ctypes.c_void_p * 2)(*(ctypes.cast(s.dll[name], ctypes.c_void_p).value for _, _, s in slaves))

    arguments = (
        (ctypes.c_void_p * 2)(*(slave.component for _, _, slave in slaves)),
        *map(functions, ("fmi2DoStep", "fmi2GetReal", "fmi2SetReal")),
        references(0, 1),
        references(2, 3),
        ctypes.c_long(round(job["stop"] / job["step"])),
        ctypes.c_double(job["step"]),
    )
    library = ctypes.CDLL(str(path))
    begun = time.perf_counter()
    status = library.ring(*arguments)
    seconds = time.perf_counter() - begun
    for _, _, slave in slaves:
        slave.dll["fmi2FreeInstance"](ctypes.c_void_p(slave.component))
    if status:
        raise RuntimeError("a call failed")
    return seconds


if __name__ == "__main__":
    serve(run, "wiper-cosim")
