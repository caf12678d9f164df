"""What a process of its own costs a run: whole commands, runs one after another, and the loop inside.

Usage: python benchmarks/isolation.py [ROUNDS]

The rounds alternate between what is compared; medians are printed, with the quartiles in brackets.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from cosim.engine import Fmu, Isolate, System, simulate
from cosim.fmu import catalogue
from cosim.scenario import assemble, read
from cosim.worker import dismiss

sys.path.insert(0, str(Path(__file__).parent))
from engine import INTEGRATOR, ROOT, SAMPLER, alternate, build, feedback, spread, wall

SCENARIO = ROOT / "scenarios" / "linkage_20ms.csv"
CHOICES: tuple[Isolate, ...] = ("never", "always")


def main() -> None:
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 11
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        foreign = folder / "foreign.csv"
        build(INTEGRATOR, 3, folder)
        foreign.write_text("# system: integrator3.fmu\n# controller: none\n# stop: 10 s\ntime [s],u [m/s]\n0,1\n")
        commands(SCENARIO, folder, rounds)
        commands(foreign, folder, rounds)
        scenario = read(SCENARIO)
        runs(SCENARIO.stem, assemble(scenario, catalogue.ensure), scenario.stop, 1e-3, rounds)
        plant, controller = (Fmu.read(build(model, 3, folder)) for model in (INTEGRATOR, SAMPLER))
        with plant, controller:
            runs(
                "sampler and integrator, 25 s in steps of 0.1 ms", feedback(plant, controller, 1e-4), 25.0, 0.01, rounds
            )
            runs("the same, 0.1 s", feedback(plant, controller, 1e-4), 0.1, 0.01, rounds)


def commands(scenario: Path, folder: Path, rounds: int) -> None:
    """Print the wall time of the whole command, by its option."""

    def timer(isolate: str) -> Callable[[], float]:
        options = ["--isolate", isolate, "--no-plots", "--quiet", "--out", str(folder)]
        command = [sys.executable, "-m", "cosim", "run", str(scenario), *options]

        def once() -> float:
            started = time.perf_counter()
            subprocess.run(command, check=True)
            return time.perf_counter() - started

        once()
        return once

    compare(f"cosim run {scenario.name} --no-plots, whole process", {c: timer(c) for c in (*CHOICES, "auto")}, rounds)


def runs(what: str, system: System, stop: float, interval: float, rounds: int) -> None:
    """Print the wall time of ``simulate``, and of the loop in it."""
    loops: dict[str, list[float]] = {choice: [] for choice in CHOICES}

    def timer(isolate: Isolate) -> Callable[[], float]:
        def once() -> float:
            started = time.perf_counter()
            result = simulate(system, stop=stop, output_interval=interval, tolerance=1e-6, isolate=isolate)
            loops[isolate].append(wall(result))
            return time.perf_counter() - started

        return once

    def first() -> float:
        dismiss()
        return timer("always")()

    compare(f"{what}, simulate()", {c: timer(c) for c in CHOICES} | {"always, first in a process": first}, rounds)
    ratio = statistics.median(b / a for a, b in zip(loops["never"], loops["always"], strict=False))
    print(f"  the loop alone: {ratio:.3f} times (median of pairs)")


def compare(what: str, timers: dict[str, Callable[[], float]], rounds: int) -> None:
    times = alternate(timers, rounds)
    print(f"\n{what}: ms")
    for name, seconds in times.items():
        ratio = statistics.median(b / a for a, b in zip(times["never"], seconds, strict=True))
        added = statistics.median(b - a for a, b in zip(times["never"], seconds, strict=True))
        print(
            f"  {name:28} {statistics.median(seconds) * 1e3:8.1f} {spread(seconds, 1e3, 1)}  "
            f"{ratio:.3f} times, {added * 1e3:+.1f} ms (medians of pairs)"
        )


if __name__ == "__main__":
    main()
