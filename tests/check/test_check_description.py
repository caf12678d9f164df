"""Each rule on archive, XML and binaries, broken once: the finding that a user gets, and none in a sound FMU."""

from __future__ import annotations

import os
import zipfile
from collections.abc import Callable
from pathlib import Path

import fmpy
import pytest
from edited_fmus import Edit, repack, replacing

from cosim.check import Finding, Severity, check

Get = Callable[..., Path]
LIBRARY = f"binaries/{fmpy.platform_tuple}/integrator{fmpy.sharedLibraryExtension}"


def findings(path: Path, rule: str) -> list[Finding]:
    return [finding for finding in check(path, run=False).findings if finding.rule == rule]


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("name", ["sampler", "integrator", "mirror"])
def test_nothing_is_found_in_a_sound_fmu(fmu_path: Get, name: str, fmi: int) -> None:
    report = check(fmu_path(name, fmi), run=False)
    assert report.findings == ()
    assert len(report.applied) > 25


BROKEN: list[tuple[str, int, str, str, str, str]] = [
    # rule, FMI version, what is replaced in the integrator's description, by what, where, what is told
    ("schema", 3, "<ModelStructure>", "<Nonsense/><ModelStructure>", "line", "Element 'Nonsense'"),
    ("schema", 2, 'guid="test"', 'guid="test" vendor="x"', "line", "The attribute 'vendor' is not allowed"),
    ("schema.missing", 2, 'modelName="integrator"', "", "line", "The attribute 'modelName' is required"),
    ("vendor", 2, 'fmiVersion="2.0"', 'fmiVersion="2.0.4"', "", "fmiVersion should be 2.0: '2.0.4'"),
    (
        "references.unknown",
        2,
        'index="4"',
        'index="99"',
        "",
        "the model structure refers to a variable that is not there",
    ),
    ("references.unknown", 3, '<Output valueReference="4"', '<Output valueReference="99"', "", "refers to a variable"),
    ("references.range", 2, 'valueReference="3"', 'valueReference="-3"', "offset", "has the value reference -3"),
    (
        "references.unit",
        2,
        'valueReference="3"',
        'valueReference="2"',
        "offset",
        "has the value reference of x0, but the unit m/s, not m",
    ),
    (
        "references.duplicate",
        2,
        'valueReference="9"',
        'valueReference="2"',
        "gain",
        "has the value reference of x0, but the start 1, not 0",
    ),
    ("semantics", 3, 'name="offset"', 'name="x0"', "line", 'The variable name "x0"'),
    ("semantics", 3, 'valueReference="3"', 'valueReference="2"', "line", "has the same value reference as"),
    (
        "semantics",
        2,
        'causality="input" variability="continuous"><Real start="0"',
        'causality="input"><Real',
        "",
        "start",
    ),
    ("semantics.lenient", 3, '<Unit name="m/s"/>', "", "line", 'The unit "m/s" of variable "u"'),
    ("semantics.lenient", 2, "InitialUnknowns", "Nothing", "", "InitialUnknowns does not contain the expected set"),
    ("interface.none", 3, "CoSimulation", "Nonsense", "", "has neither CoSimulation nor ModelExchange"),
    (
        "interface.identifier",
        3,
        'Identifier="integrator"',
        'Identifier="a-b"',
        "CoSimulation",
        "modelIdentifier is 'a-b'",
    ),
    ("token", 3, 'instantiationToken="test"', 'instantiationToken=""', "", "instantiationToken is missing or empty"),
    ("token", 2, 'guid="test"', "", "", "guid is missing or empty"),
    (
        "capabilities",
        3,
        "<CoSimulation ",
        '<CoSimulation canSerializeFMUState="true" ',
        "CoSimulation",
        "claims to serialize a state that it cannot get and set",
    ),
    ("names", 3, "<fmiModelDescription ", '<fmiModelDescription variableNamingConvention="structured" ', "", ""),
    ("start.text", 3, 'start="0" unit="m">', 'start="zero" unit="m">', "x0", "the start value 'zero' is no Float64"),
    ("start.text", 2, 'start="0" unit="m"', 'start="0 1" unit="m"', "x0", "has 2 start values for 1 elements"),
    ("start.range", 2, 'start="0" unit="m"', 'start="0" min="1" unit="m"', "x0", "starts at 0, outside 1 to INF"),
    ("units", 2, '"m/s"', '"furlong per fortnight"', "unit of u", "is not a unit"),
    (
        "units",
        2,
        '<Unit name="m"/>',
        '<Unit name="m"><BaseUnit kg="1"/></Unit>',
        "unit of x0, x",
        "'m' has another base",
    ),
    (
        "units",
        2,
        '<Unit name="m"/>',
        '<Unit name="m"><BaseUnit m="1" factor="2"/></Unit>',
        "unit of x0, x",
        "'m' has another base",
    ),
    (
        "experiment",
        2,
        "<ModelVariables>",
        '<DefaultExperiment startTime="2" stopTime="1" stepSize="-1"/><ModelVariables>',
        "DefaultExperiment",
        "",
    ),
    (
        "interface.unsupported",
        3,
        "<UnitDefinitions>",
        '<ScheduledExecution modelIdentifier="integrator"/><UnitDefinitions>',
        "",
        "has a Scheduled Execution interface",
    ),
]


