"""Model Exchange FMUs as components: integration, their three kinds of events, inputs, failures.

Each system runs twice: in the native loop with this project's solver, and in Python with CVode.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Unpack

import numpy as np
import pytest
from both_loops import Arguments, ending

from cosim.engine import (
    Channel,
    Component,
    Connection,
    Fmu,
    Isolate,
    PartialResultError,
    Result,
    Role,
    System,
    role_of,
)
from cosim.engine import simulate as simulate_once
from cosim.errors import CosimError, FmuError
from cosim.fmu import catalogue

Get = Callable[..., Fmu]
G, E = 9.81, 0.7
versions = pytest.mark.parametrize("version", [2, 3])


def simulate(system: System, **arguments: Unpack[Arguments]) -> Result:
    """Return or raise what the native loop gives, which agrees with what CVode gives in Python."""
    reference = ending("python", system, **arguments)
    native = ending("native", system, **arguments)
    if isinstance(native, CosimError):
        assert isinstance(native, PartialResultError), native
        assert isinstance(reference, PartialResultError), reference
        raise native
    assert isinstance(reference, Result)
    assert native.time.tobytes() == reference.time.tobytes()
    for name, column in native.columns.items():
        if name.endswith(".high"):
            continue  # an event after a step of the solver, and these are its own
        within = max(1e-9, 100.0 * arguments["tolerance"])
        np.testing.assert_allclose(column, reference.columns[name], rtol=within, atol=within, err_msg=name)
    return native


def height(t: float) -> float:
    """Height of the ball that falls from 1 m at t = 0 and bounces, in closed form, as long as it bounces."""
    fall = math.sqrt(2.0 / G)
    if t < fall:
        return 1.0 - G * t * t / 2.0
    v, begin = E * G * fall, fall
    while t > begin + 2.0 * v / G:
        begin, v = begin + 2.0 * v / G, E * v
    return v * (t - begin) - G * (t - begin) ** 2 / 2.0


@versions
def test_state_events_are_found_where_they_are(fmu: Get, version: int) -> None:
    result = simulate(
        System([Component("ball", fmu("ball", version))]), stop=1.5, output_interval=0.01, tolerance=1e-11
    )
    exact = [height(t) for t in result.time]
    assert np.abs(result.columns["ball.h"] - exact).max() < 1e-7
    fall = math.sqrt(2.0 / G)
    bounces = [fall, fall * (1 + 2 * E), fall * (1 + 2 * E + 2 * E**2)]
    assert result.columns["ball.bounces"].tolist() == [sum(b <= t for b in bounces) for t in result.time]
    assert result.statistics["solver"]["ball"]["state_events"] == 2


@versions
def test_steps_of_the_solver_do_not_depend_on_the_output_grid(fmu: Get, version: int) -> None:
    fine, coarse = (
        simulate(System([Component("b", fmu("ball", version))]), stop=1.0, output_interval=interval, tolerance=1e-6)
        for interval in (0.001, 0.1)
    )
    assert fine.columns["b.h"][::100] == pytest.approx(coarse.columns["b.h"], abs=1e-12)
    assert fine.statistics["solver"]["b"]["steps"] == coarse.statistics["solver"]["b"]["steps"]


@versions
def test_announced_times_are_met(fmu: Get, version: int) -> None:
    ball = Component("ball", fmu("ball", version), {"T": 0.07})
    result = simulate(System([ball]), stop=0.4, output_interval=0.01, tolerance=1e-11)
    for t, sampled in zip(result.time, result.columns["ball.sampled"], strict=True):
        assert sampled == pytest.approx(height(0.07 * math.floor(t / 0.07 + 1e-6)), abs=1e-8)
    assert result.statistics["solver"]["ball"]["time_events"] == 5


@versions
def test_events_that_completed_steps_ask_for_are_handled(fmu: Get, version: int) -> None:
    result = simulate(System([Component("b", fmu("ball", version))]), stop=0.45, output_interval=0.45, tolerance=1e-6)
    assert result.columns["b.high"].tolist() == [1, 0]
    assert result.statistics["solver"]["b"]["step_events"] == 1


@versions
def test_a_change_of_an_input_acts_at_its_instant(fmu: Get, version: int) -> None:
    """Weightless from 0.1 s on: the speed stays, exactly; the change lies between two rows."""
    weightless = Channel(("ball", "u"), [0.0, 0.105], [0.0, G])
    system = System([Component("ball", fmu("ball", version))], channels=[weightless])
    result = simulate(system, stop=0.2, output_interval=0.01, tolerance=1e-11)
    after = result.time > 0.105
    assert result.columns["ball.v"][after] == pytest.approx(-G * 0.105, abs=1e-9)
    exact = 1.0 - G * 0.105**2 / 2.0 - G * 0.105 * (result.time - 0.105)
    assert result.columns["ball.h"][after] == pytest.approx(exact[after], abs=1e-9)


@versions
def test_sampled_controller_for_model_exchange_acts_without_delay(fmu: Get, version: int) -> None:
    """Every T the integrator's rate becomes -2 x: x(k T) = (1 - 2 T)^k, as for a controller for Co-Simulation."""
    controller, plant = fmu("relay", version), fmu("integrator", version)
    assert role_of(controller) is Role.EVENT
    system = System(
        [Component("c", controller, {"K": -2.0}), Component("p", plant, {"x0": 1.0})],
        [Connection(("c", "y"), ("p", "u")), Connection(("p", "x"), ("c", "u"))],
    )
    result = simulate(system, stop=1.0, output_interval=0.02, tolerance=1e-6)
    assert result.columns["p.x"] == pytest.approx(0.96 ** np.arange(51), rel=1e-12)
    assert result.columns["c.samples"].tolist() == list(range(1, 52))


