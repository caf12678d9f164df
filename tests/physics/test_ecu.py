"""The controller unit's hardware, part by part against its law, and all of it off against the bare profile."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np
import pytest

from cosim.engine import Channel, Component, Connection, Fmu, Result, System, simulate
from cosim.errors import InputError
from cosim.fmu import catalogue

Rows = list[tuple[float, float]]
IDLE = 1
I_FULL = 5.0 / (50 * 0.01)
"""Current that fills the converter's range: 5 V over the gain of 50 and 10 mOhm [A]."""


def run_alone(stop: float, current: Rows, park: Rows, step: float = 1e-3, enable: Rows | None = None,
              **parameters: Any) -> Result:  # fmt: skip  # noqa: ANN401
    """The unit with its inputs driven by rows of (time, value)."""
    unit = Component("controller", Fmu.read(catalogue.ensure("ecu")), parameters)
    rows = {"i_motor": current, "park": park, "enable": enable or [(0.0, 1.0)]}
    channels = [Channel(("controller", name), *map(list, zip(*table, strict=True))) for name, table in rows.items()]
    return simulate(System([unit], [], channels), stop=stop, output_interval=step, tolerance=1e-6)


def closed_loop(controller: str, parameters: Mapping[str, Any], stop: float, plant: str = "rig") -> Result:
    components = [Component("plant", Fmu.read(catalogue.ensure(plant))),
                  Component("controller", Fmu.read(catalogue.ensure(controller)), dict(parameters))]  # fmt: skip
    wires = [Connection(("controller", "duty"), ("plant", "duty")),
             Connection(("plant", "i_motor"), ("controller", "i_motor")),
             Connection(("plant", "park"), ("controller", "park"))]  # fmt: skip
    return simulate(System(components, wires), stop=stop, output_interval=1e-3, tolerance=1e-8)


OPEN: Rows = [(0.0, 1.0), (0.05, 0.0)]


def ramp(stop: float, step: float = 1e-4) -> Rows:
    """A current that rises by 2 A a second, in steps finer than any sampling here."""
    return [(k * step, 2.0 * k * step) for k in range(round(stop / step))]


@pytest.mark.parametrize(
    "parameters",
    [{}, {"T_filter": 0.125, "duty_min": 0.35, "T_sample": 0.05}, {"T_delay": 0.005, "T_compute": 0.005,
                                                                   "T_measure": 0.005}],
)  # fmt: skip
def test_with_every_part_off_the_unit_is_the_voltage_profile(parameters: dict[str, float]) -> None:
    """The same decisions at the same ticks and the same duty ratio, to the last bit, in the closed loop."""
    unit = closed_loop("ecu", parameters, 8.0).columns
    bare = {name: value for name, value in parameters.items() if name != "T_measure"}
    profile = closed_loop("voltage_profile", bare, 8.0).columns
    assert len(set(profile["controller.state"])) >= 5
    for name, values in profile.items():
        assert np.array_equal(unit[name], values), name


def test_the_amplifier_errs_by_its_gain_and_offset_and_saturates_at_its_supply() -> None:
    levels = [(0.01 * k, 0.5 * k) for k in range(30)]
    result = run_alone(0.3, levels, OPEN, amplifier=True, gain_error=0.02, v_offset=0.05)
    current = 0.5 * np.floor(result.time / 0.01 + 1e-6)
    expected = np.clip(1.02 * current + 0.05 / 0.5, 0.0, I_FULL)
    assert expected.max() == I_FULL
    np.testing.assert_allclose(result.columns["controller.i_filtered"][:-1], expected[:-1], atol=1e-12)


def test_the_converter_gives_the_nearest_code_and_none_outside_its_range() -> None:
    result = run_alone(6.0, [(0.001 * k, 0.002 * k) for k in range(6000)], OPEN, n_bits=8)
    step, current = I_FULL / 256, 2.0 * result.time[:-1]
    codes = result.columns["controller.i_filtered"][:-1] / step
    assert np.array_equal(codes, np.round(codes))
    assert (codes.min(), codes.max()) == (0, 255)
    inside = current < I_FULL - step
    assert np.abs(codes[inside] * step - current[inside]).max() == pytest.approx(step / 2, rel=0.06)
    assert np.all(np.diff(codes) >= 0)


