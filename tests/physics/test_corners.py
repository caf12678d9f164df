"""Corner cases of the built plants: any parameters at the start, being pushed, coasting, braking, limiting."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from cosim.engine import Channel, Component, Fmu, Result, System, simulate
from cosim.errors import InputError
from cosim.fmu import catalogue

Steps = Sequence[tuple[float, float]]


@pytest.fixture(scope="module", params=["linkage", "rig"])
def plant(request: pytest.FixtureRequest) -> tuple[str, Fmu]:
    name: str = request.param
    return name, Fmu.read(catalogue.ensure(name))


@pytest.fixture(scope="module")
def linkage() -> Fmu:
    return Fmu.read(catalogue.ensure("linkage"))


def drive(fmu: Fmu, stop: float, parameters: dict[str, float] | None = None, **inputs: Steps) -> Result:
    """Run a plant alone; each input is a list of (time, value), held in between."""
    channels = [
        Channel(("plant", name), [t for t, _ in steps], [value for _, value in steps]) for name, steps in inputs.items()
    ]
    system = System([Component("plant", fmu, dict(parameters or {}))], [], channels)
    return simulate(system, stop=stop, output_interval=1e-4, tolerance=1e-7)


STEP = ((0.0, 0.0), (0.0, 1.0))


def test_every_start_is_exact_whatever_the_parameters(plant: tuple[str, Fmu]) -> None:
    name, fmu = plant
    random = np.random.default_rng(7)
    for _ in range(25):
        parameters = {"J_rotor": random.uniform(0.2e-4, 5e-4), "motor.R": random.uniform(0.5, 4.0)}
        if name == "linkage":
            parameters |= {"J_arm": random.uniform(0.0, 0.2), "ext_load": random.uniform(0.0, 10.0)}
        else:
            parameters |= {"m_arm": random.uniform(1.0, 4.0), "l_arm": random.uniform(0.1, 0.4)}
        result = drive(fmu, 0.05, parameters, duty=STEP)
        for variable in ("i_motor", "phi_crank", "w_crank", "w_motor"):
            assert result.columns[f"plant.{variable}"][0] == 0.0, (parameters, variable)
        assert result.columns["plant.park"][0] == 1
        assert result.columns["plant.w_crank"][-1] > 0.5


def test_a_plant_rests_for_a_second_and_starts(plant: tuple[str, Fmu]) -> None:
    _, fmu = plant
    result = drive(fmu, 1.2, duty=((0.0, 0.0), (1.0, 0.0), (1.0, 1.0)))
    rest = result.time < 1.0
    assert np.abs(result.columns["plant.w_crank"][rest]).max() < 1e-6
    assert result.columns["plant.i_motor"][rest].max() < 1e-6
    assert result.columns["plant.w_crank"][-1] > 1.0


@pytest.mark.parametrize("torque", [-20.0, -5.0, -1e-3, 1e-3, 5.0, 20.0])
def test_a_plant_can_be_pushed_from_rest(plant: tuple[str, Fmu], torque: float) -> None:
    _, fmu = plant
    result = drive(fmu, 0.2, tau_disturbance=((0.0, 0.0), (0.0, torque)))
    assert result.complete
    assert result.columns["plant.phi_crank"][-1] * torque > 0.0
    assert result.columns["plant.i_motor"].min() >= 0.0


def test_a_switched_off_motor_coasts_without_current_at_its_back_emf(plant: tuple[str, Fmu]) -> None:
    _, fmu = plant
    result = drive(fmu, 1.2, duty=((0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)))
    late = result.time > 1.05
    assert np.array_equal(result.columns["plant.i_motor"][late], np.zeros(late.sum()))
    emf = 0.113 * result.columns["plant.w_motor"][late]
    np.testing.assert_allclose(result.columns["plant.v_motor"][late], emf, atol=1e-7)


def test_a_shorted_motor_stops_sooner_than_a_coasting_one(linkage: Fmu) -> None:
    duty = ((0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0))
    coasting = drive(linkage, 1.1, duty=duty)
    shorted = drive(linkage, 1.1, {"short_brake": True}, duty=duty)
    np.testing.assert_allclose(shorted.columns["plant.w_crank"][:10000], coasting.columns["plant.w_crank"][:10000])
    assert shorted.columns["plant.w_crank"][-1] < 0.5 * coasting.columns["plant.w_crank"][-1]
    assert np.abs(shorted.columns["plant.v_motor"][10010:]).max() < 1e-9


@pytest.mark.parametrize("start", [0.0, 0.01])
def test_the_limit_holds_the_current_and_nothing_else(plant: tuple[str, Fmu], start: float) -> None:
    """Below the limit the run is the unlimited one; at it the current stays until the back-EMF has grown."""
    _, fmu = plant
    duty = ((0.0, 0.0), (start, 0.0), (start, 1.0)) if start else STEP
    free, limited = drive(fmu, 0.5, duty=duty), drive(fmu, 0.5, {"i_max": 5.0}, duty=duty)
    current, unlimited = limited.columns["plant.i_motor"], free.columns["plant.i_motor"]
    assert unlimited.max() > 8.0
    assert current.max() <= 5.0 * (1.0 + 1e-6)
    reached = int(np.argmax(unlimited > 5.0))
    np.testing.assert_allclose(current[: reached - 1], unlimited[: reached - 1], atol=1e-5)
    assert (np.abs(current - 5.0) < 1e-6).sum() > 20
    assert limited.columns["plant.w_crank"][-1] == pytest.approx(free.columns["plant.w_crank"][-1], rel=0.05)


@pytest.mark.parametrize(
    ("parameter", "value", "reason"),
    [
        ("T_filter", 2.0, "T_filter must not exceed 1024 periods of T_compute"),
        ("T_ramp", 0.0, "T_ramp must be positive"),
    ],
)
def test_a_controller_refuses_what_it_cannot_do(parameter: str, value: float, reason: str) -> None:
    fmu = Fmu.read(catalogue.ensure("voltage_profile"))
    system = System([Component("controller", fmu, {parameter: value})], [], [])
    with pytest.raises(InputError) as caught:
        simulate(system, stop=0.1, output_interval=0.01, tolerance=1e-6)
    assert str(caught.value) == (f"controller (VoltageProfile) refuses its parameters or inputs: {reason}; change them")


def test_random_driving_pushing_braking_and_limiting_never_sticks(plant: tuple[str, Fmu]) -> None:
    """Whatever the inputs do, every event finds a consistent state and the current keeps its bounds."""
    name, fmu = plant
    random = np.random.default_rng(77)
    for k in range(100):
        times = np.sort(random.uniform(0.0, 2.0, 8)).tolist()
        duty = random.choice([0.0, 0.0, 1e-3, 0.3, 0.5, 1.0], 8).tolist()
        torque = random.choice([0.0, 0.0, 5.0, -5.0, 1e-4, -1e-4, -20.0, 20.0], 8).tolist()
        limit = random.uniform(1.0, 8.0) if k % 4 == 0 else 1000.0
        parameters = {"short_brake": k % 3 == 0, "i_max": limit}
        if name == "linkage":
            parameters["naive_load"] = k % 5 == 0
        channels = [Channel(("plant", "duty"), times, duty), Channel(("plant", "tau_disturbance"), times, torque)]
        system = System([Component("plant", fmu, dict(parameters))], [], channels)
        tolerance = float(10.0 ** random.uniform(-9.0, -4.0))
        current = simulate(system, stop=2.5, output_interval=0.01, tolerance=tolerance).columns["plant.i_motor"]
        assert current.min() >= 0.0
        assert current.max() <= limit * (1.0 + 1e-6)
