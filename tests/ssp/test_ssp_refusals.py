"""Wrong structures: each is refused with file, line, what is wrong and what to do; nothing gives a traceback."""

from __future__ import annotations

import copy
import warnings
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from lxml import etree

from cosim.engine import Fmu
from cosim.errors import InputError
from cosim.ssp import _flatten, read_ssp
from ssp.structures import KMH, SSM, SSV, UNITS, connector, element, inline, link, real, ssd, wrapped

Refusal = Callable[..., str]
Pack = Callable[..., Path]
Paths = Callable[[str, int], Path]

ENDS = connector("u", "input") + connector("x", "output") + connector("y", "output")
SSD = "x.ssp/SystemStructure.ssd"


def pair(*links: str, a: str = ENDS, b: str = ENDS, own: str = "", more: str = "", after: str = UNITS) -> str:
    """Return two integrators and these connections, the system's own connectors, and what follows the elements."""
    connectors = wrapped("Connectors", own) if own else ""
    connections = wrapped("Connections", *links) if links else ""
    return ssd(connectors + wrapped("Elements", element("a", a), element("b", b) + more) + connections, after)


def with_values(*arguments: str, **more: str) -> str:
    return pair().replace("<ssd:Elements>", wrapped("ParameterBindings", inline(*arguments, **more)) + "<ssd:Elements>")


def typed(kind: str, source: str) -> str:
    return (
        element("c", "", source)
        .replace("<ssd:Connectors></ssd:Connectors>", "")
        .replace("<ssd:Component ", f'<ssd:Component type="{kind}" ')
    )


