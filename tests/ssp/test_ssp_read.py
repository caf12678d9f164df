"""Structures from other tools: nested systems, units, transformations and parameter sets give what is computed by hand.

The integrator gives x(1 s) = x0 + gain * u for a constant u, exactly up to rounding, and y = u + offset.
"""

from __future__ import annotations

import warnings
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from cosim.engine import Channel, Connection, Result, System
from cosim.errors import FmuWarning
from cosim.scenario import ScenarioWarning
from ssp.structures import KMH, SSM, SSV, connector, element, inline, link, real, ssd, wrapped

Run = Callable[..., Result]
Assemble = Callable[..., System]

U = connector("u", "input")
Y = connector("y", "output")
X = connector("x", "output")


NESTED = ssd(
    wrapped("Connectors", connector("speed", "input", "Real", "km/h"))
    + wrapped(
        "Elements",
        '<ssd:System name="car">'
        + wrapped(
            "Connectors",
            connector("v", "input", "Real", "m/s"),
            connector("way", "output"),
            connector("start", "parameter"),
        )
        + wrapped("Elements", element("engine", U + X + connector("x0", "parameter")))
        + wrapped("Connections", link("v", "engine.u"), link("engine.x", "way"), link("start", "engine.x0"))
        + "</ssd:System>",
        element("meter", U + X),
    )
    + wrapped(
        "Connections",
        link("speed", "car.v"),
        link(
            "car.way", "meter.u", '<ssc:LinearTransformation factor="-2" offset="3"/>', 'suppressUnitConversion="true"'
        ),
    )
)


def test_nested_systems_units_and_linear_transformations(run: Run) -> None:
    """36 km/h are 10 m/s; the way of the car is 10 t, the meter's is the sum of 0.1 s (3 - 2 * 10 t_k) exactly."""
    result = run(NESTED, table="time [s],speed [km/h]\n0,36\n")
    np.testing.assert_allclose(result.columns["car.engine.u"], 10.0, rtol=1e-15)
    np.testing.assert_allclose(result.columns["car.engine.x"], 10.0 * result.time, rtol=1e-14, atol=1e-14)
    assert list(result.columns) == [
        "car.engine.x",
        "car.engine.y",
        "car.engine.positive",
        "meter.x",
        "meter.y",
        "meter.positive",
        "car.engine.u",
    ]
    np.testing.assert_allclose(result.columns["meter.y"], 3.0 - 20.0 * result.time, atol=1e-12)


def test_a_column_is_converted_to_the_connector_and_on(assembled: Assemble) -> None:
    system = assembled(NESTED, table="time [s],speed [m/s]\n0,5\n0.5,6\n", keys="# linear: speed\n")
    assert [(c.target, c.times, c.linear) for c in system.channels] == [(("car.engine", "u"), [0.0, 0.5], True)]
    np.testing.assert_allclose(system.channels[0].values, [5.0, 6.0], rtol=1e-15)
    assert system.connections == [Connection(("car.engine", "x"), ("meter", "u"), -2.0, 3.0)]


def test_an_input_may_be_driven_by_its_own_name_and_parameters_set(assembled: Assemble) -> None:
    keys = "# set: car.engine.gain = 2\n# map: meter.x -> car.engine.u\n"
    structure = NESTED.replace(link("speed", "car.v"), "").replace('kind="output"', 'kind="output"')
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        system = assembled(structure, keys=keys.replace("meter.x", "meter.y"))
    assert system.components[0].parameters == {"gain": 2.0}
    assert system.connections[-1] == Connection(("meter", "y"), ("car.engine", "u"))


def test_parameters_reach_through_systems_and_outer_ones_win(assembled: Assemble) -> None:
    """The gain is set inside (5) and outside (7, by its hierarchical name); x0 by a connector of the inner system."""
    inner = wrapped("ParameterBindings", inline(real("gain", 5), real("offset", 36, "km/h"), units=KMH))
    outer = wrapped("ParameterBindings", inline(real("car.engine.gain", 7), real("start", 4), real("car.start", 2.5)))
    structure = NESTED.replace("</ssd:Connectors></ssd:Component>", f"</ssd:Connectors>{inner}</ssd:Component>", 1)
    structure = structure.replace("<ssd:Elements>", f"{outer}<ssd:Elements>", 1)
    with pytest.warns(ScenarioWarning) as caught:
        system = assembled(structure)
    origin = system.components[0].origins["gain"].removeprefix("set by ")
    assert [str(one.message) for one in caught] == [
        f"{origin}: system 'root' has no parameter of the name start; nothing is set by it"
    ]
    assert system.components[0].parameters == {"gain": 7.0, "offset": pytest.approx(10.0, rel=1e-15), "x0": 2.5}


