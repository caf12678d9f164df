"""The modelDescription.xml of an FMI 3.0 Co-Simulation FMU."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from cosim.dae import Dae
from cosim.fmu import _description_parts as parts
from cosim.fmu.layout import Layout

_ELEMENTS = {
    "TYPE_REAL": "Float64",
    "TYPE_INTEGER": "Int32",
    "TYPE_BOOLEAN": "Boolean",
    "TYPE_ENUMERATION": "Enumeration",
    "TYPE_COUNTER": "UInt64",
}


def describe(dae: Dae, layout: Layout, identifier: str, token: str) -> bytes:
    """The XML document.

    Args:
        dae: the model.
        layout: its variables; value references are positions.
        identifier: the name of the binary.
        token: the instantiation token.

    Raises:
        InputError: a variable's unit is not one.
    """
    root = parts.root_element(dae, identifier, "3.0", instantiationToken=token)
    ET.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=identifier,
        canHandleVariableCommunicationStepSize="true",
        canGetAndSetFMUState="true",
        canSerializeFMUState="true",
        hasEventMode="true",
    )
    parts.add_units(root, layout)
    types = parts.enumerations(layout)
    _types(root, types)
    parts.add_log_categories(root, discard=False)
    parts.add_experiment(root)
    variables = ET.SubElement(root, "ModelVariables")
    names = {literals: name for name, literals in types.items()}
    for reference, slot in enumerate(layout.slots):
        attributes = parts.general_attributes(reference, slot) | parts.typed_attributes(slot, names)
        ET.SubElement(variables, _ELEMENTS[slot.type], attributes)
    structure = ET.SubElement(root, "ModelStructure")
    for element, wanted in (("Output", {"output"}), ("InitialUnknown", {"output", "calculatedParameter"})):
        for reference, slot in enumerate(layout.slots):
            if slot.causality in wanted:
                ET.SubElement(structure, element, valueReference=str(reference))
    return parts.document(root)


def _types(root: ET.Element, enumerations: dict[str, tuple[str, ...]]) -> None:
    if not enumerations:
        return
    definitions = ET.SubElement(root, "TypeDefinitions")
    for name, literals in enumerations.items():
        element = ET.SubElement(definitions, "EnumerationType", name=name)
        for value, literal in enumerate(literals, start=1):
            ET.SubElement(element, "Item", name=literal, value=str(value))
