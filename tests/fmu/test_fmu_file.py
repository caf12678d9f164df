"""The FMU as a file: valid, complete, the same every time."""

from __future__ import annotations

import ctypes
import json
import os
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import fmpy
import pytest
from fmpy.model_description import ModelDescription, ModelVariable
from fmpy.validation import validate_fmu

from cosim.fmu import compile_model
from cosim.fmu.exporter import BUILD_RECORD, pack
from cosim.fmu.toolchain import fmi3_functions

Build = Callable[[str], Path]
SMALL = Path(__file__).parents[1] / "models" / "Small"
WIPER = [
    pytest.param(f"WiperDrive.{name}", marks=pytest.mark.slow)
    for name in ("Systems.LinkagePlant", "Controllers.VoltageProfile")
]
MODELS = ["MotorOnSpring", "PendulumXY", "BouncingBall", "Lights", "Rod", "SampledPI", "Steps"]


def description(path: Path) -> tuple[ModelDescription, dict[str, ModelVariable]]:
    read = fmpy.read_model_description(str(path))
    return read, {variable.name: variable for variable in read.modelVariables}


@pytest.mark.parametrize("name", [*MODELS, *WIPER])
def test_fmpy_finds_nothing_wrong(build: Build, name: str) -> None:
    assert validate_fmu(str(build(name))) == []


def test_the_description_has_units_starts_and_descriptions_of_the_model(build: Build) -> None:
    read, variables = description(build("MotorOnSpring"))
    assert (read.modelName, read.fmiVersion) == ("MotorOnSpring", "3.0")
    assert read.description == "A DC motor that winds up a spring"
    u, phi, R, J = (variables[name] for name in ("u", "phi", "R", "J"))
    assert (u.causality, u.unit, u.start, u.description) == ("input", "V", "0.0", "Supply")
    assert (phi.causality, phi.unit, phi.displayUnit) == ("output", "rad", "deg")
    assert (R.causality, R.unit, R.start, R.min) == ("parameter", "Ohm", "2.0", "0.0")
    assert (J.causality, J.unit, float(J.start)) == ("parameter", "kg.m2", 2e-3)
    # what follows from another parameter is computed, not set
    bound = variables["resistor.R"]
    assert (bound.causality, bound.initial, bound.start) == ("calculatedParameter", "calculated", None)
    units = {unit.name: unit for unit in read.unitDefinitions}
    assert (units["Ohm"].baseUnit.kg, units["Ohm"].baseUnit.m, units["Ohm"].baseUnit.s, units["Ohm"].baseUnit.A) == (
        1, 2, -3, -2,
    )  # fmt: skip
    (degree,) = units["rad"].displayUnits
    assert (degree.name, degree.factor) == ("deg", pytest.approx(57.29577951308232))


def test_outputs_come_first_and_are_in_the_structure(build: Build) -> None:
    read, variables = description(build("MotorOnSpring"))
    assert [unknown.variable.name for unknown in read.outputs] == ["phi", "i"]
    assert list(variables)[:4] == ["time", "u", "phi", "i"]


def test_integers_booleans_and_enumerations_keep_their_types(build: Build) -> None:
    read, variables = description(build("Lights"))
    kinds = {name: variables[name].type for name in ("request", "colour", "count", "n_amber")}
    assert kinds == {"request": "Boolean", "colour": "Enumeration", "count": "Int32", "n_amber": "Int32"}
    assert (variables["request"].start, variables["n_amber"].start) == ("false", "2")
    (colour,) = (kind for kind in read.typeDefinitions if kind.name == variables["colour"].declaredType.name)
    assert [(item.name, item.value) for item in colour.items] == [("red", "1"), ("green", "2"), ("amber", "3")]


def test_protected_variables_and_constants_are_not_published(build: Build) -> None:
    _, variables = description(build("PendulumXY"))
    assert "g" not in variables
    assert {"L", "m", "x", "y", "F"} <= set(variables)


def test_the_same_model_gives_the_same_bytes(build: Build, tmp_path: Path) -> None:
    dae = compile_model(SMALL / "BouncingBall.mo", "Small.BouncingBall")
    first, second = pack(dae, tmp_path / "a"), pack(dae, tmp_path / "b")
    assert first.read_bytes() == second.read_bytes() == build("BouncingBall").read_bytes()


def test_another_model_has_another_token(build: Build) -> None:
    tokens = {description(build(name))[0].instantiationToken for name in MODELS}
    assert len(tokens) == len(MODELS)


def test_the_binary_exports_the_whole_interface_and_nothing_else(build: Build, tmp_path: Path) -> None:
    with zipfile.ZipFile(build("SampledPI")) as archive:
        (binary,) = (name for name in archive.namelist() if name.startswith("binaries/"))
        library = Path(archive.extract(binary, tmp_path))
        record = json.loads(archive.read(BUILD_RECORD))
        assert "MIT No Attribution" in archive.read("documentation/licenses/LICENSE.txt").decode()
    assert record["model"] == "Small.SampledPI"
    loaded = ctypes.CDLL(str(library))
    assert [name for name in fmi3_functions() if not hasattr(loaded, name)] == []
    if sys.platform == "linux":
        done = subprocess.run(["nm", "-D", "--defined-only", library], capture_output=True, text=True, check=False)
        if done.returncode == 0:
            exported = {line.split()[-1] for line in done.stdout.splitlines()}
            assert {name for name in exported if not name.startswith(("fmi3", "_"))} == set()


def test_the_folder_of_the_export_holds_the_fmu_alone(tmp_path: Path) -> None:
    path = pack(compile_model(SMALL / "PendulumAngle.mo", "Small.PendulumAngle"), tmp_path / "new" / "folder")
    assert [entry.name for entry in path.parent.iterdir()] == ["PendulumAngle.fmu"]


@pytest.mark.slow
def test_another_process_writes_the_same_bytes(tmp_path: Path) -> None:
    """Whatever the order of sets, the time, and the folder are there."""
    program = "import sys; from pathlib import Path; from cosim.fmu import export_all; "
    program += "export_all(Path(sys.argv[1]), 'Small.Rectifier', Path(sys.argv[2]))"
    for seed in ("1", "2"):
        environment = os.environ | {"PYTHONHASHSEED": seed, "TZ": f"UTC+{seed}"}
        command = [sys.executable, "-c", program, str(SMALL / "Rectifier.mo"), str(tmp_path / seed)]
        subprocess.run(command, env=environment, check=True)
    for name in ("Rectifier.fmu", "Rectifier.fmi2.fmu"):
        assert (tmp_path / "1" / name).read_bytes() == (tmp_path / "2" / name).read_bytes()
