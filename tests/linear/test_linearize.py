"""A, B, C and D against closed forms and against central differences of FMUs; what is refused, and how."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

from cosim.engine import Channel, Component, Fmu, System, simulate
from cosim.errors import InputError, SimulationError
from cosim.fmu import export
from cosim.linear import Linearizer, linearize
from cosim.linear._system import per_second
from cosim.modelica import Source
from cosim.units import parse

ROOT = Path(__file__).parents[2]
LIBRARY = ROOT / "modelica" / "WiperDrive"
SMALL = ROOT / "tests" / "models" / "Small"
R, L, K, J, D = 2.0, 0.01, 0.1, 1e-3, 1e-4


def _names(signals: tuple) -> list[tuple[str, str]]:
    return [(signal.name, signal.unit) for signal in signals]


def test_a_dc_motor_has_its_closed_form(motor: Linearizer) -> None:
    system = motor.at(inputs={"v": "6 V"}, parameters={"R": 3.0})
    assert _names(system.states) == [("i", "A"), ("phi", "rad"), ("w", "rad/s")]
    assert _names(system.inputs) == [("v", "V"), ("tau", "N.m")]
    assert _names(system.outputs) == [("i", "A"), ("w", "rad/s"), ("P", "W")]
    np.testing.assert_allclose(system.A, [[-3 / L, 0, -K / L], [0, 0, 1], [K / J, 0, -D / J]], rtol=1e-14)
    np.testing.assert_allclose(system.B, [[1 / L, 0], [0, 0], [0, -1 / J]], rtol=1e-14)
    np.testing.assert_allclose(system.C, [[1, 0, 0], [0, 0, 1], [6, 0, 0]], rtol=1e-14)
    np.testing.assert_allclose(system.D, np.zeros((3, 2)), atol=0)
    np.testing.assert_allclose(system.slope, [6 / L, 0, 0], rtol=1e-14)
    assert [s.value for s in system.states] == [0.0, 0.5, 0.0]
    assert (system.held, system.parameters, system.at, system.time) == ({"lamp": 1.0}, {"R": 3.0}, "initial", 0.0)


def test_its_steady_state_and_its_poles_have_their_closed_form(motor: Linearizer) -> None:
    system = motor.at("steady", inputs={"tau": 0.01}, steady_except=["phi"])
    speed = (12 * K - R * 0.01) / (R * D + K**2)
    current = (D * speed + 0.01) / K
    np.testing.assert_allclose([s.value for s in system.states], [current, 0.5, speed], rtol=1e-11)
    np.testing.assert_allclose(system.D, [[0, 0], [0, 0], [current, 0]], rtol=1e-11)
    np.testing.assert_allclose(system.slope, [0, speed, 0], rtol=1e-11, atol=1e-9)
    mean, half = (R / L + D / J) / 2, math.sqrt((R / L - D / J) ** 2 / 4 - K**2 / (L * J))
    zero, slow, fast = system.poles
    assert (zero.frequency, zero.damping, zero.time_constant) == (0.0, None, None)
    assert slow.real == pytest.approx(half - mean, rel=1e-11)
    assert fast.time_constant == pytest.approx(1 / (half + mean), rel=1e-12)
    assert (slow.damping, slow.imaginary) == (1.0, 0.0)


def test_at_a_time_the_point_lies_on_the_trajectory(motor: Linearizer) -> None:
    system = motor.at(0.05, outputs=["phi", "w"])
    # the speed of a motor from rest at constant voltage, by its two poles
    mean, half = (R / L + D / J) / 2, math.sqrt((R / L - D / J) ** 2 / 4 - K**2 / (L * J))
    p, q, end = half - mean, -half - mean, 12 * K / (R * D + K**2)
    expected = end * (1 - (q * math.exp(p * 0.05) - p * math.exp(q * 0.05)) / (q - p))
    assert system.states[2].value == pytest.approx(expected, rel=1e-7)
    np.testing.assert_array_equal(system.C, [[0, 1, 0], [0, 0, 1]])


def test_a_pendulum_in_cartesian_coordinates_swings_as_its_closed_form() -> None:
    # index 3: the derivative goes through torn unknowns and differentiated constraints
    system = linearize(SMALL, "Small.PendulumXY", at="steady")
    upper, lower = system.poles
    assert upper.frequency == pytest.approx(math.sqrt(9.81 / 0.7), rel=1e-9)
    assert upper.imaginary == -lower.imaginary > 0
    assert upper.damping == pytest.approx(0.0, abs=1e-9)


def test_an_implicit_equation_has_the_derivative_of_its_inverse(valve: Linearizer) -> None:
    system = valve.at()
    q = brentq(lambda q: q + 0.3 * math.sin(q) + q**3 - 1, 0, 1, xtol=1e-15)
    slope = 1 / (1 + 0.3 * math.cos(q) + 3 * q**2)
    found = [system.A[0, 0], system.C[1, 0], system.outputs[1].value]
    np.testing.assert_allclose(found, [-slope, slope, q], rtol=1e-12)
    steady = valve.at("steady")
    assert steady.states[0].value == pytest.approx(2 + 0.3 * math.sin(2) + 8, rel=1e-12)


def test_it_equals_central_differences_of_the_fmu(valve: Linearizer, models: Path, tmp_path: Path) -> None:
    fmu = Fmu.read(export(models / "Valve.mo", "Valve", tmp_path))
    system = valve.at(0.7)
    at = np.array([system.states[0].value, system.inputs[0].value])

    def evaluate(values: np.ndarray) -> np.ndarray:
        return initial_values(fmu, {"h_0": values[0]}, {"u": values[1]}, ["slope", "h", "q", "slope"])

    exact = np.block([[system.A, system.B], [system.C, system.D]])
    np.testing.assert_allclose(differences(evaluate, at, np.array([1.0, 1.0])), exact, rtol=1e-6, atol=1e-9)


def initial_values(fmu: Fmu, parameters: dict[str, float], inputs: dict[str, float], names: list[str]) -> np.ndarray:
    """Outputs of an FMU after initialisation."""
    channels = [Channel(("m", name), [0.0], [float(value)]) for name, value in inputs.items()]
    component = Component("m", fmu, {name: float(value) for name, value in parameters.items()})
    result = simulate(System([component], channels=channels), stop=1e-6, output_interval=1e-6, tolerance=1e-10)
    return np.array([result.columns[f"m.{name}"][0] for name in names])


def differences(evaluate: Callable[[np.ndarray], np.ndarray], at: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Central differences of two steps, extrapolated to fourth order (Richardson)."""
    columns = []
    for k, h in enumerate(1e-3 * scale):
        direction = np.eye(len(at))[k]
        coarse, fine = (
            (evaluate(at + step * direction) - evaluate(at - step * direction)) / (2 * step) for step in (h, h / 2)
        )
        columns.append((4 * fine - coarse) / 3)
    return np.array(columns).T


