"""Runs a job in CoFmuPy. Variants: "jacobi" and "gauss-seidel". It records every macro step."""

from __future__ import annotations

import json
import time
from pathlib import Path

from _worker import Answer, Job, names, serve
from cofmupy import Coordinator


def run(job: Job) -> Answer:
    path = Path(job["folder"]) / "cofmu.json"
    configuration = {
        "fmus": [
            {
                "id": part["name"],
                "name": part["name"],
                "path": part["path"],
                "initialization": part["parameters"],
            }
            for part in job["parts"]
        ],
        "connections": [
            {
                "source": {"id": a, "variable": out, "unit": ""},
                "target": {"id": b, "variable": into, "unit": ""},
            }
            for a, out, b, into in job["connections"]
        ],
        "cosim_method": job["variant"].replace("-", "_"),
        "iterative": False,
    }
    path.write_text(json.dumps(configuration), encoding="utf-8")
    coordinator = Coordinator()
    coordinator.start(str(path))
    begun = time.perf_counter()
    for _ in range(round(job["stop"] / job["step"])):
        coordinator.do_step(job["step"])
    seconds = time.perf_counter() - begun
    results = coordinator.get_results()
    every = job["every"]
    rows = {"time": list(map(float, results["time"][every - 1 :: every]))}
    for name, output in zip(names(job), job["outputs"], strict=True):
        rows[name] = [float(value) for value in results[tuple(output)][every - 1 :: every]]
    return {"seconds": seconds, "rows": rows}


if __name__ == "__main__":
    serve(run, "cofmupy", "FMPy")
