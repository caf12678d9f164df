"""Terminals of FMI 3.0, which importers connect as a whole, and the icon of both FMI versions."""

from __future__ import annotations

import struct
import xml.etree.ElementTree as ET
import zlib

from cosim.fmu._description_parts import document
from cosim.fmu.layout import Layout

PLAIN = "signals"
"""The terminal of the inputs and outputs that belong to no connector of the model."""
_WIDTH, _HEIGHT, _MARGIN, _PORT = 120, 90, 16, 5
_PALETTE = bytes((255, 255, 255, 31, 78, 121, 235, 241, 248, 197, 90, 17))
_BACKGROUND, _LINE, _FACE, _OUTPUT = range(4)


def terminals_and_icons(layout: Layout) -> bytes:
    """``terminalsAndIcons.xml``: a terminal for each connector with inputs or outputs, and one for all others.

    Members are matched by their names, as this project connects a plant and its controller: a terminal of one FMU fits
    one of another whose inputs are called as its outputs.
    """
    root = ET.Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    picture = ET.SubElement(root, "GraphicalRepresentation")
    box = {"x1": "-100", "y1": "-75", "x2": "100", "y2": "75"}
    ET.SubElement(picture, "CoordinateSystem", box, suggestedScalingFactorTo_mm="0.1")
    ET.SubElement(picture, "Icon", box)
    members: dict[str, list[tuple[str, str]]] = {}
    for slot in layout.slots:
        if slot.causality in ("input", "output"):
            connector, _, member = slot.name.rpartition(".")
            members.setdefault(connector, []).append((slot.name, member))
    if members:
        terminals = ET.SubElement(root, "Terminals")
        for connector, variables in members.items():
            name = connector or next(n for n in (PLAIN, f"{PLAIN}_of_the_model") if n not in members)
            terminal = ET.SubElement(terminals, "Terminal", name=name, matchingRule="bus")
            for variable, member in variables:
                ET.SubElement(
                    terminal, "TerminalMemberVariable", variableName=variable, memberName=member, variableKind="signal"
                )
    return document(root)


def icon(layout: Layout) -> bytes:
    """A PNG: a box with a mark for each input on its left and each output on its right."""
    rows = [bytearray(_WIDTH) for _ in range(_HEIGHT)]
    for y in range(_HEIGHT):
        for x in range(_MARGIN, _WIDTH - _MARGIN):
            edge = x in (_MARGIN, _WIDTH - _MARGIN - 1) or y in (0, _HEIGHT - 1)
            rows[y][x] = _LINE if edge else _FACE
    for causality, left, colour in (("input", _MARGIN - 9, _LINE), ("output", _WIDTH - _MARGIN, _OUTPUT)):
        count = sum(slot.causality == causality for slot in layout.slots)
        shown = min(count, (_HEIGHT - 10) // (2 * _PORT))
        for port in range(shown):
            middle = (2 * port + 1) * _HEIGHT // (2 * shown)
            for x in range(9):
                reach = (8 - x) * (_PORT - 1) // 8
                for y in range(middle - reach, middle + reach + 1):
                    rows[y][left + x] = colour
    header = struct.pack(">2I5B", _WIDTH, _HEIGHT, 8, 3, 0, 0, 0)
    content = zlib.compress(b"".join(b"\0" + bytes(row) for row in rows), 9)
    chunks = ((b"IHDR", header), (b"PLTE", _PALETTE), (b"IDAT", content), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(kind, data) for kind, data in chunks)


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