PROBE = """model Probe "The plant from any state, with the derivatives of its states"
  parameter Real x_1 = 0;
  parameter Real x_2 = 0;
  parameter Real x_3 = 0;
  input Real duty;
  input Real v_supply;
  input Real tau_disturbance;
  WiperDrive.Systems.LinkagePlant plant(
    duty=duty, v_supply=v_supply, tau_disturbance=tau_disturbance,
    phi_crank(start=x_1), w_crank(start=x_2), bridge(i(start=x_3), blocking(start=false)),
    linkage(
      ds(coupler(phi(start=__DSC)), rocker(phi(start=__DSR))),
      ps(coupler(phi(start=__PSC)), rocker(phi(start=__PSR)))));
  output Real f_1 = plant.w_crank;
  output Real f_2 = der(plant.w_crank);
  output Real f_3 = der(plant.bridge.i);
  __OUTPUTS
end Probe;
"""


@pytest.mark.slow
def test_the_linkage_plant_equals_central_differences_of_its_fmu(tmp_path: Path) -> None:
    with Linearizer(LIBRARY, "WiperDrive.Systems.LinkagePlant") as plant:
        system = plant.at(1.3, inputs={"duty": 1.0})
        angles = [f"linkage.{side}.{bar}.phi" for side in ("ds", "ps") for bar in ("coupler", "rocker")]
        inside = plant.at(1.3, inputs={"duty": 1.0}, outputs=angles)
    assert [s.name for s in system.states] == ["phi_crank", "w_crank", "bridge.i"]
    text = PROBE
    for key, signal in zip(("__DSC", "__DSR", "__PSC", "__PSR"), inside.outputs, strict=True):
        text = text.replace(key, repr(signal.value))
    names = [s.name for s in system.outputs]
    text = text.replace("__OUTPUTS", "\n  ".join(f"output Real y_{name} = plant.{name};" for name in names))
    file = tmp_path / "All.mo"
    file.write_text(Source.read(LIBRARY).text + text)
    fmu = Fmu.read(export(file, "Probe", tmp_path))
    inputs = [s.name for s in system.inputs]
    columns = ["f_1", "f_2", "f_3", *(f"y_{name}" for name in names)]

    def evaluate(values: np.ndarray) -> np.ndarray:
        parameters = {f"x_{k}": value for k, value in enumerate(values[:3], 1)}
        return initial_values(fmu, parameters, dict(zip(inputs, values[3:], strict=True)), columns)

    at = np.array([s.value for s in (*system.states, *system.inputs)])
    values = np.concatenate([system.slope, [s.value for s in system.outputs]])
    np.testing.assert_allclose(evaluate(at), values, rtol=1e-9, atol=1e-9)
    found = differences(evaluate, at, np.array([1.0, 1.0, 1.0, 1.0, 10.0, 1.0]))
    exact = np.block([[system.A, system.B], [system.C, system.D]])
    np.testing.assert_allclose(found, exact, rtol=1e-6, atol=1e-9)


