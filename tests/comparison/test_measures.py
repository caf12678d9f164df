"""The figures of a comparison against values worked out by hand, and the alignment against known shifts."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cosim.comparison import Curve, Pair, on_one_grid, tube
from cosim.comparison import _measures as measures
from cosim.comparison._alignment import POINTS, correlation_lag, find_lag, over_angle
from cosim.comparison._revolutions import envelope, share_inside, turned
from cosim.errors import InputError

PAIR = Pair(np.arange(5.0), np.array([1.0, 2, 4, 2, 1]), np.array([0.0, 2, 2, 2, 4]))
"""Residual 1, 0, 2, 0, -3: squares 14, sum 0."""


def test_figures_worked_out_by_hand() -> None:
    assert measures.rmse(PAIR) == pytest.approx(np.sqrt(14 / 5))
    assert measures.nrmse(PAIR) == pytest.approx(np.sqrt(14 / 5) / 4)
    assert measures.bias(PAIR) == 0.0
    assert measures.peak_error(PAIR) == 0.0
    assert measures.valley_error(PAIR) == 1.0
    # about their mean, 2 each: result -1 0 2 0 -1, measured -2 0 0 0 2, product 2 - 2 = 0
    assert measures.correlation(PAIR) == 0.0
    assert (measures.line(PAIR).gain, measures.line(PAIR).offset) == (0.0, 2.0)


def test_a_line_is_found() -> None:
    measured = np.array([0.0, 1, 3, 2])
    line = measures.line(Pair(np.arange(4.0), 1.25 * measured - 0.5, measured))
    assert (line.gain, line.offset) == (pytest.approx(1.25, abs=1e-14), pytest.approx(-0.5, abs=1e-14))


def test_what_does_not_vary_has_no_correlation() -> None:
    flat = Pair(np.arange(3.0), np.array([1.0, 2, 3]), np.ones(3))
    assert np.isnan([measures.correlation(flat), measures.nrmse(flat), measures.line(flat).gain]).all()
    assert len(measures.peak_timing(flat)) == 0


def test_peaks_are_paired_with_their_nearest() -> None:
    time = np.arange(0.0, 10.0, 0.01)

    def bumps(*centres: float) -> np.ndarray:
        return np.asarray(sum(np.exp(-(((time - centre) / 0.2) ** 2)) for centre in centres))

    pair = Pair(time, bumps(2.1, 5.0, 7.96), bumps(2.0, 5.0, 8.0, 9.0))
    np.testing.assert_allclose(measures.peak_timing(pair), [0.1, 0.0, -0.04], atol=1e-9)


def test_coherence_of_what_is_the_same_but_for_noise_above_a_frequency() -> None:
    from scipy.signal import butter, sosfiltfilt

    rng = np.random.default_rng(5)
    common = rng.standard_normal(40000)
    high = butter(8, 8.0, "high", fs=100.0, output="sos")
    pair = Pair(np.arange(40000) / 100.0, common, common + 30.0 * sosfiltfilt(high, rng.standard_normal(40000)))
    found = measures.spectrum(pair, 20.0)
    assert found.coherence[(found.frequency > 0.1) & (found.frequency < 3.0)].min() > 0.95  # each loses its mean
    assert found.coherence[found.frequency > 10.0].mean() < 0.25
    assert found.frequency.max() <= 20.0


def test_the_spectrum_holds_the_variance() -> None:
    """Parseval: the integral of the power spectral density; a sine of amplitude a has a^2/2, wherever it lies."""
    time = np.arange(9000) / 50.0
    for frequency in (1.0, 1.003, 4.71):
        pair = Pair(time, 3.0 * np.sin(2 * np.pi * frequency * time), np.sin(2 * np.pi * frequency * time + 1.0))
        found = measures.spectrum(pair, 25.0)
        step = found.frequency[1]
        assert found.result.sum() * step == pytest.approx(4.5, rel=1e-2)
        assert found.measured.sum() * step == pytest.approx(0.5, rel=1e-2)
        assert found.mean_coherence() == pytest.approx(1.0, abs=1e-4)


def test_noise_beside_a_tone_does_not_hide_that_the_tone_is_the_same() -> None:
    """Weighted by the measurement's power; the noise of the result lies where the measurement has none."""
    time = np.arange(20000) / 100.0
    tone = np.sin(2 * np.pi * 0.7531 * time)
    noise = 0.05 * np.random.default_rng(7).standard_normal(len(time))
    assert measures.spectrum(Pair(time, tone + noise, tone), 50.0).mean_coherence() > 0.99
    assert np.isnan(measures.spectrum(Pair(time, tone, np.zeros(len(time))), 50.0).mean_coherence())


