"""How long the project's main jobs take: whole processes and the co-simulation inside them.

Run with ``python benchmarks/speed.py`` in an environment that has the package. Prints the median and the range of five
runs; nothing is asserted. Ratios against peers and floors are in the other files of this folder.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

SCENARIOS = Path(__file__).parents[1] / "scenarios"
COSIM = [sys.executable, "-c", "from cosim.cli import main; main()"]
RUNS = 5


def timed(command: list[str]) -> float:
    start = time.perf_counter()
    subprocess.run(command, check=True, capture_output=True)
    return time.perf_counter() - start


def show(what: str, seconds: list[float]) -> None:
    print(f"{what:<58} {statistics.median(seconds):7.3f} s  ({min(seconds):.3f} to {max(seconds):.3f})")


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder)
        cold = [timed([*COSIM, "build", "--out", str(out / f"fmus{k}")]) for k in range(3)]
        show("cosim build, all FMUs, warm compiler cache", cold[1:])
        for name in ("linkage_20ms", "linkage_full_voltage", "rig_20ms"):
            scenario = str(SCENARIOS / f"{name}.csv")
            run = [*COSIM, "run", scenario, "--out", folder]
            timed(run)
            show(f"cosim run {name}.csv, whole process", [timed(run) for _ in range(RUNS)])
            bare = [*run, "--no-plots"]
            walls, wholes = [], []
            for _ in range(RUNS):
                wholes.append(timed(bare))
                summary = json.loads((out / name / "summary.json").read_text(encoding="utf-8"))
                walls.append(summary["wall_s"])
            show("    the same without plots", wholes)
            show("    the 25 s of co-simulation inside it", walls)
            counts = {k: summary[k] for k in ("exchanges", "solver_steps", "rejected_steps", "events")}
            print(f"    {counts}")


if __name__ == "__main__":
    main()