DICTIONARY = '<ssd:SignalDictionaryReference name="bus" dictionary="d"/>'
STRUCTURES = {
    "a structure of another version": (
        pair().replace('version="1.0"', 'version="Draft20180219"'),
        "SystemStructureDescription is of version 'Draft20180219' of the SSP standard; 1.0 and 2.0 are read; export it "
        "again",
    ),
    "an attribute that is missing": (
        pair().replace(' kind="input"', "", 1),
        "does not fit the schema of SSP 1.0: Element 'Connector': The attribute 'kind' is required but missing. "
        "Correct it, or export it again",
    ),
    "a document type": (
        "<!DOCTYPE x [<!ENTITY e 'e'>]>" + pair(),
        "it has a document type (<!DOCTYPE ...>), which can define entities; take it out of the file",
    ),
    "no XML": ("{}", "it is not well-formed XML: line 1: not well-formed (invalid token); export it again"),
    "a parameter set as a structure": (
        SSV.format("", ""),
        "is not a .ssd file: its root is 'ParameterSet', expected 'SystemStructureDescription' of SSP",
    ),
    "a signal dictionary": (
        pair(more=DICTIONARY),
        "'bus' is a SignalDictionaryReference, which this version does not read; connect the components directly",
    ),
    "a Modelica model": (
        pair(more=typed("text/x-modelica; path=A.B", "resources/m.mo")),
        "component 'c' is of the type 'text/x-modelica'; only FMUs (application/x-fmu-sharedlibrary) and other system "
        "structures are run: export it as an FMU",
    ),
    "an interface that is not run": (
        pair()
        .replace('version="1.0"', 'version="2.0"')
        .replace("source=", 'implementation="ScheduledExecution" source=', 1),
        "component 'a' asks for ScheduledExecution; FMUs are run by Co-Simulation or Model Exchange: set "
        "implementation to one of these, or leave it out",
    ),
    "a component without a source": (
        pair().replace('version="1.0"', 'version="2.0"').replace(' source="resources/integrator.fmu"', "", 1),
        "component 'a' has no source, only its interface is described; give it an FMU",
    ),
    "a path out of the package": (
        pair(more=typed("application/x-fmu-sharedlibrary", "resources/../../secret.fmu")),
        "'resources/../../secret.fmu' leads out of x.ssp; put the file into it",
    ),
    "a path on the web": (
        pair(more=typed("application/x-fmu-sharedlibrary", "https://example.org/a.fmu")),
        "'https://example.org/a.fmu' leads out of x.ssp; put the file into it and give a path such as "
        "resources/Plant.fmu",
    ),
    "an FMU that is not there": (
        pair(more=typed("application/x-fmu-sharedlibrary", "resources/b.fmu")),
        "there is no 'resources/b.fmu' in x.ssp; there is resources/integrator.fmu",
    ),
    "a system that refers to itself": (
        pair(
            more='<ssd:System name="s" id="s">'
            + wrapped("Elements", typed("application/x-ssp-definition", "#s"))
            + "</ssd:System>"
        ),
        "component 'c' refers to a system that it is part of; take it out",
    ),
    "an id that is not there": (
        pair(more=typed("application/x-ssp-definition", "#s")),
        "there is no System with the id 's' in this file",
    ),
    "two elements of one name": (
        pair(more=element("a", ENDS)),
        "a second element 'a' in system 'root'; rename one",
    ),
    "an element that is not there": (
        pair(link("a.x", "c.u")),
        "there is no element 'c' in system 'root'; elements are a, b",
    ),
    "a connector that is not there": (
        pair(link("a.z", "b.u")),
        "'a' has no connector 'z'; its connectors are u, x, y",
    ),
    "two outputs": (
        pair(link("a.x", "b.x")),
        "'a.x' and 'b.x' are connected, but each of them gives a value; connect what gives one with what takes it",
    ),
    "two inputs": (
        pair(link("a.u", "b.u")),
        "'a.u' and 'b.u' are connected, but each of them takes a value; connect what gives one with what takes it",
    ),
    "an input with two sources": (
        pair(link("a.y", "b.u"), link("b.u", "b.y")),
        "'b.u' is connected a second time, first in line 1; it has one source",
    ),
    "systems in a circle": (
        pair(
            link("s.out", "s.in"),
            link("s.out", "a.u"),
            more='<ssd:System name="s">'
            + wrapped("Connectors", connector("in", "input") + connector("out", "output"))
            + wrapped("Connections", link("in", "out"))
            + "</ssd:System>",
        ),
        "'s.out' is connected with itself through other systems; nothing gives it a value",
    ),
    "units of different dimensions": (
        pair(link("a.x", "b.u")),
        "'a.x' -> 'b.u': cannot convert m to m/s: m against m.s-1; correct a unit, or set suppressUnitConversion to "
        "take the numbers as they are",
    ),
    "a unit that is not the FMU's": (
        pair(a=connector("u", "input", "Real", "km/h")),
        "connector 'u' of 'a' is in km/h, in integrator.fmu it is in m/s; give it the FMU's unit, connections convert "
        "units",
    ),
    "a connector that the FMU does not have": (
        pair(a=connector("w", "input")),
        "connector 'w' of 'a': integrator.fmu has no such variable; correct the name",
    ),
    "a connector of another kind": (
        pair(a=connector("u", "output")),
        "connector 'u' of 'a' is of the kind output, in integrator.fmu it is input",
    ),
    "a connector of another type": (
        pair(a=connector("u", "input", "Boolean")),
        "connector 'u' of 'a' is a Boolean, in integrator.fmu it is a Real",
    ),
    "a connector of both directions": (
        pair(link("both", "a.u"), own=connector("both", "inout")),
        "connector 'both' of system 'root' is of the kind inout; write input or output, so that it is known where its "
        "value comes from",
    ),
    "a parameter of another type": (
        with_values('<ssv:Parameter name="a.gain"><ssv:Boolean value="true"/></ssv:Parameter>'),
        "parameter 'a.gain' is a Boolean, but a.gain is a Real",
    ),
    "a value for an output": (
        with_values(real("a.x", 1)),
        "parameter 'a.x' sets a.x, which is of the causality output; parameters and numeric inputs can be set",
    ),
    "a value in another dimension": (
        with_values(real("a.x0", 1, "km/h"), units=KMH),
        "parameter 'a.x0' for a.x0: cannot convert km/h to m: m.s-1 against m; correct a unit, or set "
        "suppressUnitConversion to take the numbers as they are",
    ),
    "a list for a scalar": (
        with_values(real("a.x0", "1 2")).replace('version="1.0"', 'version="2.0"'),
        "parameter 'a.x0' has the value '1 2'; a scalar has one number",
    ),
    "an array of another length": (
        with_values(
            '<ssv:Parameter name="a.x0"><ssv:Real value="1 2"/><ssc:Dimension size="3"/></ssv:Parameter>'
        ).replace('version="1.0"', 'version="2.0"'),
        "parameter 'a.x0' is an array of 3 elements, its value has 2; give as many numbers",
    ),
    "a value that is not a number": (
        with_values(real("a.x0", "NaN")),
        "parameter 'a.x0' is not a number (NaN); give it a value",
    ),
    "a mapping to one target twice": (
        with_values(real("x0", 1), mapping='<ssm:MappingEntry source="x0" target="a.x0"/>' * 2),
        "'a.x0' is mapped a second time; one parameter can set it",
    ),
    "a parameter set that is not there": (
        pair().replace(
            "<ssd:Elements>",
            wrapped("ParameterBindings", '<ssd:ParameterBinding source="resources/p.ssv"/>') + "<ssd:Elements>",
        ),
        "there is no 'resources/p.ssv' in x.ssp",
    ),
    "nothing to run": (ssd(""), "the structure has no component that is an FMU; there is nothing to run"),
}