def test_parameter_files_with_prefix_and_mapping(assembled: Assemble, tmp_path: Path) -> None:
    """offset = 2 * (36 km/h in m/s) + 1 = 21 m/s; x0 takes the number as it is; gain is not mapped, and so not set."""
    mapping = SSM.format(
        '<ssm:MappingEntry source="car.v_wind" target="car.engine.offset">'
        '<ssc:LinearTransformation factor="2" offset="1"/></ssm:MappingEntry>'
        '<ssm:MappingEntry source="car.v_wind" target="car.engine.x0" suppressUnitConversion="true"/>'
        '<ssm:MappingEntry source="car.v_rain" target="meter.x0"/>'
    )
    values = SSV.format(real("v_wind", 36, "km/h") + real("engine.gain", 9), KMH)
    binding = wrapped(
        "ParameterBindings",
        '<ssd:ParameterBinding source="resources/a%20b.ssv" prefix="car.">'
        '<ssd:ParameterMapping source="./resources/m.ssm"/></ssd:ParameterBinding>',
    )
    structure = NESTED.replace("<ssd:Elements>", f"{binding}<ssd:Elements>", 1)
    with pytest.warns(ScenarioWarning) as caught:
        system = assembled(structure, {"resources/a b.ssv": values, "resources/m.ssm": mapping})
    origin = tmp_path / "x.ssp" / "resources" / "a b.ssv"
    assert [str(one.message) for one in caught] == [
        f"{origin}: there is no parameter car.v_rain for the mapping to set something"
    ]
    assert system.components[0].parameters == {"offset": pytest.approx(21.0, rel=1e-15), "x0": 36.0}
    assert system.components[0].origins["x0"] == f"set by {origin}"


def test_start_values_of_inputs(assembled: Assemble, run: Run) -> None:
    """A start value holds until the channel begins; without a channel, all the time. 10 m/s for 0.5 s, then 2 m/s."""
    binding = wrapped("ParameterBindings", inline(real("speed", 36)))
    structure = NESTED.replace("<ssd:Elements>", f"{binding}<ssd:Elements>", 1)
    assert run(structure).columns["car.engine.x"][-1] == pytest.approx(10.0, rel=1e-14)
    held = run(structure, table="time [s],speed [m/s]\n0.5,1\n0.5,2\n")
    assert held.columns["car.engine.x"][-1] == pytest.approx(6.0, rel=1e-14)
    system = assembled(structure, table="time [s],speed [m/s]\n0.5,1\n0.5,2\n0.7,4\n", keys="# linear: speed\n")
    (channel,) = system.channels
    np.testing.assert_allclose(channel.values, [10.0, 10.0, 2.0, 4.0], rtol=1e-15)
    assert (channel.times, channel.linear) == ([0.0, 0.5, 0.5, 0.7], True)


def test_all_types_of_parameters(assembled: Assemble) -> None:
    values = inline(
        '<ssv:Parameter name="updates"><ssv:Integer value="3"/></ssv:Parameter>',
        '<ssv:Parameter name="silent"><ssv:Boolean value="1"/></ssv:Parameter>',
        '<ssv:Parameter name="K"><ssv:Integer value="4"/></ssv:Parameter>',
    )
    system = assembled(
        ssd(
            wrapped(
                "Elements",
                element("s", "", "resources/sampler.fmu", wrapped("ParameterBindings", values)).replace(
                    "<ssd:Connectors></ssd:Connectors>", ""
                ),
            )
        )
    )
    assert system.components[0].parameters == {"updates": 3, "silent": True, "K": 4.0}
    text = inline('<ssv:Parameter name="name"><ssv:String value="a &lt; b"/></ssv:Parameter>')
    system = assembled(
        ssd(
            wrapped(
                "Elements",
                element("l", "", "resources/label.fmu", wrapped("ParameterBindings", text)).replace(
                    "<ssd:Connectors></ssd:Connectors>", ""
                ),
            )
        )
    )
    assert system.components[0].parameters == {"name": "a < b"}


