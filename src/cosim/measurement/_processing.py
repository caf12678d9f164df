"""Onset and smoothing of a torque, as the source text does them, and better.

The source's ways are in its ``extract_motor`` (appendix B.2.3) and ``motor`` (B.1.5): a threshold finds the onset, and
a causal moving average of 55 samples smooths plots, which delays them by 27 samples.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from cosim.errors import InputError

Array = NDArray[np.float64]
Onset = Literal["threshold", "correlation", "none"]
Smoothing = Literal["moving_average", "zero_phase", "none"]

WINDOW = 100
"""Samples after the one looked at, whose mean the threshold compares with it."""
RISE = 0.3
"""By how much [N.m] that mean has to be above it."""
AVERAGE = 55
"""Samples of the moving average."""
_ROUNDING = 1e-9
LARGEST = 1e30
"""Numbers beyond are refused: what is measured is smaller, and their squares overflow."""


def threshold_onset(torque: Array) -> int | None:
    """Return the source's onset: the first sample that is not zero and 0.3 N.m below the mean of it and the next 100.

    None if there is none, also where the source's script would fail since fewer than 100 samples follow.
    """
    count = len(torque) - WINDOW
    if count <= 0:
        return None
    sums = np.concatenate(([0.0], np.cumsum(torque)))
    means = (sums[WINDOW + 1 :] - sums[: -WINDOW - 1]) / (WINDOW + 1)
    scale = _ROUNDING * (1.0 + float(np.abs(torque).max()))
    # the sums round differently from a mean, so they only say where a look is worth it
    likely = (means >= torque[:count] + RISE - scale) & (torque[:count] != 0.0)
    for i in np.flatnonzero(likely).tolist():
        if np.mean(torque[i : i + WINDOW + 1]) >= torque[i] + RISE:
            return int(i)
    return None


def correlation_onset(torque: Array, window: int = WINDOW, rise: float = RISE) -> int | None:
    """Return where a signal correlates best with a step of ``window`` samples before and after.

    Of several steps the first one counts that reaches half of the largest; None if even that is below ``rise`` (in the
    unit of the signal). Unlike the threshold it weighs both sides, so that one noisy sample cannot be taken for the
    onset.
    """
    if len(torque) < 2 * window:
        return None
    sums = np.concatenate(([0.0], np.cumsum(torque)))
    after = sums[2 * window :] - sums[window:-window]
    before = sums[window:-window] - sums[: -2 * window]
    step = (after - before) / window
    largest = float(step.max())
    if not largest >= rise:
        return None
    first = int(np.argmax(step >= 0.5 * largest))
    # the maximum of the hump that begins there
    return first + int(np.argmax(step[first : first + window])) + window


def find_onset(torque: Array, method: Onset) -> int:
    """Return the number of the sample at which the motion begins; raises `InputError` if none is found."""
    if method == "none":
        return 0
    found = threshold_onset(torque) if method == "threshold" else correlation_onset(torque)
    if found is None:
        raise InputError(
            f"no onset: in {len(torque)} samples the torque never rises by {RISE} N.m within {WINDOW} samples (the "
            "script of the source text stops there with an index error); check the columns, or read it with the onset "
            "'none'"
        )
    return found


def moving_average(values: Array, length: int = AVERAGE) -> Array:
    """Return the causal average of the last ``length`` samples, those before the first being zero, shape (n,).

    This is ``filter(ones(1, n)/n, 1, x)``; it delays by (length - 1)/2 samples.
    """
    from scipy.signal import lfilter

    return np.asarray(lfilter(np.full(length, 1.0 / length), np.ones(1), values), dtype=np.float64)


def zero_phase(values: Array, length: int = AVERAGE) -> Array:
    """Return a smoothed signal without delay, shape (n,): a Butterworth filter of order 2, forward and back.

    Its corner is that of the moving average of ``length`` samples (-3 dB at 0.443 / length of the sampling rate), met
    by both passes together.
    """
    from scipy.signal import butter, filtfilt

    # each of the two passes may take 1.5 dB at the corner: its own 3 dB corner lies (sqrt(2) - 1)^(-1/4) higher
    corner = 0.443 / length / (np.sqrt(2.0) - 1.0) ** 0.25
    b, a = butter(2, 2.0 * corner)
    return np.asarray(filtfilt(b, a, values, padlen=min(3 * length, len(values) - 1)), dtype=np.float64)


def smooth(values: Array, method: Smoothing, length: int = AVERAGE) -> Array:
    """Smooth a signal by the given method, shape (n,)."""
    if method == "none":
        return values
    return moving_average(values, length) if method == "moving_average" else zero_phase(values, length)
