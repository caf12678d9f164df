"""Directional and adjoint derivatives: exact, and of the function that the importer sees."""

from __future__ import annotations

import ctypes
import shutil
from collections.abc import Callable
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Model
from importer import Importer

from cosim.fmu import export
from cosim.linear import linearize

pytest.importorskip("rumoca")

Build = Callable[[str], Path]
TESTS = Path(__file__).parents[1]
SMALL, LIBRARY = TESTS / "models" / "Small", TESTS.parent / "modelica" / "WiperDrive"

VALVE = """model Valve "A tank whose outflow is given implicitly, with a gain that is an exponent"
  parameter Real c = 0.3;
  parameter Real c2 = 2*c;
  parameter Real m = 1.5;
  parameter Real h_0 = 1;
  input Real u(start=2);
  input Real w(start=1);
  output Real h(start=h_0, fixed=true);
  output Real q(start=1);
  output Real power;
  output Real both;
  discrete output Real held(start=0, fixed=true);
equation
  der(h) = u - q;
  q + c2*sin(q) + q^3 = h + 0.1*w*time;
  power = q^m + h*w;
  both = power*u + sin(time);
  when sample(0, 0.1) then
    held = w;
  end when;
end Valve;
"""


@pytest.fixture(scope="module")
def valve(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("valve")
    (folder / "Valve.mo").write_text(VALVE)
    return export(folder / "Valve.mo", "Valve", folder)


OUTPUTS = ["h", "q", "power", "both"]


def differences(path: Path, unknowns: list[str], known: str, *, running: float) -> list[float]:
    """Central differences of what an importer reads after it has set a known."""
    with Importer(path) as importer:
        importer.fmu.enterInitializationMode(tolerance=1e-10)
        value = importer.get(known)
        width = 1e-5 * (abs(value) or 1.0)
        values = []
        if running:
            importer.fmu.exitInitializationMode()
            importer.step(running)
        for sign in (1, -1):
            importer.set(known, value + sign * width)
            values.append(np.array([importer.get(name) for name in unknowns]))
    return list((values[0] - values[1]) / (2 * width))


def test_derivatives_by_inputs_are_those_of_what_is_read_after_setting_them(valve: Path) -> None:
    with Importer(valve) as importer:
        importer.fmu.enterInitializationMode(tolerance=1e-10)
        importer.fmu.exitInitializationMode()
        importer.step(0.35)
        found = importer.directional(OUTPUTS, ["u", "w"])
    for column, known in enumerate(["u", "w"]):
        assert found[:, column] == pytest.approx(differences(valve, OUTPUTS, known, running=0.35), rel=1e-7, abs=1e-9)


def test_in_initialization_mode_derivatives_go_through_the_initial_equations(valve: Path) -> None:
    knowns = ["u", "w", "c", "m", "h_0"]
    with Importer(valve) as importer:
        importer.fmu.enterInitializationMode()
        found = importer.directional([*OUTPUTS, "c2"], knowns)
        assert importer.adjoint([*OUTPUTS, "c2"], knowns) == pytest.approx(found, rel=1e-12)
    for column, known in enumerate(knowns):
        expected = differences(valve, [*OUTPUTS, "c2"], known, running=0)
        assert found[:, column] == pytest.approx(expected, rel=1e-7, abs=1e-9)


@pytest.mark.parametrize("name", ["SteadyStart", "OperatingPoint"])
def test_what_an_initial_equation_solves_for_follows_its_parameters(build: Build, name: str) -> None:
    with Importer(build(name)) as importer:
        knowns = [v.name for v in importer.variables.values() if v.causality == "parameter" and v.type == "Float64"]
        unknowns = [u.variable.name for u in importer.description.outputs if u.variable.type == "Float64"]
        importer.fmu.enterInitializationMode()
        found = importer.directional(unknowns, knowns)
    assert np.abs(found).max() > 0
    for column, known in enumerate(knowns):
        expected = differences(build(name), unknowns, known, running=0)
        assert found[:, column] == pytest.approx(expected, rel=1e-6, abs=1e-7)


def test_the_adjoint_is_the_transposed(valve: Path, build: Build) -> None:
    plant = build("WiperDrive.Systems.LinkagePlant")
    with Importer(valve) as importer:
        importer.start()
        importer.step(0.35)
        unknowns, knowns = [*OUTPUTS, "held"], ["u", "w", "h", "time", "c", "m"]
        found = importer.directional(unknowns, knowns)
        assert importer.adjoint(unknowns, knowns) == pytest.approx(found, rel=1e-12, abs=1e-15)
        # discrete variables stand still, and an exponent has a derivative of its own
        assert not found[unknowns.index("held")].any()
        q = importer.get("q")
        row = found[OUTPUTS.index("power")]
        assert row[5] == pytest.approx(q**1.5 * np.log(q), rel=1e-9)
    with Importer(plant) as importer:
        importer.set("duty", 0.8)
        importer.start()
        importer.step(0.7)
        unknowns = [u.variable.name for u in importer.description.outputs if u.variable.type == "Float64"]
        knowns = [
            "duty",
            "v_supply",
            "tau_disturbance",
            "phi_crank",
            "w_crank",
            "motor.emf.i",
            "k_emf",
            "gear.ratio",
            "J_arm",
        ]
        found = importer.directional(unknowns, knowns)
        assert importer.adjoint(unknowns, knowns) == pytest.approx(found, rel=1e-9, abs=1e-12)


@pytest.mark.slow
def test_derivatives_are_those_of_the_linearized_model(build: Build) -> None:
    name = "WiperDrive.Systems.LinkagePlant"
    system = linearize(LIBRARY, name, at=0.5, inputs={"duty": 0.8, "tau_disturbance": 0.5})
    with Importer(build(name)) as importer:
        importer.fmu.enterInitializationMode(tolerance=1e-6)
        importer.set("duty", 0.8)
        importer.set("tau_disturbance", 0.5)
        importer.fmu.exitInitializationMode()
        importer.step(0.5)
        outputs, inputs = [s.name for s in system.outputs], [s.name for s in system.inputs]
        states = {"bridge.i": "motor.emf.i"}
        found = importer.directional(outputs, [states.get(s.name, s.name) for s in system.states])
        scale = np.abs(system.C).max(axis=1, keepdims=True) + 1e-9
        assert found / scale == pytest.approx(system.C / scale, abs=1e-6)
        assert importer.directional(outputs, inputs) == pytest.approx(system.D, rel=1e-6, abs=1e-9)
        # the state derivatives and states of Model Exchange, by the value references that ModelStructure gives them
        rates = [u.variable for u in importer.description.derivatives]
        names, known = [v.name for v in rates], [v.derivative.name for v in rates]
        A, B = importer.directional(names, known), importer.directional(names, inputs)
        scale = np.abs(system.A).max(axis=1, keepdims=True)
        assert A / scale == pytest.approx(system.A / scale, abs=1e-6)
        assert pytest.approx(system.B, rel=1e-6, abs=1e-9) == B
        assert importer.adjoint(names, known) == pytest.approx(A, rel=1e-9, abs=1e-9)


def test_in_model_exchange_they_are_those_of_what_is_read_after_setting_the_states(valve: Path) -> None:
    read = fmpy.read_model_description(str(valve))
    folder = fmpy.extract(str(valve))
    fmu = FMU3Model(guid=read.guid, unzipDirectory=folder, modelIdentifier="Valve", instanceName="i")
    fmu.instantiate()
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    fmu.enterContinuousTimeMode()
    fmu.setTime(0.05)
    states = [u.variable.derivative.valueReference for u in read.derivatives]
    unknowns = [u.variable.valueReference for u in [*read.derivatives, *read.outputs] if u.variable.type == "Float64"]
    value = fmu.getFloat64(states)[0]
    found = fmu.getDirectionalDerivative(unknowns, states, [1.0])
    values = []
    for sign in (1, -1):
        fmu.setContinuousStates((ctypes.c_double * 1)(value + sign * 1e-5), 1)
        values.append(np.array(fmu.getFloat64(unknowns)))
    fmu.freeInstance()
    shutil.rmtree(folder, ignore_errors=True)
    assert found == pytest.approx((values[0] - values[1]) / 2e-5, rel=1e-7, abs=1e-9)
    assert np.count_nonzero(found) >= 4


def test_outputs_change_in_time_as_their_derivatives_say(valve: Path) -> None:
    names = [*OUTPUTS, "time"]
    with Importer(valve) as importer:
        importer.fmu.enterInitializationMode(tolerance=1e-11)
        importer.fmu.exitInitializationMode()
        importer.step(0.349)
        before = np.array([importer.get(name) for name in names])
        importer.step(0.001)
        slope = importer.fmu.getOutputDerivatives(importer.references(names), [1] * len(names))
        importer.step(0.001)
        after = np.array([importer.get(name) for name in names])
    assert slope == pytest.approx((after - before) / 0.002, rel=1e-5)


def test_what_no_derivative_is_given_of_is_refused_with_a_reason(valve: Path, build: Build) -> None:
    def refusal(importer: Importer, unknown: str, known: str) -> str:
        said = importer.said = []
        for call in (importer.directional, importer.adjoint):
            with pytest.raises(FMICallException):
                call([unknown], [known])
        assert len(set(said)) == 2
        return said[0]

    with Importer(valve) as importer:
        assert "is not allowed before Initialization Mode" in refusal(importer, "q", "u")
        importer.start()
        assert "derivatives are by Real inputs, parameters, time and states" in refusal(importer, "q", "c2")
        assert "is none of these" in refusal(importer, "q", "power")
    with Importer(build("Lights")) as importer:
        importer.start()
        assert "derivatives are of Real outputs" in refusal(importer, "n_amber", "time")


def test_where_a_derivative_is_infinite_the_call_fails(tmp_path: Path) -> None:
    (tmp_path / "Root.mo").write_text(
        """model Root
  input Real u(start=0);
  output Real y;
equation
  y = sqrt(u);
end Root;
"""
    )
    with Importer(export(tmp_path / "Root.mo", "Root", tmp_path)) as importer:
        importer.start()
        with pytest.raises(FMICallException):
            importer.directional(["y"], ["u"])
        importer.set("u", 4.0)
        assert importer.directional(["y"], ["u"]) == pytest.approx(np.array([[0.25]]))


def test_fmi_2_gives_the_same_derivatives(build: Build, tmp_path: Path) -> None:
    path = export(SMALL / "FourBar.mo", "Small.FourBar", tmp_path, fmi="2.0")
    read = fmpy.read_model_description(str(path))
    references = {v.name: v.valueReference for v in read.modelVariables}
    outputs = [u.variable.name for u in read.outputs]
    knowns = ["phi", "w", "tau"]
    folder = fmpy.extract(str(path))
    fmu = FMU2Slave(guid=read.guid, unzipDirectory=folder, modelIdentifier="FourBar", instanceName="i")
    fmu.instantiate()
    fmu.setupExperiment()
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    fmu.doStep(0.0, 0.1)
    rows, columns = [references[n] for n in outputs], [references[n] for n in knowns]
    found = np.array([fmu.getDirectionalDerivative(rows, columns, list(seed)) for seed in np.eye(len(columns))]).T
    fmu.freeInstance()
    shutil.rmtree(folder, ignore_errors=True)
    with Importer(build("FourBar")) as importer:
        importer.start()
        importer.step(0.1)
        assert found.tolist() == importer.directional(outputs, knowns).tolist()
    assert np.abs(found).max() > 0
