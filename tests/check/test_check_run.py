"""Rules that run the binary: an honest FMU has no finding, and each lie compiled into it is found by its rule."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from edited_fmus import Edit, repack, replacing

from cosim.archive import Archive
from cosim.check import Finding, Severity, check
from cosim.check._bench import Bench
from cosim.check._run_rules import RUN_RULES
from cosim.check._subject import Subject
from cosim.foreign import read_description

Get = Callable[..., Path]
CLAIMS = {
    2: 'canGetAndSetFMUstate="true" canSerializeFMUstate="true" providesDirectionalDerivative="true" '
    'maxOutputDerivativeOrder="1"',
    3: 'canGetAndSetFMUState="true" canSerializeFMUState="true" providesDirectionalDerivatives="true" '
    'providesAdjointDerivatives="true" maxOutputDerivativeOrder="1"',
}


def claiming(fmu_path: Get, tmp_path: Path, fmi: int, edit: Edit | None = None) -> Path:
    """Return the FMU that claims everything, with a change in its description."""
    path = repack(
        fmu_path("checked", fmi), tmp_path / "x.fmu", replacing("<CoSimulation ", f"<CoSimulation {CLAIMS[fmi]} ")
    )
    return path if edit is None else repack(path, tmp_path / "y.fmu", edit)


def found_here(path: Path, folder: Path, interface: str = "CoSimulation") -> list[Finding]:
    """Apply the rules in this process, which is quicker."""
    archive = Archive.open(path)
    archive.extract(folder)
    bench = Bench(Subject(archive, read_description(archive)), interface, folder)
    return [finding for rule in RUN_RULES for finding in rule.apply(bench)]


@pytest.mark.parametrize("fmi", [2, 3])
def test_nothing_is_found_in_an_honest_fmu(fmu_path: Get, tmp_path: Path, fmi: int) -> None:
    report = check(claiming(fmu_path, tmp_path, fmi))
    assert report.findings == ()
    assert {"run.state", "run.directional", "run.dependencies", "run.derivatives"} < set(report.applied)


LIES = [
    ("START_VALUE", "run.start", "gain", "starts at 2 in the description, at 2.5 in the binary"),
    ("NOT_REPEATED", "run.repeat", "", "differ in a second run: x, first after step 1"),
    ("NOT_RESET", "run.reset", "", "differ after a reset: x, first after step 1"),
    ("NOT_RESTORED", "run.state run.serialize", "", "are not restored with the state: x, first after step 1"),
    ("NOT_SERIALIZED", "run.serialize", "", "are not restored from bytes: x, first after step 1"),
    (
        "WRONG_DERIVATIVE",
        "run.directional",
        "y",
        "the derivative by u2 is 0.505, finite differences give 0.5",
    ),
    ("WRONG_ADJOINT", "run.adjoint", "y", "the adjoint derivative by u1 is -2, the directional 2"),
    ("EQUAL_STEPS", "run.variable-steps", "", "step 2 of changing length, 0.005 s, fails: "),
    ("ENDLESS_EVENTS", "run.event-mode", "", "asks for one more update of its discrete states, 100 times"),
    ("NO_NUMBER", "run", "", "outputs that are no finite numbers: x"),
    ("NO_SLOPES", "run.derivatives", "", "OutputDerivatives failed with status 3 (error)"),
    ("ANY_TOKEN", "run.token", "", "instantiates with a wrong token"),
]


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize(("lie", "rules", "where", "what"), LIES)
def test_lies_are_found(
    fmu_path: Get,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    fmi: int,
    lie: str,
    rules: str,
    where: str,
    what: str,
) -> None:
    if fmi == 2 and lie in ("WRONG_ADJOINT", "ENDLESS_EVENTS"):
        return  # FMI 2.0 has none of these
    monkeypatch.setenv("CHECKED_LIE", lie)
    found = found_here(claiming(fmu_path, tmp_path, fmi), tmp_path)
    assert [finding.rule for finding in found] == rules.split()
    assert found[0].where.startswith(where)
    assert what in found[0].what


DEATHS = [
    ("REFUSES", "run", "the FMU says: the pump is not primed"),
    ("CRASH", "run.crash", "crashes with SIGSEGV, while the rule run was tried"),
    pytest.param("ABORT", "run.crash", "crashes with SIGABRT, while the rule run was tried", marks=pytest.mark.slow),
    ("EXIT", "run.crash", "ends the process with the exit code 7, while the rule run was tried"),
    ("HANG", "run.hang", "has not come back after 1 s, while the rule run was tried"),
]


@pytest.mark.parametrize(("lie", "rule", "what"), DEATHS)
def test_an_fmu_that_fails_ends_its_own_process_only(
    fmu_path: Get, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, lie: str, rule: str, what: str
) -> None:
    monkeypatch.setenv("CHECKED_LIE", lie)
    report = check(claiming(fmu_path, tmp_path, 3), timeout=1.0 if lie == "HANG" else 60.0)
    assert [(finding.rule, finding.where) for finding in report.findings] == [(rule, "CoSimulation")]
    assert what in report.findings[0].what


def test_a_crash_in_one_rule_leaves_the_others_to_be_tried(
    fmu_path: Get, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CHECKED_LIE", "CRASH_IN_STATE")
    report = check(claiming(fmu_path, tmp_path, 3))
    assert [finding.what for finding in report.findings] == [
        "crashes with SIGSEGV, while the rule run.state was tried",
        "crashes with SIGSEGV, while the rule run.serialize was tried",
    ]
    assert "run.dependencies" in report.applied


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_dependency_that_is_not_declared(fmu_path: Get, tmp_path: Path, fmi: int) -> None:
    path = claiming(fmu_path, tmp_path, fmi, replacing('dependencies="1 2"', 'dependencies="1"'))
    assert [(finding.rule, finding.where, finding.what) for finding in found_here(path, tmp_path)] == [
        ("run.dependencies", "y", "changes with u2, which its dependencies leave out")
    ]


@pytest.mark.slow
def test_an_fmu_that_can_be_instantiated_only_once(
    fmu_path: Get, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each rule gets a process of its own, and those that need two instances are left out."""
    monkeypatch.setenv("CHECKED_LIE", "NOT_REPEATED")
    once = replacing("<CoSimulation ", '<CoSimulation canBeInstantiatedOnlyOncePerProcess="true" ')
    report = check(claiming(fmu_path, tmp_path, 3, once))
    assert report.findings == ()
    assert "run.repeat" not in report.applied
    assert "run.state" in report.applied


