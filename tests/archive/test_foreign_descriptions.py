"""What other tools write against the schema and means one thing only: it is read, and told."""

from __future__ import annotations

import warnings
import zipfile
from pathlib import Path

import pytest
from fmpy.model_description import ModelDescription

from cosim.archive import Archive
from cosim.errors import FmuError
from cosim.foreign import read_description

HEAD = '<?xml version="1.0" encoding="UTF-8"?>\n'
FMI2 = """<fmiModelDescription fmiVersion="2.0" modelName="m" guid="g">
<CoSimulation modelIdentifier="m" canHandleVariableCommunicationStepSize="true" canGetAndSetFMUstate="true"/>
<TypeDefinitions><SimpleType name="Gear"><Enumeration><Item name="low" value="1"/><Item name="high" value="2"/>
</Enumeration></SimpleType></TypeDefinitions>
<ModelVariables>
<ScalarVariable name="p" valueReference="1" causality="parameter" variability="fixed">
<Real start="1.5"/></ScalarVariable>
<ScalarVariable name="n" valueReference="2" causality="parameter" variability="fixed">
<Integer start="3"/></ScalarVariable>
<ScalarVariable name="b" valueReference="3" causality="input" variability="discrete">
<Boolean start="true"/></ScalarVariable>
<ScalarVariable name="e" valueReference="4" causality="parameter" variability="fixed">
<Enumeration declaredType="Gear" start="2"/></ScalarVariable>
<ScalarVariable name="y" valueReference="5" causality="output" variability="continuous"><Real/></ScalarVariable>
</ModelVariables>
<ModelStructure><Outputs><Unknown index="5" dependencies="1 3"/></Outputs>
<InitialUnknowns><Unknown index="5"/></InitialUnknowns></ModelStructure>
</fmiModelDescription>"""
FMI3 = """<fmiModelDescription fmiVersion="3.0" modelName="m" instantiationToken="g">
<CoSimulation modelIdentifier="m" canHandleVariableCommunicationStepSize="true" canGetAndSetFMUState="true"/>
<ModelVariables>
<Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>
<Float64 name="p" valueReference="1" causality="parameter" variability="fixed" start="1.5 2">
<Dimension start="2"/></Float64>
<Int32 name="n" valueReference="2" causality="parameter" variability="fixed" start="3"/>
<Boolean name="b" valueReference="3" causality="input" start="true"/>
<Float64 name="y" valueReference="5" causality="output"/>
</ModelVariables>
<ModelStructure><Output valueReference="5" dependencies="1 3"/><InitialUnknown valueReference="5"/></ModelStructure>
</fmiModelDescription>"""


def reading(tmp_path: Path, xml: str | bytes) -> tuple[ModelDescription, tuple[str, ...]]:
    path = tmp_path / "x.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", xml if isinstance(xml, bytes) else HEAD + xml)
    description, _, amiss, _ = read_description(Archive.open(path))
    return description, tuple(map(str, amiss))


def facts(description: ModelDescription) -> list[tuple[object, ...]]:
    """All that the engine takes from a description."""
    variables = [
        (v.name, v.type, v.valueReference, v.causality, v.variability, v.start, v.declaredType and v.declaredType.name)
        for v in description.modelVariables
    ]
    structure = [
        (u.variable.name, None if u.dependencies is None else [d.name for d in u.dependencies])
        for u in description.outputs
    ]
    interface = description.coSimulation
    return [
        (description.fmiVersion, interface.canHandleVariableCommunicationStepSize, interface.canGetAndSetFMUstate),
        *variables,
        *structure,
    ]


@pytest.mark.parametrize("xml", [FMI2, FMI3])
def test_what_keeps_to_the_schema_has_nothing_amiss(tmp_path: Path, xml: str) -> None:
    assert reading(tmp_path, xml)[1] == ()


SAME = [
    ('fmiVersion="2.0"', 'fmiVersion="2.0.3"', "fmiVersion should be 2.0: '2.0.3'"),
    ('StepSize="true"', 'StepSize="True"', "a Boolean is true or false, in small letters: CoSimulation "),
    ("SetFMUstate", "SetFMUState", "this version of FMI writes FMUstate: CoSimulation canGetAndSetFMUState"),
    ("SetFMUState", "SetFMUstate", "this version of FMI writes FMUState: CoSimulation canGetAndSetFMUstate"),
    ('start="true"', 'start="True"', "a start value is not written as the schema demands: b ("),
    (
        'start="1.5"',
        'start="1,5"',
        "a start value is not written as the schema demands: p (line 7) = '1,5', read as 1.5",
    ),
    ('start="3"', 'start="3.0"', "a start value is not written as the schema demands: n ("),
    ('"Gear" start="2"', '"Gear" start="high"', "a start value is not written as the schema demands: e ("),
    (
        'variability="fixed">\n<Real',
        'variability="constant">\n<Real',
        "a parameter Real cannot be constant, read as fixed: p",
    ),
    (
        ' variability="fixed">\n<Integer',
        ">\n<Integer",
        "a parameter Integer needs a variability, as FMI takes it for continuous, read as fixed: n",
    ),
    (
        'variability="discrete">\n<Boolean',
        'variability="continuous">\n<Boolean',
        "a input Boolean cannot be continuous, read as discrete: b",
    ),
    (' value="1"/>', ' value="1" vendor="x"/>', "FMI has no such attribute, left out: vendor of type Gear"),
    ("<Enumeration><Item", '<Enumeration vendor="x"><Item', "FMI has no such attribute, left out: vendor of type Gear"),
    (
        'variability="continuous"><Real',
        'variability="continuous"><Real declaredType="T"',
        "the declared type is not defined",
    ),
    ("<fmiModelDescription ", '<fmiModelDescription xmlns="http://x" ', "its elements are in an XML namespace"),
    ('dependencies="1 3"', 'dependencies=" 1   3 "', None),
    ("<SimpleType", "<!-- a --><SimpleType", None),
    ("<Enumeration>", "<!-- a --><Enumeration>", None),
    (
        'guid="g"',
        'guid="g" needsExecutionTool="true"',
        "modelDescription.xml breaks the schema of FMI in one place, line 2: Element 'fmiModelDescription'",
    ),
    (
        "<ModelStructure>",
        "<VendorAnnotations/><ModelStructure>",
        "modelDescription.xml breaks the schema of FMI in one place, line 1",
    ),
    (
        "</ModelStructure>",
        "<Vendor/></ModelStructure>",
        "modelDescription.xml breaks the schema of FMI in one place, line 1",
    ),
]


