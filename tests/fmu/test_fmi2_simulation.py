"""An FMI 2.0 FMU computes what the FMI 3.0 FMU of the same model does, alone and in the closed loop."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Slave

from cosim.engine import Channel, Component, Fmu, PartialResultError, Result, System, simulate
from cosim.fmu import catalogue, export
from cosim.fmu.versions import FmiVersion
from cosim.scenario import assemble, read

pytest.importorskip("rumoca")

SCENARIOS = Path(__file__).parents[2] / "scenarios"
OUTPUTS = {
    "linkage": ("i_motor", "v_motor", "phi_crank", "w_crank", "w_motor", "tau_crank", "phi_ds", "tau_ds", "tau_ps"),
    "rig": ("i_motor", "v_motor", "phi_crank", "w_crank", "w_motor", "tau_crank", "phi_arm"),
}


def with_fmpy(name: str, fmi: FmiVersion, duty: float) -> Any:  # noqa: ANN401 - a structured array
    return fmpy.simulate_fmu(
        str(catalogue.ensure(name, fmi)),
        stop_time=3.0,
        output_interval=0.01,
        relative_tolerance=1e-7,
        start_values={"duty": duty},
        output=[*OUTPUTS[name], "park"],
    )


@pytest.mark.parametrize(("name", "duty"), list(product(("linkage", "rig"), (0.3, 1.0))))
def test_plants_under_constant_inputs_with_fmpy(name: str, duty: float) -> None:
    two, three = with_fmpy(name, "2.0", duty), with_fmpy(name, "3.0", duty)
    assert np.array_equal(two["time"], three["time"])
    assert np.array_equal(two["park"], three["park"])
    for output in OUTPUTS[name]:
        assert np.abs(two[output] - three[output]).max() <= 1e-9, output


@pytest.mark.parametrize("name", ["linkage", "rig"])
def test_plants_under_constant_inputs_with_the_engine(name: str) -> None:
    results = []
    for fmi in ("2.0", "3.0"):
        with Fmu.read(catalogue.ensure(name, fmi)) as fmu:
            system = System([Component("plant", fmu)], channels=[Channel(("plant", "duty"), [0.0], [0.7])])
            results.append(simulate(system, stop=3.0, output_interval=0.001, tolerance=1e-7))
    assert_same_bits(*results)


@cache
def closed_loop(
    scenario: str, plant: FmiVersion, controller: FmiVersion, stop: float, settings: tuple[str, ...] = ()
) -> Result:
    described = read(SCENARIOS / f"{scenario}.csv", settings)
    system = assemble(described, lambda name: catalogue.ensure(name, controller if "profile" in name else plant))
    tolerance = described.tolerance
    return simulate(system, stop=stop, output_interval=described.output_interval, tolerance=tolerance)


def assert_same_bits(two: Result, three: Result) -> None:
    assert list(two.columns) == list(three.columns)
    assert two.time.tobytes() == three.time.tobytes()
    for name in three.columns:
        assert np.asarray(two.columns[name], float).tobytes() == np.asarray(three.columns[name], float).tobytes(), name
    assert two.literals == three.literals
    assert two.units == three.units
    assert two.statistics["solver"] == three.statistics["solver"]


@pytest.mark.parametrize(("plant", "controller"), [("2.0", "2.0"), ("2.0", "3.0"), ("3.0", "2.0")])
def test_the_closed_loop_decides_and_moves_the_same(plant: FmiVersion, controller: FmiVersion) -> None:
    result = closed_loop("linkage_20ms", plant, controller, 5.0)
    assert len(set(result.columns["controller.state"])) > 2
    assert_same_bits(result, closed_loop("linkage_20ms", "3.0", "3.0", 5.0))


@pytest.mark.parametrize("period", ["1 ms", "2 ms", "10 ms", "50 ms"])
def test_every_sample_time_gives_the_same(period: str) -> None:
    settings = (f"sample_time={period}",)
    assert_same_bits(*(closed_loop("linkage_20ms", fmi, fmi, 3.0, settings) for fmi in ("2.0", "3.0")))


def test_a_sample_time_off_every_grid_gives_the_same() -> None:
    settings = ("sample_time=7.3 ms", "controller.T_compute=0.1 ms")
    assert_same_bits(*(closed_loop("linkage_20ms", fmi, fmi, 2.0, settings) for fmi in ("2.0", "3.0")))


@pytest.mark.slow
@pytest.mark.parametrize("scenario", ["linkage_20ms", "linkage_disturbed", "rig_20ms"])
def test_whole_scenarios_give_the_same(scenario: str) -> None:
    stop = read(SCENARIOS / f"{scenario}.csv").stop
    assert_same_bits(*(closed_loop(scenario, fmi, fmi, stop) for fmi in ("2.0", "3.0")))


def test_a_path_in_the_scenario_names_an_fmi_2_fmu(tmp_path: Path) -> None:
    text = (SCENARIOS / "linkage_20ms.csv").read_text(encoding="utf-8")
    plant, controller = (catalogue.ensure(name, "2.0") for name in ("linkage", "voltage_profile"))
    lines = [line for line in text.splitlines() if not line.startswith(("# system:", "# controller:"))]
    path = tmp_path / "own.csv"
    path.write_text("\n".join([f"# system: {plant}", f"# controller: {controller}", *lines, ""]), encoding="utf-8")
    described = read(path)
    system = assemble(described, lambda name: pytest.fail(f"{name} is no path"))
    assert [component.fmu.fmi_version for component in system.components] == ["2.0", "2.0"]
    result = simulate(system, stop=1.0, output_interval=0.001, tolerance=described.tolerance)
    assert_same_bits(result, closed_loop("linkage_20ms", "3.0", "3.0", 1.0))


@pytest.fixture
def slave(tmp_path: Path) -> Callable[[str], FMU2Slave]:
    """A new instance of an FMI 2.0 FMU of the catalogue, initialised."""

    def make(name: str) -> FMU2Slave:
        path = catalogue.ensure(name, "2.0")
        description = fmpy.read_model_description(str(path))
        made = FMU2Slave(
            guid=description.guid,
            unzipDirectory=fmpy.extract(str(path), str(tmp_path / name)),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        made.instantiate()
        made.setupExperiment(tolerance=1e-6, startTime=0.0)
        made.enterInitializationMode()
        made.exitInitializationMode()
        return made

    return make


@pytest.mark.parametrize("name", ["linkage", "voltage_profile"])
def test_saved_states_continue_bit_by_bit(name: str, slave: Callable[[str], FMU2Slave]) -> None:
    made = slave(name)
    variables = fmpy.read_model_description(str(catalogue.ensure(name, "2.0"))).modelVariables
    reals = [v.valueReference for v in variables if v.type == "Real" and v.causality == "output"]
    (driven,) = (v.valueReference for v in variables if v.name in ("duty", "i_motor") and v.causality == "input")

    def run() -> list[list[float]]:
        rows = []
        for k in range(100, 300):
            made.setReal([driven], [0.5 + 0.4 * (k % 7 > 3)])
            made.doStep(currentCommunicationPoint=0.001 * k, communicationStepSize=0.001)
            rows.append(made.getReal(reals))
        return rows

    for k in range(100):
        made.doStep(currentCommunicationPoint=0.001 * k, communicationStepSize=0.001)
    state = made.getFMUstate()
    data = made.serializeFMUstate(state)
    first = run()
    made.setFMUstate(state)
    assert run() == first
    copy = made.deSerializeFMUstate(data)
    made.setFMUstate(copy)
    assert run() == first
    for saved in (state, copy):
        made.freeFMUstate(saved)
    made.terminate()
    made.freeInstance()


ENDING = """
model Ending "Ends by itself at x = 0.55, or fails at x = 0.35"
  parameter Real fail = 0 "Positive: fail";
  Real x(start = 0, fixed = true) "Grows with time";
  output Real y "As x";
equation
  der(x) = 1;
  y = x;
  assert(fail < 0.5 or x < 0.35, "x is 100% too large");
  when x > 0.55 then
    terminate("over");
  end when;
end Ending;
"""


def test_ends_and_errors_reach_the_user_with_their_reasons(tmp_path: Path) -> None:
    source = tmp_path / "Ending.mo"
    source.write_text(ENDING, encoding="utf-8")
    with Fmu.read(export(source, "Ending", tmp_path, fmi="2.0")) as fmu:
        for fail, reached, message in (
            (0.0, 0.5, "plant (Ending): asked to end the simulation"),
            (1.0, 0.3, "fmi2DoStep returned Error; the FMU says: At t = 0.4 s an assertion of the model is violated: "
             "x is 100% too large"),
        ):  # fmt: skip
            system = System([Component("plant", fmu, {"fail": fail})])
            with pytest.raises(PartialResultError) as failure:
                simulate(system, stop=1.0, output_interval=0.1, tolerance=1e-6)
            assert message in str(failure.value)
            assert failure.value.result.time[-1] == pytest.approx(reached)
