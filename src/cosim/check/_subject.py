"""What the rules on an FMU's content look at."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from fmpy.model_description import CoSimulation, ModelDescription, ModelExchange, ModelVariable
from lxml import etree

from cosim.archive import Archive
from cosim.foreign import Reading

INTERFACES = {
    "CoSimulation": "coSimulation",
    "ModelExchange": "modelExchange",
    "ScheduledExecution": "scheduledExecution",
}
"""The interfaces by their element in the XML, with their name in fmpy."""


@dataclass(frozen=True)
class Subject:
    """An FMU that was read: the ``archive``, and what was ``read`` from its model description."""

    archive: Archive
    read: Reading

    @property
    def description(self) -> ModelDescription:
        """The model description, mended."""
        return self.read.description

    @property
    def fmi(self) -> int:
        """The major version of FMI: 1, 2 or 3."""
        return int(self.description.fmiMajorVersion)

    @cached_property
    def root(self) -> etree._Element:
        """The model description as it was written."""
        return etree.fromstring(self.read.xml)

    @property
    def interfaces(self) -> dict[str, CoSimulation | ModelExchange]:
        """The claimed interfaces by their element's name."""
        found = {name: getattr(self.description, attribute, None) for name, attribute in INTERFACES.items()}
        return {name: interface for name, interface in found.items() if interface is not None}

    @cached_property
    def variables(self) -> list[ModelVariable]:
        """The variables without aliases."""
        return [variable for variable in self.description.modelVariables if not variable.alias]

    def claims(self, interface: str, capability: str) -> bool:
        """Tell whether an interface claims a capability; fmpy does not read all of them, so the XML is asked.

        Capital letters and a plural, which differ from FMI 2.0 to 3.0, make no difference.
        """
        wanted = capability.lower().rstrip("s")
        for name, value in self.element(interface).attrib.items():
            if str(name).lower().rstrip("s") == wanted:
                return value.strip().lower() in ("true", "1")
        return False

    def element(self, interface: str) -> etree._Element:
        """Return an interface's element as it was written, whatever its namespace; an empty one if there is none."""
        found = self.root.iterfind(f"{{*}}{interface}")
        return next(found, etree.Element(interface))

    def number(self, interface: str, attribute: str) -> int:
        """Return a whole number that an interface claims, such as an order; 0 if it claims none."""
        text = str(getattr(self.interfaces[interface], attribute, 0) or 0)
        return int(text) if text.isdigit() else 0

    @cached_property
    def folders(self) -> dict[str, list[str]]:
        """The libraries, by the folder in ``binaries`` that holds them."""
        found: dict[str, list[str]] = {}
        for name in self.archive.sizes:
            parts = name.split("/")
            if parts[0] == "binaries" and len(parts) == 3:
                found.setdefault(parts[1], []).append(parts[2])
        return found


def place(variable: Any) -> str:  # noqa: ANN401 - fmpy has no types
    """Return a variable's name and line, for a finding."""
    line = f" (line {variable.sourceline})" if variable.sourceline else ""
    return f"{variable.name}{line}"
