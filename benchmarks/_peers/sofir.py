"""Runs a job in sofirpy. Its progress bar is written to standard error."""

from __future__ import annotations

import time

from _worker import Answer, Job, names, serve
from sofirpy.simulation import simulation as sofirpy


def run(job: Job) -> Answer:
    start_values = {part["name"]: part["parameters"] for part in job["parts"]}
    fmus = sofirpy.init_fmus({part["name"]: part["path"] for part in job["parts"]}, job["step"], start_values)
    connections = [
        sofirpy.Connection(sofirpy.SystemParameter(b, into), sofirpy.SystemParameter(a, out))
        for a, out, b, into in job["connections"]
    ]
    logged = [sofirpy.SystemParameter(name, variable) for name, variable in job["outputs"]]
    simulator = sofirpy.Simulator(fmus, connections, logged)
    interval = job["step"] * job["every"]
    begun = time.perf_counter()
    frame = simulator.simulate(job["stop"], job["step"], interval)
    seconds = time.perf_counter() - begun
    return {"seconds": seconds, "rows": {name: frame[name].tolist() for name in ("time", *names(job))}}


if __name__ == "__main__":
    serve(run, "sofirpy", "FMPy")
