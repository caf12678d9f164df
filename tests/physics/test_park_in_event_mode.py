"""The plant in an importer that uses Event Mode and takes no early return (FMI 3.0)."""

from __future__ import annotations

import shutil
from pathlib import Path

import fmpy
from fmpy.fmi3 import FMU3Slave

from cosim.fmu import catalogue


def test_park_changes_in_event_mode_only_and_the_motion_is_that_without_it() -> None:
    path = str(catalogue.ensure("linkage"))
    description = fmpy.read_model_description(path)
    references = {variable.name: variable.valueReference for variable in description.modelVariables}
    folder = fmpy.extract(path)
    plants = []
    for event_mode in (False, True):
        plant = FMU3Slave(
            guid=description.guid,
            modelIdentifier=description.coSimulation.modelIdentifier,
            unzipDirectory=folder,
            instanceName=f"plant {event_mode}",
        )
        plant.instantiate(eventModeUsed=event_mode)
        plant.setFloat64([references["duty"]], [1.0])
        plant.enterInitializationMode(tolerance=1e-8, startTime=0.0)
        plant.exitInitializationMode()
        plants.append(plant)
    plain, watched = plants

    def park(plant: FMU3Slave) -> bool:
        return bool(plant.getBoolean([references["park"]])[0])

    def angle(plant: FMU3Slave) -> float:
        return float(plant.getFloat64([references["phi_crank"]])[0])

    watched.enterStepMode()
    seen, edges = park(watched), 0
    for k in range(300):
        plain.doStep(k * 0.01, 0.01)
        needed, _, early, _ = watched.doStep(k * 0.01, 0.01)
        assert not early
        assert park(watched) == seen
        if park(plain) != seen:
            assert needed
            edges += 1
        if needed:
            watched.enterEventMode()
            watched.updateDiscreteStates()
            seen = park(watched)
            watched.enterStepMode()
        assert seen == park(plain)
        assert abs(angle(watched) - angle(plain)) < 1e-6
    assert edges >= 2
    for plant in plants:
        plant.terminate()
        plant.freeInstance()
    shutil.rmtree(Path(folder), ignore_errors=True)