@pytest.mark.parametrize(("old", "new", "told"), SAME)
def test_what_is_mended_reads_as_what_was_meant(tmp_path: Path, old: str, new: str, told: str | None) -> None:
    tried = 0
    for xml in (FMI2, FMI3):
        if old not in xml:
            continue
        tried += 1
        description, amiss = reading(tmp_path, xml.replace(old, new, 1))
        assert facts(description) == facts(reading(tmp_path, xml)[0])
        if told is None:
            assert amiss == ()
        else:
            assert len(amiss) == 1
            assert amiss[0].startswith(told)
    assert tried


def test_microsofts_and_fortrans_numbers(tmp_path: Path) -> None:
    for written, read in {
        "1.#INF": "INF",
        "-1.#INF": "-INF",
        "1.#QNAN": "NaN",
        "1d-3": "1.e-3",
        "-1,5e3": "-1.5e3",
    }.items():
        description, amiss = reading(tmp_path, FMI2.replace('start="1.5"', f'start="{written}"'))
        assert description.modelVariables[0].start == read
        assert amiss == (
            f"a start value is not written as the schema demands: p (line 7) = '{written}', read as {read}",
        )
    assert reading(tmp_path, FMI2.replace('start="1.5"', 'start="INF"'))[1] == ()


@pytest.mark.parametrize("causality", ["none", "internal"])
def test_causality_of_fmi_1(tmp_path: Path, causality: str) -> None:
    description, amiss = reading(tmp_path, FMI2.replace('"output"', f'"{causality}"'))
    assert description.modelVariables[4].causality == "local"
    assert amiss == (f"causality {causality} is that of FMI 1.0, read as local: y (line 15)",)


@pytest.mark.parametrize("index", ["0", "6", "-1", "five"])
def test_the_structure_refers_to_nothing(tmp_path: Path, index: str) -> None:
    description, amiss = reading(tmp_path, FMI2.replace('dependencies="1 3"', f'dependencies="1 {index}"'))
    assert description.outputs[0].dependencies is None
    assert amiss == (f"dependencies name a variable that is not there, taken as unknown: Unknown '{index}'",)
    description, amiss = reading(tmp_path, FMI2.replace('index="5"/>', f'index="{index}"/>'))
    assert description.initialUnknowns == []
    assert amiss == (f"the model structure refers to a variable that is not there, left out: Unknown '{index}'",)


def test_many_of_a_kind_are_one_sentence(tmp_path: Path) -> None:
    wrong = FMI2.replace('variability="fixed"', 'variability="constant"').replace('name="Gear"', 'name="Other"')
    _, amiss = reading(tmp_path, wrong)
    assert len(amiss) == 5
    assert amiss[0] == "the declared type is not defined, left out: Gear of e (line 13)"


@pytest.mark.parametrize(
    ("encode", "told"),
    [
        (lambda xml: b"\xef\xbb\xbf" + (HEAD + xml).encode(), "has a byte order mark"),
        (lambda xml: (HEAD + xml).encode("utf-16"), "has a byte order mark"),
        (lambda xml: ("\n" + HEAD + xml).encode(), "has blanks in front of the XML declaration"),
        (
            lambda xml: (HEAD.replace("UTF-8", "ISO-8859-1") + xml).encode("latin-1"),
            "is in the encoding ISO-8859-1; the standard demands UTF-8",
        ),
        (lambda xml: (HEAD + xml).encode("latin-1"), "is not the UTF-8 it says (line 2); read as Windows-1252"),
        (lambda xml: xml.encode("latin-1"), "is not the UTF-8 it says (line 1); read as Windows-1252"),
    ],
)
def test_encodings(tmp_path: Path, encode: object, told: str) -> None:
    assert callable(encode)
    description, amiss = reading(tmp_path, encode(FMI2.replace('modelName="m"', 'modelName="Wärme °C"')))
    assert description.modelName == "Wärme °C"
    assert amiss == (f"modelDescription.xml {told}",)


@pytest.mark.parametrize(
    "xml", ["<a/>", FMI2.replace("2.0", "4.0"), FMI2.replace('"1"', '"one"'), FMI3.replace("Int32", "Int7")]
)
def test_what_cannot_be_meant(tmp_path: Path, xml: str) -> None:
    with warnings.catch_warnings(), pytest.raises(FmuError, match=r"its modelDescription.xml cannot be read: "):
        warnings.simplefilter("error")
        reading(tmp_path, xml)


def test_a_dimension_is_quickly_written(tmp_path: Path) -> None:
    with pytest.raises(FmuError, match="its arrays have 20000000004 elements; 1000000 are accepted"):
        reading(
            tmp_path, FMI3.replace('<Dimension start="2"/>', '<Dimension start="100000"/><Dimension start="200000"/>')
        )
