"""What an FMU carries for people and for other tools: a page about the model, terminals, an icon."""

from __future__ import annotations

import struct
import zipfile
import zlib
from collections.abc import Callable
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import fmpy
import pytest
from lxml import etree

from cosim.fmu import compile_model
from cosim.fmu.documentation import document_model
from cosim.fmu.layout import Layout, lay_out
from cosim.fmu.terminals import icon, terminals_and_icons

pytest.importorskip("rumoca")

Build = Callable[[str], Path]
TESTS = Path(__file__).parents[1]
SMALL, LIBRARY = TESTS / "models" / "Small", TESTS.parent / "modelica" / "WiperDrive"
VOID = {"meta", "br"}


class Page(HTMLParser):
    """Collects text, and checks that what is opened is closed."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.rows: list[list[str]] = []
        self.text = ""
        self.links: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.links += [value or "" for name, value in attrs if name in ("href", "src")]
        if tag not in VOID:
            self.open.append(tag)
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data
        if self.rows and {"td", "th"} & set(self.open):
            self.rows[-1][-1] += data


def read(path: Path, name: str) -> bytes:
    with zipfile.ZipFile(path) as archive:
        return archive.read(name)


def test_the_page_tells_parameters_with_provenance_and_all_equations() -> None:
    dae = compile_model(LIBRARY, "WiperDrive.Systems.RigPlant")
    layout = lay_out(dae)
    page = Page(document_model(dae, layout, {"casadi": "3.7"}, None).decode())
    assert (page.open, page.links) == ([], [])
    rows = {row[0]: row[1:] for row in page.rows if row}
    for parameter in (slot for slot in layout.slots if slot.causality == "parameter"):
        value, unit, variability, description, provenance = rows[parameter.name]
        assert variability == parameter.variability
        # a comment of the library's own: each parameter's description ends in where its value comes from
        assert provenance[:4] in ("[S] ", "[A] ")
        assert f"{description} {provenance}" == parameter.description
        assert parameter.scalar is not None
        assert unit == (parameter.scalar.declaration.unit or "")
        if parameter.type == "TYPE_REAL":
            assert float(value) == pytest.approx(parameter.start, rel=1e-8)
    for equation in dae.equations:
        text, place = equation.rsplit(" (", 1)
        assert [text, place.removesuffix(")")] in page.rows
    assert "RODAS5P" in page.text
    assert "casadi 3.7" in page.text


def test_texts_of_a_model_cannot_break_the_page(tmp_path: Path) -> None:
    (tmp_path / "Odd.mo").write_text(
        """model Odd "a < b & c <script>alert(1)</script>"
  parameter Real k = 1 "less < more [A] a & b";
  output Real y;
equation
  y = if time < k and 1 > 0 then 1 else 2;
end Odd;
"""
    )
    dae = compile_model(tmp_path / "Odd.mo", "Odd")
    page = Page(document_model(dae, lay_out(dae), {}, 1e-3).decode())
    assert page.open == []
    assert "a < b & c <script>alert(1)</script>" in page.text
    assert ["k", "1", "", "tunable", "less < more", "[A] a & b"] in page.rows
    assert "steps of 0.001 s" in page.text


def test_terminals_name_inputs_and_outputs_once_and_obey_the_schema(build: Build) -> None:
    path = build("WiperDrive.Systems.LinkagePlant")
    document = read(path, "terminalsAndIcons/terminalsAndIcons.xml")
    schema = Path(fmpy.__file__).parent / "schema" / "fmi3" / "fmi3TerminalsAndIcons.xsd"
    root = etree.fromstring(document)
    etree.XMLSchema(etree.parse(str(schema))).assertValid(root)
    variables = fmpy.read_model_description(str(path)).modelVariables
    expected = {v.name for v in variables if v.causality in ("input", "output")}
    named = [member.get("variableName") for member in root.iter("TerminalMemberVariable")]
    assert (len(named), set(named)) == (len(expected), expected)


def test_what_belongs_to_a_connector_is_a_terminal_of_its_own() -> None:
    slots = lay_out(compile_model(SMALL / "MotorOnSpring.mo", "Small.MotorOnSpring")).slots
    names = {"u": "left.torque", "phi": "left.angle", "i": "i"}
    layout = Layout([replace(slot, name=names.get(slot.name, slot.name)) for slot in slots])
    root = etree.fromstring(terminals_and_icons(layout))
    found = {t.get("name"): {m.get("memberName") for m in t} for t in root.iter("Terminal")}
    assert found == {"left": {"torque", "angle"}, "signals": {"i"}}


def test_the_icon_is_a_small_picture_that_is_the_same_every_time(build: Build) -> None:
    content = read(build("Rectifier"), "terminalsAndIcons/icon.png")
    layout = lay_out(compile_model(SMALL / "Rectifier.mo", "Small.Rectifier"))
    assert content == icon(layout)
    assert len(content) < 1000
    assert content.startswith(b"\x89PNG\r\n\x1a\n")
    chunks, at = {}, 8
    while at < len(content):
        (length,) = struct.unpack(">I", content[at : at + 4])
        kind, data = content[at + 4 : at + 8], content[at + 8 : at + 8 + length]
        assert struct.unpack(">I", content[at + 8 + length : at + 12 + length])[0] == zlib.crc32(kind + data)
        chunks[kind], at = data, at + 12 + length
    width, height = struct.unpack(">2I", chunks[b"IHDR"][:8])
    assert len(zlib.decompress(chunks[b"IDAT"])) == height * (width + 1)
