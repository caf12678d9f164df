"""The modelDescription.xml of an FMI 3.0 FMU."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Sequence

from cosim.dae import Dae
from cosim.fmu import _description_parts as parts
from cosim.fmu.dependencies import Dependencies, Dependency
from cosim.fmu.layout import Layout

_ELEMENTS = {
    "TYPE_REAL": "Float64",
    "TYPE_INTEGER": "Int32",
    "TYPE_BOOLEAN": "Boolean",
    "TYPE_ENUMERATION": "Enumeration",
    "TYPE_COUNTER": "UInt64",
}


def describe(dae: Dae, layout: Layout, identifier: str, token: str, fixed_step: float | None = None) -> bytes:
    """The XML document.

    Args:
        dae: the model.
        layout: its variables; value references are positions.
        identifier: the name of the binary.
        token: the instantiation token.
        fixed_step: the length of the solver's steps [s], ``None`` for error control.

    Raises:
        InputError: a variable's unit is not one.
    """
    root = parts.root_element(dae, identifier, "3.0", instantiationToken=token)
    ET.SubElement(
        root,
        "ModelExchange",
        modelIdentifier=identifier,
        canGetAndSetFMUState="true",
        canSerializeFMUState="true",
        needsCompletedIntegratorStep="true",
        providesDirectionalDerivatives="true",
        providesAdjointDerivatives="true",
    )
    simulation = ET.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=identifier,
        canHandleVariableCommunicationStepSize="true",
        canGetAndSetFMUState="true",
        canSerializeFMUState="true",
        mightReturnEarlyFromDoStep="true",
        canReturnEarlyAfterIntermediateUpdate="true",
        providesIntermediateUpdate="true",
        hasEventMode="true",
        maxOutputDerivativeOrder="1",
        providesDirectionalDerivatives="true",
        providesAdjointDerivatives="true",
    )
    if fixed_step is not None:
        simulation.set("fixedInternalStepSize", repr(fixed_step))
    parts.add_units(root, layout)
    types = parts.enumerations(layout)
    _types(root, types)
    parts.add_log_categories(root)
    parts.add_experiment(root, fixed_step)
    variables = ET.SubElement(root, "ModelVariables")
    names = {literals: name for name, literals in types.items()}
    for reference, slot in enumerate(layout.slots):
        attributes = parts.general_attributes(reference, slot) | parts.typed_attributes(slot, names, 0)
        ET.SubElement(variables, _ELEMENTS[slot.type], attributes)
    _structure(root, dae, layout)
    return parts.document(root)


def _structure(root: ET.Element, dae: Dae, layout: Layout) -> None:
    structure = ET.SubElement(root, "ModelStructure")
    dependencies = Dependencies(dae, layout)

    def add(element: str, reference: int, found: Sequence[Dependency]) -> None:
        ET.SubElement(structure, element, {"valueReference": str(reference)} | parts.dependencies(found, 0))

    for reference, slot in enumerate(layout.slots):
        if slot.causality == "output":
            add("Output", reference, dependencies.of(reference))
    for reference in layout.derivatives:
        add("ContinuousStateDerivative", reference, dependencies.of(reference))
    for reference in parts.initial_unknowns(layout):
        add("InitialUnknown", reference, dependencies.of_initial(reference))
    for reference in layout.indicators:
        add("EventIndicator", reference, dependencies.of(reference))


def _types(root: ET.Element, enumerations: dict[str, tuple[str, ...]]) -> None:
    if not enumerations:
        return
    definitions = ET.SubElement(root, "TypeDefinitions")
    for name, literals in enumerations.items():
        element = ET.SubElement(definitions, "EnumerationType", name=name)
        for value, literal in enumerate(literals, start=1):
            ET.SubElement(element, "Item", name=literal, value=str(value))
