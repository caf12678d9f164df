"""Each small model ends as an FMU, runs in fmpy and obeys its law."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from laws import G, linear
from scipy.integrate import solve_ivp

Simulate = Callable[..., Any]


def test_a_motor_winds_up_a_spring_as_its_linear_equations_say(simulate: Simulate) -> None:
    result = simulate("MotorOnSpring", 2, step=0.05, u=10.0)
    R, L, k, J, c, d = 2, 0.1, 0.3, 2e-3, 0.5, 0.01
    A = np.array([[-R / L, 0, -k / L], [0, 0, 1], [k / J, -c / J, -d / J]])
    expected = linear(A, np.array([10 / L, 0, 0]), np.zeros(3), result["time"])
    assert result["i"] == pytest.approx(expected[:, 0], abs=1e-6)
    assert result["phi"] == pytest.approx(expected[:, 1], abs=1e-6)


def test_a_parameter_set_from_outside_changes_the_equations(simulate: Simulate) -> None:
    result = simulate("MotorOnSpring", 60, step=60, u=10.0, R=4.0)
    assert result["i"][-1] == pytest.approx(10 / 4, rel=1e-6)
    # at rest the spring holds the motor's torque
    assert result["phi"][-1] == pytest.approx(0.3 * 10 / 4 / 0.5, rel=1e-6)


def test_the_pendulum_in_x_and_y_moves_as_the_one_in_its_angle(simulate: Simulate) -> None:
    cartesian = simulate("PendulumXY", 10, step=0.02)
    angle = simulate("PendulumAngle", 10, step=0.02)
    assert cartesian["x"] == pytest.approx(0.7 * np.sin(angle["phi"]), abs=1e-6)
    assert cartesian["y"] == pytest.approx(-0.7 * np.cos(angle["phi"]), abs=1e-6)
    assert np.ptp(cartesian["E"]) < 1e-6 * abs(cartesian["E"][0])
    assert np.abs(cartesian["x"] ** 2 + cartesian["y"] ** 2 - 0.7**2).max() < 1e-9


def test_the_pendulum_swings_with_the_period_of_the_elliptic_integral(simulate: Simulate) -> None:
    result = simulate("PendulumAngle", 10, step=0.001)
    down = np.flatnonzero((result["phi"][:-1] > 0) & (result["phi"][1:] <= 0))
    exact = result["time"][down] + 0.001 * result["phi"][down] / (result["phi"][down] - result["phi"][down + 1])
    a, b = 1.0, math.cos(0.5 / 2)  # arithmetic-geometric mean
    for _ in range(10):
        a, b = (a + b) / 2, math.sqrt(a * b)
    assert np.diff(exact) == pytest.approx(2 * math.pi * math.sqrt(0.7 / G) / a, rel=1e-6)


def test_inductors_in_series_have_one_current(simulate: Simulate) -> None:
    result = simulate("SeriesInductors", 0.5, step=0.01, u=10.0)
    decay = np.exp(-result["time"] * 4 / 0.4)
    assert result["i"] == pytest.approx(10 / 4 * (1 - decay), abs=1e-7)
    assert result["v_2"] == pytest.approx(10 * 0.3 / 0.4 * decay, abs=1e-6)


def test_capacitors_in_parallel_have_one_voltage(simulate: Simulate) -> None:
    result = simulate("ParallelCapacitors", 2, step=0.05, u=5.0)
    decay = np.exp(-result["time"] / (1000 * 4e-4))
    assert result["v"] == pytest.approx(5 - 4 * decay, abs=1e-7)
    assert result["i_2"] == pytest.approx(4e-3 * decay * 3 / 4, abs=1e-9)


def test_the_ball_bounces_when_the_geometric_series_says(simulate: Simulate) -> None:
    result = simulate("BouncingBall", 2.3, step=0.01)
    first, e = math.sqrt(2 / G), 0.7
    times = [first * (1 + 2 * sum(e**k for k in range(1, n + 1))) for n in range(6)]
    for n, t in enumerate(times, start=1):
        seen = result["last_bounce"][result["bounces"] == n]
        assert len(seen), f"bounce {n} is missing"
        assert seen == pytest.approx(t, abs=1e-7)
    # between bounces the energy falls by e^2
    energy = G * result["h"] + result["v"] ** 2 / 2
    for n in range(5):
        assert energy[result["bounces"] == n] == pytest.approx(G * e ** (2 * n), rel=1e-5)


def test_the_diode_charges_the_capacitor_and_does_not_discharge_it(simulate: Simulate) -> None:
    rows = [(0.0, 10.0), (0.1, 10.0), (0.1, -10.0), (0.3, -10.0)]
    result = simulate("Rectifier", 0.3, step=0.002, signals=("u", rows))
    t, tau = result["time"], 0.01 * 1 * 10 / 11
    charging = t < 0.099
    assert result["v"][charging] == pytest.approx(100 / 11 * (1 - np.exp(-t[charging] / tau)), abs=1e-6)
    falling = t > 0.103
    start = 100 / 11 * (1 - np.exp(-0.1 / tau))
    assert result["v"][falling] == pytest.approx(start * np.exp(-(t[falling] - 0.1) / 0.1), abs=2e-4 * start)
    assert result["blocking"][falling].all()
    assert (result["i"][falling] == 0).all()
    assert (result["i"] >= -1e-9).all()


def test_a_sine_is_rectified_with_one_conduction_a_period(simulate: Simulate) -> None:
    times = np.arange(0, 0.2 + 1e-9, 1e-3)
    rows = list(zip(times.tolist(), (10 * np.sin(2 * np.pi * 50 * times)).tolist(), strict=True))
    result = simulate("Rectifier", 0.2, step=1e-3, signals=("u", rows))
    starts = np.flatnonzero(result["blocking"][:-1] & ~result["blocking"][1:])
    assert np.diff(starts[2:]) == pytest.approx(20, abs=1)
    # fmpy holds the input over each step, so a row shows the end of a step with the input of its start
    held = 10 * np.sin(2 * np.pi * 50 * (result["time"][1:] - 1e-3))
    assert result["i"][1:] == pytest.approx(np.maximum(0, held - result["v"][1:]), abs=1e-6)


def test_the_slider_follows_the_crank_as_on_paper(simulate: Simulate) -> None:
    result = simulate("SliderCrank", 3, step=0.01)
    phi, w, r, length = result["phi"], result["w"], 0.2, 0.6
    root = np.sqrt(length**2 - (r * np.sin(phi)) ** 2)
    assert phi[-1] > 4 * np.pi  # several turns
    assert result["x"] == pytest.approx(r * np.cos(phi) + root, abs=1e-8)
    assert result["psi"] == pytest.approx(-np.arcsin(r * np.sin(phi) / length), abs=1e-8)
    v = -r * np.sin(phi) * (1 + r * np.cos(phi) / root) * w
    assert result["v"] == pytest.approx(v, abs=1e-7)
    assert result["E"] == pytest.approx(result["E"][0], rel=1e-6)


def test_power_on_the_crank_becomes_kinetic_energy(simulate: Simulate) -> None:
    result = simulate("SliderCrank", 2, step=0.01, tau=0.7)
    assert result["E"] - result["E"][0] == pytest.approx(0.7 * (result["phi"] - result["phi"][0]), abs=1e-5)


def test_two_geared_inertias_move_as_one(simulate: Simulate) -> None:
    result = simulate("GearedInertias", 20, step=0.5, tau=1.0)
    J = 0.01 * 5**2 + 2
    assert result["w_2"] == pytest.approx(5 / 0.5 * (1 - np.exp(-0.5 / J * result["time"])), abs=1e-6)
    assert result["w_1"] == pytest.approx(5 * result["w_2"], abs=1e-12)


def test_the_double_pendulum_agrees_with_its_equations_in_angles(simulate: Simulate) -> None:
    result = simulate("DoublePendulum", 5, step=0.05)

    def f(_: float, x: np.ndarray) -> list[float]:
        a, b, wa, wb = x
        mass = np.array([[2, np.cos(a - b)], [np.cos(a - b), 1]])
        force = [-np.sin(a - b) * wb**2 - 2 * G * np.sin(a), np.sin(a - b) * wa**2 - G * np.sin(b)]
        return [wa, wb, *np.linalg.solve(mass, force)]

    expected = solve_ivp(f, (0, 5), [0.4, -0.3, 0, 0], t_eval=result["time"], rtol=1e-10, atol=1e-10, method="DOP853").y
    for row, name in enumerate(("a", "b", "wa", "wb")):
        assert result[name] == pytest.approx(expected[row], abs=1e-5), name
    assert np.ptp(result["E"]) < 1e-5


def test_the_sampled_controller_equals_its_loop_written_by_hand(simulate: Simulate) -> None:
    result = simulate("SampledPI", 5, step=0.05)
    k, T_i, T_s, T = 2, 0.5, 0.1, 0.4
    x = u = y = 0.0
    for n in range(101):
        row = result[n]
        if n % 2 == 0:  # a tick; outputs are read before it, except at the start
            if n > 0:
                assert row["y"] == pytest.approx(y, abs=1e-8)
            x += T_s * (1 - y) / T_i
            u = k * (1 - y + x)
        else:
            assert row["u"] == pytest.approx(u, abs=1e-8)
        y = u + (y - u) * math.exp(-0.05 / T)
    assert result["y"][-1] == pytest.approx(1, abs=1e-3)


def test_the_pump_starts_and_stops_at_its_two_levels(simulate: Simulate) -> None:
    result = simulate("Tank", 40, step=0.01)
    low, high, q, k = 0.4, 1.0, 0.3, 0.2
    top = q / k
    fill = math.log((top - low) / (top - high)) / k
    drain = math.log(high / low) / k
    first = math.log((top - 0.5) / (top - high)) / k
    edges = result["time"][1:][result["filling"][1:] != result["filling"][:-1]]
    expected = list(itertools.accumulate([first, *([drain, fill] * 4)]))
    assert edges == pytest.approx(expected, abs=0.0101)
    assert result["starts"][-1] == 4, "the start of the simulation is not a start of the pump"
    assert result["level"].min() > low - 1e-6
    assert result["level"].max() < high + 1e-6


@pytest.mark.parametrize(("n_amber", "n_red"), [(2, 3), (1, 5)])
def test_the_lights_follow_their_chart(simulate: Simulate, n_amber: int, n_red: int) -> None:
    rows = [(0.0, 0.0), (1.2, 0.0), (1.2, 1.0), (20.0, 1.0)]
    result = simulate("Lights", 10, step=0.25, signals=("request", rows), n_amber=n_amber, n_red=n_red)
    red, green, amber = 1, 2, 3
    colour, count, changes = green, 0, 0
    for tick in range(20):
        request = tick * 0.5 > 1.2
        count += 1
        before = colour
        if before == green:
            if request:
                colour, count = amber, 0
        elif before == amber and count >= n_amber:
            colour, count = red, 0
        elif before == red and count >= n_red:
            colour, count = green, 0
        changes += count == 0
        row = result[np.searchsorted(result["time"], 0.5 * tick + 0.2)]  # after this tick, before the next
        assert (row["colour"], row["count"], row["changes"]) == (colour, count, changes), f"at {row['time']} s"
    assert changes >= 3


@pytest.mark.parametrize("w", [1.0, -1.0])
def test_mod_floor_and_ceil_step_where_the_ramp_crosses_a_multiple(simulate: Simulate, w: float) -> None:
    result = simulate("Steps", 5, step=0.03, w=w)
    phi = w * result["time"]
    inside = np.abs((phi + 0.35) % 0.7 - 0.35) > 1e-6  # at the multiples themselves either side is right
    inside[0] = False
    assert result["saw"][inside] == pytest.approx(np.mod(phi, 0.7)[inside], abs=1e-8)
    assert (result["turns"] == np.floor(phi / 0.7))[inside].all()
    assert (result["rounded_up"] == np.ceil(phi / 0.7))[inside].all()
    whole, rest = divmod(5.0, 0.7)
    area = whole * 0.7**2 / 2 + rest**2 / 2 if w > 0 else (whole + 1) * 0.7**2 / 2 - (0.7 - rest) ** 2 / 2
    assert result["area"][-1] == pytest.approx(area, abs=1e-7)


def test_heat_runs_along_the_rod_as_the_matrix_says(simulate: Simulate) -> None:
    result = simulate("Rod", 4, step=0.1)
    n, a = 8, 5.0
    A = a * (np.diag([-2.0] * (n - 1) + [-1.0]) + np.diag([1.0] * (n - 1), 1) + np.diag([1.0] * (n - 1), -1))
    expected = linear(A, np.array([a] + [0.0] * (n - 1)), np.zeros(n), result["time"])
    for cell in range(n):
        assert result[f"T[{cell + 1}]"] == pytest.approx(expected[:, cell], abs=1e-7)
    assert result["mean"] == pytest.approx(expected.mean(axis=1), abs=1e-7)
    assert result["total"] == pytest.approx(expected.sum(axis=1), abs=1e-6)


def test_momentum_grows_with_the_force_while_mass_is_lost(simulate: Simulate) -> None:
    result = simulate("Momentum", 10, step=0.5)
    assert result["v"] == pytest.approx((20 + 3 * result["time"]) / (10 - 0.5 * result["time"]), rel=1e-7)


@pytest.mark.parametrize("R", [3.0, 0.0, 100.0])
def test_a_steady_start_stays_where_it_is(simulate: Simulate, R: float) -> None:
    result = simulate("SteadyStart", 1, step=0.1, u=12.0, R=R)
    assert result["i"] == pytest.approx(12 / (R + 9), rel=1e-9)
    assert result["v"] == pytest.approx(12 * 9 / (R + 9), rel=1e-9)


def test_the_modellers_choice_of_state_does_not_change_the_motion(simulate: Simulate) -> None:
    result = simulate("Coupled", 4, step=0.1)
    assert result["v"] == pytest.approx(-1.5 * np.exp(-0.5 * result["time"]), abs=1e-8)