@pytest.mark.parametrize("rate", [5e-4, 2e-3])
def test_the_low_pass_lags_a_rising_current_by_its_time_constant(rate: float) -> None:
    """Exactly, whatever the rate of sampling: y = s (t - tau + tau exp(-t/tau)) for the current s t."""
    rows = [(k * rate, 2.0 * k * rate) for k in range(round(0.1 / rate))]
    result = run_alone(0.1 - rate, rows, OPEN, rate, f_lowpass=50.0, T_measure=rate, T_compute=rate)
    tau, t = 1 / (2 * np.pi * 50.0), result.time
    expected = 2.0 * (t - tau + tau * np.exp(-t / tau))
    np.testing.assert_allclose(result.columns["controller.i_filtered"], expected, atol=1e-12)


def test_late_samples_are_late_by_up_to_the_jitter_and_are_of_that_instant() -> None:
    result = run_alone(2.0, ramp(2.0, 1e-5), OPEN, 1e-3, T_jitter=4e-4)
    taken = result.columns["controller.i_filtered"] / 2.0  # when the sample that a row shows was taken
    late = taken[2:] - result.time[1:-1]
    assert np.all((late > -1.1e-5) & (late < 4e-4))
    n = len(late)
    assert late.mean() == pytest.approx(2e-4 - 5e-6, abs=4 * 4e-4 / np.sqrt(12 * n))
    assert late.std() == pytest.approx(4e-4 / np.sqrt(12), rel=4 / np.sqrt(n))
    assert abs(np.corrcoef(late[1:], late[:-1])[0, 1]) < 4 / np.sqrt(n)


def test_the_moving_average_has_its_length_at_the_rate_of_measuring() -> None:
    result = run_alone(0.6, [(0.0, 0.0), (0.2, 1.0)], OPEN, 1e-3, T_filter=0.125, T_measure=2.5e-4)
    expected = np.clip((result.time - 0.2 + 2.5e-4) / 0.125, 0.0, 1.0) * (result.time > 0.2 - 1e-9)
    np.testing.assert_allclose(result.columns["controller.i_filtered"][:-1], expected[:-1], atol=1e-12)


def test_noise_has_its_deviation_and_its_seed_decides_it() -> None:
    def run(seed: int) -> np.ndarray[Any, Any]:
        columns = run_alone(4.0, [(0.0, 2.0)], OPEN, v_noise=0.05, seed=seed).columns
        return np.asarray(columns["controller.i_filtered"][1:] - 2.0)

    first, again, other = run(7), run(7), run(8)
    assert np.array_equal(first, again)
    n = len(first)
    for noise in (first, other):
        assert abs(noise.mean()) < 4 * 0.1 / np.sqrt(n)
        assert noise.std() == pytest.approx(0.05 / 0.5, rel=4 / np.sqrt(2 * n))
    assert abs(np.corrcoef(first, other)[0, 1]) < 4 / np.sqrt(n)


def test_the_park_input_sees_the_contact_late_and_lets_go_of_it_soon() -> None:
    """5 V through 50 Hz pass 4.5 V after tau log(10), and fall below it again after tau log(5/4.5)."""
    tick = 1e-4
    park = [(0.0, 1.0), (0.05, 0.0), (1.4, 1.0), (1.45, 0.0)]
    result = run_alone(
        1.5, [(0.0, 2.0)], park, tick, enable=[(0.0, 1.0), (1.0, 0.0)],
        v_park=4.5, f_park=50.0, T_compute=tick, T_measure=1e-2, T_sample=1e-2,
    )  # fmt: skip
    tau = 1 / (2 * np.pi * 50.0)
    # switched off, the chart becomes IDLE on the tick at which it sees the contact
    seen = result.time[np.flatnonzero(result.columns["controller.state"] != IDLE)[-1] + 1]
    assert seen == pytest.approx(1.4 + tau * np.log(10.0) + tick, abs=1.01 * tick)
    period = result.columns["controller.period"]
    opened = result.time[1:][np.diff(period) != 0]
    assert opened[-1] == pytest.approx(1.45 + tau * np.log(5.0 / 4.5) + tick, abs=1.01 * tick)