@pytest.mark.parametrize(("structure", "message"), STRUCTURES.values(), ids=STRUCTURES.keys())
def test_a_structure_that_is_refused(refusal: Refusal, structure: str, message: str) -> None:
    place, _, rest = refusal(structure).partition(": ")
    assert rest == message
    assert place.partition(":")[0] == SSD


def test_the_line_is_that_of_the_element(refusal: Refusal) -> None:
    structure = pair(link("a.x", "b.x")).replace("<ssd:Conn", "\n<ssd:Conn").replace("<ssd:Comp", "\n<ssd:Comp")
    line = structure[: structure.index("<ssd:Connection ")].count("\n") + 1
    assert refusal(structure).startswith(f"{SSD}:{line}: 'a.x' and 'b.x' are connected")


def test_files_that_are_no_ssp(refusal: Refusal, tmp_path: Path) -> None:
    assert refusal(pair(), system="y.ssp") == "x.csv:1: there is no file 'y.ssp'"
    (tmp_path / "y.ssp").write_bytes(b"PK but no archive")
    assert refusal(pair(), system="y.ssp") == ("y.ssp: is not an SSP: it is not a zip archive; export the model again")
    assert refusal(pair(), system="x.ssp#B.ssd") == (
        "x.csv:1: there is no 'B.ssd' in x.ssp; there is SystemStructure.ssd"
    )
    assert refusal(pair(), {"../evil.txt": ""}) == (
        "x.ssp: is refused, nothing was unpacked: ../evil.txt leads out of the folder it is unpacked to"
    )
    assert refusal(pair().replace("integrator.fmu", "c.fmu"), {"resources/c.fmu": b"no FMU"}) == (
        "x.ssp/resources/c.fmu: is not an FMU: it is not a zip archive; export the model again"
    )


def test_files_that_are_referred_to_have_their_own_place(refusal: Refusal) -> None:
    binding = wrapped(
        "ParameterBindings",
        '<ssd:ParameterBinding source="resources/p.ssv"><ssd:ParameterMapping source="resources/m.ssm"/>'
        "</ssd:ParameterBinding>",
    )
    structure = pair().replace("<ssd:Elements>", f"{binding}<ssd:Elements>")
    files = {
        "resources/p.ssv": SSV.format("\n" + real("a", 1) + real("a", 1) + real("a", 2), ""),
        "resources/m.ssm": SSM.format(""),
    }
    assert refusal(structure, files) == (
        "x.ssp/resources/p.ssv:2: a second value of parameter 'a' in this parameter set; give one"
    )
    files = {"resources/p.ssv": SSV.format("", ""), "resources/m.ssm": SSM.format("\n<ssm:MappingEntry source='a'/>")}
    assert refusal(structure, files) == (
        "x.ssp/resources/m.ssm:2: does not fit the schema of SSP 1.0: Element 'MappingEntry': The attribute 'target' "
        "is required but missing. Correct it, or export it again"
    )


def test_a_scenario_that_does_not_fit_the_structure(refusal: Refusal) -> None:
    own = connector("v", "input", "Real", "km/h") + connector("idle", "input")
    structure = pair(link("v", "a.u"), link("a.y", "b.u"), own=own)
    assert refusal(structure, keys="# controller: voltage_profile\n") == (
        "x.csv:3: the components of 'x.ssp' are all in it; take the 'controller' out"
    )
    for header, message in {
        "v [V]": "column 'v' is in V, 'v' is in km/h; write 'v [km/h]'",
        "idle": "column 'idle': this connector drives nothing; remove the column",
        "b.u [m/s]": "column 'b.u': 'b.u' is driven already by a.y; remove the column",
    }.items():
        assert refusal(structure, table=f"time [s],{header}\n0,1\n") == f"x.csv:3:2: {message}"
    assert refusal(structure, table="time [s],v [km/h],a.u [m/s]\n0,1,1\n") == (
        "x.csv:3:3: column 'a.u': 'a.u' is driven already in column 2; remove the column"
    )
    assert refusal(structure, keys="# set: c.gain = 2\n").startswith("x.csv:3: unknown parameter 'c.gain'")


