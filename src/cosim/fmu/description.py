"""The modelDescription.xml of an FMI 3.0 Co-Simulation FMU."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from cosim import __version__
from cosim.dae import Dae
from cosim.fmu.layout import Layout, Slot
from cosim.modelica.flat import Variable
from cosim.units import linear_map, parse

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
    root = ET.Element(
        "fmiModelDescription",
        fmiVersion="3.0",
        modelName=identifier,
        instantiationToken=token,
        generationTool=f"wiper-cosim {__version__}",
        variableNamingConvention="structured",
    )
    if dae.description:
        root.set("description", dae.description)
    ET.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=identifier,
        canHandleVariableCommunicationStepSize="true",
        canGetAndSetFMUState="true",
        canSerializeFMUState="true",
        hasEventMode="true",
    )
    _units(root, layout)
    _types(root, layout)
    ET.SubElement(root, "DefaultExperiment", startTime="0", tolerance="1e-06")
    variables = ET.SubElement(root, "ModelVariables")
    for reference, slot in enumerate(layout.slots):
        _variable(variables, reference, slot, dae)
    structure = ET.SubElement(root, "ModelStructure")
    for element, wanted in (("Output", {"output"}), ("InitialUnknown", {"output", "calculatedParameter"})):
        for reference, slot in enumerate(layout.slots):
            if slot.causality in wanted:
                ET.SubElement(structure, element, valueReference=str(reference))
    ET.indent(root)
    text: bytes = ET.tostring(root, encoding="utf-8", xml_declaration=True)
    return text + b"\n"


def _declarations(layout: Layout) -> list[Variable]:
    return [slot.scalar.declaration for slot in layout.slots if slot.scalar is not None]


def _units(root: ET.Element, layout: Layout) -> None:
    units = sorted({v.unit for v in _declarations(layout) if v.type == "Real" and v.unit} | {"s"})
    definitions = ET.SubElement(root, "UnitDefinitions")
    for name in units:
        unit = parse(name)
        element = ET.SubElement(definitions, "Unit", name=name)
        base = {key: str(exponent) for key, exponent in unit.exponents.items() if exponent}
        if unit.factor != 1.0:
            base["factor"] = repr(unit.factor)
        if unit.offset != 0.0:
            base["offset"] = repr(unit.offset)
        ET.SubElement(element, "BaseUnit", base)
        for display in sorted({v.display_unit for v in _declarations(layout) if v.unit == name and v.display_unit}):
            factor, offset = linear_map(unit, parse(display))
            shown = ET.SubElement(element, "DisplayUnit", name=display, factor=repr(factor))
            if offset != 0.0:
                shown.set("offset", repr(offset))


def _types(root: ET.Element, layout: Layout) -> None:
    enumerations = {v.literals: v for v in _declarations(layout) if v.type == "Enumeration"}
    if not enumerations:
        return
    definitions = ET.SubElement(root, "TypeDefinitions")
    for literals in enumerations:
        element = ET.SubElement(definitions, "EnumerationType", name=_type_name(literals))
        for value, literal in enumerate(literals, start=1):
            ET.SubElement(element, "Item", name=literal, value=str(value))


def _type_name(literals: tuple[str, ...]) -> str:
    return "Enumeration_" + "_".join(literals)


def _variable(variables: ET.Element, reference: int, slot: Slot, dae: Dae) -> None:
    element = ET.SubElement(
        variables,
        _ELEMENTS[slot.type],
        name=slot.name,
        valueReference=str(reference),
        causality=slot.causality,
        variability=slot.variability,
    )
    if slot.description:
        element.set("description", slot.description)
    if slot.initial is not None:
        element.set("initial", slot.initial)
    if slot.store == "STORE_TIME":
        element.set("unit", "s")
    declaration = slot.scalar.declaration if slot.scalar is not None else None
    if declaration is not None and declaration.type == "Enumeration":
        element.set("declaredType", _type_name(declaration.literals))
    if declaration is not None and declaration.type == "Real":
        if declaration.unit:
            element.set("unit", declaration.unit)
            if declaration.display_unit:
                element.set("displayUnit", declaration.display_unit)
        if declaration.quantity:
            element.set("quantity", declaration.quantity)
        for attribute, expression in (("min", declaration.minimum), ("max", declaration.maximum)):
            value = getattr(expression, "value", None)
            if isinstance(value, int | float) and not isinstance(value, bool):
                element.set(attribute, repr(float(value)))
    if slot.start is not None:
        element.set("start", _start(slot))


def _start(slot: Slot) -> str:
    assert slot.start is not None
    if slot.type == "TYPE_BOOLEAN":
        return "true" if slot.start else "false"
    return repr(float(slot.start)) if slot.type == "TYPE_REAL" else str(int(slot.start))
