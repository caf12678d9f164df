"""How long ``cosim run`` takes from the start of its process to its first doStep, with FMUs that are built.

Usage: python benchmarks/cold_start.py [SCENARIO] [RUNS]

Prints the median of the parts, and the modules that take longest to import (``python -X importtime``).
"""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

SCENARIO = Path(__file__).parents[1] / "scenarios" / "linkage_20ms.csv"
TRACED = """
import json, os, sys, time
marks = {"interpreter": (time.time(), time.process_time())}
import cosim.cli
mark = lambda: (time.time(), time.process_time())
marks["import cosim.cli"] = mark()
import cosim.engine._execution as engine
marks["import cosim.engine"] = mark()
import cosim.cli._run as command
marks["import the rest of the command"] = mark()
def before(module, function, name):
    original = getattr(module, function)
    def call(*arguments, **named):
        marks.setdefault(name, mark())
        return original(*arguments, **named)
    setattr(module, function, call)
before(command, "assemble", "parse arguments, read scenario")
before(command, "simulate", "find and read the FMUs, assemble")
before(engine, "initialize", "instantiate, set parameters")
for loop in ("run_native", "run"):
    before(engine, loop, "initialise: the first doStep is next")
try:
    cosim.cli.main()
finally:
    marks["co-simulate, write results, end"] = mark()
    print(json.dumps([marks, sorted(m for m in sys.modules if "." not in m)]), file=open(os.environ["MARKS"], "w"))
"""


def main() -> None:
    scenario = Path(sys.argv[1]) if len(sys.argv) > 1 else SCENARIO
    runs = int(sys.argv[2]) if len(sys.argv) > 2 else 11
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        command = ["run", str(scenario), "--out", name, "--quiet", "--no-plots"]
        walls: dict[str, list[float]] = {}
        processor: dict[str, list[float]] = {}
        modules: list[str] = []
        for number in range(runs + 1):
            marks, modules = traced(command, folder)
            if number == 0:
                continue  # builds what is missing
            for part, (wall, cpu) in marks.items():
                walls.setdefault(part, []).append(wall)
                processor.setdefault(part, []).append(cpu)
        print(f"cosim run {scenario.name} --no-plots, {runs} runs; seconds after the process start")
        print(f"  {'':40} median  lowest  processor time, median")
        for part, seconds in walls.items():
            median, cpu = statistics.median(seconds), statistics.median(processor[part])
            print(f"  {part:40} {median:6.3f}  {min(seconds):6.3f}  {cpu:6.3f}")
        heavy = (
            "casadi",
            "scipy",
            "rumoca",
            "ziglang",
            "matplotlib",
            "plotly",
            "pandas",
            "pyarrow",
            "pint",
            "pydantic",
        )
        print("  imported by the end:", ", ".join(m for m in heavy if m in modules) or "none of the heavy packages")
        imports(command)


def traced(arguments: list[str], folder: Path) -> tuple[dict[str, tuple[float, float]], list[str]]:
    """Return wall and processor time from the process start to the end of each part, and the imported packages."""
    marks = folder / "marks.json"
    environment = os.environ | {"MARKS": str(marks)}
    started = time.time()
    subprocess.run([sys.executable, "-c", TRACED, *arguments], env=environment, check=True)
    times, modules = json.loads(marks.read_text(encoding="utf-8"))
    return {part: (wall - started, cpu) for part, (wall, cpu) in times.items()}, modules


def imports(arguments: list[str]) -> None:
    """Print the packages with the longest import, their dependencies included."""
    code = "import cosim.cli; cosim.cli.main()"
    done = subprocess.run(
        [sys.executable, "-X", "importtime", "-c", code, *arguments], capture_output=True, text=True, check=True
    )
    rows = []
    for line in done.stderr.splitlines():
        fields = line.removeprefix("import time:").split("|")
        if len(fields) == 3 and fields[1].strip().isdigit():
            rows.append((int(fields[1]), fields[2].strip(), len(fields[2]) - len(fields[2].lstrip())))
    print("  longest imports [ms], dependencies that were not imported before included:")
    for microseconds, module, _ in sorted(rows, reverse=True)[:25]:
        print(f"    {microseconds / 1000:7.1f}  {module}")


if __name__ == "__main__":
    main()
