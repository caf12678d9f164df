"""Textbook models: invariants, modes, hysteresis, populations and problems of higher index."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

Simulate = Callable[..., Any]


def test_the_thermostat_switches_when_the_exponentials_say(simulate: Simulate) -> None:
    result = simulate("Thermostat", 20000, step=50)
    C, G, P, low, high, outside = 5e5, 100, 4000, 20.0, 22.0, 273
    hottest, tau = P / G, C / G
    first = tau * math.log((hottest - 17) / (hottest - high))
    heat = tau * math.log((hottest - low) / (hottest - high))
    cool = tau * math.log(high / low)
    expected = [first]
    while expected[-1] < 20000:
        expected.append(expected[-1] + (cool if len(expected) % 2 else heat))
    edges = result["time"][1:][result["heating"][1:] != result["heating"][:-1]]
    assert edges == pytest.approx(expected[:-1], abs=50)
    assert result["switchings"][-1] == len(expected) - 1
    on = sum(b - a for a, b in zip([0.0, *expected[1::2]], [*expected[0::2], 20000.0], strict=False) if b <= 20000)
    if len(expected) % 2:
        on += 20000 - expected[-2]
    assert result["E"][-1] == pytest.approx(P * on, rel=1e-7)
    stored = C * (result["T"] - 290)
    assert stored[-1] < result["E"][-1]
    assert result["T"][result["time"] > first].min() > outside + low - 1e-6


def test_levels_of_two_tanks_meet_as_torricelli_says(simulate: Simulate) -> None:
    result = simulate("TwoTanks", 6, step=0.1)
    A_1, A_2, k, g = 1, 2, 0.05, 9.81
    # the root of the difference falls at a constant rate
    root = math.sqrt(1.5) - k * math.sqrt(2 * g) / 2 * (1 / A_1 + 1 / A_2) * result["time"]
    assert root[-1] > 0.1
    assert result["h_1"] - result["h_2"] == pytest.approx(root**2, abs=1e-8)
    assert result["V"] == pytest.approx(3.0, abs=1e-12)


def test_edges_of_a_sine_are_counted(simulate: Simulate) -> None:
    result = simulate("Counter", 20, step=0.1)
    up, down = math.asin(0.5), math.pi - math.asin(0.5)
    angle = 5 * result["time"]
    rising = np.floor((angle - up) / (2 * math.pi)) + 1
    falling = np.floor((angle - down) / (2 * math.pi)) + 1
    assert (result["rising"] == rising).all()
    assert (result["changes"] == rising + falling).all()
    assert (result["digit"] == np.mod(rising, 4)).all()
    after = rising > 0
    assert result["last"][after] == pytest.approx(((up + 2 * math.pi * (rising - 1)) / 5)[after], abs=1e-11)


@pytest.mark.slow
def test_predators_and_prey_stay_on_their_closed_curve(simulate: Simulate) -> None:
    result = simulate("LotkaVolterra", 60, step=0.05)
    assert result["H"] == pytest.approx(result["H"][0], abs=1e-7)
    # over whole periods the means are those of the equilibrium
    starts = np.flatnonzero((result["y"][:-1] < 2.75) & (result["y"][1:] >= 2.75))
    assert len(starts) >= 4
    period = result[starts[0] : starts[-1]]
    assert period["x"].mean() == pytest.approx(0.4 / 0.1, rel=0.01)
    assert period["y"].mean() == pytest.approx(1.1 / 0.4, rel=0.01)


@pytest.mark.slow
def test_growth_to_a_limit_is_the_logistic_curve(simulate: Simulate) -> None:
    result = simulate("Logistic", 12, step=0.1)
    assert result["N"] == pytest.approx(1000 / (1 + 99 * np.exp(-0.8 * result["time"])), rel=1e-8)


@pytest.mark.slow
def test_a_harvest_that_the_stock_limits_leaves_the_smaller_limit(simulate: Simulate) -> None:
    result = simulate("Logistic", 12, step=0.1, q=0.5)
    # below the saturation the harvest only slows the growth: logistic again, with r - q
    limit = 1000 * (0.8 - 0.5) / 0.8
    expected = limit / (1 + (limit / 10 - 1) * np.exp(-0.3 * result["time"]))
    assert result["N"] == pytest.approx(expected, rel=1e-8)
    # from above it the full harvest ends where the stock falls below
    above = simulate("Logistic", 40, step=0.1, q=0.3)
    assert above["N"][-1] == pytest.approx(1000 / 2 * (1 + math.sqrt(1 - 4 * 0.3 * 600 / 0.8 / 1000)), rel=1e-3)


def test_two_lags_are_driven_along_a_sine(simulate: Simulate) -> None:
    result = simulate("IndexTwo", 10, step=0.1)
    # 3 T_1 = T_2: eliminating u and y leaves 4 x' + 0 x = 3 s' + s - ... = (T_2 s' + s + ...)
    T_1, T_2, w, t = 1.0, 3.0, 2.0, result["time"]
    s, ds = np.sin(w * t), w * np.cos(w * t)
    assert result["x"] + result["y"] == pytest.approx(s, abs=1e-12)
    # (T_1 + T_2) x' = T_2 s' + s - 2 x, from u = T_1 x' + x = T_2 (s' - x') + s - x
    a, T = 2.0, T_1 + T_2
    amplitude = (T_2 * 1j * w + 1) / (T * 1j * w + a)  # of the forced motion, for s = Im e^(iwt)
    forced = np.imag(amplitude * np.exp(1j * w * t))
    x = forced + (0.5 - forced[0]) * np.exp(-a / T * t)
    assert result["x"] == pytest.approx(x, abs=1e-8)
    dx = (T_2 * ds + s - a * x) / T
    assert result["u"] == pytest.approx(T_1 * dx + x, abs=1e-7)


def test_the_force_along_a_given_path_is_its_second_derivative(simulate: Simulate) -> None:
    result = simulate("IndexThree", 5, step=0.05)
    t, w = result["time"], 3
    v = w * (np.cos(w * t) - np.exp(-w * t))
    a = w**2 * (np.exp(-w * t) - np.sin(w * t))
    assert result["x"] == pytest.approx(np.sin(w * t) + np.exp(-w * t), abs=1e-12)
    assert result["v"] == pytest.approx(v, abs=1e-12)
    assert result["F"] == pytest.approx(2 * a + 0.5 * v, abs=1e-11)


@pytest.mark.slow
def test_a_charged_particle_drifts_across_both_fields(simulate: Simulate) -> None:
    result = simulate("Cyclotron", 10, step=0.1)
    t, w, drift = result["time"], 4, 0.5
    # a circle about a centre that moves with the drift, to minus y
    assert result["x"] == pytest.approx((np.sin(w * t) + drift * (1 - np.cos(w * t))) / w, abs=1e-6)
    assert result["y"] == pytest.approx((np.cos(w * t) - 1 + drift * np.sin(w * t)) / w - drift * t, abs=1e-6)


@pytest.mark.slow
def test_each_mode_of_heat_decays_at_its_own_rate(simulate: Simulate) -> None:
    result = simulate("HeatModes", 1, step=0.05)
    n, a = 20, 30
    cell = np.arange(1, n + 1)
    expected = sum(
        size
        * np.outer(
            np.exp(-4 * a * math.sin(mode * math.pi / (2 * n + 2)) ** 2 * result["time"]),
            np.sin(mode * math.pi * cell / (n + 1)),
        )
        for mode, size in ((1, 1.0), (3, 0.5))
    )
    for k in cell:
        assert result[f"T[{k}]"] == pytest.approx(expected[:, k - 1], abs=1e-8)


def test_a_sine_is_sent_whenever_it_has_moved_by_delta(simulate: Simulate) -> None:
    result = simulate("SendOnDelta", 20, step=0.05)
    expected, level, t = [], 0, 0.0  # in units of delta
    while True:
        crossings = []
        for goal in (level + 1, level - 1):
            if abs(0.3 * goal) < 1:
                angle = math.asin(0.3 * goal)
                for first in (angle, math.pi - angle):
                    crossings.append((first + 2 * math.pi * math.ceil((t - first) / (2 * math.pi) + 1e-9), goal))
        t, level = min(crossings)
        if t > 20:
            break
        expected.append((t, level))
    assert len(expected) > 30
    for row in result[1:]:
        before = [crossing for crossing in expected if crossing[0] <= row["time"]]
        assert row["messages"] == len(before)
        if before:
            assert row["last"] == pytest.approx(before[-1][0], abs=1e-7)
            assert row["sent"] == pytest.approx(0.3 * before[-1][1], abs=1e-7)
