"""Rules on the XML: the schema of FMI, the known freedoms of vendors, what fmpy calls a problem."""

from __future__ import annotations

import re
from collections.abc import Iterator

from fmpy.validation import validate_model_description

from cosim.check._rules import Found, Rules, Severity
from cosim.check._subject import Subject
from cosim.foreign import NAME, Violation

_REPORT = "report it to the tool that wrote the FMU"
_LENIENT = ("is not defined", "InitialUnknowns", 'attribute "derivative"')
"""Parts of fmpy's problems that importers live with."""

SCHEMA_RULES: Rules[Subject] = Rules()


def _found(violation: Violation) -> Found:
    return Found(violation.text, f"{NAME}, line {violation.line}", _REPORT)


@SCHEMA_RULES("schema.missing", Severity.ERROR)
def missing(subject: Subject) -> Iterator[Found]:
    """All attributes that the schema of FMI requires are there."""
    yield from (_found(one) for one in subject.read.broken if one.is_missing)


@SCHEMA_RULES("schema", Severity.WARNING)
def schema(subject: Subject) -> Iterator[Found]:
    """The model description follows the schema of FMI: no other elements and attributes, in order, values as typed."""
    yield from (_found(one) for one in subject.read.broken if not one.is_missing)


@SCHEMA_RULES("vendor", Severity.WARNING)
def vendor(subject: Subject) -> Iterator[Found]:
    """Nothing has to be mended that can mean one thing only: encodings, spellings, variabilities, start values."""
    yield from (Found(one.text, NAME, _REPORT) for one in subject.read.amiss if one.id == "vendor")


@SCHEMA_RULES("references.unknown", Severity.ERROR)
def unknown(subject: Subject) -> Iterator[Found]:
    """The model structure and derivatives refer to variables that are there."""
    yield from (Found(one.text, NAME, _REPORT) for one in subject.read.amiss if one.id == "references")


def _problems(subject: Subject) -> Iterator[tuple[str, bool]]:
    if subject.fmi == 1:
        return
    try:
        problems = validate_model_description(subject.description, validate_model_structure=True)
    except Exception as error:  # fmpy takes for granted what other rules look at
        problems = [f"fmpy cannot look at the semantics: {error}"]
    for problem in problems:
        yield problem, any(part in problem for part in _LENIENT)


def _of_fmpy(problem: str) -> Found:
    where = re.search(r"line (\d+)", problem)
    return Found(problem, f"{NAME}, line {where[1]}" if where else NAME, _REPORT)


@SCHEMA_RULES("semantics", Severity.ERROR)
def semantics(subject: Subject) -> Iterator[Found]:
    """Names and value references are unique, start values there, causality, variability and initial go together."""
    yield from (_of_fmpy(problem) for problem, lenient in _problems(subject) if not lenient)


@SCHEMA_RULES("semantics.lenient", Severity.WARNING)
def lenient(subject: Subject) -> Iterator[Found]:
    """Units are defined and InitialUnknowns complete; importers live without."""
    yield from (_of_fmpy(problem) for problem, lenient in _problems(subject) if lenient)
