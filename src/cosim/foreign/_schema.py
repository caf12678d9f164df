"""The schema of FMI, and where a model description breaks it."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import fmpy
from lxml import etree

_FOLDER = Path(fmpy.__file__).parent / "schema"
_SCHEMAS = {
    "1": "fmi1/fmiModelDescription.xsd",
    "2": "fmi2/fmi2ModelDescription.xsd",
    "3": "fmi3/fmi3ModelDescription.xsd",
}


class Violation(NamedTuple):
    """What breaks the schema in which line; ``is_missing`` if it is an attribute that has to be there."""

    text: str
    line: int
    is_missing: bool


def violations(root: etree._Element) -> list[Violation]:
    """Return where a model description breaks the schema of its FMI version; none if it has no known version."""
    name = _SCHEMAS.get(str(root.get("fmiVersion", "")).strip()[:1])
    if name is None:
        return []
    schema = etree.XMLSchema(file=str(_FOLDER / name))
    if schema.validate(root):
        return []
    return [
        Violation(str(entry.message).rstrip("."), int(entry.line), str(entry.type_name) == "SCHEMAV_CVC_COMPLEX_TYPE_4")
        for entry in schema.error_log
    ]
