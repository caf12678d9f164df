"""A tube around a curve, within which another one passes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cosim.errors import InputError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Tube:
    """``lower`` and ``upper`` at ``time`` [s], each of shape (n,)."""

    time: Array
    lower: Array
    upper: Array

    def outside(self, time: Array, values: Array) -> Array:
        """Return by how much a curve leaves the tube at each of its instants, zero where it stays inside; shape (n,).

        Raises `InputError` if it has instants outside those of the tube.
        """
        slack = 1e-9 * (self.time[-1] - self.time[0])
        if time[0] < self.time[0] - slack or time[-1] > self.time[-1] + slack:
            raise InputError(
                f"the curve lasts from {time[0]:g} s to {time[-1]:g} s, the tube from {self.time[0]:g} s to "
                f"{self.time[-1]:g} s"
            )
        above = values - np.interp(time, self.time, self.upper)
        below = np.interp(time, self.time, self.lower) - values
        return np.maximum(0.0, np.maximum(above, below))


def tube(time: Array, values: Array, half_width: float, half_height: float) -> Tube:
    """Return the tube that a rectangle sweeps whose centre moves along a curve.

    This is the idea of LBNL's funnel: at each instant the bounds are the largest and the smallest value of the curve
    within ``half_width`` [s] of it, plus and minus ``half_height``, so that a curve of the same shape passes that comes
    a little sooner or later. Between samples the curve is a polygon.

    Args:
        time: increasing, shape (n,).
        values: of the reference, shape (n,).
        half_width: tolerance in time [s], not negative.
        half_height: tolerance of the values, not negative.

    Raises:
        InputError: a tolerance is negative or no number.
    """
    if not (half_width >= 0.0 and half_height >= 0.0):
        raise InputError(f"the tolerances of the tube, {half_width:g} s and {half_height:g}, must not be negative")
    # the bounds of a polygon change where a sample enters or leaves the window, besides at the samples
    grid = np.unique(np.concatenate((time, time - half_width, time + half_width)))
    grid = grid[(grid >= time[0]) & (grid <= time[-1])]
    starts, stops = np.clip(grid - half_width, time[0], time[-1]), np.clip(grid + half_width, time[0], time[-1])
    ends = np.interp(starts, time, values), np.interp(stops, time, values)
    first, last = np.searchsorted(time, starts, "right"), np.searchsorted(time, stops, "left")
    highest = np.maximum(_extremes(values, first, last, np.maximum), np.maximum(*ends))
    lowest = np.minimum(_extremes(values, first, last, np.minimum), np.minimum(*ends))
    return Tube(grid, lowest - half_height, highest + half_height)


def _extremes(values: Array, first: NDArray[np.intp], last: NDArray[np.intp], better: np.ufunc) -> Array:
    """Return better(values[first[i]:last[i]]) for each i, the identity of ``better`` where that is empty.

    By a table of the extremes of 1, 2, 4, ... neighbours: any range is two of them that may overlap.
    """
    neutral = -np.inf if better is np.maximum else np.inf
    result = np.full(len(first), neutral)
    level, length = values, 1
    sizes = last - first
    while length <= max(int(sizes.max(initial=0)), 1):
        here = (sizes >= length) & (sizes < 2 * length)
        result[here] = better(level[first[here]], level[last[here] - length])
        if 2 * length > len(values):
            break
        level, length = better(level[:-length], level[length:]), 2 * length
    return result
