"""Small electrical models: circuits, machines, switches and clocks against their closed forms."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from laws import linear
from scipy.optimize import brentq
from scipy.special import lambertw

Simulate = Callable[..., Any]


@pytest.mark.parametrize("w", [100.0, 80.0])
@pytest.mark.slow
def test_the_resonant_circuit_swings_up_as_its_matrix_says(simulate: Simulate, w: float) -> None:
    result = simulate("Resonance", 1, step=0.01, w=w)
    R, L, C = 1, 0.1, 1e-3
    # current, voltage, and sine and cosine of the source as two more states
    A = np.array([[-R / L, -1 / L, 10 / L, 0], [1 / C, 0, 0, 0], [0, 0, 0, w], [0, 0, -w, 0]])
    expected = linear(A, np.zeros(4), np.array([0, 0, 0, 1.0]), result["time"])
    assert result["i"] == pytest.approx(expected[:, 0], abs=1e-6)
    assert result["v_C"] == pytest.approx(expected[:, 1], abs=1e-5)
    if w == 100:
        # at resonance the coil and the capacitor cancel, and Q = 10 times the source's voltage is across each
        assert np.abs(result["v_C"]).max() == pytest.approx(100, rel=0.02)


@pytest.mark.slow
def test_the_transformer_couples_both_coils(simulate: Simulate) -> None:
    result = simulate("Transformer", 2, step=0.02, u=10.0)
    L, R = np.array([[0.4, 0.19], [0.19, 0.1]]), np.diag([2.0, 5.0])
    inverse = np.linalg.inv(L)
    expected = linear(-inverse @ R, inverse @ np.array([10.0, 0.0]), np.zeros(2), result["time"])
    assert result["i_1"] == pytest.approx(expected[:, 0], abs=1e-7)
    assert result["i_2"] == pytest.approx(expected[:, 1], abs=1e-7)


@pytest.mark.slow
def test_the_motor_as_a_gyrator_starts_and_loses_no_energy_unseen(simulate: Simulate) -> None:
    result = simulate("GyratorMotor", 2, step=0.02)
    R, L, k, J, d, u = 1, 0.05, 0.2, 0.01, 0.01, 12
    A = np.array([[-R / L, -k / L], [k / J, -d / J]])
    expected = linear(A, np.array([u / L, 0]), np.zeros(2), result["time"])
    assert result["i"] == pytest.approx(expected[:, 0], abs=1e-7)
    assert result["w"] == pytest.approx(expected[:, 1], abs=1e-6)
    assert result["w"][-1] == pytest.approx(u * k / (k**2 + R * d), rel=1e-3)
    assert result["E_in"] == pytest.approx(result["E_out"], abs=1e-5)


@pytest.mark.parametrize("duty", [0.3, 0.8])
def test_the_choppers_current_ripples_between_its_two_closed_forms(simulate: Simulate, duty: float) -> None:
    result = simulate("Chopper", 0.06, step=5e-5, duty=duty)
    U, R, period, tau = 24, 2, 1e-3, 0.01 / 2
    late = result[result["time"] > 12 * tau - 2 * period]
    on, off, whole = (math.exp(-x * period / tau) for x in (duty, 1 - duty, 1))
    highest, lowest = U / R * (1 - on) / (1 - whole), U / R * (1 - on) / (1 - whole) * off
    left = math.exp(-(12 - 2 * period / tau))  # of the start, where the current was zero
    assert late["i"].max() == pytest.approx(highest, abs=2 * left * highest)
    assert late["i"].min() == pytest.approx(lowest, abs=2 * left * highest)
    # the place in the period, away from the switching itself
    place = np.mod(result["time"] / period, 1)
    clear = (np.abs(place - duty) > 1e-6) & (place > 1e-6) & (place < 1 - 1e-6)
    assert (result["on"] == (place < duty))[clear].all()


def test_a_switch_joins_two_capacitors_and_keeps_their_charge(simulate: Simulate) -> None:
    result = simulate("ChargeSharing", 0.5, step=0.005)
    C_1, C_2, R, t = 1e-3, 3e-3, 20, result["time"]
    end, tau = (C_1 * 10 + C_2 * 2) / (C_1 + C_2), R * C_1 * C_2 / (C_1 + C_2)
    left = np.where(t < 0.1, 1, np.exp(-(t - 0.1) / tau))
    assert result["v_1"] == pytest.approx(end + (10 - end) * left, abs=1e-7)
    assert result["v_2"] == pytest.approx(end + (2 - end) * left, abs=1e-7)
    # whatever the resistance, half the reduced capacitance times the squared difference is lost
    assert result["E"][0] - result["E"][-1] == pytest.approx(C_1 * C_2 / (C_1 + C_2) * 8**2 / 2, rel=1e-6)


@pytest.mark.parametrize(("u", "R"), [(12.0, 100.0), (0.3, 100.0), (300.0, 10.0), (-5.0, 100.0)])
def test_the_operating_point_is_lamberts_function(simulate: Simulate, u: float, R: float) -> None:
    result = simulate("OperatingPoint", 1e-3, step=1e-3, u=u, R=R)
    i_s, v_t = 1e-12, 0.025
    # by logarithms, for the argument is beyond any double: w + log(w) = log(R i_s / v_t) + (u + R i_s) / v_t
    right = math.log(R * i_s / v_t) + (u + R * i_s) / v_t
    if right < 500:
        w = lambertw(math.exp(right)).real
    else:
        w = brentq(lambda w: w + math.log(w) - right, 1, right, xtol=1e-12)
    assert result["i"] == pytest.approx(v_t / R * w - i_s, rel=1e-7, abs=1e-15)
    assert result["v"] == pytest.approx(u - R * (v_t / R * w - i_s), abs=1e-9)


def test_the_trigger_with_a_lag_swings_with_its_period(simulate: Simulate) -> None:
    result = simulate("Schmitt", 2, step=0.01)
    tau, k = 0.1, 0.4
    half = tau * math.log((1 + k) / (1 - k))
    first = tau * math.log(1 / (1 - k))
    assert result["periods"][-1] == math.floor((2 - first - half) / (2 * half)) + 1
    last = first + half + 2 * half * (result["periods"] - 1)
    begun = result["periods"] > 0
    assert result["last"][begun] == pytest.approx(last[begun], abs=1e-9)
    assert np.abs(result["v"]).max() <= k * 5 + 1e-9


def test_chuas_circuit_follows_its_matrix_in_each_of_its_three_regions(simulate: Simulate) -> None:
    result = simulate("Chua", 40, step=0.02)
    inside, outside = -8 / 7, -5 / 7

    def region(x: float) -> int:
        return int(x > 1) - int(x < -1)

    def over_a_row(now: int) -> np.ndarray:
        """Where the origin and the three unit vectors are a row later."""
        slope = outside if now else inside
        A = np.array([[-9 * (1 + slope), 9, 0], [1, -1, 1], [0, -100 / 7, 0]])
        b = np.array([-9 * now * (inside - outside), 0, 0])
        return np.array([linear(A, b, x0, np.array([0.02]))[0] for x0 in np.vstack([np.zeros(3), np.eye(3)])])

    rows = {now: over_a_row(now) for now in (-1, 0, 1)}
    # from row to row, where both ends and what is between are in one region, the motion is linear
    compared = np.zeros(3, int)
    for before, after in itertools.pairwise(result):
        now = region(before["x"])
        if region(after["x"]) != now or min(abs(abs(row["x"]) - 1) for row in (before, after)) < 0.1:
            continue
        start = np.array([before[name] for name in "xyz"])
        expected = rows[now][0] + start @ (rows[now][1:] - rows[now][0])
        assert [after[name] for name in "xyz"] == pytest.approx(expected, abs=1e-7), before["time"]
        compared[now] += 1
    assert compared.min() > 10, "each region is visited"
