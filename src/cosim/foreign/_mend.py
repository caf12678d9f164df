"""Mends what tools are known to write into model descriptions against the schema, where only one meaning is possible.

Each rule is a function that changes the tree and yields what it has found and where; the docstring names the tools that
the public trackers of FMPy, FMIKit-Simulink and the FMI standard report it of, as far as known.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import NamedTuple

from attrs import fields
from fmpy.model_description import Item, SimpleType
from lxml import etree

from cosim.foreign._terms import (
    INTERFACES,
    STRUCTURE,
    TYPES,
    indexed,
    is_fmi2,
    is_true_or_false,
    label,
    legal_variability,
    value_of,
    variables_of,
)

Found = Iterator[tuple[str, str]]
_SHOWN = 3
_NO_TYPE_ATTRIBUTES = frozenset(("name", "description"))


class Amiss(NamedTuple):
    """What was amiss with a description, in a sentence.

    ``id`` is "vendor" for what was mended, "references" for what refers to nothing, "schema" for what of the schema is
    broken after that.
    """

    id: str
    text: str

    def __str__(self) -> str:
        """Return the sentence."""
        return self.text


def mend(root: etree._Element) -> list[Amiss]:
    """Mend a model description in place; return what was amiss, one sentence for each kind."""
    amiss: list[Amiss] = []
    for rule in _RULES:
        where: dict[str, list[str]] = {}
        for what, place in rule(root):
            where.setdefault(what, []).append(place)
        for what, places in where.items():
            more = f" and {len(places) - _SHOWN} more" if len(places) > _SHOWN else ""
            kind = "references" if rule in (_structure, _derivatives) else "vendor"
            amiss.append(Amiss(kind, f"{what}: {', '.join(places[:_SHOWN])}{more}"))
    return amiss


def _namespaces(root: etree._Element) -> Found:
    """Put the elements into no namespace, as FMI has it; writers that put a default one on the root."""
    if isinstance(root.tag, str) and root.tag.startswith("{"):
        space = root.tag[: root.tag.index("}") + 1]
        for element in list(root.iter(f"{space}*")):
            element.tag = str(element.tag).removeprefix(space)
        etree.cleanup_namespaces(root)
        yield "its elements are in an XML namespace, which FMI does not use", space[1:-1]


def _version(root: etree._Element) -> Found:
    """Take "2.0.3" for "2.0": a revision of the text is no version of the standard."""
    found = re.fullmatch(r"\s*(2\.0)(\.\d+)?\s*|\s*([13]\.0)\s*", version := root.get("fmiVersion", ""))
    if found and (plain := found[1] or found[3]) != version:
        root.set("fmiVersion", plain)
        yield f"fmiVersion should be {plain}", repr(version)


def _capabilities(root: etree._Element) -> Found:
    """Read "True" as true, and the spelling of FMI 2.0 in FMI 3.0 or the other way round."""
    wrong, right = ("FMUState", "FMUstate") if is_fmi2(root) else ("FMUstate", "FMUState")
    for element in root:
        if element.tag not in INTERFACES:
            continue
        for name, value in dict(element.attrib).items():
            if is_true_or_false(value):
                element.set(name, value.lower())
                yield "a Boolean is true or false, in small letters", f"{element.tag} {name}={value!r}"
            if str(name).endswith(wrong):
                element.set(str(name).replace(wrong, right), value.lower())
                del element.attrib[name]
                yield f"this version of FMI writes {right}", f"{element.tag} {name}"


def _indicators(root: etree._Element) -> Found:
    """Take an empty numberOfEventIndicators as none."""
    if (count := root.get("numberOfEventIndicators")) is not None and not count.strip().isdigit():
        root.set("numberOfEventIndicators", "0")
        yield "numberOfEventIndicators is no number, taken as 0", repr(count)


def _type_definitions(root: etree._Element) -> Found:
    """Leave out attributes that FMI does not know, and types without content."""
    known = {field.name for field in fields(SimpleType)} - {"type", "items"}
    known_of_item = {field.name for field in fields(Item)}
    for definition in root.findall("TypeDefinitions/*"):
        inner = definition[0] if is_fmi2(root) and len(definition) else definition
        if is_fmi2(root) and inner is definition:
            definition.getparent().remove(definition)
            yield "a type has no content, left out", label(definition)
            continue
        forbidden = _NO_TYPE_ATTRIBUTES if inner is not definition else frozenset[str]()
        for element, allowed in [(inner, known - forbidden), *((item, known_of_item) for item in inner.iter("Item"))]:
            for name in [str(name) for name in element.attrib if str(name) not in allowed]:
                del element.attrib[name]
                yield "FMI has no such attribute, left out", f"{name} of type {label(definition)}"


def _variables(root: etree._Element) -> Found:
    """Read a description without variables as one with none."""
    if root.find("ModelVariables") is None:
        etree.SubElement(root, "ModelVariables")
        yield "ModelVariables is missing", "no variable is described"


def _declared_types(root: etree._Element) -> Found:
    """Forget a declared type that is not defined."""
    defined = {definition.get("name") for definition in root.findall("TypeDefinitions/*")}
    for variable in variables_of(root):
        value = value_of(variable, root)
        if value is not None and (declared := value.get("declaredType")) is not None and declared not in defined:
            del value.attrib["declaredType"]
            yield "the declared type is not defined, left out", f"{declared} of {label(variable)}"


def _causalities(root: etree._Element) -> Found:
    """Read the "none" (OpenModelica) and "internal" of FMI 1.0 as local."""
    if root.get("fmiVersion") == "1.0":
        return
    for variable in variables_of(root):
        if (causality := variable.get("causality")) in ("none", "internal"):
            variable.set("causality", "local")
            yield f"causality {causality} is that of FMI 1.0, read as local", label(variable)


def _variabilities(root: etree._Element) -> Found:
    """Give parameters that are constant (Dymola) or continuous, and Booleans that are continuous, one they can have."""
    if root.get("fmiVersion") == "1.0":
        return
    for variable in variables_of(root):
        value = value_of(variable, root)
        stated = variable.get("variability")
        if value is None or (stated is None and not is_fmi2(root)):
            continue
        legal = legal_variability(
            variable.get("causality", "local"), stated or "continuous", str(value.tag), is_given=stated is not None
        )
        if legal is not None:
            variable.set("variability", legal)
            kind = f"{variable.get('causality', 'local')} {value.tag}"
            wrong = f"cannot be {stated}" if stated else "needs a variability, as FMI takes it for continuous"
            yield f"a {kind} {wrong}, read as {legal}", label(variable)


def _starts(root: etree._Element) -> Found:
    """Read "False" (Python's), "1,5", "1.#INF" (Microsoft's), "1d-3" (Fortran's), "3.0" for 3 and names of literals."""
    items = {
        definition.get("name"): {item.get("name"): item.get("value") for item in definition.iter("Item")}
        for definition in root.findall("TypeDefinitions/*")
    }
    for variable in variables_of(root):
        value = value_of(variable, root)
        if value is None or (start := value.get("start")) is None:
            continue
        literals = items.get(value.get("declaredType"), {})
        if value.tag == "Enumeration" and start in literals and not start.lstrip("-").isdigit():
            read = literals[start] or start
        else:
            read = " ".join(TYPES[str(value.tag)](token) for token in start.split()) if value.tag in TYPES else start
        if read.split() != start.split():
            value.set("start", read)
            yield "a start value is not written as the schema demands", f"{label(variable)} = {start!r}, read as {read}"


def _structure(root: etree._Element) -> Found:
    """Leave out entries of the model structure that refer to nothing; take single blanks between references."""
    if root.get("fmiVersion") == "1.0":
        return
    there = indexed(root)
    found = root.findall("ModelStructure/*/Unknown" if is_fmi2(root) else "ModelStructure/*")
    for unknown in [entry for entry in found if entry.tag in STRUCTURE]:
        reference = unknown.get("index" if is_fmi2(root) else "valueReference", "")
        if reference.strip() not in there:
            group = unknown.getparent()
            group.remove(unknown)
            if len(group) == 0 and group.getparent() is not None and is_fmi2(root):
                group.getparent().remove(group)
            yield "the model structure refers to a variable that is not there, left out", f"{unknown.tag} {reference!r}"
            continue
        known = unknown.get("dependencies")
        if known is None:
            continue
        unknown.set("dependencies", " ".join(known.split()))
        if missing := [one for one in known.split() if one not in there]:
            del unknown.attrib["dependencies"]
            unknown.attrib.pop("dependenciesKind", None)
            yield "dependencies name a variable that is not there, taken as unknown", f"{unknown.tag} {missing[0]!r}"


def _derivatives(root: etree._Element) -> Found:
    """Forget of which state a variable is the derivative, if that is not there."""
    if root.get("fmiVersion") == "1.0":
        return
    there = indexed(root)
    for variable in variables_of(root):
        value = value_of(variable, root)
        if value is not None and (state := value.get("derivative")) is not None and state.strip() not in there:
            del value.attrib["derivative"]
            yield "is said to be the derivative of a variable that is not there", f"{label(variable)} of {state!r}"


_RULES: tuple[Callable[[etree._Element], Found], ...] = (
    _namespaces,
    _version,
    _capabilities,
    _indicators,
    _type_definitions,
    _variables,
    _declared_types,
    _causalities,
    _variabilities,
    _starts,
    _structure,
    _derivatives,
)