def test_the_timer_rounds_the_duty_ratio_to_its_steps() -> None:
    plain, stepped = (run_alone(2.0, [(0.0, 0.5)], OPEN, n_pwm=n).columns["controller.duty"] for n in (0, 40))
    assert np.abs(stepped * 40 - np.round(stepped * 40)).max() < 1e-12
    assert np.abs(stepped - plain).max() == pytest.approx(0.5 / 40, rel=0.05)


def test_the_protection_latches_off_until_the_switch_is_off() -> None:
    current = [(0.0, 2.0), (0.5, 16.0), (0.5012, 2.0)]
    result = run_alone(1.5, current, OPEN, enable=[(0.0, 1.0), (1.0, 0.0), (1.2, 1.0)], i_trip=15.0)
    time, duty, tripped = result.time, result.columns["controller.duty"], result.columns["controller.tripped"]
    latched = (time > 0.4995) & (time < 0.9995)
    assert np.all(tripped[latched] == 1) and np.all(tripped[~latched] == 0)
    assert np.all(duty[latched] == 0)
    assert np.all(duty[time < 0.4995] >= 0.7) and np.all(duty[time > 1.0005] > 0)


def test_measuring_and_computing_each_keep_their_rate() -> None:
    park = [*OPEN, (1.013, 1.0), (1.043, 0.0), (2.007, 1.0), (2.037, 0.0)]
    result = run_alone(3.0, ramp(3.0), park, T_measure=1e-3, T_compute=20e-3, T_filter=0.125)
    ticks = np.arange(len(result.time))
    states = np.flatnonzero(np.diff(result.columns["controller.state"])) + 1
    assert len(states) > 3 and np.all(ticks[states] % 20 == 0)
    assert np.all(np.diff(result.columns["controller.i_filtered"])[:-1] > 0)


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"T_jitter": 1e-3}, "T_jitter must not be negative, and must be less than T_measure"),
        ({"T_filter": 0.125, "T_measure": 1e-4}, "T_filter must not exceed 1024 periods of T_measure"),
        ({"n_bits": 25}, "n_bits must lie between 0 (off) and 24"),
        ({"f_lowpass": -1.0}, "f_lowpass must not be negative"),
        ({"v_park": 5.0}, "v_park must be less than v_closed, or the contact is never seen"),
        ({"n_pwm": -1}, "n_pwm must not be negative"),
        ({"seed": -1}, "seed must not be negative"),
    ],
)
def test_parameters_that_make_no_sense_are_refused(parameters: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as caught:
        run_alone(0.01, [(0.0, 0.0)], OPEN, **parameters)
    assert str(caught.value) == f"controller (ECU) refuses its parameters or inputs: {message}; change them"


@cache
def loop_with_everything_on() -> Result:
    parameters = {
        "T_measure": 5e-4, "T_jitter": 1e-4, "T_filter": 0.125, "amplifier": True, "gain_error": 0.01,
        "v_offset": 0.01, "f_lowpass": 50.0, "v_noise": 0.01, "n_bits": 10, "v_park": 4.5, "f_park": 50.0,
        "duty_min": 0.35, "n_pwm": 250, "T_delay": 1e-3, "i_trip": 15.0,
    }  # fmt: skip
    return closed_loop("ecu", parameters, 10.0)


def test_the_rig_wipes_on_with_all_imperfections() -> None:
    columns = loop_with_everything_on().columns
    closes = np.flatnonzero(np.diff(columns["plant.park"]) > 0)
    assert len(closes) == 4
    assert columns["controller.tripped"].max() == 0
    # what is measured is the motor's average current, off by gain and offset, the low-pass's time constant late, with
    # what is left of the noise and of the converter's steps
    averaged = 1.01 * np.convolve(columns["plant.i_motor"], np.ones(125) / 125)[: len(columns["plant.i_motor"])] + 0.02
    late = np.abs(np.gradient(averaged, 1e-3)[1000:]).max() / (2 * np.pi * 50.0)
    noise = np.hypot(0.01 / 0.5, I_FULL / 1024 / np.sqrt(12)) / np.sqrt(250)
    error = columns["controller.i_filtered"][1000:] - averaged[1000:]
    assert np.abs(error).max() < 1.1 * late + 5 * noise
    assert abs(error.mean()) < 2e-3
