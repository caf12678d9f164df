"""A quantity over time, and two of them on one grid."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cosim.errors import InputError

Array = NDArray[np.float64]

_ROUNDING = 1e-6
_MUCH_FINER = 1.5
"""A signal sampled this many times more often than the grid is low-passed before it is sampled less often."""
_ORDER = 4


@dataclass(frozen=True)
class Curve:
    """``values`` at ``time`` [s], both of shape (n,), time increasing; ``angle`` [rad] of the crank where it is known.

    ``name`` is for messages and pictures.
    """

    name: str
    time: Array
    values: Array
    angle: Array | None = None

    @property
    def step(self) -> float:
        """The median distance [s] of the samples."""
        return float(np.median(np.diff(self.time)))

    def between(self, start: float, stop: float) -> Curve:
        """Return the part from one time to another, both included; raises `InputError` if fewer than two samples."""
        slack = _ROUNDING * self.step
        inside = (self.time >= start - slack) & (self.time <= stop + slack)
        if inside.sum() < 2:
            raise InputError(
                f"{self.name}: {int(inside.sum())} samples from {start:g} s to {stop:g} s; it lasts from "
                f"{self.time[0]:g} s to {self.time[-1]:g} s"
            )
        angle = None if self.angle is None else self.angle[inside]
        return replace(self, time=self.time[inside], values=self.values[inside], angle=angle)

    def later(self, seconds: float) -> Curve:
        """Return the same, so much later."""
        return replace(self, time=self.time + seconds)


@dataclass(frozen=True)
class Pair:
    """A result and a measurement at the same instants: ``time`` [s] of the result, values of shape (n,) each."""

    time: Array
    result: Array
    measured: Array

    @property
    def residual(self) -> Array:
        """Result minus measurement, shape (n,)."""
        return self.result - self.measured

    @property
    def step(self) -> float:
        """The distance [s] of the samples."""
        return float(self.time[1] - self.time[0])


def on_one_grid(result: Curve, measured: Curve) -> Pair:
    """Sample both at the instants of the coarser one, where both are known.

    The finer one is freed beforehand, without delay, from what the coarser grid cannot show (Butterworth of order 4,
    forward and back, its corner at 0.8 of half the grid's sampling rate).

    Raises `InputError` if they have less than two instants in common.
    """
    step = max(result.step, measured.step)
    coarser = measured if measured.step >= result.step * (1.0 - _ROUNDING) else result
    start, stop = max(result.time[0], measured.time[0]), min(result.time[-1], measured.time[-1])
    slack = _ROUNDING * step
    origin = coarser.time[0]
    first, last = np.ceil((start - origin - slack) / step), np.floor((stop - origin + slack) / step)
    if not last - first >= 1:
        raise InputError(
            f"{result.name} and {measured.name} have no time in common: {result.time[0]:g} s to {result.time[-1]:g} s "
            f"and {measured.time[0]:g} s to {measured.time[-1]:g} s"
        )
    grid = origin + step * np.arange(first, last + 1)
    return Pair(grid, sampled(result, grid), sampled(measured, grid))


def sampled(curve: Curve, grid: Array) -> Array:
    """Return a curve at the instants of a uniform grid, freed beforehand from what the grid cannot show."""
    step = float(grid[1] - grid[0])
    time, values = curve.time, curve.values
    if step > _MUCH_FINER * curve.step:
        time, values = _low_passed(curve, step)
    return np.interp(grid, time, values)


def _low_passed(curve: Curve, step: float) -> tuple[Array, Array]:
    from scipy.signal import butter, sosfiltfilt

    count = round((curve.time[-1] - curve.time[0]) / curve.step)
    uniform = curve.time[0] + curve.step * np.arange(count + 1)
    values = np.interp(uniform, curve.time, curve.values)
    sos = butter(_ORDER, 0.8 * curve.step / step, output="sos")
    return uniform, np.asarray(sosfiltfilt(sos, values, padlen=min(len(values) - 1, 30)), dtype=np.float64)
