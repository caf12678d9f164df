"""Means, rates and spectra of sampled signals. Times are in s, increasing, of shape (n,) like the values."""

from __future__ import annotations

import numpy as np

from cosim.assessment._trace import Array

_ROUNDING = 1e-9
"""Share of a window that rounding errors of the times may take."""


def mean(time: Array, values: Array) -> float:
    """Return the mean over time, 1/T int x dt, by the trapezoidal rule."""
    return float(np.trapezoid(values, time) / (time[-1] - time[0]))


def rms(time: Array, values: Array) -> float:
    """Return the root of the mean square over time, sqrt(1/T int x^2 dt), exact for the polygon through the rows."""
    a, b = values[:-1], values[1:]
    squares = (a**2 + a * b + b**2) / 3.0
    return float(np.sqrt((squares * np.diff(time)).sum() / (time[-1] - time[0])))


def mean_rate(time: Array, values: Array, window: float) -> tuple[Array, Array]:
    """Return r(t) = (x(t) - x(t - window)) / window, and its times: those of the rows a window after the first.

    This is the exact mean of dx/dt over the window, for any x(t) that is exact at the rows; between rows x is
    interpolated linearly, which is needed only where the window is no multiple of their distance. No smaller distance
    of the rows changes it, other than a derivative from neighbouring rows, which grows without bound at a jump.
    """
    first = int(np.searchsorted(time, time[0] + window * (1 - _ROUNDING)))
    ends = time[first:]
    before = np.interp(ends - window, time, values)
    return ends, (values[first:] - before) / window


def spectrum(time: Array, values: Array) -> tuple[Array, Array]:
    """Return frequencies [Hz] and one-sided amplitudes of x minus its mean, both under a Hann window w.

    A[k] = 2 |sum_j w_j (x_j - m) exp(-2 pi i j k / n)| / sum_j w_j, with m = sum_j w_j x_j / sum_j w_j: a sine of
    amplitude a gives a line of height a, lowered by up to 15 % where its frequency lies between two of the returned
    ones (`lines` makes up for it).
    """
    frequencies, transform, weights = _transform(time, values)
    return frequencies, 2.0 * transform / weights.sum()


def band_rms(time: Array, values: Array, low: float, high: float) -> float:
    """Return the RMS of the part of x from one frequency to another [Hz], the first included.

    sqrt(sum_k 2 |X_k|^2 / (n sum_j w_j^2)) with X the transform of x minus its mean under the Hann window w. The
    window fades out both ends of the signal: what happens once, at the start, is no part of it.
    """
    frequencies, transform, weights = _transform(time, values)
    inside = (frequencies >= low) & (frequencies < high)
    return float(np.sqrt(2.0 * (transform[inside] ** 2).sum() / (len(weights) * (weights**2).sum())))


def lines(time: Array, values: Array, count: int, high: float) -> list[tuple[float, float]]:
    """Return frequency [Hz] and amplitude of the ``count`` strongest peaks of the spectrum below ``high`` [Hz].

    What lies between the frequencies of the transform is found from a peak and its larger neighbour, with the ratio
    r of their heights: d = (2 r - 1) / (r + 1) of the distance of the frequencies beside the peak, higher than it by
    pi d (1 - d^2) / sin(pi d). This is exact for one line of a long signal under a Hann window.
    """
    frequencies, amplitudes = spectrum(time, values)
    inner = amplitudes[1:-1]
    peaks = 1 + np.flatnonzero(
        (inner > amplitudes[:-2]) & (inner >= amplitudes[2:]) & (frequencies[1:-1] < high) & (inner > 0)
    )
    strongest = sorted(peaks[np.argsort(amplitudes[peaks])[::-1][:count]].tolist())
    return [_refined(frequencies, amplitudes, k) for k in strongest]


def _refined(frequencies: Array, amplitudes: Array, k: int) -> tuple[float, float]:
    side = 1 if amplitudes[k + 1] >= amplitudes[k - 1] else -1
    ratio = float(amplitudes[k + side] / amplitudes[k])
    d = max(0.0, (2 * ratio - 1) / (ratio + 1))  # below 1/2 the neighbour belongs to another line
    raised = np.pi * d * (1 - d**2) / np.sin(np.pi * d) if d > 0 else 1.0
    return float(frequencies[k] + side * d * frequencies[1]), float(amplitudes[k] * raised)


def _transform(time: Array, values: Array) -> tuple[Array, Array, Array]:
    """Return frequencies [Hz], magnitudes of the transform of what the window leaves of x, and the window."""
    step, sampled = _uniform(time, values)
    n = len(sampled)
    weights: Array = np.sin(np.pi * (np.arange(n) + 0.5) / n) ** 2
    fluctuation = sampled - (weights * sampled).sum() / weights.sum()
    magnitudes: Array = np.abs(np.fft.rfft(weights * fluctuation))
    return np.arange(len(magnitudes)) / (step * n), magnitudes, weights


def _uniform(time: Array, values: Array) -> tuple[float, Array]:
    """Return the median distance of the rows [s] and the values at multiples of it, interpolated linearly."""
    step = float(np.median(np.diff(time)))
    grid = time[0] + step * np.arange(int((time[-1] - time[0]) / step * (1 + _ROUNDING)) + 1)
    return step, np.interp(grid, time, values)