@pytest.mark.slow
def test_the_linkage_plant_is_refused_where_it_has_no_derivative_or_no_rest() -> None:
    with Linearizer(LIBRARY, "WiperDrive.Systems.LinkagePlant") as plant:
        with pytest.raises(InputError) as caught:
            plant.at(1.0)
        assert str(caught.value) == (
            "WiperDrive.Systems.LinkagePlant cannot be linearized here: 'bridge.duty <= 0' switches exactly at this "
            "operating point, where no derivative exists; take another time or another value of an input"
        )
        with pytest.raises(InputError) as caught:
            plant.at("steady", inputs={"duty": 1.0})
        assert str(caught.value) == (
            "WiperDrive.Systems.LinkagePlant has no steady state: phi_crank would move on and on; such a state is an "
            "integrator, like the angle of a shaft that turns. Let it keep its value: --steady-except phi_crank"
        )
        system = plant.at("steady", inputs={"duty": 1.0}, steady_except=["phi_crank"])
    # the park contact acts on nothing of the linear system
    assert list(system.held) == ["bridge.blocking", "bridge.limiting", "bridge.returning", "bridge.braking"]
    phi, w, _ = (signal.value for signal in system.states)
    assert (phi, system.slope[0]) == (0.0, w)
    np.testing.assert_allclose(system.slope[1:], 0, atol=1e-9)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"inputs": {"u": 1.0}}, "Motor has no input 'u'; there are v, tau, lamp"),
        ({"inputs": {"tua": 1.0}}, "Motor has no input 'tua'; did you mean tau?"),
        ({"inputs": {"v": "3 A"}}, "'3 A' is in A, 'v' is in V; write for example 3 V"),
        ({"inputs": {"v": math.nan}}, "'v' takes a finite number, not nan"),
        ({"parameters": {"v": 1.0}}, "Motor has no parameter 'v'; there are R, L, k, J, d"),
        ({"outputs": ["omega"]}, "Motor has no Real variable 'omega' that could be an output; cosim info shows the "
         "variables of its FMU"),
        ({"moment": -1.0}, "no model can be linearized at t = -1.0 s; give a time from 0 on, initial or steady"),
        ({"moment": "steady"}, "Motor has no steady state: nothing determines phi; such a state is an integrator, "
         "like the angle of a shaft that turns. Let it keep its value: --steady-except phi"),
        ({"moment": "steady", "steady_except": ["x"]}, "Motor has no state 'x'; its states are i, phi, w"),
    ],
)  # fmt: skip
def test_what_is_refused(motor: Linearizer, options: dict, message: str) -> None:
    with pytest.raises(InputError) as caught:
        motor.at(**options)
    assert str(caught.value) == message


