"""What the compiler makes of a model: states, torn unknowns, index, sizes, and what it tells about them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from networks import Part, compile_network

from cosim.dae import Dae
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
    lines = str(plant).splitlines()
    what = "Wiper drive with the two four-bar linkages and the load of the blades"
    assert lines[0] == f"WiperDrive.Systems.LinkagePlant: {what}"
    sizes = plant.sizes
    assert lines[2:14] == [
        f"equations            {sizes.flat} flat, {sizes.after_aliases} after alias elimination, {sizes.differentiated}"
        " with derivatives of constraints",
        "differentiation index  3",
        "continuous states    3",
        "    phi_crank",
        "    w_crank",
        "    bridge.i",
        "torn unknowns        5 (found by the solver together with the states)",
        "    phi_ds",
        "    linkage.ds.coupler.phi",
        "    phi_ps",
        "    linkage.ps.coupler.phi",
        "    der(der(phi_crank))",
    ]
    assert "    w_crank = der(phi_crank)" in lines
    assert "    phi_crank = 0 (fixed start) (Drive.mo:18)" in lines


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
