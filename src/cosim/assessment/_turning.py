"""When a run starts, turns and completes its revolutions."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cosim.assessment._trace import Array, Trace

_SLOW = 0.05
"""Share of the largest speed below which the drive is taken to stand."""


def revolution_time(trace: Trace, inside: NDArray[np.bool_]) -> float | None:
    """Return the mean time between two closings of the park contact [s], None if there are not two.

    The wipe rate is its inverse. The time from the start to the first closing, in which the drive speeds up, is no
    part of it.
    """
    if not trace.has("park"):
        return None
    park, time = trace.switch("park")[inside], trace.time[inside]
    closes = time[1:][park[1:] & ~park[:-1]]
    return float((closes[-1] - closes[0]) / (len(closes) - 1)) if len(closes) > 1 else None


def starting_time(trace: Trace, inside: NDArray[np.bool_]) -> float | None:
    """Return when the first current flows [s]; None if the motor turns before, or never."""
    speed = next((trace.signal(name, "rad/s") for name in ("w_motor", "w_crank") if trace.has(name)), None)
    current = trace.signal("i_motor", "A")[inside] if trace.has("i_motor") else None
    time = trace.time[inside]
    if speed is None or current is None or not current.max() > 0:
        return None
    flows = int(np.flatnonzero(current > 0)[0])
    at_rest = abs(float(speed[inside][max(flows - 1, 0)])) <= _SLOW * float(np.abs(speed).max())
    return float(time[max(flows - 1, 0)]) if at_rest else None


def turning_points(trace: Trace, inside: NDArray[np.bool_]) -> tuple[list[float], bool]:
    """Return when a rocker's speed changes its sign [s], in the order of time, and True.

    Without rockers, when the crank passes a multiple of half a turn, near which a linkage turns, and False. What
    happens while the crank stands is left out.
    """
    time = trace.time[inside]
    moving = np.ones(len(time), dtype=bool)
    if trace.has("w_crank"):
        speed = np.abs(trace.signal("w_crank", "rad/s")[inside])
        moving = speed > _SLOW * speed.max()
    rockers = [name for name in ("w_ds", "w_ps") if trace.has(name)]
    found: list[float] = []
    for name in rockers:
        found += _crossings(time, trace.signal(name, "rad/s")[inside], moving)
    if not rockers and trace.has("phi_crank"):
        half_turns = trace.signal("phi_crank", "rad")[inside] / math.pi
        for level in range(math.ceil(half_turns.min()), math.floor(half_turns.max()) + 1):
            found += _crossings(time, half_turns - level, moving)
    return sorted(found), bool(rockers)


def _crossings(time: Array, values: Array, moving: NDArray[np.bool_]) -> list[float]:
    """Return the zeros between rows of different sign, by linear interpolation."""
    a, b = values[:-1], values[1:]
    rows = np.flatnonzero(((a < 0) & (b >= 0) | (a > 0) & (b <= 0)) & moving[1:])
    return [float(t) for t in time[rows] + (time[rows + 1] - time[rows]) * a[rows] / (a[rows] - b[rows])]
