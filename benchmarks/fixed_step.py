"""How long the longest step of an FMU with a fixed step takes, beside the usual FMU: counts, and shares of the median.

usage: python benchmarks/fixed_step.py [seconds]
"""

from __future__ import annotations

import ctypes
import sys
import tempfile
import time
from pathlib import Path

import fmpy
import numpy as np
from fmpy.fmi3 import FMU3Slave, fmi3Boolean, fmi3Float64, fmi3UInt64, fmi3ValueReference

from cosim.fmu import compile_model
from cosim.fmu.exporter import pack

LIBRARY = Path(__file__).parents[1] / "modelica" / "WiperDrive"
STEP = 1e-3
REPEATS = 7
DUTY = [0.9, 0.5, 0.0, 1.0, 0.2]
"""Duty ratios, each for a fifth of a period of 5 s."""


def run(path: Path, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Times [s] and evaluations of each communication step."""
    read = fmpy.read_model_description(str(path))
    references = {v.name: v.valueReference for v in read.modelVariables}
    fmu = FMU3Slave(
        guid=read.guid,
        unzipDirectory=fmpy.extract(str(path)),
        modelIdentifier=read.coSimulation.modelIdentifier,
        instanceName="i",
    )
    fmu.instantiate()
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    count = round(seconds / STEP)
    step = fmu.dll.fmi3DoStep
    step.argtypes = [ctypes.c_void_p, ctypes.c_double, ctypes.c_double, ctypes.c_bool, *[ctypes.c_void_p] * 4]
    event, terminate, early, last = fmi3Boolean(), fmi3Boolean(), fmi3Boolean(), fmi3Float64()
    told = [ctypes.byref(x) for x in (event, terminate, early, last)]
    evaluations = (fmi3ValueReference * 1)(references["solver.rhs_evaluations"])
    value = (fmi3UInt64 * 1)()
    times, counts, before = np.empty(count), np.empty(count), 0
    for k in range(count):
        if k % 1000 == 0:
            fmu.setFloat64([references["duty"]], [DUTY[k // 1000 % len(DUTY)]])
        start = time.perf_counter_ns()
        status = step(fmu.component, k * STEP, STEP, True, *told)
        times[k] = (time.perf_counter_ns() - start) * 1e-9
        assert status == 0
        fmu.fmi3GetUInt64(fmu.component, evaluations, 1, value, 1)
        counts[k], before = value[0] - before, value[0]
    fmu.freeInstance()
    return times, counts


def main() -> None:
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 25.0
    dae = compile_model(LIBRARY, "WiperDrive.Systems.LinkagePlant")
    at = (50, 99, 99.9, 100)
    print(f"| {'FMU':10} | {'evaluations: mean':17} | " + " | ".join(f"{p:g} %" for p in at), end=" | ")
    print("median [us] | " + " | ".join(f"{p:g} % / median" for p in at[1:]) + " |")
    with tempfile.TemporaryDirectory() as folder:
        for name, step in (("usual", None), ("fixed step", STEP)):
            path = pack(dae, Path(folder) / name.replace(" ", "_"), fixed_step=step, with_sources=False)
            runs = [run(path, seconds) for _ in range(REPEATS)]
            # every run does the same: what a step takes at best is its own time, the rest is the machine's
            times, counts = np.min([times for times, _ in runs], axis=0), runs[0][1]
            median = np.median(times)
            shares = " | ".join(f"{np.percentile(times, p) / median:.1f}" for p in at[1:])
            quantiles = " | ".join(f"{np.percentile(counts, p):.0f}" for p in at)
            print(f"| {name:10} | {counts.mean():17.1f} | {quantiles} | {median * 1e6:.1f} | {shares} |")


if __name__ == "__main__":
    main()