@pytest.mark.parametrize(
    ("package", "model", "message"),
    [
        (
            LIBRARY,
            "WiperDrive.Controllers.VoltageProfile",
            " is discrete: it has no continuous state, its variables change at events only; linearize the model of a"
            " plant",
        ),
        (
            SMALL,
            "Small.SampledPI",
            " has parts that change at sample times, which have no derivative, so its steady state is not sought;"
            " linearize it at a time, or the plant alone",
        ),
    ],
)
def test_models_that_are_refused(package: Path, model: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        linearize(package, model, at="steady")
    assert str(caught.value) == model + message


def test_a_model_that_depends_on_time_has_no_steady_state(tmp_path: Path) -> None:
    file = tmp_path / "M.mo"
    file.write_text("model M\n  output Real x(start=0, fixed=true);\nequation\n  der(x) = time - x;\nend M;\n")
    with pytest.raises(InputError) as caught:
        linearize(file, "M", at="steady")
    assert str(caught.value) == "M depends on time, so it has no steady state; linearize it at a time instead"


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"a": -1.0, "b": 0.5, "c": 1.0}, "from t = 0 s: Newton's method stops with der(x) = -0.938"),
        ({"d": -2.0}, "it lies where 'x < 0.5' has switched; the simulation failed at t = 0 s"),
    ],
)
def test_a_steady_state_that_is_not_there(switched: Linearizer, parameters: dict, message: str) -> None:
    with pytest.raises(SimulationError) as caught:
        switched.at("steady", parameters=parameters)
    assert str(caught.value).startswith("Switched: no steady state was found (from t = 0 s: ")
    assert message in str(caught.value)
    assert str(caught.value).endswith(
        "); simulate closer to it with --settle, except a state with --steady-except, or linearize at a time"
    )


def test_a_steady_state_beyond_an_event_is_found_by_simulating(switched: Linearizer) -> None:
    # from the start, Newton's method runs to x = 1, where the other slope holds; there, x = 2 is the steady state
    assert switched.at("steady").states[0].value == pytest.approx(2.0, rel=1e-12)


def test_an_event_at_the_time_is_refused_and_beside_it_not(switched: Linearizer) -> None:
    with pytest.raises(InputError, match=r"'x < 0.5' switches exactly at this operating point"):
        switched.at(0.5, parameters={"b": 0.0})
    systems = [switched.at(time, parameters={"b": 0.0}) for time in (0.499, 0.501)]
    assert [s.slope[0] for s in systems] == pytest.approx([1.0, 1.5 - 0.0015], abs=1e-5)
    assert [s.A[0, 0] for s in systems] == [0.0, -1.0]


@pytest.mark.parametrize(
    ("unit", "derivative"),
    [("rad", "rad/s"), ("m/s", "m/s2"), ("m/s2", "m/s3"), ("V/m", "V/(m.s)"), ("W/(m2.K)", "W/(m2.K.s)"), ("1", "1/s")],
)
def test_the_unit_of_a_derivative(unit: str, derivative: str) -> None:
    assert per_second(unit) == derivative
    before, after = parse(unit).exponents, parse(derivative).exponents
    assert {**before, "s": before.get("s", 0) - 1} == {"s": 0, **after}
