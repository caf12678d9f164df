"""The XML files of an SSP: parsed without entities, held against the published schemas, and read by element."""

from __future__ import annotations

import importlib.util
import re
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from cosim.archive import utf8_of
from cosim.errors import FmuWarning, InputError

_STANDARD = "http://ssp-standard.org/SSP1/SystemStructure"
SPACES = {
    "ssc": f"{_STANDARD}Common",
    "ssd": f"{_STANDARD}Description",
    "ssv": f"{_STANDARD}ParameterValues",
    "ssm": f"{_STANDARD}ParameterMapping",
}
_ROOTS = {
    "ssd": "SystemStructureDescription",
    "ssv": "ParameterSet",
    "ssm": "ParameterMapping",
}
# The packages that the schemas come with, and where in them.
_SCHEMAS = {"1.0": ("fmpy", "ssp/schema"), "2.0": ("pyssp_standard", "resources/ssp2")}
_LARGEST = 64 << 20


@dataclass(frozen=True)
class Place:
    """Where something stands in an SSP: ``file`` such as ``x.ssp/SystemStructure.ssd``, and the line, from 1."""

    file: str
    line: int | None = None

    def fail(self, message: str) -> InputError:
        """Make the error for this place."""
        return InputError(message, file=self.file, line=self.line)

    def warn(self, message: str) -> None:
        """Warn of what the standard forbids, but does no harm (`FmuWarning`)."""
        where = self.file if self.line is None else f"{self.file}:{self.line}"
        warnings.warn(f"{where}: {message}", FmuWarning, stacklevel=3)


class Node:
    """An element of an XML file, with its place; names are ``prefix:Name`` with the prefixes of `SPACES`."""

    def __init__(self, element: Any, file: str) -> None:  # noqa: ANN401
        """Wrap an element of lxml; users call `parse`."""
        self._element = element
        self.place = Place(file, element.sourceline)

    @property
    def name(self) -> str:
        """The element's name without its namespace."""
        return re.sub(r"^\{.*\}", "", str(self._element.tag))

    def text(self, attribute: str, default: str = "") -> str:
        """Return an attribute."""
        return str(self._element.get(attribute, default))

    def has(self, attribute: str) -> bool:
        """Tell whether there is an attribute."""
        return self._element.get(attribute) is not None

    def number(self, attribute: str, default: float) -> float:
        """Return an attribute as a number; the schema has made sure that it is one."""
        return float(self._element.get(attribute, default))

    def flag(self, attribute: str) -> bool:
        """Return a Boolean attribute, false by default."""
        return self.text(attribute).strip() in ("true", "1")

    def child(self, path: str) -> Node | None:
        """Return the first element at a path such as ``ssd:Connectors``."""
        found = self._element.find(path, SPACES)
        return None if found is None else Node(found, self.place.file)

    def children(self, path: str) -> Iterator[Node]:
        """Return all elements at a path, in the order of the file."""
        for found in self._element.iterfind(path, SPACES):
            yield Node(found, self.place.file)

    def of(self, prefix: str) -> Iterator[Node]:
        """Return the elements directly inside that are of a namespace."""
        for found in self._element.iterchildren(f"{{{SPACES[prefix]}}}*"):
            yield Node(found, self.place.file)

    def inline(self, kind: str) -> Node | None:
        """Return a file of a kind, ``ssv`` or ``ssm``, that stands inside this element, held against its schema."""
        found = self.child(f"{kind}:{_ROOTS[kind]}")
        if found is not None:
            found._validate(kind)
        return found

    def _validate(self, kind: str) -> None:
        version = self.text("version")
        if version != "2.0" and not version.startswith("1."):
            raise self.place.fail(
                f"{self.name} is of version '{version}' of the SSP standard; 1.0 and 2.0 are read; export it again"
            )
        validator = _schema(kind, "2.0" if version == "2.0" else "1.0")
        if not validator.validate(self._element):
            first = validator.error_log[0]
            text = re.sub(r"\{[^{}]*\}", "", first.message)
            raise InputError(
                f"does not fit the schema of SSP {version}: {text} Correct it, or export it again",
                file=self.place.file,
                line=first.line or None,
            )


def parse(content: bytes, file: str, kind: str) -> Node:
    """Read a file of a kind (``ssd``, ``ssv`` or ``ssm``) and hold it against the schema of its version.

    Raises `InputError` if it is not XML, has a document type (and so entities), is of another kind or version, or does
    not fit the schema; warns (`FmuWarning`) of an encoding that the standard forbids.
    """
    from lxml import etree

    if len(content) > _LARGEST:
        raise InputError(f"has {len(content) >> 20} MiB; {_LARGEST >> 20} MiB are accepted", file=file)
    try:
        utf8, amiss = utf8_of(content, "it")
    except InputError as error:
        raise InputError(str(error), file=file) from error
    for what in amiss:
        Place(file).warn(what)
    parser = etree.XMLParser(
        encoding="utf-8",
        resolve_entities=False,
        no_network=True,
        load_dtd=False,
        huge_tree=False,
        remove_comments=True,
        remove_pis=True,
    )
    try:
        element = etree.fromstring(utf8, parser)
    except etree.XMLSyntaxError as error:
        raise InputError(
            f"is not well-formed XML: {error.msg}; export it again", file=file, line=error.lineno
        ) from None
    root = Node(element, file)
    wanted = _ROOTS[kind]
    if element.tag != f"{{{SPACES[kind]}}}{wanted}":
        raise root.place.fail(f"is not a .{kind} file: its root is '{root.name}', expected '{wanted}' of SSP")
    root._validate(kind)
    return root


@lru_cache(maxsize=8)
def _schema(kind: str, version: str) -> Any:  # noqa: ANN401
    """Return the schema for a kind of file, from the package that ships it."""
    from lxml import etree

    package, folder = _SCHEMAS[version]
    found = importlib.util.find_spec(package)
    if found is None or found.origin is None:
        raise InputError(f"the schemas of SSP {version} are missing; install them with 'pip install {package}'")
    name = SPACES[kind].rpartition("/")[2]
    return etree.XMLSchema(file=str(Path(found.origin).parent / folder / f"{name}.xsd"))
