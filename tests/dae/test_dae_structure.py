"""What the compiler makes of a model: states, torn unknowns, index, sizes, and what it tells about them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from networks import Part, compile_network

from cosim.dae import Dae, explain
from cosim.fmu import compile_model

pytest.importorskip("rumoca")

TESTS = Path(__file__).parents[1]
LIBRARY = TESTS.parent / "modelica" / "WiperDrive"
SMALL = TESTS / "models" / "Small"

Compile = Callable[[str], Dae]


@pytest.fixture(scope="module")
def plant() -> Dae:
    return compile_model(LIBRARY, "WiperDrive.Systems.LinkagePlant")


def small(name: str) -> Dae:
    return compile_model(SMALL / f"{name}.mo", f"Small.{name}")


def test_the_linkage_plant_has_three_states_and_five_torn_unknowns(plant: Dae) -> None:
    assert [state.name for state in plant.states] == ["phi_crank", "w_crank", "bridge.i"]
    assert [unknown.name for unknown in plant.torn] == [
        "phi_ds",
        "linkage.ds.coupler.phi",
        "phi_ps",
        "linkage.ps.coupler.phi",
        "der(der(phi_crank))",
    ]
    assert plant.sizes.index == 3
    assert plant.sizes.after_aliases < plant.sizes.flat / 3


def test_the_explanation_of_the_linkage_plant_can_be_read(plant: Dae) -> None:
    lines = explain(plant).splitlines()
    what = "Wiper drive with the two four-bar linkages and the load of the blades"
    assert lines[0] == f"WiperDrive.Systems.LinkagePlant: {what}"
    sizes = plant.sizes
    assert lines[6:8] == [
        f"equations             {sizes.flat} flat, {sizes.after_aliases} after alias elimination,"
        f" {sizes.differentiated} with derivatives of constraints",
        "differentiation index 3",
    ]
    start = lines.index("continuous states     3")
    assert lines[start + 1 : start + 4] == ["    phi_crank", "    w_crank", "    bridge.i"]
    assert "    phi_crank = 0 (fixed start) (Drive.mo:18)" in lines
    assert "    v_motor = bridge.p.v = bridge.v = motor.p.v = motor.filter_supply.p.v" in lines
    assert max(len(line) for line in lines) <= 120


def test_the_explanation_of_a_linkage_tells_what_became_of_its_equations() -> None:
    assert (
        explain(small("FourBar"))
        == """\
Small.FourBar: A planar four-bar linkage whose crank turns all the way; the rocker has a moment of inertia

inputs                tau
outputs               phi, w, theta, psi, w_3, E
parameters            6, 6 of them to be set
equations             8 flat, 6 after alias elimination, 10 with derivatives of constraints
differentiation index 3
differentiated        2 equations
    twice: a * cos(phi) + b * cos(theta) = d + c * cos(psi) (FourBar.mo:20)
    twice: a * sin(phi) + b * sin(theta) = c * sin(psi) (FourBar.mo:21)
continuous states     2
    phi
    w
not chosen as states  der(theta), w_3, theta, psi
torn unknowns         2, found by the solver together with the states
    theta
    psi
blocks                4, 1 of them single assignments
    block 1: implicit, 2 unknowns, torn in theta, psi: theta, psi
    block 2: linear, 2 unknowns, solved symbolically: der(theta), der(psi)
    block 3: linear, 5 unknowns, solved symbolically: F_x, F_y, der(der(phi)), der(der(theta)), der(der(psi))
state events          none
time events           none
discrete variables    none
assertions            none
initial system        4 equations
    a * cos(phi) + b * cos(theta) = d + c * cos(psi) (FourBar.mo:20)
    a * sin(phi) + b * sin(theta) = c * sin(psi) (FourBar.mo:21)
    phi = 0 (fixed start) (FourBar.mo:10)
    w = 6 (fixed start) (FourBar.mo:11)
eliminated aliases    2
    der(phi) = w
    der(psi) = w_3"""
    )


def test_the_explanation_of_a_brake_and_a_chopper_tells_of_their_events() -> None:
    lines = explain(small("Brake")).splitlines()
    start = lines.index("state events          4, where one of these changes its value")
    assert (
        lines[start : start + 15]
        == """\
state events          4, where one of these changes its value
    w < 0
    w > 0
    tau > tau_0
    tau < -tau_0
time events           none
discrete variables    stuck, direction
    when-condition: pre(direction) > 0 and w < 0 or pre(direction) < 0 and w > 0
    when-condition: pre(stuck) and tau > tau_0
    when-condition: pre(stuck) and tau < -tau_0
    in when-clauses: stuck
    in when-clauses: direction
    when-condition: stuck
