"""``cosim info``: what a person wants to know, in 100 columns, of any FMU that can be read."""

from __future__ import annotations

import json
import re
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import Result

Cosim = Callable[..., Result]
XML = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="Pump" instantiationToken="x" description="A pump [S] 3" version="1.2"
  author="Ada" license="MIT" generationTool="Mill 3" generationDateAndTime="2026-01-02T03:04:05Z">
  <ModelExchange modelIdentifier="Pump"/>
  <CoSimulation modelIdentifier="Pump" canHandleVariableCommunicationStepSize="true" canGetAndSetFMUState="true"
    providesDirectionalDerivatives="true" hasEventMode="false" maxOutputDerivativeOrder="2"/>
  <TypeDefinitions>
    <EnumerationType name="Gear"><Item name="low" value="1"/><Item name="high" value="2"/></EnumerationType>
  </TypeDefinitions>
  <DefaultExperiment startTime="0" stopTime="10" tolerance="1e-4" stepSize="0.001"/>
  <ModelVariables>
    <Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>
    <Float64 name="shaft.J" valueReference="1" causality="parameter" variability="fixed" start="0.5"
      description="Inertia"/>
    <Float64 name="Z" valueReference="2" causality="parameter" variability="fixed" start="INF"/>
    <Float64 name="area" valueReference="3" causality="parameter" variability="fixed" start="1 2 3">
      <Dimension start="3"/></Float64>
    <Float64 name="omega" valueReference="4" causality="input" start="0.1234567890123"
      description="A very long description that goes on and on, past the width of all screens there are, and further"/>
    <Boolean name="on" valueReference="5" causality="input" start="true"/>
    <Enumeration name="gear" valueReference="6" causality="input" declaredType="Gear" start="2"/>
    <Float64 name="flow" valueReference="7" causality="output"/>
  </ModelVariables>
  <ModelStructure><Output valueReference="7"/><InitialUnknown valueReference="7"/></ModelStructure>
</fmiModelDescription>"""


@pytest.fixture
def pump(tmp_path: Path) -> Path:
    """An FMU for Windows only, in FMI 3.0."""
    path = tmp_path / "pump.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", XML)
        archive.writestr("binaries/x86_64-windows/Pump.dll", bytes(2_500_000))
        archive.writestr("sources/pump.c", "")
    return path


def lines(text: str) -> list[str]:
    return [re.sub(r"\s{2,}", "  ", line.rstrip()) for line in text.splitlines()]


def test_at_a_glance(cosim: Cosim, pump: Path) -> None:
    done = cosim("info", "pump.fmu")
    assert (done.exit_code, done.stderr) == (0, "")
    text = lines(done.stdout)
    assert text[:10] == [
        "model  Pump, version 1.2",
        "  A pump [S] 3",
        "FMI  3.0",
        "Co-Simulation  variable steps, get and set state, directional derivatives, derivatives of outputs",
        "  up to order 2",
        "Model Exchange  yes",
        "platforms  x86_64-windows (2.5 MB), sources",
        "experiment  0 s to 10 s, tolerance 0.0001, step 0.001 s",
        "made by  Mill 3, 2026-01-02T03:04:05Z",
        "author  Ada",
    ]
    assert "variables  3 inputs, 1 outputs, 3 parameters" in text
    assert "omega  0.1234568  A very long description that goes on and on, past the width of all" in text
    assert "gear  Enumeration  high  (low, high)" in text
    assert "on  Boolean  true" in text
    assert [line for line in text if line.startswith(("area", "Z", "shaft"))] == [
        "area[3]  1 2 3",
        "Z  inf",
        "shaft.J  0.5  Inertia",
    ]


@pytest.mark.parametrize("columns", ["200", "60"])
@pytest.mark.parametrize("terminal", [False, True])
def test_it_fits_a_hundred_columns_and_nothing_is_cut_off(
    cosim: Cosim, pump: Path, monkeypatch: pytest.MonkeyPatch, terminal: bool, columns: str
) -> None:
    monkeypatch.setenv("COLUMNS", columns)
    monkeypatch.setenv("FORCE_COLOR" if terminal else "NO_COLOR", "1")
    text = re.sub("\x1b[^m]*m", "", cosim("info", "pump.fmu").stdout)
    assert "\u2026" not in text
    assert max(map(len, text.splitlines())) <= (60 if terminal and columns == "60" else 100)


def test_as_json(cosim: Cosim, pump: Path) -> None:
    document = json.loads(cosim("info", "pump.fmu", "--json").stdout)
    assert (document["path"], document["model"], document["fmi_version"]) == ("pump.fmu", "Pump", "3.0")
    assert document["variables"] == 8
    assert document["platforms"] == {"x86_64-windows": 2_500_000}
    assert document["interfaces"]["CoSimulation"]["maxOutputDerivativeOrder"] == 2
    assert document["interfaces"]["CoSimulation"]["canGetAndSetFMUState"] is True
    assert document["default_experiment"] == {"startTime": 0.0, "stopTime": 10.0, "tolerance": 1e-4, "stepSize": 1e-3}
    names = {variable["name"]: variable for variable in document["interface"]}
    assert list(names) == ["omega", "on", "gear", "flow", "area", "Z", "shaft.J"]
    assert names["omega"]["start"] == 0.1234567890123
    assert names["Z"]["start"] == "inf"
    assert names["area"]["start"] == [1.0, 2.0, 3.0]
    assert names["gear"]["literals"] == {"1": "low", "2": "high"}


def test_what_is_amiss_is_told_and_read(cosim: Cosim, tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "x.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", XML.replace('start="true"', 'start="True"'))
    done = cosim("info", "x.fmu")
    assert done.exit_code == 0
    assert done.stderr == (
        "warning: x.fmu: a start value is not written as the schema demands: on (line 20) = 'True', read as true\n"
    )
    assert "on  Boolean  true" in lines(done.stdout)


def test_a_dangerous_archive_is_refused(cosim: Cosim, tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "x.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", XML)
        archive.writestr("../x", "")
    done = cosim("info", "x.fmu")
    assert (done.exit_code, done.stdout) == (2, "")
    assert done.stderr == (
        "error: x.fmu: is refused, nothing was unpacked: ../x leads out of the folder it is unpacked to\n"
    )
