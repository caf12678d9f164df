"""Vibration measures against closed forms of signals made by hand."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.assessment import Method, Trace, compare, spectrum, vibration
from cosim.errors import InputError

from .test_shipped import run as shipped

TIME = np.arange(20001) * 1e-3


def signals(**columns: np.ndarray) -> Trace:
    return Trace("made", TIME, {f"plant.{name}": values for name, values in columns.items()})


@settings(max_examples=20, deadline=None)
@given(
    amplitude=st.floats(0.1, 50.0),
    offset=st.floats(-20.0, 20.0),
    cycles=st.integers(5, 600),
    window=st.floats(2e-3, 5e-2),
)
def test_a_sine_torque(amplitude: float, offset: float, cycles: int, window: float) -> None:
    frequency = cycles / 20
    found = vibration(
        signals(tau_crank=offset + amplitude * np.sin(2 * np.pi * frequency * TIME)),
        Method(window=window, bands=(0.1, 40.0)),
    )
    # a whole number of cycles; the rows miss the top of a cycle by half a row at most, the polygon lies inside the arc
    miss = (np.pi * frequency * 1e-3) ** 2
    assert found["torque_rms"] == pytest.approx(math.sqrt(offset**2 + amplitude**2 / 2), rel=miss + 1e-9)
    assert found["torque_peak"] == pytest.approx(abs(offset) + amplitude, rel=miss + 1e-9)
    assert found["torque_peak_to_peak"] == pytest.approx(2 * amplitude, rel=miss + 1e-9)
    # the mean of the derivative over w: its amplitude is lowered by sin(pi f w) / (pi f w)
    lowered = abs(math.sin(math.pi * frequency * window)) / (math.pi * frequency * window)
    rate = amplitude * 2 * math.pi * frequency * lowered
    rounding = 0.13 * amplitude * (2 * math.pi * frequency * 1e-3) ** 2 / window  # of x between rows
    assert found["torque_rate_peak"] == pytest.approx(rate, rel=miss, abs=rounding)


@pytest.mark.parametrize("frequency", [0.4367, 2.0, 3.333, 17.77])
def test_the_strongest_line_of_a_sine_is_the_sine(frequency: float) -> None:
    values = 5.0 + 3.0 * np.sin(2 * np.pi * frequency * TIME + 0.7)
    found = vibration(signals(tau_crank=values), Method(bands=(0.1, 1.0, 100.0), lines=1))
    ((line, height),) = found.lines["torque"]
    assert line == pytest.approx(frequency, abs=2e-3)
    assert height == pytest.approx(3.0, rel=1e-3)
    low, high = found["torque_band_0.1_1"], found["torque_band_1_100"]
    inside, outside = (low, high) if frequency < 1 else (high, low)
    assert inside == pytest.approx(3.0 / math.sqrt(2), rel=1e-3)
    assert outside < 1e-3 * inside


def test_the_spectrum_of_two_sines_on_its_frequencies_is_their_amplitudes() -> None:
    time = np.arange(2000) * 5e-3  # 10 s, lines each 0.1 Hz
    frequencies, amplitudes = spectrum(
        time, 2 + 3 * np.cos(2 * np.pi * 1.5 * time) + 0.2 * np.sin(2 * np.pi * 12 * time)
    )
    assert frequencies[:2] == pytest.approx([0, 0.1])
    assert amplitudes[[15, 120]] == pytest.approx([3.0, 0.2])
    others = np.delete(amplitudes, [14, 15, 16, 119, 120, 121])
    assert others.max() < 1e-9


@settings(max_examples=20, deadline=None)
@given(st.lists(st.floats(-5, 5), min_size=3, max_size=12))
def test_bands_share_out_the_variance(levels: list[float]) -> None:
    knots = np.linspace(0, 20, len(levels))
    values = np.interp(TIME, knots, levels)
    edges = (0.0, 0.3, 1.0, 7.0, 100.0)
    found = vibration(signals(i_motor=values), Method(bands=edges))
    parts = [found[f"current_band_{a:g}_{b:g}"] ** 2 for a, b in pairwise(edges)]
    weights = np.sin(np.pi * (np.arange(20001) + 0.5) / 20001) ** 2
    weighted = (weights * (values - np.average(values, weights=weights))) ** 2
    # Parseval: what the window leaves of the variance, but for what lies above 100 Hz
    assert sum(parts) == pytest.approx(weighted.sum() / (weights**2).sum(), rel=1e-2, abs=1e-12)


def test_a_ramp_has_its_slope_as_rate_whatever_the_window_and_the_rows() -> None:
    rng = np.random.default_rng(1)
    time = np.cumsum(rng.uniform(1e-3, 4e-3, 3000))
    for window in (4e-3, 10e-3, 17e-3):
        found = vibration(Trace("t", time, {"tau_crank": 3 - 7 * time}), Method(window=window))
        assert found["torque_rate_peak"] == pytest.approx(7, rel=1e-9)
        assert found["torque_rate_rms"] == pytest.approx(7, rel=1e-9)
        assert found["torque_rate_peak_to_peak"] == pytest.approx(0, abs=1e-8)


def test_a_step_is_a_rate_of_its_height_over_the_window() -> None:
    found = vibration(signals(tau_crank=np.where(TIME < 10, 1.0, 5.0)), Method(window=0.02))
    assert found["torque_rate_peak"] == pytest.approx(4.0 / 0.02)


def test_the_deviation_of_the_current_from_its_rms() -> None:
    # to and fro between 1 A and 3 A, linearly from row to row
    current = np.where(np.arange(20001) % 2 == 0, 1.0, 3.0)
    found = vibration(signals(i_motor=current))
    effective, mean = math.sqrt((1 + 3 + 9) / 3), 2.0
    assert found["current_rms"] == pytest.approx(effective)
    assert found["current_deviation"] == pytest.approx(math.sqrt(2 * effective**2 - 2 * effective * mean))
    assert found["current_deviation_relative"] == pytest.approx(found["current_deviation"] / effective)
    assert found["current_deviation_peak"] == pytest.approx(effective - 1.0)


def test_a_direct_current_does_not_deviate() -> None:
    found = vibration(signals(i_motor=np.full(20001, 2.5)))
    assert (found["current_rms"], found["current_deviation"]) == (pytest.approx(2.5), pytest.approx(0, abs=1e-12))


def test_power_and_energy() -> None:
    found = vibration(
        signals(
            v_motor=np.full(20001, 24.0),
            i_motor=2 + np.sin(2 * np.pi * TIME),
            tau_crank=np.full(20001, 9.0),
            w_crank=np.full(20001, 2.0),
        )
    )
    assert found["power_mean"] == pytest.approx(48.0)
    assert found["power_peak"] == pytest.approx(72.0)
    assert found["power_energy"] == pytest.approx(960.0)
    assert [found["crank_power_mean"], found["crank_power_energy"]] == pytest.approx([18.0, 360.0])


def test_the_start_is_where_the_first_current_flows() -> None:
    # at rest until 4 s, then a motor that starts with a time constant of 50 ms, and much later a jolt
    since = np.clip(TIME - 4.0, 0, None)
    speed = 200 * (1 - np.exp(-since / 0.05)) + np.where(TIME > 12, 20.0, 0.0)
    found = vibration(
        signals(w_motor=speed, w_crank=speed / 73, i_motor=10 * since * np.exp(-since / 0.05)), Method(window=0.01)
    )
    steepest = 200 * (1 - math.exp(-0.2)) / 0.01
    assert found["start_motor_acceleration"] == pytest.approx(steepest)
    assert found["start_pin_acceleration"] == pytest.approx(0.055 * steepest / 73)
    assert found["motor_acceleration_peak"] == pytest.approx(steepest)
    assert vibration(signals(w_motor=speed + 50, i_motor=0 * TIME + 1)).notes[-1].startswith("no turning point")
    assert "start_motor_acceleration" not in vibration(signals(w_motor=speed + 50, i_motor=0 * TIME + 1)).measures


def test_turning_points_are_where_rockers_turn_and_only_what_is_near_them_counts() -> None:
    # the rocker turns at 0.5 s, 1.5 s, ...; a torque pulse at each, one twice as high, and a higher one elsewhere
    pulses = sum(
        height * np.clip(1 - np.abs(TIME - at) / 0.04, 0, None)
        for at, height in [(0.5 + k, 2.0) for k in range(19)] + [(7.5, 2.0), (9.0, 30.0)]
    )
    columns = {"w_ds": np.cos(np.pi * TIME), "w_crank": np.full(20001, np.pi), "tau_crank": 5.0 + pulses}
    found = vibration(signals(**columns))
    assert found["turns"] == 20
    assert found["turn_torque_peak_to_peak_worst"] == pytest.approx(4.0)
    assert found["turn_torque_peak_to_peak_mean"] == pytest.approx((18 * 2.0 + 4.0) / 20)
    assert found["turn_torque_rate_worst"] == pytest.approx(4.0 / 0.04)
    assert found["torque_rate_peak"] == pytest.approx(30 / 0.04)
    # without rockers: half turns of the crank, at 1 s, 2 s, ...
    del columns["w_ds"]
    half = vibration(signals(phi_crank=np.pi * TIME, **columns))
    assert half["turn_torque_peak_to_peak_worst"] == pytest.approx(30.0)
    assert "turning points are taken at half turns of the crank, since there are no rockers" in half.notes


def test_the_time_of_a_revolution_leaves_the_first_one_out() -> None:
    found = vibration(signals(i_motor=TIME, park=((TIME - 3.0) % 2.0 < 0.012) & (TIME > 2.9)))
    assert found["revolution_time"] == pytest.approx(2.0)


@pytest.mark.parametrize("name", ["linkage_20ms", "rig_20ms"])
def test_halving_the_distance_of_the_rows_changes_no_measure_by_one_percent(name: str) -> None:
    coarse, fine = (vibration(shipped(name, f"output_interval={ms} ms")) for ms in (1.0, 0.5))
    assert coarse.measures.keys() == fine.measures.keys()
    changes = {key: coarse[key] / fine[key] - 1 for key in fine.measures}
    assert {key: change for key, change in changes.items() if abs(change) >= 0.01} == {}


def test_ratios_to_a_baseline() -> None:
    park = (TIME % 2.0 < 0.012) & (TIME > 0.1)
    base = vibration(signals(tau_crank=4 + np.sin(TIME), park=park, i_motor=0 * TIME))
    same = compare(vibration(signals(tau_crank=8 + 2 * np.sin(TIME), park=park, i_motor=0 * TIME)), base)
    assert same.notes == ()
    assert same.ratios["revolution_time"] == 1.0
    torques = {key: ratio for key, ratio in same.ratios.items() if key.startswith(("torque_", "turn_torque"))}
    assert list(torques.values()) == pytest.approx([2.0] * len(torques))
    assert len(torques) >= 8
    assert "current_rms" not in same.ratios  # zero in the baseline
    slow = (TIME % 2.5 < 0.012) & (TIME > 0.1)
    other = compare(vibration(signals(tau_crank=np.sin(TIME), park=slow), Method(window=0.02)), base)
    assert other.notes == (
        "not at the same wipe rate: a revolution takes 2.5 s in made and 2 s in made",
        "the two were measured in different ways",
    )
    (note,) = compare(vibration(signals(tau_crank=TIME)), base).notes
    assert note.startswith("the wipe rates are not known")


@pytest.mark.parametrize(
    ("table", "method", "message"),
    [
        ({"time": TIME, "x": TIME}, {}, "none of the columns tau_crank, i_motor, w_motor and w_crank is there"),
        ({"time": TIME * 20, "i_motor": TIME}, {}, r"rows are up to 0.02 s apart; .* need at most 0.005 s: .*=1ms"),
        ({"time": TIME, "i_motor": TIME}, {"since": 30.0}, "no two rows from 30 s on; "),
        ({"time": TIME, "i_motor": TIME}, {"until": 0.015}, "0.015 s are too short to measure anything"),
    ],
)
def test_what_cannot_be_measured_is_refused(
    table: dict[str, np.ndarray], method: dict[str, float], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        vibration(pd.DataFrame(table), Method(**method))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"window": 0.0}, "window 0.0: must be positive"),
        ({"radius": math.inf}, "radius inf: must be positive"),
        ({"since": 2.0, "until": 1.0}, "the first must lie before the second"),
        ({"bands": (1.0,)}, "give limits that increase"),
        ({"bands": (10.0, 1.0)}, "give limits that increase"),
    ],
)
def test_methods_out_of_range_are_refused(wrong: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Method(**wrong)  # type: ignore[arg-type]
