"""From an archive to fmpy's ModelDescription, and what was amiss on the way."""

from __future__ import annotations

import io
import math
import zipfile
from typing import NamedTuple

import fmpy
from fmpy.model_description import ModelDescription
from lxml import etree

from cosim.archive import Archive, utf8_of
from cosim.errors import FmuError
from cosim.foreign._mend import Amiss, mend
from cosim.foreign._schema import Violation, violations

NAME = "modelDescription.xml"
SOURCES = "sources/buildDescription.xml"
MOST_ELEMENTS = 1_000_000
"""More elements of arrays than this are refused: a dimension is quickly written, and each element takes memory."""

RUN_CHECK = "run `cosim check` for all that is wrong with it"


class Reading(NamedTuple):
    """A model description, the XML it was read from (UTF-8), what was amiss, and what of the schema still is broken."""

    description: ModelDescription
    xml: bytes
    amiss: tuple[Amiss, ...]
    broken: tuple[Violation, ...]


def read_description(archive: Archive) -> Reading:
    """Read an FMU's model description; what breaks the schema without harm is mended and told.

    Raises FmuError if there is none, or it cannot be understood.
    """
    if NAME not in archive:
        raise FmuError(
            f"is not an FMU: it has no {NAME}{_elsewhere(archive)}; export the model again", file=archive.path
        )
    try:
        xml, amiss = utf8_of(archive.read(NAME), f"its {NAME}")
        sources, amiss_there = utf8_of(archive.read(SOURCES), f"its {SOURCES}") if SOURCES in archive else (None, [])
    except FmuError as error:
        raise error if error.file else FmuError(str(error), file=archive.path) from error
    told = [f"{NAME} {what}" for what in amiss] + [f"{SOURCES} {what}" for what in amiss_there]
    if archive.dotted:
        told.append("its files are packed with './' in front of their names")
    if archive.backslashed:
        told.append("its files are packed with backslashes in their names")
    found = [Amiss("vendor", what) for what in told]
    try:
        root = etree.fromstring(xml, etree.XMLParser(remove_comments=True, remove_pis=True))
        found += mend(root)
        broken = violations(root)
        found += _of_schema(broken)
        description = fmpy.read_model_description(_packed(etree.tostring(root), sources), validate=False)
    except Exception as error:  # fmpy meets what is wrong with all kinds of exceptions
        raise FmuError(f"its {NAME} cannot be read: {error}; {RUN_CHECK}", file=archive.path) from error
    elements = sum(math.prod(variable.shape) for variable in description.modelVariables)
    if elements > MOST_ELEMENTS:
        raise FmuError(f"its arrays have {elements} elements; {MOST_ELEMENTS} are accepted", file=archive.path)
    return Reading(description, xml, tuple(found), tuple(broken))


def _of_schema(broken: list[Violation]) -> list[Amiss]:
    """Sum up where the schema is broken: the first place, and how many there are."""
    if not broken:
        return []
    places = f"{len(broken)} places, first" if len(broken) > 1 else "one place,"
    return [Amiss("schema", f"{NAME} breaks the schema of FMI in {places} line {broken[0].line}: {broken[0].text}")]


def _elsewhere(archive: Archive) -> str:
    """Tell where the description is if someone has packed the folder instead of what is in it."""
    for name in archive.sizes:
        if name.endswith(f"/{NAME}"):
            return f" at the top, but {name}: pack what is in that folder"
    return ""


def _packed(xml: bytes, sources: bytes | None) -> io.BytesIO:
    """Return an archive with what fmpy reads, so that it reads what was checked and mended."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr(NAME, xml)
        if sources is not None:
            archive.writestr(SOURCES, sources)
    return stream
