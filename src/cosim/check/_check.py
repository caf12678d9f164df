"""From an FMU to a report: one group of rules after another, as far as the FMU can be followed."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lxml import etree

from cosim.archive import Archive, utf8_of
from cosim.check._archive_rules import ARCHIVE_RULES
from cosim.check._binary_rules import BINARY_RULES
from cosim.check._description_rules import DESCRIPTION_RULES
from cosim.check._rules import Finding, Rule, Severity
from cosim.check._run_rules import RUN_RULES
from cosim.check._schema_rules import SCHEMA_RULES
from cosim.check._subject import Subject
from cosim.check._trial import EXTRA, run_trials
from cosim.errors import FmuError
from cosim.foreign import NAME, read_description, violations

READABLE = "readable"
"""The rule that an FMU breaks if nothing more can be said of it."""


@dataclass(frozen=True)
class Report:
    """What was found in an FMU: the ``findings``, the worst first, and the ids of the rules ``applied``."""

    path: Path
    findings: tuple[Finding, ...]
    applied: tuple[str, ...]

    def count(self, severity: Severity) -> int:
        """Return the number of findings of one severity."""
        return sum(finding.severity is severity for finding in self.findings)


def check(path: Path | str, *, run: bool = True, timeout: float = 30.0) -> Report:
    """Apply all rules to an FMU; with ``run`` also those that run its binary, in a process of its own.

    ``timeout`` [s] is how long each of these may take. Raises FmuError only if there is no such file; whatever else is
    wrong is a finding.
    """
    path = Path(path)
    if not path.is_file():
        raise FmuError("there is no such FMU", file=path)
    findings: list[Finding] = []
    applied: list[str] = []
    try:
        archive = Archive.inspect(path)
        _apply(ARCHIVE_RULES, archive, findings, applied)
        if not archive.dangers:
            subject = Subject(archive, read_description(archive))
            for group in (SCHEMA_RULES, DESCRIPTION_RULES, BINARY_RULES):
                _apply(group, subject, findings, applied)
            if run:
                found, tried = run_trials(subject, timeout)
                findings += found
                applied += tried
    except FmuError as error:
        findings.append(_unreadable(str(error).removeprefix(f"{path}: ")))
        findings += _of_schema(path)
    applied.insert(0, READABLE)
    findings.sort(key=lambda finding: -finding.severity)
    return Report(path, tuple(findings), tuple(applied))


def rules() -> list[tuple[str, Severity, str]]:
    """Return all rules in the order they are applied: id, severity, and what has to be so."""
    groups: list[list[Rule[Any]]] = [ARCHIVE_RULES, SCHEMA_RULES, DESCRIPTION_RULES, BINARY_RULES, RUN_RULES]
    first = (
        READABLE,
        Severity.ERROR,
        "The FMU is a whole zip archive, with a model description that can be understood.",
    )
    return [first, *EXTRA, *((rule.id, rule.severity, rule.text) for group in groups for rule in group)]


def _apply(group: list[Rule[Any]], subject: object, findings: list[Finding], applied: list[str]) -> None:
    for rule in group:
        findings += rule.apply(subject)
        applied.append(rule.id)


def _of_schema(path: Path) -> list[Finding]:
    """Return where an unreadable model description breaks the schema, which may say why; none if it is no XML."""
    try:
        root = etree.fromstring(utf8_of(Archive.open(path).read(NAME), NAME)[0])
    except (FmuError, KeyError, etree.XMLSyntaxError):
        return []
    return [
        Finding("schema", Severity.WARNING, one.text, f"{NAME}, line {one.line}", "export the model again")
        for one in violations(root)
    ]


def _unreadable(text: str) -> Finding:
    what, _, remedy = text.rpartition("; ")
    return Finding(READABLE, Severity.ERROR, what or text, "", remedy if what else "")
