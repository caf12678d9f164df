"""``cosim check``: what is wrong with an FMU, as a table or JSON."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from rich.console import Console
from rich.table import Table

from cosim.check import Finding, Report, Severity, check
from cosim.cli._builtin import locate
from cosim.cli._screen import Screen
from cosim.errors import FmuError

_WIDTH = 100
_MOST_OF_A_RULE = 10
"""Findings of one rule that the table shows; JSON has all."""


def check_fmu(name: str, screen: Screen, *, strict: bool, run: bool, timeout: float) -> int:
    """Check an FMU, a path or the name of a built-in one; return 2 if it has errors, with ``strict`` warnings, too."""
    path = Path(name)
    if path.suffix.lower() != ".fmu" and not path.is_file():
        with screen.working(f"getting {name} ready"):
            path = locate(name)
    with screen.working(f"checking {path}"):
        report = check(path, run=run, timeout=timeout)
    bad = report.count(Severity.ERROR) + (report.count(Severity.WARNING) if strict else 0)
    exit_code = FmuError.exit_code if bad else 0
    screen.document(
        {
            "fmu": str(path),
            "exit_code": exit_code,
            "counts": {severity.name.lower(): report.count(severity) for severity in reversed(Severity)},
            "findings": [_plain(finding) for finding in report.findings],
            "rules": list(report.applied),
        }
    )
    if screen.talks:
        _print(report)
    elif not screen.as_json:
        for finding in report.findings:
            if finding.severity is Severity.ERROR:
                screen.error(f"{path}: {finding.rule}: {_sentence(finding)}")
    return exit_code


def _plain(finding: Finding) -> dict[str, str]:
    return {
        "rule": finding.rule,
        "severity": finding.severity.name.lower(),
        "where": finding.where,
        "what": finding.what,
        "remedy": finding.remedy,
    }


def _sentence(finding: Finding) -> str:
    where = f"{finding.where}: " if finding.where else ""
    return f"{where}{finding.what}" + (f"; {finding.remedy}" if finding.remedy else "")


def _print(report: Report) -> None:
    console = Console(highlight=False, markup=False)
    console.width = min(console.width, _WIDTH) if console.is_terminal else _WIDTH
    if report.findings:
        table = Table(box=None, padding=(0, 1), pad_edge=False)
        table.add_column("severity")
        table.add_column("rule", no_wrap=True)
        table.add_column("finding", overflow="fold")
        counts: Counter[str] = Counter()
        for finding in report.findings:
            counts[finding.rule] += 1
            if counts[finding.rule] <= _MOST_OF_A_RULE:
                table.add_row(finding.severity.name.lower(), finding.rule, _sentence(finding))
        for rule, count in counts.items():
            if count > _MOST_OF_A_RULE:
                table.add_row("", rule, f"and {count - _MOST_OF_A_RULE} more; --json shows all")
        console.print(table)
        console.print()
    told = [f"{count} {severity.name.lower()}{'s' * (count > 1)}" for severity, count in _counts(report) if count]
    applied = len(report.applied)
    found = ", ".join(told) or "nothing found"
    console.print(f"{report.path}: {found} by {applied} rule{'s' * (applied > 1)}", soft_wrap=True)


def _counts(report: Report) -> list[tuple[Severity, int]]:
    return [(severity, report.count(severity)) for severity in reversed(Severity)]