def test_mappings_of_parameter_values(assembled: Assemble) -> None:
    """true -> false, 3 -> 7 while 4 stays, and an enumeration's item by its name."""
    table = '<ssc:{0}MappingTransformation><ssc:MapEntry source="{1}" target="{2}"/></ssc:{0}MappingTransformation>'
    mapping = (
        f'<ssm:MappingEntry source="a" target="silent">{table.format("Boolean", "true", "false")}</ssm:MappingEntry>'
        f'<ssm:MappingEntry source="b" target="updates">{table.format("Integer", "3", "7")}</ssm:MappingEntry>'
        f'<ssm:MappingEntry source="c" target="K">{table.format("Integer", "3", "7")}</ssm:MappingEntry>'
    )
    values = inline(
        '<ssv:Parameter name="a"><ssv:Boolean value="true"/></ssv:Parameter>',
        '<ssv:Parameter name="b"><ssv:Integer value="3"/></ssv:Parameter>',
        '<ssv:Parameter name="c"><ssv:Integer value="4"/></ssv:Parameter>',
        mapping=mapping,
    )
    system = assembled(
        ssd(wrapped("Elements", element("s", U, "resources/sampler.fmu", wrapped("ParameterBindings", values))))
    )
    assert system.components[0].parameters == {"silent": False, "updates": 7, "K": 4.0}
    renamed = table.format("Enumeration", "broken", "error")
    mapping = f'<ssm:MappingEntry source="f" target="fault">{renamed}</ssm:MappingEntry>'
    values = inline('<ssv:Parameter name="f"><ssv:Enumeration value="broken"/></ssv:Parameter>', mapping=mapping)
    system = assembled(
        ssd(
            wrapped(
                "Elements",
                element("f", connector("y", "output"), "resources/faulty.fmu", wrapped("ParameterBindings", values)),
            )
        )
    )
    assert system.components[0].parameters == {"fault": 3}


def test_systems_in_other_files(assembled: Assemble, fmu_path: Callable[[str, int], Path], tmp_path: Path) -> None:
    """An .ssd beside, a variant of an .ssp inside, a system of the same file used twice; an FMU is read once."""
    part = ssd(
        wrapped("Connectors", connector("in", "input"), connector("out", "output"))
        + wrapped("Elements", element("i", U + X, "integrator.fmu"))
        + wrapped("Connections", link("in", "i.u"), link("i.x", "out"))
    )
    inner = tmp_path / "inner.ssp"
    with zipfile.ZipFile(inner, "w") as archive:
        archive.writestr("SystemStructure.ssd", part.replace('"i"', '"wrong"'))
        archive.writestr("B.ssd", part)
        archive.write(fmu_path("integrator", 3), "integrator.fmu")
    ends = connector("in", "input") + connector("out", "output")
    bindings = wrapped("ParameterBindings", inline(real("i.gain", 3)))
    structure = ssd(
        wrapped(
            "Elements",
            element("a", ends, "resources/part.ssd", bindings).replace(
                "<ssd:Component ", '<ssd:Component type="application/x-ssp-definition" '
            ),
            element("b", ends, "resources/inner.ssp#B.ssd").replace(
                "<ssd:Component ", '<ssd:Component type="application/x-ssp-package" '
            ),
            element("c", ends, "#again").replace(
                "<ssd:Component ", '<ssd:Component type="application/x-ssp-definition" '
            ),
            '<ssd:System name="d" id="again">'
            + wrapped("Connectors", ends)
            + wrapped("Elements", element("i", U + X))
            + wrapped("Connections", link("in", "i.u"), link("i.x", "out"))
            + "</ssd:System>",
        )
        + wrapped(
            "Connections",
            *(link(f"{a}.out", f"{b}.in", more='suppressUnitConversion="true"') for a, b in ("ab", "bc", "cd")),
        ),
    )
    files: dict[str, str | bytes] = {
        "resources/part.ssd": part,
        "resources/inner.ssp": inner.read_bytes(),
    }
    system = assembled(structure, files)
    assert [component.name for component in system.components] == ["a.i", "b.i", "c.i", "d.i"]
    assert [(c.source, c.target) for c in system.connections] == [
        ((f"{a}.i", "x"), (f"{b}.i", "u")) for a, b in ("ab", "bc", "cd")
    ]
    assert system.components[0].parameters == {"gain": 3.0}
    fmus = [component.fmu for component in system.components]
    assert fmus[0] is fmus[2] is fmus[3] and fmus[1] is not fmus[0]


