"""The shapes of the profiles, tick by tick: corner points, rates, and what parking does."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from cosim.engine import Channel, Component, Connection, Fmu, System, simulate
from cosim.fmu import catalogue

Array = np.ndarray
CORNERS = ((0.0, 0.7), (0.1, 1.0), (0.9, 1.0), (1.0, 0.3), (1.1, 1.0), (1.9, 1.0), (2.0, 0.7))
"""Of figure 3.12."""


@cache
def duty_of(controller: str, tick: float) -> tuple[Array, Array]:
    """Time and duty ratio of two seconds with figure 3.12's half revolution and a current that invites every turn."""
    fmu = Fmu.read(catalogue.ensure(controller))
    parameters = {"T_compute": tick, "stop_ratio": 1.0}
    channels = [
        Channel(("controller", "i_motor"), [0.0], [0.5]),
        Channel(("controller", "park"), [0.0, 0.05], [1.0, 0.0]),
    ]
    system = System([Component("controller", fmu, parameters)], [], channels)
    result = simulate(system, stop=2.1, output_interval=tick, tolerance=1e-6)
    return result.time, result.columns["controller.duty"]


@pytest.mark.parametrize("controller", ["voltage_profile", "s_curve"])
def test_figure_3_12_has_its_corner_points(controller: str) -> None:
    """A chart that computes each T puts a corner off by its slope times T, so two T give the one of T = 0 exactly."""
    values = {}
    for tick in (1e-3, 5e-4):
        _, duty = duty_of(controller, tick)
        values[tick] = np.array([duty[round(t / tick)] for t, _ in CORNERS[:-1]])
    expected = np.array([y for _, y in CORNERS[:-1]])
    if controller == "voltage_profile":
        np.testing.assert_allclose(2 * values[5e-4] - values[1e-3], expected, atol=1e-9)
    else:  # its ramps are level at their ends, so that a tick is of second order
        np.testing.assert_allclose((4 * values[5e-4] - values[1e-3]) / 3, expected, atol=1e-9)
    # the soft stop ends in the next soft start, two ticks late by then: the least value is the last corner
    time, duty = duty_of(controller, 5e-4)
    assert duty[time > 1.95].min() == pytest.approx(CORNERS[-1][1], abs=1e-12)
    assert time[time > 1.95][duty[time > 1.95].argmin()] == pytest.approx(2.0, abs=1.1e-3)


def test_the_s_curve_limits_the_second_difference_that_the_trapezoid_does_not() -> None:
    tick = 5e-4
    _, trapezoid = duty_of("voltage_profile", tick)
    _, curve = duty_of("s_curve", tick)
    inside = slice(1, round(1.9 / tick))  # beyond, both begin a new revolution with a step
    height, ramp = 0.7, 0.1
    bound = 4 * height / ramp**2
    rates = {name: np.diff(duty[inside]) / tick for name, duty in (("trapezoid", trapezoid), ("curve", curve))}
    assert np.abs(np.diff(rates["curve"]) / tick).max() == pytest.approx(bound, rel=1e-9)
    # the trapezoid's rate jumps within a tick, whatever its length, from falling to rising at the turning point
    assert np.abs(np.diff(rates["trapezoid"])).max() == pytest.approx(2 * height / ramp, rel=1e-9)
    # same start, same end, same mean; twice the greatest rate
    assert np.abs(rates["curve"]).max() == pytest.approx(2 * height / ramp * (1 - tick / ramp), rel=1e-9)
    assert curve[inside].sum() == pytest.approx(trapezoid[inside].sum(), rel=1e-12)


@pytest.mark.parametrize("controller", ["voltage_profile", "s_curve", "constant_voltage"])
@pytest.mark.parametrize("plant", ["linkage", "rig"])
def test_switched_off_the_motor_runs_on_to_the_contact_and_stops(plant: str, controller: str) -> None:
    components = [Component(name, Fmu.read(catalogue.ensure(file))) for name, file in
                  (("plant", plant), ("controller", controller))]  # fmt: skip
    channels = [Channel(("controller", "enable"), [0.0, 3.0], [1.0, 0.0])]
    wires = [(("controller", "duty"), ("plant", "duty")), (("plant", "i_motor"), ("controller", "i_motor")),
             (("plant", "park"), ("controller", "park"))]  # fmt: skip
    system = System(components, [Connection(*ends) for ends in wires], channels)
    result = simulate(system, stop=8.0, output_interval=1e-3, tolerance=1e-8)
    time, columns = result.time, result.columns
    closes = time[1:][np.diff(columns["plant.park"]) > 0]
    parked = closes[closes > 3.0][0]
    running = (time > 3.0) & (time < parked - 1e-9)
    assert columns["controller.duty"][running].min() >= 0.3
    after = time > parked + 1.5e-3
    assert np.all(columns["controller.duty"][after] == 0)
    assert np.all(columns["controller.state"][after] == 1)
    # the current decays with L/R against the back-EMF; what flows later is the freewheel diode's, when the arm swings
    # back: -k w = R i as soon as that is slow beside L/R
    late = time > parked + 0.03
    current, speed = columns["plant.i_motor"][late], columns["plant.w_motor"][late]
    assert np.all(current[speed > 0] == 0)
    if plant == "linkage":
        assert abs(columns["plant.w_crank"][-1]) < 1e-2
    else:
        assert current[-1] == pytest.approx(-0.113 * speed[-1] / 1.91, rel=1e-3)
