"""Time over error between the points that were measured."""

from __future__ import annotations

import numpy as np

Curve = list[tuple[float, float]]
"""Errors and seconds."""


def at(curve: Curve, error: float) -> float:
    """Seconds that a method needs for an error: on a straight line of the logarithms between the points measured.

    Beyond them it is the time of the nearest one: for a larger error too much, for a smaller one too little.
    """
    logs = np.log([[e, s] for e, s in sorted(curve)])
    return float(np.exp(np.interp(np.log(error), logs[:, 0], logs[:, 1])))


def ratio(curve: Curve, own: Curve, error: float) -> str:
    """A method's seconds over our own at an error, as text that says so where points are missing."""
    low, high = min(curve)[0], max(curve)[0]
    bound = "> " if error < low else "< " if error > high else ""
    return f"{bound}{at(curve, error) / at(own, error):.1f}"
