"""Run in a process of its own: steps an SSP in ecos and prints a JSON list of rows."""

from __future__ import annotations

import ctypes
import json
import sys
from contextlib import suppress
from pathlib import Path

with suppress(OSError):  # ecos needs libtbb, which PyPI's tbb puts into the environment's lib folder
    ctypes.CDLL(str(Path(sys.prefix) / "lib" / "libtbb.so.12"), mode=ctypes.RTLD_GLOBAL)

from ecospy import EcosLib, EcosSimulation

path, step, steps, *names = sys.argv[1:]
EcosLib.set_log_level("warn")
with EcosSimulation(float(step), ssp_path=path) as simulation:
    simulation.init()
    rows = []
    for _ in range(int(steps)):
        simulation.step(1)
        rows.append([simulation.get_real(name) for name in names])
print(json.dumps(rows))
