"""The torque over a revolution of the crank: how it varies from one to the next."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cosim.comparison._alignment import POINTS
from cosim.comparison._curve import Curve

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Envelope:
    """Least, mean and largest value at each of POINTS angles of a revolution, over ``revolutions`` of them."""

    low: Array
    mean: Array
    high: Array
    revolutions: int


def envelope(curve: Curve) -> Envelope:
    """Return the envelope of the whole revolutions of a curve over the crank angle (``over_angle``)."""
    whole = (len(curve.values) - 1) // POINTS
    turns = curve.values[: whole * POINTS].reshape(whole, POINTS)
    return Envelope(turns.min(axis=0), turns.mean(axis=0), turns.max(axis=0), whole)


def turned(result: Envelope, measured: Envelope) -> int:
    """Return by how many of the POINTS angles the measurement's mean has to be turned back to fit the result's best.

    By circular correlation of the means.
    """
    a, b = result.mean - result.mean.mean(), measured.mean - measured.mean.mean()
    circular = np.fft.irfft(np.fft.rfft(b) * np.conj(np.fft.rfft(a)), POINTS)
    return int(np.argmax(circular))


def share_inside(result: Envelope, measured: Envelope, shift: int) -> float:
    """Return the part of a revolution in which the result's mean lies within the measurement's envelope."""
    low, high = np.roll(measured.low, -shift), np.roll(measured.high, -shift)
    return float(np.mean((result.mean >= low) & (result.mean <= high)))
