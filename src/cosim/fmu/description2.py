"""The modelDescription.xml of an FMI 2.0 FMU."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Sequence

from cosim.dae import Dae
from cosim.fmu import _description_parts as parts
from cosim.fmu.dependencies import Dependencies
from cosim.fmu.layout import Layout

_ELEMENTS = {
    "TYPE_REAL": "Real",
    "TYPE_INTEGER": "Integer",
    "TYPE_BOOLEAN": "Boolean",
    "TYPE_ENUMERATION": "Enumeration",
    "TYPE_COUNTER": "Integer",
}


def describe2(
    dae: Dae,
    layout: Layout,
    identifier: str,
    token: str,
    sources: Sequence[str] = (),
    fixed_step: float | None = None,
) -> bytes:
    """The XML document.

    Args:
        dae: the model.
        layout: its variables; value references are positions.
        identifier: the name of the binary.
        token: the GUID.
        sources: names of the C files to compile, if the FMU has its sources.
        fixed_step: the length of the solver's steps [s], ``None`` for error control.

    Raises:
        InputError: a variable's unit is not one.
    """
    root = parts.root_element(dae, identifier, "2.0", guid=token)
    root.set("numberOfEventIndicators", str(len(layout.indicators)))
    exchange = ET.SubElement(
        root,
        "ModelExchange",
        modelIdentifier=identifier,
        canNotUseMemoryManagementFunctions="true",
        canGetAndSetFMUstate="true",
        canSerializeFMUstate="true",
        providesDirectionalDerivative="true",
    )
    simulation = ET.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=identifier,
        canHandleVariableCommunicationStepSize="true",
        canNotUseMemoryManagementFunctions="true",
        canGetAndSetFMUstate="true",
        canSerializeFMUstate="true",
        maxOutputDerivativeOrder="1",
        providesDirectionalDerivative="true",
    )
    for interface in (exchange, simulation) if sources else ():
        files = ET.SubElement(interface, "SourceFiles")
        for name in sources:
            ET.SubElement(files, "File", name=name)
    parts.add_units(root, layout)
    types = parts.enumerations(layout)
    _types(root, types)
    parts.add_log_categories(root)
    parts.add_experiment(root, fixed_step)
    variables = ET.SubElement(root, "ModelVariables")
    names = {literals: name for name, literals in types.items()}
    for reference, slot in enumerate(layout.slots):
        variable = ET.SubElement(variables, "ScalarVariable", parts.general_attributes(reference, slot))
        ET.SubElement(variable, _ELEMENTS[slot.type], parts.typed_attributes(slot, names, 1))
    _structure(root, dae, layout)
    return parts.document(root)


def _types(root: ET.Element, enumerations: dict[str, tuple[str, ...]]) -> None:
    if not enumerations:
        return
    definitions = ET.SubElement(root, "TypeDefinitions")
    for name, literals in enumerations.items():
        element = ET.SubElement(ET.SubElement(definitions, "SimpleType", name=name), "Enumeration")
        for value, literal in enumerate(literals, start=1):
            ET.SubElement(element, "Item", name=literal, value=str(value))


def _structure(root: ET.Element, dae: Dae, layout: Layout) -> None:
    """Variables are named by their position from 1; a list without entries is left out."""
    structure = ET.SubElement(root, "ModelStructure")
    dependencies = Dependencies(dae, layout)
    outputs = [reference for reference, slot in enumerate(layout.slots) if slot.causality == "output"]
    for element, references, of in (
        ("Outputs", outputs, dependencies.of),
        ("Derivatives", layout.derivatives, dependencies.of),
        ("InitialUnknowns", parts.initial_unknowns(layout), dependencies.of_initial),
    ):
        if references:
            unknowns = ET.SubElement(structure, element)
            for reference in references:
                attributes = {"index": str(reference + 1)} | parts.dependencies(of(reference), 1)
                ET.SubElement(unknowns, "Unknown", attributes)