@versions
def test_in_a_process_of_its_own_it_gives_the_same(fmu: Get, version: int) -> None:
    """There every call of the FMU is noted, also those that the solver makes with arguments of its own."""
    system = System([Component("ball", fmu("ball", version))])

    def heights(isolate: Isolate) -> list[float]:
        result = simulate_once(system, stop=0.6, output_interval=0.01, tolerance=1e-9, isolate=isolate)
        found: list[float] = result.columns["ball.h"].tolist()
        return found

    assert heights("always") == heights("never")


@versions
def test_indicators_without_states_are_watched(fmu: Get, version: int) -> None:
    system = System([Component("c", fmu("relay", version), {"t_cross": 0.33})])
    result = simulate(system, stop=0.5, output_interval=0.02, tolerance=1e-6)
    assert result.columns["c.late"].tolist() == [t > 0.33 for t in result.time]


@versions
def test_coupled_with_a_controller_it_equals_the_closed_form(fmu: Get, version: int) -> None:
    """A sampled force u = -4 h on a ball without weight: the exact map of the double integrator over each period."""
    system = System(
        [Component("ball", fmu("ball", version), {"g": 0.0}), Component("c", fmu("relay", version), {"K": -4.0})],
        [Connection(("c", "y"), ("ball", "u")), Connection(("ball", "h"), ("c", "u"))],
    )
    result = simulate(system, stop=0.6, output_interval=0.02, tolerance=1e-11)
    h, v, T = 1.0, 0.0, 0.02
    for row in result.columns["ball.h"]:
        assert row == pytest.approx(h, abs=1e-8)
        h, v = h + T * v - 4.0 * h * T * T / 2.0, v - 4.0 * h * T


@versions
def test_jacobi_takes_it_too(fmu: Get, version: int) -> None:
    system = System([Component("ball", fmu("ball", version))])
    result = simulate(system, stop=1.0, output_interval=0.1, tolerance=1e-11, algorithm="jacobi", step=0.05)
    assert result.columns["ball.h"] == pytest.approx([height(t) for t in result.time], abs=1e-7)


@pytest.mark.parametrize(
    ("parameter", "said"),
    [
        ({"t_wrong": 0.2}, "returned Error"),
        ({"t_end": 0.2}, "asked to end the simulation"),
        ({"again": True}, "still needs to update its discrete states after 100 updates"),
        ({}, "has had 1000 events"),
    ],
)
@versions
def test_failures_say_what_when_and_who(fmu: Get, version: int, parameter: dict[str, float], said: str) -> None:
    system = System([Component("ball", fmu("ball", version), parameter)])
    with pytest.raises(PartialResultError, match=r"the simulation failed .*ball \(ball\)") as caught:
        simulate(system, stop=3.0, output_interval=0.01, tolerance=1e-10)
    assert said in str(caught.value)


@versions
def test_co_simulation_can_be_asked_for_and_is_missed(fmu_path: Callable[[str, int], object], version: int) -> None:
    with pytest.raises(FmuError, match="has no Co-Simulation interface"):
        Fmu.read(fmu_path("ball", version), "CoSimulation")  # type: ignore[arg-type]


@versions
def test_our_own_plant_agrees_with_its_co_simulation(version: int) -> None:
    """The rig, its diode and park contact, pushed and under a sampled controller: two solvers, one trajectory."""
    path, controller = (catalogue.ensure(name, "2.0" if version == 2 else "3.0") for name in ("rig", "speed_control"))
    found = {}
    for interface in ("CoSimulation", "ModelExchange"):
        with Fmu.read(path, interface) as plant, Fmu.read(controller) as speed_control:  # type: ignore[arg-type]
            system = System(
                [Component("plant", plant), Component("controller", speed_control)],
                [
                    Connection(("plant", "w_crank"), ("controller", "w_crank")),
                    Connection(("controller", "duty"), ("plant", "duty")),
                ],
                [Channel(("plant", "tau_disturbance"), [0.0, 1.0, 1.3], [0.0, -4.0, 0.0])],
            )
            found[interface] = simulate(system, stop=3.0, output_interval=1e-3, tolerance=1e-9)
    stepped, integrated = found["CoSimulation"].columns, found["ModelExchange"].columns
    for name in ("plant.phi_crank", "plant.w_crank", "plant.i_motor", "controller.duty"):
        assert np.abs(stepped[name] - integrated[name]).max() < 1e-6, name
    assert stepped["plant.park"].tolist() == integrated["plant.park"].tolist()