def test_too_few_samples_have_no_spectrum() -> None:
    pair = Pair(np.arange(30.0), np.arange(30.0), np.arange(30.0))
    assert not len(measures.spectrum(pair, 1.0).frequency)


def wave(time: np.ndarray) -> np.ndarray:
    """Starts at t = 1, then swings, each period a little other than the one before."""
    after = np.maximum(time - 1.0, 0.0)
    return np.asarray((1 - np.exp(-5 * after)) * (5 + 3 * np.sin(3.1 * after) + 0.6 * np.sin(0.37 * after)))


@pytest.mark.parametrize("method", ["correlation", "onset"])
@pytest.mark.parametrize("shift", [-0.35, 0.0, 0.204, 0.78])
def test_a_known_shift_is_found_to_a_sample(method: str, shift: float) -> None:
    fine, coarse = np.arange(0.0, 20.0, 0.001), np.arange(0.0, 16.0, 0.002)
    result, measured = Curve("r", fine, wave(fine)), Curve("m", coarse, wave(coarse - shift))
    assert find_lag(result, measured, method) == pytest.approx(shift, abs=0.002 + 1e-9)  # type: ignore[arg-type]


def test_noise_and_scale_do_not_move_the_lag() -> None:
    time = np.arange(0.0, 20.0, 0.002)
    noise = np.random.default_rng(2).standard_normal(len(time))
    measured = Curve("m", time, 0.8 * wave(time - 0.5) + 1.5 + 0.5 * noise)
    assert find_lag(Curve("r", time, wave(time)), measured, "correlation") == pytest.approx(0.5, abs=0.002 + 1e-9)


def test_of_two_periods_of_a_steady_motion_the_nearer_one_counts() -> None:
    time = np.arange(0.0, 20.0, 0.01)
    result, measured = Curve("r", time, np.sin(np.pi * time)), Curve("m", time, np.sin(np.pi * (time - 0.6)))
    assert correlation_lag(result, measured) == pytest.approx(0.6, abs=1e-9)


@pytest.mark.parametrize("step", [0.001, 0.02])
def test_runs_and_workbooks_that_begin_with_the_onset(step: float) -> None:
    """The workbook is cut there, the run begins there; another time stood still for 0.6 s."""
    time = np.arange(0.0, 12.0, step)
    at_once = Curve("r", time, 0.3 * wave(time + 1.0))
    fine = np.arange(0.0, 12.0, 0.002)
    assert abs(find_lag(at_once, Curve("m", fine, wave(fine + 1.0)), "onset")) <= max(step, 0.002)
    assert find_lag(at_once, Curve("m", fine, wave(fine + 0.4)), "onset") == pytest.approx(0.6, abs=max(step, 0.002))