@pytest.mark.parametrize(("rule", "fmi", "old", "new", "where", "what"), BROKEN)
def test_what_is_found_in_a_description(
    fmu_path: Get, tmp_path: Path, rule: str, fmi: int, old: str, new: str, where: str, what: str
) -> None:
    edit = replacing(old, new)
    if rule == "names":
        edit = _both(edit, replacing('name="x0"', 'name="x 0"'))
    found = findings(repack(fmu_path("integrator", fmi), tmp_path / "x.fmu", edit), rule)
    assert found
    assert where in found[0].where
    assert what in found[0].what


def _both(first: Edit, second: Edit) -> Edit:
    def edit(name: str, content: bytes) -> tuple[str, bytes] | None:
        done = first(name, content)
        return second(*done) if done else None

    return edit


def test_an_enumeration_that_starts_nowhere(fmu_path: Get, tmp_path: Path) -> None:
    edit = replacing('declaredType="Choice" start="1"', 'declaredType="Choice" start="7"')
    found = findings(repack(fmu_path("mirror", 2), tmp_path / "x.fmu", edit), "start.range")
    assert [finding.what for finding in found] == ["starts at 7, which is no literal"]


def _binary(old: str, new: str, content: bytes | None = None) -> Edit:
    return lambda name, found: (name.replace(old, new), content if content is not None and old in name else found)


@pytest.mark.parametrize(
    ("rule", "edit", "where", "what"),
    [
        (
            "binary.none",
            lambda name, content: None if name.startswith("bin") else (name, content),
            "binaries",
            "neither",
        ),
        ("binary.missing", _binary("/integrator", "/other"), f"binaries/{fmpy.platform_tuple}", "is missing"),
        ("binary.missing", _binary(LIBRARY, "binaries/x86_64-windows/Integrator.dll"), "", ""),
        ("binary.missing", _binary(LIBRARY, "binaries/darwin32/integrator.dylib"), "", ""),
        ("binary.folder", _binary(fmpy.platform_tuple, "linux"), "binaries/linux", "is no platform of FMI 3.0"),
        ("binary.format", _binary("none", "none", b""), "", ""),
        ("binary.format", _binary(LIBRARY, LIBRARY, b"nonsense"), LIBRARY, "is no library of a known format"),
        (
            "binary.format",
            _binary(LIBRARY, "binaries/x86_64-windows/integrator.dll"),
            "binaries/x86_64-windows/integrator.dll",
            "is a file of format ELF, but PE is expected",
        ),
        (
            "binary.format",
            _binary(fmpy.platform_tuple, "riscv64-linux"),
            "binaries/riscv64-linux/integrator.so",
            "is for the processor X86_64",
        ),
    ],
)
def test_what_is_found_in_binaries(fmu_path: Get, tmp_path: Path, rule: str, edit: Edit, where: str, what: str) -> None:
    pytest.importorskip("lief")
    found = findings(repack(fmu_path("integrator", 3), tmp_path / "x.fmu", edit), rule)
    if not what:
        assert found == []
        return
    assert found[0].where == where
    assert what in found[0].what


def test_functions_that_an_interface_needs(fmu_path: Get, tmp_path: Path) -> None:
    """The test FMUs export all functions; one under another name is missed."""
    pytest.importorskip("lief")

    def edit(name: str, content: bytes) -> tuple[str, bytes]:
        return name, content.replace(b"\0fmi3DoStep\0", b"\0fmi3DoStop\0") if name == LIBRARY else content

    found = findings(repack(fmu_path("integrator", 3), tmp_path / "x.fmu", edit), "binary.exports")
    assert [(finding.where, finding.what) for finding in found] == [(LIBRARY, "does not export fmi3DoStep")]


def test_names_that_windows_does_not_tell_apart(fmu_path: Get, tmp_path: Path) -> None:
    path = repack(fmu_path("integrator", 3), tmp_path / "x.fmu", lambda name, content: (name, content))
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("resources/a.txt", "")
        archive.writestr("resources/A.txt", "")
    assert [finding.where for finding in findings(path, "archive.case")] == ["resources/a.txt, resources/A.txt"]


@pytest.mark.parametrize(
    ("member", "rule"),
    [("../x", "archive.path"), ("modelDescription.xml/x", "archive.duplicate")],
)
def test_a_dangerous_archive_is_judged_and_not_read(fmu_path: Get, tmp_path: Path, member: str, rule: str) -> None:
    path = repack(fmu_path("integrator", 3), tmp_path / "x.fmu", lambda name, content: (name, content))
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr(member, "")
    report = check(path)
    assert [(finding.rule, finding.severity) for finding in report.findings] == [(rule, Severity.ERROR)]
    assert "schema" not in report.applied


@pytest.mark.parametrize("content", [b"", b"PK\3\4", b"text", os.urandom(1000)])
def test_what_is_no_fmu(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "x.fmu").write_bytes(content)
    assert [finding.rule for finding in check(tmp_path / "x.fmu").findings] == ["readable"]
