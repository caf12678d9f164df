"""What it takes to build all FMUs for all platforms and both FMI versions, and how large they are.

Run with ``python benchmarks/build.py`` in an environment that has the package. The first build warms the compiler's
caches: its C libraries for each platform. CPU time is that of all processes, the figure to compare beside others on the
same machine. Nothing is asserted.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

COSIM = [sys.executable, "-c", "from cosim.cli import main; main()"]
ALL = ["--platform", "all", "--fmi", "both"]


def timed(what: str, out: Path, options: list[str]) -> None:
    """Build into a new folder; print wall and CPU time [s]."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run([*COSIM, "build", "--out", str(out), *options], check=True, capture_output=True)
    wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    user, system = after.ru_utime - before.ru_utime, after.ru_stime - before.ru_stime
    print(f"{what:<44} {wall:6.1f} s wall  {user + system:6.1f} s CPU ({user:.1f} user, {system:.1f} system)")


def main() -> None:
    print(f"{os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}")
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder)
        timed("all platforms, both FMI versions, first", out / "first", ALL)
        timed("all platforms, both FMI versions", out / "all", ALL)
        timed("this platform, FMI 3.0", out / "host", [])
        for path in sorted((out / "all").glob("*.fmu")):
            print(f"{path.name:<44} {path.stat().st_size / 1000:6.1f} kB")


if __name__ == "__main__":
    main()
