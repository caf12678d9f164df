"""What the modelDescription.xml of FMI 2.0 and of FMI 3.0 have in common."""

from __future__ import annotations

import itertools
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence

from cosim import __version__
from cosim.dae import Dae
from cosim.fmu.dependencies import Dependency
from cosim.fmu.layout import Layout, Slot
from cosim.modelica.flat import Variable
from cosim.units import linear_map, parse

_LOG_CATEGORIES = {
    "logStatusError": "What failed, and why",
    "logStatusWarning": "Assertions of the model that are warnings",
    "logStatusDiscard": "What could not be computed at a trial point; steps that terminate() has ended early",
    "logEvents": "State events, with the relations that changed",
}


def root_element(dae: Dae, identifier: str, fmi: str, **token: str) -> ET.Element:
    """The root, with the attributes that all FMI versions know and the version's own name of the token."""
    root = ET.Element(
        "fmiModelDescription",
        token,
        fmiVersion=fmi,
        modelName=identifier,
        generationTool=f"wiper-cosim {__version__}",
        variableNamingConvention="structured",
    )
    if dae.description:
        root.set("description", dae.description)
    return root


def add_units(root: ET.Element, layout: Layout) -> None:
    """Add the units of all variables.

    Raises:
        InputError: a variable's unit is not one.
    """
    declared = {v.unit for v in declarations(layout) if v.type == "Real" and v.unit}
    units = sorted(declared | {slot.unit for slot in layout.slots if slot.unit} | {"s"})
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
        for display in sorted({v.display_unit for v in declarations(layout) if v.unit == name and v.display_unit}):
            factor, offset = linear_map(unit, parse(display))
            shown = ET.SubElement(element, "DisplayUnit", name=display, factor=repr(factor))
            if offset != 0.0:
                shown.set("offset", repr(offset))


def add_log_categories(root: ET.Element) -> None:
    """Add what the runtime logs."""
    categories = ET.SubElement(root, "LogCategories")
    for name, description in _LOG_CATEGORIES.items():
        ET.SubElement(categories, "Category", name=name, description=description)


def add_experiment(root: ET.Element, fixed_step: float | None) -> None:
    """Add the default experiment; with a fixed step [s], that is the step size to take."""
    experiment = ET.SubElement(root, "DefaultExperiment", startTime="0", tolerance="1e-06")
    if fixed_step is not None:
        experiment.set("stepSize", repr(fixed_step))


def initial_unknowns(layout: Layout) -> list[int]:
    """Value references of what is computed in Initialization Mode, as both FMI versions list it."""
    wanted = {"output", "calculatedParameter"}
    derivatives = layout.derivatives
    states = {layout.slots[reference].derivative_of for reference in derivatives}
    return [
        k
        for k, slot in enumerate(layout.slots)
        if (slot.causality in wanted or k in states or k in derivatives) and slot.initial == "calculated"
    ]


def dependencies(found: Sequence[Dependency], first: int) -> dict[str, str]:
    """The attributes that tell what an unknown depends on; variables count from ``first``."""
    attributes = {"dependencies": " ".join(str(d.reference + first) for d in found)}
    if found:
        attributes["dependenciesKind"] = " ".join(d.kind.name.lower() for d in found)
    return attributes


def declarations(layout: Layout) -> list[Variable]:
    """The Modelica declarations of the variables that have one."""
    return [slot.scalar.declaration for slot in layout.slots if slot.scalar is not None]


def enumerations(layout: Layout) -> dict[str, tuple[str, ...]]:
    """The names of the enumeration types, and the literals of each, which count from 1.

    A name is made of the literals, and unlike that of any variable and of any other type, as FMI 3.0 demands.
    """
    taken = {slot.name for slot in layout.slots}
    types: dict[str, tuple[str, ...]] = {}
    for literals in dict.fromkeys(v.literals for v in declarations(layout) if v.type == "Enumeration"):
        plain = "Enumeration_" + "_".join(literals)
        names = itertools.chain([plain], (f"{plain}_{count}" for count in itertools.count(2)))
        types[next(name for name in names if name not in taken and name not in types)] = literals
    return types


def general_attributes(reference: int, slot: Slot) -> dict[str, str]:
    """The attributes of a variable that do not depend on its type."""
    attributes = {
        "name": slot.name,
        "valueReference": str(reference),
        "causality": slot.causality,
        "variability": slot.variability,
    }
    if slot.description:
        attributes["description"] = slot.description
    if slot.initial is not None:
        attributes["initial"] = slot.initial
    return attributes


def typed_attributes(slot: Slot, types: Mapping[tuple[str, ...], str], first: int) -> dict[str, str]:
    """The attributes of a variable that depend on its type; ``types`` has the names of enumerations.

    Variables count from ``first`` where one names another.
    """
    attributes: dict[str, str] = {}
    if slot.store == "STORE_TIME":
        attributes["unit"] = "s"
    declaration = slot.scalar.declaration if slot.scalar is not None else None
    if declaration is not None and declaration.type == "Enumeration":
        attributes["declaredType"] = types[declaration.literals]
    if declaration is not None and declaration.type == "Real":
        if declaration.unit:
            attributes["unit"] = declaration.unit
            if declaration.display_unit:
                attributes["displayUnit"] = declaration.display_unit
        if declaration.quantity:
            attributes["quantity"] = declaration.quantity
        for attribute, expression in (("min", declaration.minimum), ("max", declaration.maximum)):
            value = getattr(expression, "value", None)
            if isinstance(value, int | float) and not isinstance(value, bool):
                attributes[attribute] = repr(float(value))
        if slot.scalar is not None and slot.scalar.nominal != 1.0:
            attributes["nominal"] = repr(slot.scalar.nominal)
    if slot.unit is not None:
        attributes["unit"] = slot.unit
    if slot.derivative_of is not None:
        attributes["derivative"] = str(slot.derivative_of + first)
    if slot.reinitialised:
        attributes["reinit"] = "true"
    if slot.start is not None:
        attributes["start"] = _start(slot, slot.start)
    return attributes


def document(root: ET.Element) -> bytes:
    """The XML document as bytes."""
    ET.indent(root)
    text: bytes = ET.tostring(root, encoding="utf-8", xml_declaration=True)
    return text + b"\n"


def _start(slot: Slot, start: float) -> str:
    if slot.type == "TYPE_BOOLEAN":
        return "true" if start else "false"
    return repr(float(start)) if slot.type == "TYPE_REAL" else str(int(start))
