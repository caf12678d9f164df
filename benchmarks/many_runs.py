"""What many runs in one process leave behind: memory, files in the temporary folder, and time for each run.

Usage: python benchmarks/many_runs.py [RUNS]

Each run instantiates a sampler and an integrator (FMI 3.0, from the tests), simulates 0.1 s in a closed loop and frees
them. A line for each tenth of the runs: all three should stay as they are after the first.
"""

from __future__ import annotations

import gc
import sys
import tempfile
import time
from pathlib import Path

from cosim.engine import Fmu, simulate
from engine import INTEGRATOR, SAMPLER, build, feedback


def main() -> None:
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 100_000
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        tempfile.tempdir = name
        with Fmu.read(build(INTEGRATOR, 3, folder)) as plant, Fmu.read(build(SAMPLER, 3, folder)) as controller:
            print(f"{'runs':>8}{'memory [MB]':>14}{'temporary files':>18}{'ms per run':>13}{'processor ms':>15}")
            for part in range(1, 11):
                begun, worked = time.perf_counter(), time.process_time()
                for _ in range(runs // 10):
                    simulate(feedback(plant, controller, 0.02), stop=0.1, output_interval=0.02, tolerance=1e-6)
                spent, work = time.perf_counter() - begun, time.process_time() - worked
                gc.collect()
                files = sum(1 for _ in folder.glob("cosim-*"))
                wall, processor = (seconds / (runs // 10) * 1e3 for seconds in (spent, work))
                print(f"{part * (runs // 10):8}{resident():14.1f}{files:18}{wall:13.3f}{processor:15.3f}", flush=True)


def resident() -> float:
    """Return the memory of this process [MB]; Linux only."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096 / 1e6


if __name__ == "__main__":
    main()
