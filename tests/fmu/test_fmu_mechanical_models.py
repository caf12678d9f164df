"""Small mechanical models: constraints, dry friction, backlash and collisions against their closed forms."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from laws import G, linear
from scipy.optimize import brentq

Simulate = Callable[..., Any]


def test_the_masses_on_the_rope_accelerate_as_atwood_found(simulate: Simulate) -> None:
    result = simulate("Atwood", 1, step=0.05)
    t, inertia = result["time"], 0.01 / 0.1**2
    a = G * (3 - 2) / (3 + 2 + inertia)
    assert result["x_1"] == pytest.approx(a * t**2 / 2, abs=1e-9)
    assert result["x_2"] == pytest.approx(1 - a * t**2 / 2, abs=1e-9)
    assert result["F_1"] == pytest.approx(3 * (G - a), rel=1e-9)
    assert result["F_2"] == pytest.approx(2 * (G + a), rel=1e-9)


@pytest.mark.parametrize("shape", [0.5, 1.0])
@pytest.mark.slow
def test_a_wheel_rolls_slower_than_a_block_slides(simulate: Simulate, shape: float) -> None:
    result = simulate("RollingWheel", 2, step=0.1, shape=shape)
    a = G * math.sin(0.2) / (1 + shape)
    assert result["x"] == pytest.approx(a * result["time"] ** 2 / 2, abs=1e-9)
    assert result["phi"] == pytest.approx(result["x"] / 0.3, rel=1e-12)
    assert result["F"] == pytest.approx(shape * 2 * a, rel=1e-9)


def test_the_crank_of_the_four_bar_turns_and_the_loop_stays_closed(simulate: Simulate) -> None:
    result = simulate("FourBar", 3, step=0.01, tau=0.05)
    a, b, c, d = 0.1, 0.4, 0.25, 0.4
    phi, psi = result["phi"], result["psi"]
    assert phi[-1] > 4 * math.pi
    # the rocker's angle from the two triangles that the diagonal from the crank pin to the rocker's bearing makes
    diagonal = np.hypot(d - a * np.cos(phi), a * np.sin(phi))
    to_pin = np.arctan2(a * np.sin(phi), a * np.cos(phi) - d)
    inside = np.arccos((c**2 + diagonal**2 - b**2) / (2 * c * diagonal))
    assert psi == pytest.approx(np.mod(to_pin, 2 * np.pi) - inside, abs=1e-8)
    # power of the torque becomes kinetic energy
    assert result["E"] - result["E"][0] == pytest.approx(0.05 * phi, abs=1e-7)


@pytest.mark.parametrize("start", [0.3, 1.0, 2.5])
def test_the_bead_on_the_cycloid_swings_in_the_same_time_from_everywhere(simulate: Simulate, start: float) -> None:
    result = simulate("Cycloid", 6, step=0.05, start=start)
    # the way along the wire from the bottom, 4 r cos(theta/2), is a harmonic oscillation of sqrt(g/r)/2
    expected = math.cos(start / 2) * np.cos(math.sqrt(G / 0.5) / 2 * result["time"])
    assert np.cos(result["theta"] / 2) == pytest.approx(expected, abs=1e-7)
    assert result["E"] == pytest.approx(result["E"][0], rel=1e-6)


@pytest.mark.slow
def test_the_quarter_car_rides_as_its_matrix_says(simulate: Simulate) -> None:
    result = simulate("QuarterCar", 2, step=0.02, road=0.05)
    mb, mw, cb, db, ct = 300, 40, 2e4, 1500, 2e5
    A = np.array(
        [
            [0, 0, 1, 0],
            [0, 0, 0, 1],
            [-cb / mb, cb / mb, -db / mb, db / mb],
            [cb / mw, -(cb + ct) / mw, db / mw, -db / mw],
        ]
    )
    expected = linear(A, np.array([0, 0, 0, ct / mw * 0.05]), np.zeros(4), result["time"])
    assert result["z_body"] == pytest.approx(expected[:, 0], abs=1e-8)
    assert result["z_wheel"] == pytest.approx(expected[:, 1], abs=1e-8)


def test_the_brake_stops_holds_and_lets_go(simulate: Simulate) -> None:
    J, friction, w0 = 0.5, 2.0, 10.0
    rows = [(0.0, 0.0), (4.0, 0.0), (4.0, 1.9), (6.0, 1.9), (6.0, -5.0), (8.0, -5.0)]
    result = simulate("Brake", 8, step=0.05, signals=("tau", rows))
    t, stop = result["time"], w0 * J / friction
    braking, holding, loose = t < stop - 0.01, (t > stop + 0.01) & (t < 5.99), t > 6.06
    assert result["w"][braking] == pytest.approx(w0 - friction / J * t[braking], abs=1e-8)
    assert result["phi"][holding] == pytest.approx(w0 * stop / 2, abs=1e-8)
    assert (result["w"][holding] == 0).all()
    assert result["stuck"][holding].all()
    assert not result["stuck"][loose].any()
    # fmpy hands a step of an input on at the next communication point at the latest
    since = t[loose] + result["w"][loose] / ((5 - friction) / J)
    assert np.ptp(since) < 1e-8
    assert since[0] == pytest.approx(6, abs=0.051)


def test_the_mass_sticks_and_slips_with_the_period_of_its_two_phases(simulate: Simulate) -> None:
    m, k, v, static, kinetic = 1.0, 50.0, 0.1, 8.0, 5.0
    result = simulate("StickSlip", 20, step=0.002)
    omega, lead = math.sqrt(k / m), (static - kinetic) / k
    # slipping: x - kinetic/k = lead cos(wt) + v/w sin(wt), until the speed is the belt's again, at minus the lead
    slip = 2 * (math.pi - math.atan2(lead * omega, v)) / omega
    stick = 2 * lead / v
    first = static / k / v
    assert result["slips"][-1] == 1 + math.floor((20 - first) / (slip + stick))
    edges = result["time"][1:][result["sticking"][1:] != result["sticking"][:-1]]
    pattern = np.arange(edges.size // 2 + 1) * (slip + stick) + first
    expected = np.sort(np.concatenate([pattern, pattern + slip]))[: edges.size]
    assert edges == pytest.approx(expected, abs=0.0021)
    last = first + (slip + stick) * (result["slips"][-1] - 1)
    since = result["time"] - last
    slipping = (since > 1e-6) & (since < slip - 1e-6)
    motion = kinetic / k + lead * np.cos(omega * since) + v / omega * np.sin(omega * since)
    assert slipping.sum() > 10
    assert result["x"][slipping] == pytest.approx(motion[slipping], abs=1e-6)


@pytest.mark.parametrize("torque", [3.0, -3.0])
def test_the_lossy_gear_takes_its_part_whichever_way_power_goes(simulate: Simulate, torque: float) -> None:
    result = simulate("LossyGear", 0.1, step=0.01, tau=torque)
    ratio, eta, J_1, J_2, t = 4, 0.7, 0.02, 1.5, result["time"]
    passed = ratio * (eta if torque > 0 else 1 / eta)
    a = passed * torque / (J_2 + passed * ratio * J_1)
    assert result["w_2"].min() > 0, "the test is about one direction of motion"
    assert result["w_2"] == pytest.approx(1 + a * t, abs=1e-9)
    turned = t + a * t**2 / 2
    kinetic = (J_2 + ratio**2 * J_1) * ((1 + a * t) ** 2 - 1) / 2
    assert result["E_lost"] == pytest.approx(torque * ratio * turned - kinetic, abs=1e-8)
    assert np.diff(result["E_lost"]).min() > 0
    assert (result["driving"] == (torque > 0)).all()


def test_rotors_with_backlash_swap_their_speeds_at_each_contact(simulate: Simulate) -> None:
    result = simulate("Backlash", 2, step=0.005)
    play, contact = 0.1, math.pi / math.sqrt(400 * 2 / 0.2)
    # free flight over half the play, then over all of it, with an elastic contact in between; equal inertias
    hits = play + np.arange(8) * (2 * play + contact)
    inside = np.zeros(len(result), bool)
    for n, hit in enumerate([-contact, *hits]):
        flight = (result["time"] > hit + contact) & (result["time"] < hits[n] if n < len(hits) else False)
        assert result["w_1"][flight] == pytest.approx(float(n % 2 == 0), abs=1e-8), n
        inside |= flight
    assert inside.sum() > 0.6 * len(result)
    assert result["w_1"] + result["w_2"] == pytest.approx(1.0, abs=1e-9)


def test_carts_collide_with_their_momentum_and_energy(simulate: Simulate) -> None:
    result = simulate("Collisions", 12, step=0.25)
    mass, x, v, t = np.array([1.0, 2.0, 6.0]), np.array([0.0, 1.0, 3.0]), np.array([1.0, 0.0, 0.0]), 0.0
    pieces = [(t, x, v)]
    while True:
        gaps, closing = np.diff(x), v[:-1] - v[1:]
        meets = np.where(closing > 1e-12, gaps / np.where(closing > 1e-12, closing, 1), np.inf)
        pair = int(np.argmin(meets))
        if not np.isfinite(meets[pair]):
            break
        t, x = t + meets[pair], x + v * meets[pair]
        common = (mass[pair : pair + 2] @ v[pair : pair + 2]) / mass[pair : pair + 2].sum()
        v = v.copy()
        v[pair : pair + 2] = 2 * common - v[pair : pair + 2]
        pieces.append((t, x, v))
    assert result["hits"][-1] == len(pieces) - 1 == 2
    for row in result:
        since, place, speed = next(piece for piece in reversed(pieces) if piece[0] <= row["time"])
        assert [row[f"x_{k}"] for k in (1, 2, 3)] == pytest.approx(place + speed * (row["time"] - since), abs=1e-8)


def test_the_ball_rests_when_it_has_become_slow(simulate: Simulate) -> None:
    result = simulate("RestingBall", 5, step=0.05)
    fall, e = math.sqrt(2 / G), 0.6
    bounces = math.ceil(math.log(0.05 / (G * fall)) / math.log(e))
    rest = fall * (1 + 2 * sum(e**n for n in range(1, bounces)))
    assert result["bounces"][-1] == bounces
    assert result["t_rest"][-1] == pytest.approx(rest, abs=1e-9)
    down = result["time"] > rest
    assert (result["h"][down] == 0).all()
    assert (result["v"][down] == 0).all()


@pytest.mark.slow
def test_the_planet_is_where_keplers_equation_says(simulate: Simulate) -> None:
    result = simulate("Kepler", 20, step=0.5)
    e = 0.6
    anomaly = [brentq(lambda E, M=t: E - e * math.sin(E) - M, t - 1, t + 1, xtol=1e-14) for t in result["time"]]
    assert result["x"] == pytest.approx(np.cos(anomaly) - e, abs=1e-6)
    assert result["y"] == pytest.approx(math.sqrt(1 - e**2) * np.sin(anomaly), abs=1e-6)
    assert result["H"] == pytest.approx(-0.5, abs=1e-8)
    assert result["L"] == pytest.approx(math.sqrt(1 - e**2), abs=1e-8)
