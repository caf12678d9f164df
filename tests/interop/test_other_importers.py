"""Our FMUs in fmpy, in containers of fmu-manipulation-toolbox, in ecos and in libcosim: the same numbers as here."""

from __future__ import annotations

from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi3 import FMU3Slave

from cosim.fmu import catalogue
from cosim.fmu.versions import FmiVersion

from .conftest import Need
from .peers import PEERS, Case, agree, run_ours, run_peer

INPUTS = {"duty": 0.7, "v_supply": 27.0, "tau_disturbance": -1.0}
OUTPUTS = ("phi_crank", "w_crank", "i_motor", "v_motor", "tau_crank")


def single(name: str, fmi: FmiVersion) -> Case:
    """A plant that starts from rest at constant inputs; its diode switches and its park contact opens and closes."""
    outputs = tuple(("plant", output) for output in OUTPUTS)
    return Case({"plant": catalogue.ensure(name, fmi)}, {"plant": INPUTS}, (), outputs, 1e-3, 4.0, 10)


@pytest.mark.parametrize("name", ["rig", "linkage"])
@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
def test_fmpy(name: str, fmi: FmiVersion) -> None:
    case = single(name, fmi)
    found = fmpy.simulate_fmu(
        str(case.fmus["plant"]),
        stop_time=case.stop,
        output_interval=case.step,
        relative_tolerance=1e-6,
        start_values=INPUTS,
        output=list(OUTPUTS),
        set_stop_time=False,
    )
    rows = {"time": found["time"][:: case.every]} | {f"plant.{o}": found[o][:: case.every] for o in OUTPUTS}
    agree(run_ours(case, jacobi=False), rows, case, 1e-9)


@pytest.mark.parametrize("name", ["rig", "linkage"])
@pytest.mark.parametrize(
    ("peer", "fmi"),
    [("ecos", "2.0"), ("ecos", "3.0"), ("libcosim", "2.0"), ("fmutool_container", "2.0")],
)
def test_one_fmu_gives_the_same_numbers(need: Need, peer: str, name: str, fmi: FmiVersion, tmp_path: Path) -> None:
    need(PEERS[peer])
    case = single(name, fmi)
    agree(run_ours(case, jacobi=False), run_peer(peer, case, tmp_path), case, 1e-9)


@pytest.mark.parametrize("name", ["rig", "linkage"])
def test_an_fmi_3_container_handles_our_events(need: Need, name: str, tmp_path: Path) -> None:
    """It uses Event Mode, in which each event ends a step of the solver: the same as fmpy with Event Mode."""
    need(PEERS["fmutool_container"])
    case = single(name, "3.0")
    theirs = run_peer("fmutool_container", case, tmp_path)
    agree(with_event_mode(case), theirs, case, 1e-9)
    agree(run_ours(case, jacobi=False), theirs, case, 1e-5)  # other steps: to solver tolerance


def with_event_mode(case: Case) -> dict[str, np.ndarray]:
    """Return the rows of fmpy's object, stepped with Event Mode by the rules of the standard."""
    path = str(case.fmus["plant"])
    description = fmpy.read_model_description(path)
    fmu = FMU3Slave(
        guid=description.guid,
        unzipDirectory=fmpy.extract(path),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="plant",
    )
    references = {variable.name: variable.valueReference for variable in description.modelVariables}
    recorded = [references[output] for output in OUTPUTS]

    def settle() -> None:
        while fmu.updateDiscreteStates()[0]:
            pass
        fmu.enterStepMode()

    fmu.instantiate(eventModeUsed=True)
    fmu.setFloat64([references[name] for name in INPUTS], list(INPUTS.values()))
    fmu.enterInitializationMode(startTime=0.0)
    fmu.exitInitializationMode()
    settle()
    rows = [fmu.getFloat64(recorded)]
    for k in range(round(case.stop / case.step)):
        if fmu.doStep(k * case.step, case.step)[0]:
            fmu.enterEventMode()
            settle()
        rows.append(fmu.getFloat64(recorded))
    fmu.terminate()
    fmu.freeInstance()
    table = np.array(rows[:: case.every])
    time = case.step * case.every * np.arange(len(table))
    return {"time": time} | {f"plant.{output}": table[:, i] for i, output in enumerate(OUTPUTS)}


@pytest.mark.parametrize(
    ("peer", "fmi"), [(peer, fmi) for peer in PEERS for fmi in ("2.0", "3.0") if (peer, fmi) != ("libcosim", "3.0")]
)
def test_a_closed_loop_has_one_step_of_delay_in_jacobi_containers(
    need: Need, peer: str, fmi: FmiVersion, tmp_path: Path
) -> None:
    """They step all FMUs at once: as ours does by the Jacobi algorithm, one step later than it does by default."""
    need(PEERS[peer])
    case = Case(
        {"plant": catalogue.ensure("rig", fmi), "controller": catalogue.ensure("speed_control", fmi)},
        {"plant": {}, "controller": {"w_ref": 1.5}},
        (("plant", "w_crank", "controller", "w_crank"), ("controller", "duty", "plant", "duty")),
        (("plant", "phi_crank"), ("plant", "w_crank"), ("controller", "duty")),
        0.01,
        3.0,
        1,
    )
    theirs = run_peer(peer, case, tmp_path)
    agree(run_ours(case, jacobi=True), theirs, case, 1e-9)
    exact = run_ours(case, jacobi=False)
    duty = theirs["controller.duty"]
    assert np.abs(duty - exact["controller.duty"][-len(duty) :]).max() > 1e-3
