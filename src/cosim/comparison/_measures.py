"""Figures that say how well two signals on one grid agree."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cosim.comparison._curve import Pair

Array = NDArray[np.float64]

_PROMINENCE = 0.2
"""A peak stands out by this part of the signal's range."""

_LEAST_SEGMENT = 8
"""Samples of a segment of a spectrum."""
_NO_POWER = 1e-24
"""Of the largest product of both powers: less is rounding."""


@dataclass(frozen=True)
class Line:
    """A straight line through (measured, result): result = gain * measured + offset, by least squares."""

    gain: float
    offset: float


def rmse(pair: Pair) -> float:
    """Return the root of the mean square of the residual."""
    return float(np.sqrt(np.mean(pair.residual**2)))


def nrmse(pair: Pair) -> float:
    """Return the RMSE over the range of the measurement; NaN if that is zero."""
    spread = float(np.ptp(pair.measured))
    return rmse(pair) / spread if spread > 0.0 else float("nan")


def bias(pair: Pair) -> float:
    """Return the mean of the residual, positive if the result is the larger one."""
    return float(np.mean(pair.residual))


def peak_error(pair: Pair) -> float:
    """Return by how much the result's largest value exceeds the measurement's."""
    return float(pair.result.max() - pair.measured.max())


def valley_error(pair: Pair) -> float:
    """Return by how much the result's smallest value exceeds the measurement's."""
    return float(pair.result.min() - pair.measured.min())


def correlation(pair: Pair) -> float:
    """Return Pearson's coefficient of correlation; NaN if a signal does not vary."""
    a, b = pair.result - pair.result.mean(), pair.measured - pair.measured.mean()
    scale = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / scale if scale > 0.0 else float("nan")


def line(pair: Pair) -> Line:
    """Return the line that takes the measurement to the result; NaN if the measurement does not vary."""
    b = pair.measured - pair.measured.mean()
    spread = float(b @ b)
    gain = float((pair.result - pair.result.mean()) @ b) / spread if spread > 0.0 else float("nan")
    return Line(gain, float(pair.result.mean()) - gain * float(pair.measured.mean()))


def peak_timing(pair: Pair) -> Array:
    """Return for each peak of the measurement by how much later [s] the result's peak nearest to it is.

    Peaks stand out by a fifth of the signal's range. A peak of the measurement that is not the nearest one to the peak
    that is nearest to it has no partner and is left out.
    """
    from scipy.signal import find_peaks

    measured, result = (
        pair.time[find_peaks(values, prominence=_PROMINENCE * float(np.ptp(values)) or None)[0]]
        for values in (pair.measured, pair.result)
    )
    if not len(measured) or not len(result):
        return np.empty(0)
    partner = np.abs(result[None, :] - measured[:, None]).argmin(axis=1)
    back = np.abs(result[None, :] - measured[:, None]).argmin(axis=0)
    mutual = back[partner] == np.arange(len(measured))
    return np.asarray((result[partner] - measured)[mutual], dtype=np.float64)


@dataclass(frozen=True)
class Spectrum:
    """Power spectral densities [unit^2/Hz] of both at ``frequency`` [Hz], and their magnitude-squared coherence.

    All of shape (n,), empty if there are too few samples; the coherence is NaN where one of them has no power.
    """

    frequency: Array
    result: Array
    measured: Array
    coherence: Array

    def mean_coherence(self) -> float:
        """Return the coherence where the measurement has its power: weighted by it; NaN if there is none."""
        known = ~np.isnan(self.coherence)
        weight = float(self.measured[known].sum())
        return float(self.measured[known] @ self.coherence[known]) / weight if weight > 0.0 else float("nan")


def spectrum(pair: Pair, high: float) -> Spectrum:
    """Return the spectra at frequencies up to ``high`` [Hz], by Welch's method with Hann's window.

    Eight segments that overlap by half; of one alone the coherence would be one everywhere.
    """
    from scipy.signal import csd, welch

    length, rate = int(len(pair.time) / 4.5), 1.0 / pair.step
    if length < _LEAST_SEGMENT:
        return Spectrum(*(np.empty(0) for _ in range(4)))
    frequency, result = welch(pair.result, rate, nperseg=length)
    _, measured = welch(pair.measured, rate, nperseg=length)
    _, cross = csd(pair.result, pair.measured, rate, nperseg=length)
    power = result * measured
    least = _NO_POWER * float(power.max())
    coherence = np.divide(np.abs(cross) ** 2, power, out=np.full(len(power), np.nan), where=power > least)
    inside = frequency <= high
    return Spectrum(frequency[inside], result[inside], measured[inside], coherence[inside])
