"""Runs a job in ecos. Its libraries need libtbb, which PyPI's tbb puts into the environment's lib folder."""

from __future__ import annotations

import ctypes
import sys
import time
from contextlib import suppress
from pathlib import Path

from _worker import Answer, Job, row_count, serve, table

for library in ("libtbb.so.12",):
    with suppress(OSError):
        ctypes.CDLL(str(Path(sys.prefix) / "lib" / library), mode=ctypes.RTLD_GLOBAL)

from ecospy import EcosLib, EcosSimulation, EcosSimulationStructure  # noqa: E402


def run(job: Job) -> Answer:
    EcosLib.set_log_level("warn")
    with EcosSimulationStructure() as structure:
        for part in job["parts"]:
            structure.add_model(part["name"], part["path"])
        for a, out, b, into in job["connections"]:
            structure.make_real_connection(f"{a}::{out}", f"{b}::{into}")
        parameters = {
            f"{part['name']}::{key}": float(value) for part in job["parts"] for key, value in part["parameters"].items()
        }
        structure.add_parameter_set("initial", parameters)
        with EcosSimulation(job["step"], structure=structure) as simulation:
            simulation.init(parameter_set="initial")
            recorded = [f"{name}::{variable}" for name, variable in job["outputs"]]
            begun = time.perf_counter()
            rows = [(0.0, *map(simulation.get_real, recorded))]
            for _ in range(row_count(job)):
                reached = simulation.step(job["every"])
                rows.append((reached, *map(simulation.get_real, recorded)))
            seconds = time.perf_counter() - begun
    return {"seconds": seconds, "rows": table(job, rows)}


if __name__ == "__main__":
    serve(run, "ecospy")
