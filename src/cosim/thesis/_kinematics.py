"""Linkage and wipers as points in the plane, by the formulas of the source's scripts (B.1.2 to B.1.4, B.2.2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cosim.engine import Fmu

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Side:
    """A four-bar with its wiper: lengths [m], angles [rad], the ground joint B by its coordinates [m]."""

    a: float
    """Crank A-D."""
    f: float
    """Coupler D-C."""
    b: float
    """Rocker B-C."""
    ground: tuple[float, float]
    """B, seen from the crank axle A."""
    branch: int
    """+1: the first solution of ``intersectcircle``; -1: the second."""
    wiper: tuple[tuple[float, float], tuple[float, float]]
    """Distance from B and angle to the rocker of both ends of the wiper (Q1 to Q4 of B.1.4)."""
    xi: float
    """``angle_xi`` of B.1.3, "experimental"."""

    def pin(self, crank: ArrayLike) -> Array:
        """Return the crank pin D, shape (2, n), at the crank angles [rad]."""
        angle = np.atleast_1d(np.asarray(crank, dtype=np.float64))
        return self.a * np.stack([np.cos(angle), np.sin(angle)])

    def joint(self, crank: ArrayLike) -> Array:
        """Return the joint C, shape (2, n): where the circles about D and B meet, ``intersectcircle`` of B.2.2."""
        pin = self.pin(crank)
        to_ground = np.reshape(self.ground, (2, 1)) - pin
        distance = np.hypot(*to_ground)
        x, y = to_ground / distance
        along = (self.f**2 - self.b**2 + distance**2) / (2.0 * distance)
        across = self.branch * np.sqrt(self.f**2 - along**2)
        joint: Array = pin + np.stack([along * x + across * y, along * y - across * x])
        return joint

    def wiper_points(self, crank: ArrayLike) -> tuple[Array, Array]:
        """Return the inner and the outer end of the wiper, each of shape (2, n): A1 and B1, or A2 and B2.

        The script takes atan(x / y) of C - B, which is continuous here, as C stays below B.
        """
        x, y = self.joint(crank) - np.reshape(self.ground, (2, 1))
        alpha = self.xi + np.arctan(x / y)
        inner, outer = (
            np.stack([self.ground[0] - q * np.cos(o + alpha), self.ground[1] + q * np.sin(o + alpha)])
            for q, o in self.wiper
        )
        return inner, outer


@dataclass(frozen=True)
class Drawing:
    """Both sides on the crank axle A = (0, 0)."""

    ps: Side
    """Passenger side, left in the source's drawing."""
    ds: Side
    """Driver side."""


WIPER_PS = ((0.1186, np.deg2rad(44.0)), (0.9419, np.deg2rad(3.2)))
"""Q1, Q2 [m] and their angles [rad], B.1.4 lines 30, 31, 36, 37."""
WIPER_DS = ((0.1511, np.deg2rad(53.0)), (0.9475, np.deg2rad(7.1)))
"""Q3, Q4 [m] and their angles [rad], B.1.4 lines 32, 33, 39, 40."""
XI_PS, XI_DS = np.pi / 4, np.pi / 5
"""B.1.3 lines 10 and 11 [rad]."""


def drawing(linkage: Fmu) -> Drawing:
    """Return the geometry from the catalogue points that the linkage's FMU has as parameters, by B.1.3."""
    e, f, end_ds, end_ps, crank_ds, crank_ps = (
        _point(linkage, name) for name in ("PT_E", "PT_F", "PT_DS", "PT_PS", "PT_MDS", "PT_MPS")
    )
    corrections = _point(linkage, "corr3D")
    a, b_ds, b_ps, offset = (_number(linkage, name) for name in ("lever_M", "lever_DS", "lever_PS", "angle_offset"))
    axle = crank_ds + a * np.array([np.sin(offset), np.cos(offset), 0.0])
    f_ds = float(np.linalg.norm(crank_ds - end_ds) + corrections[1])
    f_ps = float(np.linalg.norm(crank_ps - end_ps) + corrections[2])
    g_ds = float(np.linalg.norm(axle - e))
    g_ps = float(np.linalg.norm(axle - f) - corrections[0])
    phi_ds, phi_ps = (float(np.arctan((p[2] - axle[2]) / abs(p[1] - axle[1]))) for p in (e, f))
    ground_ds = (g_ds * float(np.cos(phi_ds)), g_ds * float(np.sin(phi_ds)))
    ground_ps = (-g_ps * float(np.cos(phi_ps)), g_ps * float(np.sin(phi_ps)))
    return Drawing(
        ps=Side(a, f_ps, b_ps, ground_ps, -1, WIPER_PS, XI_PS),
        ds=Side(a, f_ds, b_ds, ground_ds, +1, WIPER_DS, XI_DS),
    )


def _number(linkage: Fmu, name: str) -> float:
    value = linkage.variables[f"linkage.geometry.{name}"].start
    assert isinstance(value, float)
    return value


def _point(linkage: Fmu, name: str) -> Array:
    return np.array([_number(linkage, f"{name}[{k}]") for k in (1, 2, 3)])