reinitialised states  w
assertions            none""".splitlines()
    )
    lines = explain(small("Chopper")).splitlines()
    start = lines.index("time events           2 sample clocks")
    assert lines[start + 1 : start + 3] == ["    every 0.001 s from 0 s on", "    every 0.001 s from 0.0003 s on"]
    assert "    i = 0 (fixed start) (Chopper.mo:3)" in lines


def test_a_start_that_the_model_leaves_open_is_pointed_out(tmp_path: Path) -> None:
    dae = compile_text(tmp_path, "  Real x(start=2);\nequation\n  der(x) = -x;")
    assert "    x = its start value, which is not fixed" in explain(dae).splitlines()


def test_the_rig_has_the_same_states_and_one_torn_unknown_at_most() -> None:
    dae = compile_model(LIBRARY, "WiperDrive.Systems.RigPlant")
    assert [state.name for state in dae.states] == ["phi_crank", "w_crank", "bridge.i"]
    assert len(dae.torn) <= 1


@pytest.mark.parametrize(
    ("name", "index", "states", "torn"),
    [
        ("MotorOnSpring", 1, ["inductor.i", "rotor.phi", "rotor.w"], []),
        ("PendulumXY", 3, ["x", "vx"], ["y"]),
        ("PendulumAngle", 1, ["phi", "w"], []),
        ("SeriesInductors", 2, ["first.i"], []),
        ("ParallelCapacitors", 2, ["first.v"], []),
        ("GearedInertias", 3, ["fast.phi", "fast.w"], []),
        ("SliderCrank", 3, ["phi", "w"], ["psi"]),
        ("DoublePendulum", 3, ["a", "wa", "b", "wb"], []),
        ("Rectifier", 1, ["capacitor.v"], []),
        ("Rod", 1, [f"T[{k}]" for k in range(1, 9)], []),
        ("Lights", 1, [], []),
        ("Coupled", 2, ["z"], []),
    ],
)
def test_a_small_model_gets_as_few_states_as_it_has_freedoms(
    name: str, index: int, states: list[str], torn: list[str]
) -> None:
    dae = small(name)
    assert [state.name for state in dae.states] == states
    assert [unknown.name for unknown in dae.torn] == torn
    # inductors in one loop and capacitors side by side are equal by an alias equation, before any reduction
    assert dae.sizes.index == (1 if name in ("SeriesInductors", "ParallelCapacitors") else index)


def compile_text(tmp_path: Path, body: str) -> Dae:
    file = tmp_path / "M.mo"
    file.write_text(f'model M "Model"\n{body}\nend M;\n')
    return compile_model(file, "M")


@pytest.mark.parametrize(("x", "z", "state"), [("prefer", "default", "x"), ("default", "prefer", "z")])
def test_state_select_decides_among_equal_choices(tmp_path: Path, x: str, z: str, state: str) -> None:
    dae = compile_text(
        tmp_path,
        f"""  Real x(stateSelect=StateSelect.{x});
              Real z(stateSelect=StateSelect.{z});
              Real f;
            equation
              der(x) = -x + f;
              der(z) = -f;
              z = 3*x + 1;""",
    )
    assert [unknown.name for unknown in dae.states] == [state]


def test_a_fixed_start_decides_among_equal_choices(tmp_path: Path) -> None:
    body = "  Real x{0};\n  Real z{1};\n  Real f;\nequation\n  der(x) = -x + f;\n  der(z) = -f;\n  z = 3*x + 1;"
    fixed = "(start=1, fixed=true)"
    assert [s.name for s in compile_text(tmp_path, body.format(fixed, "")).states] == ["x"]
    assert [s.name for s in compile_text(tmp_path, body.format("", fixed)).states] == ["z"]


def test_a_second_derivative_may_go_through_any_number_of_names(tmp_path: Path) -> None:
    dae = compile_text(
        tmp_path,
        """  Real x(start=1, fixed=true);
              Real v(start=0, fixed=true);
              Real a; Real b; Real c;
            equation
              v = der(x);
              a = -v;
              b = der(a);
              c = -b;
              c = -4*x;""",
    )
    assert len(dae.states) == 2
    assert dae.sizes.index == 1


def test_a_coil_into_a_dead_end_is_no_state(tmp_path: Path) -> None:
    # node 3 hangs on node 2 by two resistors, so no current comes through the coil; which cancellation alone shows
    parts = [Part("R", 1, 1, 0), Part("L", 1, 1, 2), Part("R", 2, 2, 3), Part("R", 3, 2, 3)]
    dae = compile_network(tmp_path, parts, 4)
    assert dae.states == []
    assert dae.torn == []


def test_capacitors_side_by_side_off_the_ground_are_one_state(tmp_path: Path) -> None:
    parts = [Part("C", 1, 1, 2), Part("C", 2, 1, 2), Part("R", 3, 2, 0)]
    assert [state.name for state in compile_network(tmp_path, parts, 3).states] == ["p0.v"]


def test_the_value_of_a_condition_is_not_taken_for_zero(tmp_path: Path) -> None:
    dae = compile_text(tmp_path, "  Real x; Boolean b;\nequation\n  b = time > 1;\n  x = if b then 1 else 0;")
    (published,) = [p.value for p in dae.published if p.scalar.name == "x"]
    assert not published.is_constant()


def test_every_element_has_its_own_nominal_value(tmp_path: Path) -> None:
    """Each of an array, and by a parameter's default where it follows from one."""
    file = tmp_path / "Sizes.mo"
    file.write_text(
        "model Sizes\n  parameter Real p = 1e-4;\n  Real x[2](each start=1, each fixed=true, nominal={10, 1e-3});\n"
        "  Real y(start=1, fixed=true, nominal=2*p);\nequation\n  der(x) = -x;\n  der(y) = -y;\nend Sizes;\n"
    )
    states = compile_model(file, "Sizes").states
    assert {state.name: state.nominal for state in states} == {"x[1]": 10.0, "x[2]": 1e-3, "y": 2e-4}
