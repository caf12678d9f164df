"""The FMI 2.0 FMU as a file: valid, complete, the same every time, and no other model than the FMI 3.0 one."""

from __future__ import annotations

import ctypes
import json
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import pytest
from fmpy.model_description import ModelDescription, ModelVariable
from fmpy.validation import validate_fmu

from cosim.dae import Dae
from cosim.fmu import catalogue, compile_model, export_all
from cosim.fmu.exporter import BUILD_RECORD, pack
from cosim.fmu.toolchain import fmi_functions, runtime_sources

pytest.importorskip("rumoca")

SMALL = Path(__file__).parents[1] / "models" / "Small"
MODELS = ["MotorOnSpring", "PendulumXY", "BouncingBall", "Lights", "Rod", "SampledPI", "Steps"]
TYPES = {"Float64": "Real", "Int32": "Integer", "UInt64": "Integer", "Int64": "Integer"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Both FMUs of each small model."""
    out = tmp_path_factory.mktemp("both")
    for name in MODELS:
        paths = export_all(SMALL / f"{name}.mo", f"Small.{name}", out)
        assert [path.name for path in paths] == [f"{name}.fmu", f"{name}.fmi2.fmu"]
    return out


def description(path: Path) -> tuple[ModelDescription, dict[str, ModelVariable]]:
    read = fmpy.read_model_description(str(path))
    return read, {variable.name: variable for variable in read.modelVariables}


@pytest.mark.parametrize("name", MODELS)
def test_fmpy_finds_nothing_wrong(folder: Path, name: str) -> None:
    assert validate_fmu(str(folder / f"{name}.fmi2.fmu")) == []
    assert validate_fmu(str(folder / f"{name}.fmu")) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", ["linkage", "rig", "voltage_profile"])
def test_fmpy_finds_nothing_wrong_with_the_wiper_drive(name: str) -> None:
    path = catalogue.ensure(name, "2.0")
    assert path.name.endswith(".fmi2.fmu")
    assert validate_fmu(str(path)) == []


def test_the_description_has_units_starts_and_descriptions_of_the_model(folder: Path) -> None:
    read, variables = description(folder / "MotorOnSpring.fmi2.fmu")
    assert (read.modelName, read.fmiVersion, read.variableNamingConvention) == ("MotorOnSpring", "2.0", "structured")
    assert read.description == "A DC motor that winds up a spring"
    u, phi, R, J = (variables[name] for name in ("u", "phi", "R", "J"))
    assert (u.type, u.causality, u.unit, u.start, u.description) == ("Real", "input", "V", "0.0", "Supply")
    assert (phi.causality, phi.unit, phi.displayUnit) == ("output", "rad", "deg")
    assert (R.causality, R.variability, R.unit, R.start, R.min) == ("parameter", "tunable", "Ohm", "2.0", "0.0")
    assert (J.unit, float(J.start)) == ("kg.m2", 2e-3)
    bound = variables["resistor.R"]
    assert (bound.causality, bound.initial, bound.start) == ("calculatedParameter", "calculated", None)
    units = {unit.name: unit for unit in read.unitDefinitions}
    ohm = units["Ohm"].baseUnit
    assert (ohm.kg, ohm.m, ohm.s, ohm.A) == (1, 2, -3, -2)


def test_what_the_fmu_can_do_is_announced_and_nothing_else(folder: Path) -> None:
    with zipfile.ZipFile(folder / "Steps.fmi2.fmu") as archive:
        text = archive.read("modelDescription.xml").decode()
    read, _ = description(folder / "Steps.fmi2.fmu")
    exchange = read.modelExchange
    assert exchange.canGetAndSetFMUstate
    assert exchange.canSerializeFMUstate
    assert exchange.needsCompletedIntegratorStep
    assert exchange.providesDirectionalDerivative
    capabilities = read.coSimulation
    assert capabilities.canHandleVariableCommunicationStepSize
    assert capabilities.canGetAndSetFMUstate
    assert capabilities.canSerializeFMUstate
    assert not capabilities.canInterpolateInputs
    assert capabilities.maxOutputDerivativeOrder == 1
    assert capabilities.providesDirectionalDerivative
    assert 'canNotUseMemoryManagementFunctions="true"' in text


def test_log_categories_of_both_versions(folder: Path) -> None:
    names = {"logStatusError", "logStatusWarning", "logStatusDiscard", "logEvents"}
    for file in ("Steps.fmu", "Steps.fmi2.fmu"):
        read, _ = description(folder / file)
        assert {category.name for category in read.logCategories} == names


@pytest.mark.parametrize("name", MODELS)
def test_both_versions_describe_the_same_variables(folder: Path, name: str) -> None:
    read2, two = description(folder / f"{name}.fmi2.fmu")
    read3, three = description(folder / f"{name}.fmu")
    assert list(two) == list(three)
    for variable in three:
        a, b = two[variable], three[variable]
        assert a.type == TYPES.get(b.type, b.type)
        for key in ("valueReference", "causality", "variability", "unit", "displayUnit", "start", "description"):
            assert getattr(a, key) == getattr(b, key), (variable, key)
    for outputs in ("outputs", "initialUnknowns"):
        names = [[u.variable.name for u in getattr(read, outputs)] for read in (read2, read3)]
        assert names[0] == names[1]
    assert read2.guid != read3.instantiationToken


def test_enumerations_keep_their_literals(folder: Path) -> None:
    _, variables = description(folder / "Lights.fmi2.fmu")
    kinds = {name: variables[name].type for name in ("request", "colour", "count", "solver.steps")}
    assert kinds == {"request": "Boolean", "colour": "Enumeration", "count": "Integer", "solver.steps": "Integer"}
    items = variables["colour"].declaredType.items
    assert [(item.name, item.value) for item in items] == [("red", "1"), ("green", "2"), ("amber", "3")]


def test_the_binary_exports_the_whole_interface_and_nothing_else(folder: Path, tmp_path: Path) -> None:
    with zipfile.ZipFile(folder / "SampledPI.fmi2.fmu") as archive:
        assert archive.testzip() is None
        (binary,) = (name for name in archive.namelist() if name.startswith("binaries/"))
        library = Path(archive.extract(binary, tmp_path))
        record = json.loads(archive.read(BUILD_RECORD))
        assert "MIT No Attribution" in archive.read("documentation/licenses/LICENSE.txt").decode()
    assert binary == f"binaries/{fmpy.platform}/SampledPI{fmpy.sharedLibraryExtension}"
    assert record["model"] == "Small.SampledPI"
    names = fmi_functions("2.0")
    assert len(names) == 44
    loaded = ctypes.CDLL(str(library))
    assert [name for name in names if not hasattr(loaded, name)] == []
    if sys.platform == "linux":
        done = subprocess.run(["nm", "-D", "--defined-only", library], capture_output=True, text=True, check=False)
        if done.returncode == 0:
            exported = {line.split()[-1] for line in done.stdout.splitlines()}
            assert {name for name in exported if not name.startswith("_")} == set(names)


def test_a_library_has_one_shell() -> None:
    two, three = ({path.name for path in runtime_sources(fmi)} for fmi in ("2.0", "3.0"))
    assert two - three == {name for name in two if name.startswith("fmi2")}
    assert three - two == {name for name in three if name.startswith("fmi3")}
    assert {"advance.c", "instance.c", "state.c"} <= two & three


@pytest.fixture(scope="module")
def dae() -> Dae:
    return compile_model(SMALL / "BouncingBall.mo", "Small.BouncingBall")


def test_the_same_model_gives_the_same_bytes(folder: Path, dae: Dae, tmp_path: Path) -> None:
    first, second = pack(dae, tmp_path / "a", fmi="2.0"), pack(dae, tmp_path / "b", fmi="2.0")
    assert first.read_bytes() == second.read_bytes() == (folder / "BouncingBall.fmi2.fmu").read_bytes()


def test_the_folder_of_the_export_holds_the_fmu_alone(dae: Dae, tmp_path: Path) -> None:
    path = pack(dae, tmp_path / "new" / "folder", fmi="2.0")
    assert [entry.name for entry in path.parent.iterdir()] == ["BouncingBall.fmi2.fmu"]


@pytest.mark.slow
def test_the_catalogue_builds_what_is_missing_of_each_version(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    both = catalogue.build(["linkage"], tmp_path, fmi="both")
    assert [path.name for path in both] == ["LinkagePlant.fmu", "LinkagePlant.fmi2.fmu"]
    content = [path.read_bytes() for path in both]
    both[1].unlink()
    stamp = both[0].stat().st_mtime_ns
    assert catalogue.build(["linkage"], tmp_path, fmi="both") == both
    assert [path.read_bytes() for path in both] == content
    assert both[0].stat().st_mtime_ns == stamp
    monkeypatch.setattr("cosim.fmu.exporter.export_all", lambda *_, **__: pytest.fail("nothing is missing"))
    for choice, expected in (("both", both), ("2.0", both[1:]), ("3.0", both[:1])):
        assert catalogue.build(["LinkagePlant"], tmp_path, fmi=choice) == expected
