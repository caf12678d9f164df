"""How much later a measurement is than a result."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from cosim.comparison._curve import Curve, on_one_grid, sampled
from cosim.errors import InputError
from cosim.measurement import correlation_onset

Array = NDArray[np.float64]
Alignment = Literal["correlation", "onset", "angle", "none"]

_AS_GOOD = 2e-3
"""Correlations that are lower by no more than this are as good: of two periods of a steady motion the nearer counts."""
_OVERLAP = 0.5
"""The part of the shorter signal that has to overlap."""
_ONSET_WINDOW = 0.2
"""Seconds before and after an onset that are held against each other: 100 of the supplier's samples."""
_LEAST_RISE = 0.05
"""An onset rises by this part of the signal's range at least."""
_MOST_TURNS = 0.25
"""Revolutions from one sample to the next: more say nothing about one."""
POINTS = 720
"""Samples of a revolution in the domain of the crank angle."""


def find_lag(result: Curve, measured: Curve, method: Alignment, most: float = np.inf) -> float:
    """Return by how many seconds the measurement is later than the result; see ``find_angle`` for "angle".

    "onset" compares the instants at which both begin to rise; "correlation" takes the lag at which the parts that
    overlap, by half of the shorter one at least, correlate best, as a multiple of the coarser sampling time; none is
    beyond ``most`` [s].

    Raises `InputError` if a signal has no onset or does not vary.
    """
    if method == "onset":
        step = max(result.step, measured.step)
        return _onset(measured, step) - _onset(result, step)
    if method == "correlation":
        return correlation_lag(result, measured, most)
    return 0.0


def _onset(curve: Curve, step: float) -> float:
    """The instant [s] of the onset, looked for in samples that are ``step`` [s] apart.

    Before the first sample the signal is taken to have stood still, since workbooks are cut at the onset and runs begin
    with it.
    """
    window = max(2, round(_ONSET_WINDOW / step))
    values = _uniform(curve, step)
    standing = np.concatenate((np.full(window, values[0]), values))
    rise = _LEAST_RISE * float(np.ptp(values))
    found = correlation_onset(standing, window, rise) if rise > 0.0 else None
    if found is None:
        raise InputError(
            f"{curve.name}: no onset: it does not rise within {_ONSET_WINDOW:g} s by {_LEAST_RISE:.0%} of its range; "
            "choose another alignment"
        )
    return float(curve.time[0]) + step * (found - window)


def correlation_lag(result: Curve, measured: Curve, most: float = np.inf) -> float:
    """Return the lag [s] of best correlation, ``most`` at most; see ``find_lag``."""
    shift = measured.time[0] - result.time[0]
    # both from zero on one step, each with all of its samples
    step = max(result.step, measured.step)
    a, b = (_uniform(curve, step) for curve in (result, measured))
    correlation = _correlations(a, b)
    lags = step * (np.arange(len(correlation)) - (len(a) - 1)) + shift
    correlation = np.where(np.abs(lags) <= most * (1 + 1e-9), correlation, np.nan)
    if np.isnan(correlation).all():
        raise InputError(f"{result.name} or {measured.name} does not vary; there is nothing to align")
    best = float(np.nanmax(correlation))
    good = np.flatnonzero(correlation >= best - _AS_GOOD)
    # of neighbouring lags that are as good, the best; of humps that are, the nearest
    humps = np.split(good, np.flatnonzero(np.diff(good) > 1) + 1)
    tops = [int(hump[np.nanargmax(correlation[hump])]) for hump in humps]
    return float(lags[min(tops, key=lambda k: abs(lags[k]))])


def _uniform(curve: Curve, step: float) -> Array:
    length = curve.time[-1] - curve.time[0]
    if length < step * (1.0 - 1e-9):
        raise InputError(f"{curve.name}: {length:g} s are too short to align, with samples {step:g} s apart")
    grid = Curve("", curve.time[0] + step * np.arange(int(length / step * (1 + 1e-9)) + 1), np.empty(0))
    return on_one_grid(curve, replace(grid, values=np.zeros(len(grid.time)))).result


def _correlations(a: Array, b: Array) -> Array:
    """Return Pearson's correlation of a[i] with b[i + lag] over the overlap, for lag = 1 - len(a) to len(b) - 1."""
    from scipy.signal import fftconvolve

    a, b = a - a.mean(), b - b.mean()
    one_a, one_b = np.ones(len(a)), np.ones(len(b))

    def over_lags(x: Array, y: Array) -> Array:
        return np.asarray(fftconvolve(y, x[::-1]), dtype=np.float64)

    count = np.round(over_lags(one_a, one_b))
    sum_a, sum_b = over_lags(a, one_b), over_lags(one_a, b)
    covariance = over_lags(a, b) - sum_a * sum_b / count
    spread_a = over_lags(a**2, one_b) - sum_a**2 / count
    spread_b = over_lags(one_a, b**2) - sum_b**2 / count
    enough = count >= _OVERLAP * min(len(a), len(b))
    scale = 1e-9 * count
    varies = (spread_a > scale * a.var()) & (spread_b > scale * b.var())
    with np.errstate(invalid="ignore", divide="ignore"):
        correlation = covariance / np.sqrt(spread_a * spread_b)
    return np.where(enough & varies, correlation, np.nan)


def over_angle(curve: Curve) -> Curve:
    """Return a curve over the crank angle instead of time: ``time`` holds revolutions, from 0 on, POINTS each.

    Raises `InputError` if the angle is unknown, or the crank stands still or goes less than two revolutions.
    """
    if curve.angle is None:
        raise InputError(
            f"{curve.name}: the crank angle is unknown; it follows from a column phi_crank or from the speed"
        )
    angle = np.maximum.accumulate(curve.angle - curve.angle[0])
    turns = angle / (2.0 * np.pi)
    moving = np.concatenate(([True], np.diff(turns) > 0))
    if turns[-1] < 2.0:
        raise InputError(f"{curve.name}: the crank makes {turns[-1]:.2f} revolutions; at least two are needed")
    if turns[-1] > _MOST_TURNS * len(turns):
        raise InputError(
            f"{curve.name}: {len(turns)} samples of {turns[-1]:.4g} revolutions are too few; is the unit of the angle "
            "or the speed right?"
        )
    grid = np.arange(int(turns[-1] * POINTS) + 1) / POINTS
    seen = Curve(curve.name, turns[moving], curve.values[moving])
    # what 720 samples cannot show must not be folded down; a crank that all but stands still has no rate to filter at
    dense = seen.step > 0.01 / POINTS
    values = sampled(seen, grid) if dense else np.interp(grid, seen.time, seen.values)
    return replace(curve, time=grid, values=values, angle=None)
