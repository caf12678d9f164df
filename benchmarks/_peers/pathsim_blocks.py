"""Runs a job in PathSim, each FMU as a block of pathsim-fmi."""

from __future__ import annotations

import time

from _worker import Answer, Job, serve, table
from pathsim import Connection, Simulation
from pathsim_fmi import CoSimulationFMU


def run(job: Job) -> Answer:
    step = job["step"]
    blocks = {
        part["name"]: CoSimulationFMU(part["path"], part["name"], start_values=part["parameters"], dt=step)
        for part in job["parts"]
    }
    connections = [
        Connection(blocks[a].__getitem__(out), blocks[b].__getitem__(into)) for a, out, b, into in job["connections"]
    ]
    simulation = Simulation(list(blocks.values()), connections, dt=step, log=False)
    recorded = [(blocks[name].outputs, variable) for name, variable in job["outputs"]]
    rows: list[tuple[float, ...]] = [(0.0, *(float(register[name]) for register, name in recorded))]
    begun = time.perf_counter()
    for k in range(round(job["stop"] / step)):
        simulation.timestep(step)
        if (k + 1) % job["every"] == 0:
            rows.append((float(simulation.time), *(float(register[name]) for register, name in recorded)))
    return {"seconds": time.perf_counter() - begun, "rows": table(job, rows)}


if __name__ == "__main__":
    serve(run, "pathsim-fmi", "pathsim", "FMPy")