def test_a_variant_and_a_structure_in_a_folder(assembled: Assemble, pack: Callable[..., Path], tmp_path: Path) -> None:
    other = NESTED.replace('name="meter"', 'name="gauge"').replace('"meter"', '"gauge"')
    assert assembled(NESTED, {"B.ssd": other}, system="x.ssp#B.ssd").components[1].name == "gauge"
    with zipfile.ZipFile(pack(NESTED)) as archive:
        archive.extractall(tmp_path)
    system = assembled(NESTED, system="SystemStructure.ssd")
    assert [component.name for component in system.components] == ["car.engine", "meter"]


def test_version_2(assembled: Assemble) -> None:
    structure = NESTED.replace('version="1.0"', 'version="2.0"').replace("ssc:Real", "ssc:Float64")
    assert assembled(structure).connections == assembled(NESTED).connections


def test_the_direction_is_that_of_the_kinds_not_of_the_ends(assembled: Assemble) -> None:
    turned = NESTED.replace(link("v", "engine.u"), link("engine.u", "v")).replace(
        link("speed", "car.v"), link("car.v", "speed")
    )
    assert assembled(turned, table="time [s],speed [km/h]\n0,36\n").channels == [
        Channel(("car.engine", "u"), [0.0], [10.0])
    ]


def test_mapping_tables_on_connections(run: Run) -> None:
    """A contact is negated, whole numbers are renumbered, and the items of an enumeration are mapped by name."""

    def table(kind: str, *pairs: tuple[str, str]) -> str:
        entries = "".join(f'<ssc:MapEntry source="{a}" target="{b}"/>' for a, b in pairs)
        return f"<ssc:{kind}MappingTransformation>{entries}</ssc:{kind}MappingTransformation>"

    kinds = ("Boolean", "Int32", "Enumeration")
    ends = "".join(
        connector(f"{letter}_{kind}", way) for kind in kinds for letter, way in (("u", "input"), ("y", "output"))
    )
    structure = ssd(
        wrapped("Connectors", "".join(connector(kind, "input") for kind in kinds))
        + wrapped("Elements", element("a", ends, "resources/mirror.fmu"), element("b", ends, "resources/mirror.fmu"))
        + wrapped(
            "Connections",
            link("Int32", "a.u_Int32", table("Integer", ("1", "5"))),
            *(link(kind, f"a.u_{kind}") for kind in kinds if kind != "Int32"),
            link("a.y_Boolean", "b.u_Boolean", table("Boolean", ("true", "false"), ("0", "1"))),
            link("a.y_Int32", "b.u_Int32", table("Integer", ("5", "-3"))),
            link("a.y_Enumeration", "b.u_Enumeration", table("Enumeration", ("left", "right"), ("right", "left"))),
        )
    )
    result = run(structure, table="time [s],Boolean,Int32,Enumeration\n0,1,1,1\n0.5,0,2,3\n")
    assert [result.columns[f"a.y_{kind}"][5] for kind in kinds] == [1, 5, 1]
    assert [result.columns[f"b.y_{kind}"][5] for kind in kinds] == [0, -3, 3]
    assert [result.columns[f"b.y_{kind}"][-1] for kind in kinds] == [1, 2, 1]


def test_what_other_tools_write_against_the_standard(assembled: Assemble, tmp_path: Path) -> None:
    """Empty names for the system itself and for no unit, and units that are not defined, with a warning."""
    structure = ssd(
        wrapped("Connectors", connector("v", "input", "Real", "cm/s"), connector("w", "input", "Real", "[furlong]"))
        + wrapped("Elements", element("a", connector("u", "input", "Real")), element("b", U))
        + wrapped("Connections", link("v", "a.u"), link("w", "b.u"))
    )
    structure = structure.replace("<ssc:Real/>", '<ssc:Real unit=""/>').replace(
        'startConnector="v"', 'startElement="" startConnector="v"'
    )
    with pytest.warns(FmuWarning) as caught:
        system = assembled(structure, table="time [s],v [cm/s],w [m/s]\n0,100,3\n")
    assert [(channel.target, channel.values) for channel in system.channels] == [
        (("a", "u"), [1.0]),
        (("b", "u"), [3.0]),
    ]
    place = f"{tmp_path / 'x.ssp' / 'SystemStructure.ssd'}:1: the unit"
    assert [str(one.message) for one in caught] == [
        f"{place} 'cm/s' is not defined in the Units of this file, taken as the SI has it",
        f"{place} '[furlong]' is not defined in the Units of this file, so that numbers in it are not converted",
    ]


