"""Runs a container FMU, which steps the FMUs inside it, in fmpy.

Variants: "simulate_fmu", as fmpy's users would, and "one doStep" over the whole time, which records the end only.
"""

from __future__ import annotations

import time
from pathlib import Path

from _worker import Answer, Job, names
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

_extracted: dict[Path, tuple[object, str]] = {}


def run_container(path: Path, job: Job, prefix: str = "") -> Answer:
    """Run a job whose container has been built; its outputs have the prefix before their names."""
    if path not in _extracted:
        _extracted[path] = (read_model_description(path, validate=False), extract(path))
    description, folder = _extracted[path]
    parameters = {f"{part['name']}.{k}": value for part in job["parts"] for k, value in part["parameters"].items()}
    outer = [prefix + name for name in names(job)]
    if job["variant"] == "one doStep":
        return _one_step(description, folder, parameters, job, outer)

    def simulate(stop: float):  # noqa: ANN202 - a structured array
        begun = time.perf_counter()
        result = simulate_fmu(
            folder,
            validate=False,
            model_description=description,
            stop_time=stop,
            output_interval=job["step"] * job["every"],
            start_values=parameters,
            output=outer,
        )
        return time.perf_counter() - begun, result

    set_up, _ = simulate(job["step"] * job["every"])
    seconds, result = simulate(job["stop"])
    return {
        "seconds": seconds - set_up,
        "rows": {n: result[o].tolist() for n, o in zip(("time", *names(job)), ("time", *outer), strict=True)},
    }


def _one_step(description, folder: str, parameters: dict[str, float], job: Job, outer: list[str]) -> Answer:  # noqa: ANN001
    kind = FMU2Slave if description.fmiVersion == "2.0" else FMU3Slave
    fmu = kind(
        guid=description.guid,
        unzipDirectory=folder,
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="container",
    )
    references = {variable.name: variable.valueReference for variable in description.modelVariables}
    fmu.instantiate()
    if kind is FMU2Slave:
        fmu.setupExperiment(startTime=0.0)
        put, get = fmu.setReal, fmu.getReal
    else:
        put, get = fmu.setFloat64, fmu.getFloat64
    put([references[name] for name in parameters], list(parameters.values()))
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    begun = time.perf_counter()
    fmu.doStep(currentCommunicationPoint=0.0, communicationStepSize=job["stop"])
    seconds = time.perf_counter() - begun
    values = get([references[name] for name in outer])
    fmu.terminate()
    fmu.freeInstance()
    return {
        "seconds": seconds,
        "rows": {"time": [job["stop"]]} | {n: [v] for n, v in zip(names(job), values, strict=True)},
    }
