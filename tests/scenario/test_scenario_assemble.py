"""From a scenario to the engine's system, with plants and controllers that exist only as lists of variables."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import pytest

from cosim.engine import Connection, Fmu, PowerConnection, System, Variable
from cosim.errors import FmuError, InputError
from cosim.scenario import ScenarioWarning, assemble, read


def variable(
    name: str,
    causality: str,
    unit: str | None = None,
    *,
    kind: str = "Real",
    start: float | str | None = None,
    literals: tuple[str, ...] | None = None,
    minimum: float | None = None,
    maximum: float | None = None,
) -> Variable:
    return Variable(name, kind, causality, "continuous", unit, None, start, 0, literals, None, minimum, maximum)


def fmu(name: str, *variables: Variable) -> Fmu:
    fake = SimpleNamespace(
        name=name,
        path=Path(f"{name}.fmu"),
        variables={v.name: v for v in variables},
        capabilities={"canBeInstantiatedOnlyOncePerProcess": False},
        left_out={},
    )
    return cast(Fmu, fake)


PLANT = fmu(
    "Plant",
    variable("duty", "input", "1", start=0.0, minimum=0.0, maximum=1.1),
    variable("v_supply", "input", "V", start=28.0),
    variable("lights", "input", kind="Boolean"),
    variable("gear", "input", kind="Enumeration", literals=("LOW", "HIGH")),
    variable("free", "input"),
    variable("odd", "input", "wiggles"),
    variable("i_motor", "output", "A"),
    variable("tau_crank", "output", "N.m"),
    variable("park", "output", kind="Boolean"),
    variable("ext_load", "parameter", "N.m", start=3.0),
    variable("motor.R", "parameter", "Ohm", start=1.91, minimum=0.0),
    variable("n", "parameter", kind="Integer", start=2, minimum=1, maximum=256),
    variable("brake", "parameter", kind="Boolean"),
    variable("load", "parameter", kind="Enumeration", literals=("simple", "naive")),
    variable("file", "parameter", kind="String"),
    variable("motor.i", "local", "A"),
)
CONTROLLER = fmu(
    "Controller",
    variable("i_motor", "input", "mA"),
    variable("park", "input", kind="Boolean"),
    variable("enable", "input", kind="Boolean"),
    variable("torque", "input", "N.m"),
    variable("duty", "output", "1"),
    variable("T_compute", "parameter", "s", start=0.001),
    variable("T_sample", "parameter", "ms", start=20.0, maximum=1000.0),
)
OTHER = fmu("Other", variable("volt", "input", "V"), variable("u", "output", "1"), variable("ext_load", "parameter"))
CLASH = fmu("Clash", variable("i_motor", "input", "V"), variable("duty", "output", "1"))
LOAD = fmu("Load", variable("tau", "input", "N.m"), variable("w", "output", "rad/s"))
FMUS = {"plant": PLANT, "control": CONTROLLER, "other": OTHER, "clash": CLASH, "load": LOAD}

Assemble = Callable[..., System]


def locate(name: str) -> Path:
    if name not in FMUS:
        raise InputError(f"no built-in '{name}'; there are {', '.join(FMUS)}")
    return Path(name)


@pytest.fixture
def build(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Assemble:
    monkeypatch.setattr(Fmu, "read", staticmethod(lambda path: FMUS[Path(path).stem]))

    def run(lines: str, table: str = "time [s]\n", *options: str, controller: str = "control") -> System:
        head = f"# system: plant\n# controller: {controller}\n# stop: 2 s\n"
        (tmp_path / "x.csv").write_text(head + lines + table)
        return assemble(read(tmp_path / "x.csv", options), locate)

    return run


@pytest.fixture
def refusal(build: Assemble, tmp_path: Path) -> Callable[..., str]:
    def run(*arguments: str, controller: str = "control") -> str:
        with pytest.raises(InputError) as error:
            build(*arguments, controller=controller)
        return str(error.value).removeprefix(f"{tmp_path / 'x.csv'}:").strip()

    return run


def test_names_connect_with_their_units(build: Assemble) -> None:
    system = build("")
    assert [component.name for component in system.components] == ["plant", "controller"]
    assert system.connections == [
        Connection(("controller", "duty"), ("plant", "duty")),
        Connection(("plant", "i_motor"), ("controller", "i_motor"), 1000.0),
        Connection(("plant", "park"), ("controller", "park")),
    ]
    assert system.components[1].parameters == {"T_sample": 20.0}


def test_a_plant_alone(build: Assemble) -> None:
    system = build("", "time [ms],duty [%],lights [1],gear,free\n0,0,0,1,7\n0,100,,,\n500,50,1,2,\n", controller="none")
    assert [component.name for component in system.components] == ["plant"]
    assert system.connections == []
    assert [(c.target, c.times, c.values, c.linear) for c in system.channels] == [
        (("plant", "duty"), [0.0, 0.0, 0.5], [0.0, 1.0, 0.5], False),
        (("plant", "lights"), [0.0, 0.5], [0.0, 1.0], False),
        (("plant", "gear"), [0.0, 0.5], [1.0, 2.0], False),
        (("plant", "free"), [0.0], [7.0], False),
    ]


def test_linear_channels_and_qualified_names(build: Assemble) -> None:
    system = build("# linear: plant.v_supply\n", "time [s],plant.v_supply [mV]\n0,24000\n1,28000\n")
    assert [(c.target, c.values, c.linear) for c in system.channels] == [(("plant", "v_supply"), [24.0, 28.0], True)]


def test_parameters_are_converted(build: Assemble) -> None:
    system = build(
        "# set: plant.ext_load = 40 N.cm\n# set: motor.R = 2 Ohm\n# set: n = 3\n# set: brake = true\n"
        "# set: load = naive\n# set: file = a b.txt\n# set: controller.T_compute = 2 ms\n",
        "time [s]\n",
        "plant.ext_load=5 N.m",
        "sample_time=50 ms",
    )
    assert system.components[0].parameters == {
        "ext_load": 5.0,
        "motor.R": 2.0,
        "n": 3,
        "brake": True,
        "load": 2,
        "file": "a b.txt",
    }
    assert system.components[1].parameters == {"T_compute": 0.002, "T_sample": 50.0}


def test_an_option_wins_over_a_line_with_another_spelling(build: Assemble) -> None:
    system = build("# set: plant.ext_load = 4 N.m\n", "time [s]\n", "ext_load=5 N.m")
    assert system.components[0].parameters == {"ext_load": 5.0}


@pytest.mark.parametrize(
    ("line", "option", "sample"),
    [
        ("sample_time: 50 ms", "T_sample=10 ms", 10.0),
        ("sample_time: 50 ms", "controller.T_sample=10 ms", 10.0),
        ("set: T_sample = 50 ms", "sample_time=10 ms", 10.0),
        ("set: T_sample = 50 ms", "plant.n=2", 50.0),
    ],
)
def test_an_option_wins_over_either_name_of_the_sample_time(
    build: Assemble, line: str, option: str, sample: float
) -> None:
    assert build(f"# {line}\n", "time [s]\n", option).components[1].parameters == {"T_sample": sample}


def test_two_options_for_the_sample_time_are_refused(build: Assemble) -> None:
    with pytest.raises(InputError) as error:
        build("", "time [s]\n", "sample_time=10 ms", "T_sample=10 ms")
    assert str(error.value) == "--set: 'sample_time' and 'controller.T_sample' are both given; keep one of them"


def test_bounds_are_reached_in_any_unit(build: Assemble) -> None:
    system = build("# set: motor.R = 0 mOhm\n# set: n = 256\n", "time [s],duty [%]\n0,0\n1,110\n", controller="none")
    assert system.components[0].parameters == {"motor.R": 0.0, "n": 256}
    assert system.channels[0].values == pytest.approx([0.0, 1.1])


def test_what_has_set_a_parameter_is_kept(build: Assemble) -> None:
    lines = "# set: plant.ext_load = 4 N.m\n# set: n = 3\n"
    plant, controller = build(lines, "time [s]\n", "n=4").components
    assert plant.origins == {"ext_load": "set by the scenario", "n": "set by --set"}
    assert controller.origins == {"T_sample": "set by the scenario's default sample_time"}
    assert build("# sample_time: 10 ms\n").components[1].origins == {"T_sample": "set by the scenario"}
    assert build("# sample_time: 10 ms\n", "time [s]\n", "T_sample=5 ms").components[1].origins == {
        "T_sample": "set by --set"
    }


def test_a_map_replaces_the_name(build: Assemble) -> None:
    system = build("# map: plant.tau_crank -> controller.torque\n# map: controller.duty -> plant.free\n")
    assert Connection(("plant", "tau_crank"), ("controller", "torque")) in system.connections
    assert Connection(("controller", "duty"), ("plant", "free")) in system.connections


LOADED = "# map: plant.tau_crank -> controller.tau\n# map: controller.w -> plant.free\n"


def test_a_power_is_an_effort_and_a_flow(build: Assemble) -> None:
    system = build(f"{LOADED}# power: plant.tau_crank * controller.w\n", controller="load")
    assert system.power == [PowerConnection(("plant", "tau_crank"), ("controller", "w"))]
    turned = build(f"# power: -plant.tau_crank*controller.w\n{LOADED}", controller="load")
    assert turned.power == [PowerConnection(("plant", "tau_crank"), ("controller", "w"), -1.0)]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (
            "plant.tau_crank controller.w",
            "'plant.tau_crank controller.w' is not a power; write 'power: component.effort * component.flow', for "
            "example 'power: motor.tau * load.w'",
        ),
        (
            "plant.tau_crank * controller.omega",
            "controller.omega: Load has no output omega; its outputs are w",
        ),
        (
            "plant.i_motor * controller.w",
            "power plant.i_motor * controller.w: plant.i_motor drives no input of controller; power goes over one "
            "connection each way",
        ),
    ],
)
def test_a_power_that_is_refused(refusal: Callable[..., str], line: str, message: str) -> None:
    assert refusal(f"{LOADED}# power: {line}\n", controller="load") == f"6: {message}"


PARAMETERS = "parameters are plant.ext_load, plant.motor.R, plant.n, plant.brake, plant.load, plant.file"
INPUTS = "inputs are plant.duty, plant.v_supply, plant.lights, plant.gear, plant.free, plant.odd"


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (
            "set: plant.ext_lod = 4 N.m",
            f"4: unknown parameter 'plant.ext_lod', did you mean 'plant.ext_load'?; {PARAMETERS}",
        ),
        (
            "set: v_supply = 24 V",
            "4: 'plant.v_supply' is an input, not a parameter; drive it with a column 'v_supply [V]'",
        ),
        (
            "set: motor.i = 1 A",
            f"4: 'plant.motor.i' is computed by the model, not a parameter; {PARAMETERS}, "
            "controller.T_compute, controller.T_sample",
        ),
        (
            "set: ext_lod = 4 N.m",
            f"4: unknown parameter 'ext_lod', did you mean 'plant.ext_load'?; {PARAMETERS}, "
            "controller.T_compute, controller.T_sample",
        ),
        ("set: ext_load = 4", "4: '4' is in 1, 'plant.ext_load' is in N.m; write for example 4 N.m"),
        ("set: ext_load = 4 A", "4: '4 A' is in A, 'plant.ext_load' is in N.m; write for example 4 N.m"),
        (
            "set: ext_load = much",
            "4: 'plant.ext_load': 'much' is not a number with a unit; write it like 20 ms or 4.5 N.m",
        ),
        ("set: motor.R = -10 mOhm", "4: plant.motor.R = -0.01 Ohm is below its minimum 0 Ohm"),
        ("set: n = 0", "4: plant.n = 0 is below its minimum 1"),
        ("set: n = 257", "4: plant.n = 257 is above its maximum 256"),
        ("sample_time: 2 s", "4: 'sample_time': controller.T_sample = 2000 ms is above its maximum 1000 ms"),
        ("set: n = 1.5", "4: 'plant.n' is an Integer, '1.5' is not; write a whole number"),
        ("set: brake = 2", "4: 'plant.brake' is a Boolean, '2' is not; write 0 or 1"),
        (
            "set: load = nave",
            "4: 'plant.load' has no value 'nave', did you mean 'naive'?; "
            "it takes whole numbers from 1 to 2 or one of simple, naive",
        ),
        ("set: n = 1\n# set: plant.n = 2", "5: 'plant.n' is set a second time, first in line 4"),
        (
            "sample_time: 1.5 ms",
            "4: the sample time 0.0015 s is not a multiple of the controller's T_compute, 0.001 s; "
            "change 'sample_time' or set controller.T_compute",
        ),
        (
            "sample_time: 20 ms\n# set: T_sample = 10 ms",
            "4: 'sample_time' and 'controller.T_sample' are both given; keep one of them",
        ),
        (
            "map: plant.tau_crnk -> controller.torque",
            "4: unknown output 'plant.tau_crnk', did you mean 'plant.tau_crank'?; "
            "outputs are plant.i_motor, plant.tau_crank, plant.park",
        ),
        (
            "map: motor.tau -> controller.torque",
            "4: 'motor.tau': there is no component 'motor'; there is plant and controller",
        ),
        (
            "map: plant.i_motor -> controller.torque",
            "4: plant.i_motor [A] cannot drive controller.torque [N.m]: cannot convert A to N.m: A against kg.m2.s-2",
        ),
        (
            "map: plant.i_motor -> controller.i_motor\n# map: plant.tau_crank -> controller.i_motor",
            "5: 'controller.i_motor' is connected a second time; an input has one source",
        ),
    ],
)
def test_lines_that_are_refused(refusal: Callable[..., str], line: str, message: str) -> None:
    assert refusal(f"# {line}\n") == message


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("dutty [1]\n0,1", f"4:2: unknown channel 'dutty', did you mean 'plant.duty'?; {INPUTS}"),
        (
            "duty[1]\n0,1",
            f"4:2: unknown channel 'duty[1]', did you mean 'plant.duty'?; {INPUTS}; "
            "if [1] is the unit, write 'duty [1]'",
        ),
        ("dutty[1]\n0,1", f"4:2: unknown channel 'dutty[1]', did you mean 'plant.duty'?; {INPUTS}"),
        ("duty[2]\n0,1", f"4:2: unknown channel 'duty[2]', did you mean 'plant.duty'?; {INPUTS}"),
        ("i_motor [A]\n0,1", f"4:2: 'plant.i_motor' is an output, not an input; {INPUTS}"),
        (
            "ext_load [N.m]\n0,1",
            "4:2: 'plant.ext_load' is a parameter, not an input; set it with '# set: plant.ext_load = ...'",
        ),
        (
            "v_supply [A]\n0,1",
            "4:2: column 'v_supply' is in A, 'plant.v_supply' is in V; write 'v_supply [V]'",
        ),
        ("v_supply\n0,1", "4:2: column 'v_supply' has no unit, 'plant.v_supply' is in V; write 'v_supply [V]'"),
        (
            "free [ms]\n0,1",
            "4:2: column 'free' is in ms, but the FMU gives no unit for 'plant.free'; "
            "write the number as the FMU takes it",
        ),
        (
            "odd [mm]\n0,1",
            "4:2: column 'odd' is in mm, but the FMU gives the unit 'wiggles', which is not understood, "
            "for 'plant.odd'; write the number as the FMU takes it",
        ),
        ("lights [V]\n0,1", "4:2: column 'lights' is in V, 'plant.lights' is Boolean; write 'lights [1]'"),
        ("lights\n0,1\n1,0.5", "6:2: 0.5 in column 'lights': 'plant.lights' takes 0 and 1"),
        ("duty [%]\n0,0\n1,-1", "6:2: plant.duty = -0.01 is below its minimum 0"),
        ("free,duty\n0,0,0\n1,0,2", "6:3: plant.duty = 2 is above its maximum 1.1"),
        ("gear\n0,1\n1,3", "6:2: 3 in column 'gear': 'plant.gear' takes whole numbers from 1 to 2"),
        (
            "duty [1],plant.duty [1]\n0,1,1",
            "4:3: column 'plant.duty': 'plant.duty' is driven already in column 2; remove the column",
        ),
    ],
)
def test_columns_that_are_refused(refusal: Callable[..., str], table: str, message: str) -> None:
    assert refusal("", f"time [s],{table}\n", controller="none") == message


def test_a_column_cannot_drive_what_is_connected(refusal: Callable[..., str]) -> None:
    assert refusal("", "time [s],duty [1]\n0,1\n") == (
        "4:2: column 'duty': 'plant.duty' is driven already by controller.duty; remove the column or the controller"
    )


def test_a_boolean_cannot_be_linear(refusal: Callable[..., str]) -> None:
    assert refusal("# linear: lights\n", "time [s],lights\n0,1\n", controller="none") == (
        "5:2: column 'lights' cannot be linear: 'plant.lights' is Boolean; take it out of 'linear'"
    )


def test_a_name_of_two_components_needs_the_component(refusal: Callable[..., str]) -> None:
    assert refusal("# map: controller.u -> plant.duty\n# set: ext_load = 1 N.m\n", controller="other") == (
        "5: 'ext_load' is parameter of more than one component; write plant.ext_load or controller.ext_load"
    )


def test_nothing_connects(refusal: Callable[..., str]) -> None:
    assert refusal("", controller="other") == (
        "2: nothing connects plant and controller, no output has the name of an input; "
        "plant has outputs i_motor, tau_crank, park and inputs duty, v_supply, lights, gear, free, odd, "
        "controller has outputs u and inputs volt; add '# map: ...' lines"
    )


def test_the_same_name_with_another_dimension(refusal: Callable[..., str]) -> None:
    assert refusal("", controller="clash") == (
        "plant.i_motor [A] cannot drive controller.i_motor [V]: cannot convert A to V: A against kg.m2.s-3.A-1; "
        "connect it otherwise with a 'map' line"
    )


def test_a_unit_that_only_the_fmu_understands_is_not_converted(build: Assemble) -> None:
    with pytest.warns(ScenarioWarning) as caught:
        system = build("# map: controller.duty -> plant.odd\n")
    assert Connection(("controller", "duty"), ("plant", "odd")) in system.connections
    assert str(caught[0].message) == (
        "controller.duty [1] drives plant.odd [wiggles] without conversion, "
        "the unit 'wiggles' of the FMU is not understood"
    )


def test_types_that_do_not_fit_are_refused_with_the_file(refusal: Callable[..., str]) -> None:
    assert refusal("# map: plant.tau_crank -> controller.enable\n").startswith(
        "plant.tau_crank -> controller.enable: a Real cannot drive a Boolean"
    )


def test_fmus_that_are_not_there(refusal: Callable[..., str], tmp_path: Path) -> None:
    assert refusal("", controller="linkge") == "2: no built-in 'linkge'; there are plant, control, other, clash, load"
    assert refusal("", controller="my/own.fmu") == f"2: there is no FMU '{tmp_path / 'my/own.fmu'}'"
    assert refusal("", controller="system.SSP") == (
        "2: 'system.SSP' is a whole system; give it as 'system', without a controller"
    )


def test_an_fmu_is_found_beside_the_scenario(build: Assemble, tmp_path: Path) -> None:
    (tmp_path / "control.fmu").touch()
    assert build("", controller="control.fmu").components[1].fmu is CONTROLLER


def test_an_fmu_that_cannot_be_read_keeps_its_own_place(
    refusal: Callable[..., str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(path: Path) -> Fmu:
        raise FmuError("is no FMU", file=path)

    monkeypatch.setattr(Fmu, "read", staticmethod(fail))
    assert refusal("") == "plant: is no FMU"


@pytest.mark.parametrize(
    ("controller", "reason"),
    [("none", "there is no controller"), ("other", "the controller has no parameter T_sample")],
)
def test_a_sample_time_that_nothing_uses_is_said(build: Assemble, tmp_path: Path, controller: str, reason: str) -> None:
    lines = "# sample_time: 10 ms\n" + ("# map: controller.u -> plant.duty\n" if controller == "other" else "")
    with pytest.warns(ScenarioWarning) as caught:
        build(lines, controller=controller)
    assert str(caught[0].message) == f"{tmp_path / 'x.csv'}: 'sample_time' has no effect, {reason}"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        build(lines.partition("\n")[2], controller=controller)