def test_an_fmu_that_needs_its_tool_is_not_run(fmu_path: Get, tmp_path: Path) -> None:
    edit = replacing("<CoSimulation ", '<CoSimulation needsExecutionTool="true" ')
    report = check(claiming(fmu_path, tmp_path, 3, edit))
    assert [(finding.rule, finding.severity, finding.what) for finding in report.findings] == [
        ("run.left-out", Severity.NOTE, "is not run: it needs its tool, cosim tests")
    ]


@pytest.mark.parametrize("fmi", [2, 3])
def test_model_exchange(fmu_path: Get, tmp_path: Path, fmi: int) -> None:
    """The description of this FMU says that nothing depends on anything, which the derivative of a height does."""
    path = repack(fmu_path("ball", fmi), tmp_path / "sound.fmu", replacing(' dependencies=""', ""))
    assert found_here(path, tmp_path / "sound", "ModelExchange") == []
    assert check(path, run=False).findings == ()
    found = found_here(fmu_path("ball", fmi), tmp_path / "lying", "ModelExchange")
    assert [(finding.rule, finding.where, finding.what) for finding in found] == [
        ("run.structure", where, f"changes with {known}, which its dependencies leave out")
        for where, known in (("h", "h"), ("der(h)", "v"), ("v", "v"))
    ]
    if fmi == 3:
        one_more = replacing("</ModelStructure>", '<EventIndicator valueReference="4"/>' * 2 + "</ModelStructure>")
        found = found_here(repack(path, tmp_path / "x.fmu", one_more), tmp_path / "wrong", "ModelExchange")
        assert [finding.what for finding in found] == ["the description has 2 event indicators, the binary 1"]