POOL = (
    *("", "a", "b", "u", "x", "y", "a.u", "root", "gain", "a.gain", "s", "#s", "0", "1", "-1", "1e400", "NaN", "INF"),
    *("true", "km/h", "m", "input", "output", "inout", "parameter", "2.0", "1.0", "resources/integrator.fmu", "//"),
    *("resources/..", "application/x-ssp-definition", "SystemStructure.ssd", "SSD", "component", "\u00e9", " ", "%00"),
    "x" * 300,
    *("http://[", "1 2", "3", "", "true false"),
)
VALID = pair(
    link("v", "a.u", '<ssc:LinearTransformation factor="2" offset="1"/>'),
    link("a.y", "s.in"),
    link("s.out", "b.u", more='suppressUnitConversion="true"'),
    own=connector("v", "input", "Real", "km/h"),
    more='<ssd:System name="s" id="s">'
    + wrapped("Connectors", connector("in", "input", "Real", "m/s") + connector("out", "output"))
    + wrapped("Elements", element("c", ENDS))
    + wrapped("Connections", link("in", "c.u"), link("c.x", "out"))
    + "</ssd:System>",
).replace(
    "<ssd:Elements>",
    wrapped(
        "ParameterBindings",
        inline(
            real("a.gain", 2), real("v", 3, "km/h"), units=KMH,
            mapping='<ssm:MappingEntry source="a.gain" target="s.c.gain"/>',
        ),
        inline('<ssv:Parameter name="b.gain"><ssv:Integer value="3"/></ssv:Parameter>'),
    ) + "<ssd:Elements>",
    1,
)  # fmt: skip


@pytest.fixture(scope="module")
def one_fmu(fmu_path: Paths) -> Fmu:
    return Fmu.read(fmu_path("integrator", 3))


Edit = tuple[str, int, int, str]
EDITS = st.lists(
    st.tuples(
        st.sampled_from(["delete", "double", "move", "attribute", "text"]),
        st.integers(0, 200),
        st.integers(0, 200),
        st.sampled_from(POOL) | st.text(max_size=5),
    ),
    min_size=1,
    max_size=4,
)


def edited(edits: list[Edit], version: str) -> bytes:
    """Return the valid structure with elements deleted, doubled and moved, and attributes replaced."""
    root = etree.fromstring(VALID.replace('version="1.0"', f'version="{version}"'))
    for what, first, second, text in edits:
        nodes = list(root.iter())
        node, other = nodes[first % len(nodes)], nodes[second % len(nodes)]
        parent = node.getparent()
        try:
            if what == "attribute" and node.attrib:
                node.set(sorted(node.attrib)[second % len(node.attrib)], text)
            elif what == "text":
                node.text = text
            elif parent is not None and what == "delete":
                parent.remove(node)
            elif parent is not None and what == "double":
                parent.insert(0, copy.deepcopy(node))
            elif parent is not None and node not in other.iterancestors() and node is not other:
                other.append(copy.deepcopy(node))
        except ValueError:  # XML has no place for control characters
            continue
    return bytes(etree.tostring(root))


@given(edits=EDITS, version=st.sampled_from(["1.0", "2.0"]))
@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_damaged_structure_is_read_or_refused(
    edits: list[Edit], version: str, one_fmu: Fmu, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(_flatten, "read_fmu", lambda location, place, interface: (location.content(place), one_fmu)[1])
    path = tmp_path / "SystemStructure.ssd"
    (tmp_path / "resources").mkdir(exist_ok=True)
    (tmp_path / "resources" / "integrator.fmu").touch()
    path.write_bytes(edited(edits, version))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            read_ssp(path)
        except InputError as error:
            assert str(error).startswith(str(tmp_path))


@given(
    cuts=st.lists(
        st.tuples(st.integers(0, len(VALID)), st.integers(0, 9), st.binary(max_size=4)), min_size=1, max_size=3
    )
)
@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_damaged_bytes_are_read_or_refused(
    cuts: list[tuple[int, int, bytes]], one_fmu: Fmu, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(_flatten, "read_fmu", lambda location, place, interface: one_fmu)
    content = VALID.encode()
    for start, length, put in cuts:
        content = content[:start] + put + content[start + length :]
    path = tmp_path / "SystemStructure.ssd"
    path.write_bytes(content)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            read_ssp(path)
        except InputError as error:
            assert str(error).startswith(str(tmp_path))


@pytest.mark.parametrize("version", ["1.0", "2.0"])
def test_the_structure_that_is_damaged_is_a_valid_one(
    version: str, one_fmu: Fmu, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(_flatten, "read_fmu", lambda location, place, interface: one_fmu)
    (tmp_path / "SystemStructure.ssd").write_text(VALID.replace('version="1.0"', f'version="{version}"'))
    read = read_ssp(tmp_path / "SystemStructure.ssd")
    assert [component.name for component in read.components] == ["a", "b", "s.c"]
    assert (len(read.connections), list(read.inputs), len(read.starts)) == (2, ["v"], 0)
    assert [component.parameters for component in read.components] == [{}, {"gain": 3.0}, {"gain": 2.0}]
