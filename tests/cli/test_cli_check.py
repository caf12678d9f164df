"""``cosim check``: what a user sees, the exit code, and the page that lists the rules."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import Result

from cosim import check
from cosim.check import Finding, Report, Severity

Cosim = Callable[..., Result]
DOCS = Path(__file__).parents[2] / "docs"
ERROR = Finding("run.start", Severity.ERROR, "starts at 1", "x (line 7)", "mend it")
WARNING = Finding("schema", Severity.WARNING, "is not allowed", "", "")


@pytest.fixture
def found(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Callable[..., None]:
    """Let the check find what a test says."""
    (tmp_path / "x.fmu").touch()

    def let(*findings: Finding) -> None:
        report = Report(Path("x.fmu"), findings, ("run.start", "schema"))
        monkeypatch.setattr("cosim.cli._check.check", lambda path, *, run, timeout: report)

    return let


def test_the_table(cosim: Cosim, found: Callable[..., None]) -> None:
    found(ERROR, WARNING)
    done = cosim("check", "x.fmu")
    assert done.exit_code == 2
    assert [line.rstrip() for line in done.stdout.splitlines()] == [
        "severity  rule       finding",
        "error     run.start  x (line 7): starts at 1; mend it",
        "warning   schema     is not allowed",
        "",
        "x.fmu: 1 error, 1 warning by 2 rules",
    ]


@pytest.mark.parametrize(
    ("findings", "options", "code"),
    [
        ((), (), 0),
        ((), ("--strict",), 0),
        ((WARNING,), (), 0),
        ((WARNING,), ("--strict",), 2),
        ((ERROR,), (), 2),
    ],
)
def test_the_exit_code_tells_the_severity(
    cosim: Cosim, found: Callable[..., None], findings: tuple[Finding, ...], options: tuple[str, ...], code: int
) -> None:
    found(*findings)
    assert cosim("check", "x.fmu", *options).exit_code == code
    document = json.loads(cosim("check", "x.fmu", "--json", *options).stdout)
    assert document["exit_code"] == code
    assert document["counts"] == {
        "error": findings.count(ERROR),
        "warning": findings.count(WARNING),
        "note": 0,
    }


def test_json_has_every_finding(cosim: Cosim, found: Callable[..., None]) -> None:
    found(*[ERROR] * 30)
    document = json.loads(cosim("check", "x.fmu", "--json").stdout)
    assert (
        document["findings"]
        == [
            {
                "rule": "run.start",
                "severity": "error",
                "where": "x (line 7)",
                "what": "starts at 1",
                "remedy": "mend it",
            }
        ]
        * 30
    )
    text = cosim("check", "x.fmu").stdout
    assert text.count("starts at 1") == 10
    assert "and 20 more; --json shows all" in text


def test_quiet_shows_errors_only(cosim: Cosim, found: Callable[..., None]) -> None:
    found(ERROR, WARNING)
    done = cosim("check", "x.fmu", "--quiet")
    assert (done.stdout, done.stderr) == ("", "error: x.fmu: run.start: x (line 7): starts at 1; mend it\n")


def test_there_is_no_such_file(cosim: Cosim) -> None:
    done = cosim("check", "nowhere.fmu")
    assert (done.exit_code, done.stderr) == (2, "error: nowhere.fmu: there is no such FMU\n")


def test_the_page_lists_the_rules(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(DOCS))
    monkeypatch.delitem(sys.modules, "check_rules", raising=False)
    import check_rules

    assert check_rules.PAGE.read_text(encoding="utf-8") == check_rules.page()
    names = [name for name, _, _ in check.rules()]
    assert len(set(names)) == len(names)
    assert all(text.endswith(".") and len(text) < 120 for _, _, text in check.rules())
