"""Runs a job in a loop written by hand around fmpy's FMU objects, as fmpy's example custom_input.py does.

Variants: "" exchanges all values, then steps all FMUs, which is a delay of one macro step from the begin of a step of
the last FMU to its effect on the first. The others are references for two FMUs, plant and controller: "delay 0" steps
the controller before the plant, "delay 2" lets its outputs wait one step more, "plant first" steps the plant before
the controller, which so sees outputs from the end of its own step, "start values" takes the first step without an
exchange before it.
"""

from __future__ import annotations

import time

from _worker import Answer, Job, serve, table
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

_extracted: dict[str, tuple[object, str]] = {}


def slave(path: str, name: str, parameters: dict[str, float]):  # noqa: ANN201 - fmpy has no types
    """Return an initialised FMU, its value references, and its functions for real numbers."""
    if path not in _extracted:
        _extracted[path] = (read_model_description(path), extract(path))
    description, folder = _extracted[path]
    kind = FMU2Slave if description.fmiVersion == "2.0" else FMU3Slave
    fmu = kind(
        guid=description.guid,
        unzipDirectory=folder,
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName=name,
    )
    references = {variable.name: variable.valueReference for variable in description.modelVariables}
    fmu.instantiate()
    if kind is FMU2Slave:
        fmu.setupExperiment(startTime=0.0)
        put, get = fmu.setReal, fmu.getReal
    else:
        put, get = fmu.setFloat64, fmu.getFloat64
    put([references[key] for key in parameters], list(parameters.values()))
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    return fmu, references, put, get


def run(job: Job) -> Answer:
    slaves = {part["name"]: slave(part["path"], part["name"], part["parameters"]) for part in job["parts"]}
    wires = []
    for source, output, target, into in job["connections"]:
        _, out_references, _, get = slaves[source]
        _, in_references, put, _ = slaves[target]
        wires.append((get, [out_references[output]], put, [in_references[into]]))
    recorded = [(slaves[name][3], [slaves[name][1][variable]]) for name, variable in job["outputs"]]
    step, every = job["step"], job["every"]
    steps = [fmu.doStep for fmu, *_ in slaves.values()]

    if job["variant"]:
        return {"seconds": 0.0, "rows": table(job, reference(job, wires, steps, recorded))}
    begun = time.perf_counter()
    rows = [(0.0, *(get(reference)[0] for get, reference in recorded))]
    for k in range(round(job["stop"] / step)):
        values = [get(source) for get, source, _, _ in wires]
        for (_, _, put, target), value in zip(wires, values, strict=True):
            put(target, value)
        for do_step in steps:
            do_step(currentCommunicationPoint=k * step, communicationStepSize=step)
        if (k + 1) % every == 0:
            rows.append(((k + 1) * step, *(get(reference)[0] for get, reference in recorded)))
    seconds = time.perf_counter() - begun
    for fmu, *_ in slaves.values():
        fmu.terminate()
        fmu.freeInstance()
    return {"seconds": seconds, "rows": table(job, rows)}


def reference(job: Job, wires: list, steps: list, recorded: list) -> list[tuple[float, ...]]:  # type: ignore[type-arg]
    """Return the rows of a loop of plant and controller with the order or the delay of the variant."""
    step, variant = job["step"], job["variant"]
    (get_plant, plant_out, put_controller, controller_in), (get_controller, controller_out, put_plant, plant_in) = wires
    step_plant, step_controller = steps
    rows = [(0.0, *(get(reference)[0] for get, reference in recorded))]
    waiting = get_controller(controller_out)
    for k in range(round(job["stop"] / step)):
        if variant == "plant first":
            put_plant(plant_in, get_controller(controller_out))
            step_plant(k * step, step)
            put_controller(controller_in, get_plant(plant_out))
            step_controller(k * step, step)
        elif variant == "start values":
            if k > 0:
                put_plant(plant_in, get_controller(controller_out))
                put_controller(controller_in, get_plant(plant_out))
            step_plant(k * step, step)
            step_controller(k * step, step)
        else:
            put_controller(controller_in, get_plant(plant_out))
            if variant == "delay 2":
                put_plant(plant_in, waiting)
                waiting = get_controller(controller_out)
            step_controller(k * step, step)
            if variant == "delay 0":
                put_plant(plant_in, get_controller(controller_out))
            step_plant(k * step, step)
        if (k + 1) % job["every"] == 0:
            rows.append(((k + 1) * step, *(get(reference)[0] for get, reference in recorded)))
    return rows


if __name__ == "__main__":
    serve(run, "FMPy")