def test_over_the_angle_what_720_samples_cannot_show_is_left_out() -> None:
    time = np.arange(0.0, 12.0, 0.0001)
    angle = 3.0 * time
    ripple = np.cos(719.0 * angle)  # would look like one period a revolution
    found = over_angle(Curve("a", time, np.cos(2 * angle) + ripple, angle))
    inner = slice(POINTS // 4, -POINTS // 4)
    np.testing.assert_allclose(found.values[inner], np.cos(4 * np.pi * found.time)[inner], atol=5e-3)


def test_a_crank_that_creeps_most_of_the_time() -> None:
    time = np.arange(0.0, 100.0, 0.01)
    angle = np.where(time < 80.0, 1e-13 * time, 3.0 * (time - 80.0))
    assert np.isfinite(over_angle(Curve("a", time, np.sin(angle), angle)).values).all()


def test_nothing_to_align() -> None:
    time = np.arange(0.0, 5.0, 0.01)
    flat, swings = Curve("flat", time, np.ones(len(time))), Curve("swings", time, np.sin(9 * time))
    with pytest.raises(InputError, match=r"^flat or swings does not vary; there is nothing to align$"):
        find_lag(flat, swings, "correlation")
    with pytest.raises(InputError, match=r"^flat: no onset"):
        find_lag(flat, swings, "onset")


def test_the_coarser_grid_is_kept_and_what_it_cannot_show_is_left_out() -> None:
    fine, coarse = np.arange(0.0, 10.0, 0.001), np.arange(0.5, 12.0, 0.02)
    slow, fast = np.sin(2 * np.pi * 1.0 * fine), np.sin(2 * np.pi * 49.0 * fine)  # 49 Hz would look like 1 Hz at 50 Hz
    pair = on_one_grid(Curve("r", fine, slow + fast), Curve("m", coarse, np.sin(2 * np.pi * coarse)))
    np.testing.assert_allclose(pair.time, np.arange(0.5, 10.0, 0.02)[:475], atol=1e-9)
    inner = slice(20, -20)
    assert np.abs(pair.residual[inner]).max() < 2e-3
    assert np.array_equal(pair.measured, np.sin(2 * np.pi * coarse)[: len(pair.time)])


def test_signals_that_never_meet() -> None:
    a, b = Curve("a", np.arange(3.0), np.zeros(3)), Curve("b", np.arange(5.0, 8.0), np.zeros(3))
    with pytest.raises(InputError, match=r"^a and b have no time in common: 0 s to 2 s and 5 s to 7 s$"):
        on_one_grid(a, b)


def turning(name: str, speed: float, start: float, scale: float = 1.0) -> Curve:
    """Torque that depends on the crank angle alone, at a steady speed [rad/s] from an angle [rad]."""
    time = np.arange(0.0, 12.0, 0.001)
    angle = start + speed * time
    return Curve(name, time, scale * (5 + 3 * np.cos(2 * angle) + np.sin(angle)), angle)


def test_over_the_angle_the_speed_does_not_matter() -> None:
    """Two motors of other speeds, the second one seen from another angle on."""
    a, b = over_angle(turning("a", 3.0, 0.0)), over_angle(turning("b", 4.4, np.pi / 3))
    shift = turned(envelope(a), envelope(b))
    # b's angle 0 is a's pi/3, so b has to be turned back by 2 pi - pi/3
    assert shift == round(POINTS * 5 / 6)
    moved = Curve("b", b.time - shift / POINTS, b.values)
    assert np.abs(on_one_grid(a, moved).residual).max() < 1e-3
    assert envelope(a).revolutions == 5 and envelope(b).revolutions == 8
    assert share_inside(envelope(a), envelope(over_angle(turning("c", 4.4, 0.0, 1.3))), 0) == 0.0


def test_a_signal_shorter_than_a_sample_of_the_other() -> None:
    long, short = Curve("long", np.arange(5.0), np.arange(5.0)), Curve("short", np.array([0.0, 0.5]), np.arange(2.0))
    for method in ("correlation", "onset"):
        with pytest.raises(InputError, match=r"^short: 0.5 s are too short to align, with samples 1 s apart$"):
            find_lag(long, short, method)  # type: ignore[arg-type]


def test_an_angle_in_another_unit() -> None:
    with pytest.raises(InputError, match=r"^a: 12000 samples of 1.91e\+04 revolutions are too few; is the unit"):
        over_angle(turning("a", 1e4, 0.0))


def test_too_few_revolutions() -> None:
    with pytest.raises(InputError, match=r"^a: the crank makes 0.19 revolutions; at least two are needed$"):
        over_angle(turning("a", 0.1, 0.0))
    with pytest.raises(InputError, match=r"^a: the crank angle is unknown"):
        over_angle(Curve("a", np.arange(3.0), np.zeros(3)))


WALKS = arrays(np.float64, st.integers(2, 40), elements=st.integers(-50, 50).map(lambda k: k / 8))


@settings(deadline=None, max_examples=200)
@given(WALKS, st.sampled_from([0.0, 0.3, 1.0, 2.5, 7.0]), st.sampled_from([0.0, 0.5]))
def test_the_tube_is_what_a_rectangle_sweeps(values: np.ndarray, width: float, height: float) -> None:
    """Bounds by looking at every point of a fine polygon; only the corners of a polygon can be extreme."""
    time = np.arange(len(values), dtype=np.float64)
    found = tube(time, values, width, height)
    for t in np.linspace(time[0], time[-1], 61):
        low, high = max(t - width, time[0]), min(t + width, time[-1])
        near = np.concatenate(([low, high], time[(time >= low) & (time <= high)]))
        heights = np.interp(near, time, values)
        assert np.interp(t, found.time, found.upper) >= heights.max() + height - 1e-9
        assert np.interp(t, found.time, found.lower) <= heights.min() - height + 1e-9
        if t in found.time:
            assert np.interp(t, found.time, found.upper) == pytest.approx(heights.max() + height, abs=1e-9)
    assert not found.outside(time, values).any()


def test_a_curve_of_the_same_shape_passes_if_it_comes_within_the_width() -> None:
    time = np.linspace(0.0, 10.0, 2001)
    around = tube(time, np.sin(3 * time), 0.1, 0.01)
    for shift, passes in ((0.09, True), (-0.09, True), (0.15, False)):
        inside = (time > 0.2) & (time < 9.8)
        assert (around.outside(time, np.sin(3 * (time - shift)))[inside] == 0).all() == passes
    excess = around.outside(time, np.sin(3 * time) + 0.5)
    assert excess.max() == pytest.approx(0.49, abs=1e-9)  # at the tops
    with pytest.raises(InputError, match=r"the curve lasts from -1 s to 1 s, the tube from 0 s to 10 s"):
        around.outside(np.array([-1.0, 1.0]), np.zeros(2))
    with pytest.raises(InputError, match="must not be negative"):
        tube(time, time, -1.0, 0.0)


@pytest.mark.parametrize("seed", range(3))
def test_the_verdict_is_that_of_the_funnel(seed: int, tmp_path: object) -> None:
    """LBNL's funnel has the same tube for smooth curves; verdicts agree but for a hair's breadth around it."""
    pyfunnel = pytest.importorskip("pyfunnel")
    rng = np.random.default_rng(seed)
    time = np.linspace(0.0, 10.0, 400)
    a, b, c = rng.uniform(0.5, 2.0, 3)
    reference = a * np.sin(1.3 * time) + b * np.sin(2.9 * time + c)
    test = a * np.sin(1.3 * (time - 0.05)) + b * np.sin(2.9 * (time - 0.05) + c) + 0.1 * np.cos(time)
    around = tube(time, reference, 0.08, 0.15)
    pyfunnel.compareAndReport(time, reference, time, test, str(tmp_path), atolx=0.08, atoly=0.15)
    upper = np.loadtxt(f"{tmp_path}/upperBound.csv", delimiter=",", skiprows=1)
    lower = np.loadtxt(f"{tmp_path}/lowerBound.csv", delimiter=",", skiprows=1)
    grid = time[(time > 0.1) & (time < 9.9)]
    for bound, ours in ((upper, around.upper), (lower, around.lower)):
        difference = np.interp(grid, bound[:, 0], bound[:, 1]) - np.interp(grid, around.time, ours)
        assert np.abs(difference).max() < 0.02