DIMENSION = '<ssc:Dimension size="3"/>'


def array(name: str, kind: str, dimensions: str = DIMENSION) -> str:
    return f'<ssd:Connector name="{name}" kind="{kind}"><ssc:Float64/>{dimensions}</ssd:Connector>'


def test_arrays_of_version_2(run: Run) -> None:
    """y = K u per element: K = 1, 2, 4 in the first, its start value 1 in the second; u = 5, 6, 7."""
    dimensions = f'{DIMENSION}<ssc:Dimension size="1"/>'
    gains = f'<ssv:Parameter name="first.K"><ssv:Float64 value="1 2 4"/>{dimensions}</ssv:Parameter>'
    binding = inline(gains).replace('version="1.0"', 'version="2.0"')
    structure = ssd(
        wrapped("Connectors", array("v", "input"))
        + wrapped("ParameterBindings", binding)
        + wrapped(
            "Elements",
            element("first", array("u", "input") + array("y", "output"), "resources/vector.fmu"),
            element("second", array("u", "input"), "resources/vector.fmu"),
        )
        + wrapped("Connections", link("v", "first.u"), link("first.y", "second.u"))
    ).replace('version="1.0"', 'version="2.0"', 1)
    result = run(structure, table="time [s],v[1] [m],v[2] [m],v[3] [m]\n0,5,6,7\n")
    assert [result.columns[f"first.y[{k}]"][-1] for k in (1, 2, 3)] == [5.0, 12.0, 28.0]
    assert [result.columns[f"second.y[{k}]"][-1] for k in (1, 2, 3)] == [5.0, 12.0, 28.0]


def test_arrays_that_do_not_fit(refusal: Callable[..., str]) -> None:
    def refused(ends: str, more: str = "", first: str = "first.y") -> str:
        structure = ssd(
            wrapped(
                "Elements",
                element("first", array("y", "output"), "resources/vector.fmu"),
                element("second", ends, "resources/vector.fmu"),
            )
            + wrapped("Connections", link(first, "second.u", more=more))
        )
        return refusal(structure.replace('version="1.0"', 'version="2.0"')).partition(":1: ")[2]

    assert refused(array("u", "input", "<ssc:Dimension/>")) == (
        "'u' is an array without a fixed size; give its Dimension a size"
    )
    assert refused(array("u", "input", '<ssc:Dimension size="2"/>')) == (
        "'y' and 'u' are connected, but have 3 elements and 2 elements; connect what has as many"
    )
    assert refused(connector("u", "input")) == (
        "'y' and 'u' are connected, but have 3 elements and a scalar; connect what has as many"
    )
    assert refused(connector("u", "input"), first="second.u") == (
        "connector 'u' of 'second' is an array in the FMU; give it a Dimension with its size"
    )
    assert refused(array("u", "input"), 'startIndices="1" endIndices="1"') == (
        "'startIndices' picks elements of an array, and the standard does not say whether they count from 0 or 1; "
        "connect whole arrays"
    )


def test_parameters_inside_of_the_fmu(
    assembled: Assemble, refusal: Callable[..., str], fmu_path: Callable[[str, int], Path], tmp_path: Path
) -> None:
    own = tmp_path / "own.fmu"
    own.write_bytes(fmu_path("integrator", 3).read_bytes())
    with zipfile.ZipFile(own, "a") as archive:
        archive.writestr("resources/p.ssv", SSV.format(real("gain", 6), ""))
    binding = '<ssd:ParameterBinding source="resources/p.ssv" sourceBase="component"/>'
    inside = element("a", U, "resources/own.fmu", wrapped("ParameterBindings", binding))
    files: dict[str, str | bytes] = {"resources/own.fmu": own.read_bytes()}
    system = assembled(ssd(wrapped("Elements", inside)), files)
    assert system.components[0].parameters == {"gain": 6.0}
    assert system.components[0].origins["gain"].endswith("x.ssp/resources/own.fmu/resources/p.ssv")
    outside = ssd(wrapped("ParameterBindings", binding) + wrapped("Elements", inside))
    assert refusal(outside, files) == (
        "x.ssp/SystemStructure.ssd:1: 'resources/p.ssv' is said to lie inside of a component, but this is a system"
    )
