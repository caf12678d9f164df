"""What the model description of an FMI 1.0 FMU says beyond what fmpy reads of it."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass

_CAPABILITIES = (
    "canHandleVariableCommunicationStepSize",
    "canBeInstantiatedOnlyOncePerProcess",
    "canInterpolateInputs",
)


@dataclass(frozen=True)
class Facts:
    """``capabilities`` in the names of FMI 2.0; ``negated`` are the variables that are another's negative."""

    capabilities: dict[str, object]
    negated: frozenset[str]


def facts_of(description: bytes) -> Facts:
    """Return them from a modelDescription.xml."""
    root = ET.fromstring(description)
    found = root.find("Implementation/*/Capabilities")
    capabilities: dict[str, object] = {
        name: found is not None and found.get(name) in ("true", "1") for name in _CAPABILITIES
    }
    capabilities["needsExecutionTool"] = root.find("Implementation/CoSimulation_Tool") is not None
    variables = root.iterfind("ModelVariables/ScalarVariable[@alias='negatedAlias']")
    return Facts(capabilities, frozenset(variable.get("name", "") for variable in variables))
