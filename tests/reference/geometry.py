"""Planar crank-rocker linkage of the wiper drive, from the catalogue points of the thesis (B.1.2 to B.1.4, B.2.2).

The loop closure of one side, written with complex numbers and the crank angle ``theta``, is

    a exp(j theta) + f exp(j chi) = B + b exp(j psi),      B = g exp(j ground)

with the crank pin D at the end of the crank ``a``, the coupler ``f`` from D to C at the angle ``chi`` and the rocker
``b`` from the ground joint B to C at the angle ``psi``. Lengths in metres, angles in radians; every function of the
crank angle takes arrays and is smooth: the angles never jump, because rocker and coupler of a crank-rocker swing by
less than a turn about their positions at ``theta = 0``, whose angles are the ``atan2`` values.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

# B.1.2, drawing 2371908 and Catia, in mm.
PT_E = np.array([1480.25, -808.17, 1486.42])
PT_F = np.array([1354.91, 82.32, 1494.36])
PT_DS = np.array([1376.26, 32.13, 1446.37])
PT_PS = np.array([1416.18, -876.37, 1434.76])
PT_MDS = np.array([1383.33, -428.93, 1418.80])
PT_MPS = np.array([1372.36, -429.21, 1419.58])
LEVER_DS, LEVER_PS, LEVER_M = 76.44, 67.11, 55.0
ANGLE_OFFSET_DEG = 2.2
# B.1.3, corr3D, "due to simplification from 2D to 3D", in mm; the script's indices 1, 2, 3.
CORR_3D = (2.0, -26.0, 15.0)


@dataclass(frozen=True)
class FourBar:
    """One side of the linkage: bar lengths [m], direction of B seen from A [rad], branch of the circle intersection."""

    a: float
    """Crank A-D."""
    f: float
    """Coupler D-C."""
    b: float
    """Rocker B-C."""
    g: float
    """Ground A-B."""
    ground: float
    """Direction of B from A, counter-clockwise from the x axis."""
    branch: int
    """+1: first solution of ``intersectcircle``; -1: the second."""

    @property
    def pivot(self) -> tuple[float, float]:
        """Position of the ground joint B."""
        return self.g * float(np.cos(self.ground)), self.g * float(np.sin(self.ground))

    def pin(self, theta: ArrayLike) -> Array:
        """Position of the crank pin D, shape (2, ...)."""
        theta = np.asarray(theta, dtype=float)
        return self.a * np.stack([np.cos(theta), np.sin(theta)])

    def joint(self, theta: ArrayLike) -> Array:
        """Position of the joint C, shape (2, ...), by ``intersectcircle`` (B.2.2).

        With Q the row vector ``h (B - D) / d`` the script adds ``Q F N = (Q_y, -Q_x)`` for its first solution and
        subtracts it for the second.
        """
        d_x, d_y = self.pin(theta)
        b_x, b_y = self.pivot
        d = np.hypot(b_x - d_x, b_y - d_y)
        e_x, e_y = (b_x - d_x) / d, (b_y - d_y) / d
        along = (self.f**2 - self.b**2 + d**2) / (2 * d)
        h = self.branch * np.sqrt(self.f**2 - along**2)
        return np.stack([d_x + along * e_x + h * e_y, d_y + along * e_y - h * e_x])

    def rocker(self, theta: ArrayLike) -> Array:
        """Rocker angle psi = atan2(C - B), unwrapped."""
        b_x, b_y = self.pivot
        return _unwrapped(lambda x: _direction(self.joint(x) - np.reshape([b_x, b_y], (2,) + (1,) * np.ndim(x))), theta)

    def coupler(self, theta: ArrayLike) -> Array:
        """Coupler angle chi = atan2(C - D), unwrapped."""
        return _unwrapped(lambda x: _direction(self.joint(x) - self.pin(x)), theta)

    def slopes(self, theta: ArrayLike) -> tuple[Array, Array]:
        """First derivatives (psi', chi') with respect to the crank angle.

        The derivative of the loop closure, turned by -chi (-psi) so that the coupler (rocker) drops out of its real
        part.
        """
        theta = np.asarray(theta, dtype=float)
        psi, chi = self.rocker(theta), self.coupler(theta)
        across = np.sin(psi - chi)
        return (
            self.a * np.sin(theta - chi) / (self.b * across),
            self.a * np.sin(theta - psi) / (self.f * across),
        )

    def curvatures(self, theta: ArrayLike) -> tuple[Array, Array]:
        """Second derivatives (psi'', chi'') with respect to the crank angle, from the closure differentiated twice."""
        theta = np.asarray(theta, dtype=float)
        psi, chi = self.rocker(theta), self.coupler(theta)
        psi1, chi1 = self.slopes(theta)
        across, along = np.sin(psi - chi), np.cos(psi - chi)
        psi2 = (self.a * np.cos(theta - chi) + self.f * chi1**2 - self.b * along * psi1**2) / (self.b * across)
        chi2 = (self.a * np.cos(theta - psi) + self.f * along * chi1**2 - self.b * psi1**2) / (self.f * across)
        return psi2, chi2

    def turning_points(self) -> tuple[float, float]:
        """Crank angles in [0, 2 pi) of the rocker's extremes: crank and coupler stretched, then folded in line.

        The rocker turns where A, D and C lie on one line, at the distance f + a or f - a of C from A; the cosine rule
        in the triangle A B C then gives the direction of C, and the crank points there or opposite.
        """
        stretched, folded = (
            self.ground - self.branch * float(np.arccos((self.g**2 + r**2 - self.b**2) / (2 * self.g * r)))
            for r in (self.f + self.a, self.f - self.a)
        )
        return stretched % (2 * np.pi), (folded + np.pi) % (2 * np.pi)

    def swing(self) -> float:
        """Angle between the rocker's extremes [rad]."""
        first, second = self.rocker(np.array(self.turning_points()))
        return abs(float(first - second))

    def is_crank_rocker(self) -> bool:
        """Grashof's condition with the crank as the shortest bar, and both collinear positions reachable."""
        shortest, p, q, longest = sorted((self.a, self.f, self.b, self.g))
        return shortest == self.a and shortest + longest <= p + q and self.a + self.f < self.b + self.g


@dataclass(frozen=True)
class Linkage:
    """Both sides of the linkage on their common crank."""

    ds: FourBar
    """Driver side."""
    ps: FourBar
    """Passenger side."""


def catalogue_linkage(corr3d: tuple[float, float, float] = CORR_3D) -> Linkage:
    """Both four-bars by the formulas of B.1.3 (mm there, m here)."""
    offset = np.deg2rad(ANGLE_OFFSET_DEG)
    pt_m = PT_MDS + LEVER_M * np.array([np.sin(offset), np.cos(offset), 0.0])
    f_ds = np.linalg.norm(PT_MDS - PT_DS) + corr3d[1]
    f_ps = np.linalg.norm(PT_MPS - PT_PS) + corr3d[2]
    g_ds = np.linalg.norm(pt_m - PT_E)
    g_ps = np.linalg.norm(pt_m - PT_F) - corr3d[0]
    phi_ds = float(np.arctan((PT_E[2] - pt_m[2]) / abs(PT_E[1] - pt_m[1])))
    phi_ps = float(np.arctan((PT_F[2] - pt_m[2]) / abs(PT_F[1] - pt_m[1])))
    mm = 1e-3
    return Linkage(
        ds=FourBar(LEVER_M * mm, float(f_ds) * mm, LEVER_DS * mm, float(g_ds) * mm, phi_ds, branch=1),
        ps=FourBar(LEVER_M * mm, float(f_ps) * mm, LEVER_PS * mm, float(g_ps) * mm, np.pi - phi_ps, branch=-1),
    )


def _direction(vector: Array) -> Array:
    return np.asarray(np.arctan2(vector[1], vector[0]))


def _unwrapped(angle: Callable[[Array], Array], theta: ArrayLike) -> Array:
    """Continue the angle from its value at theta = 0; valid because it stays within half a turn of it."""
    start = angle(np.zeros(()))
    change = angle(np.asarray(theta, dtype=float)) - start
    return np.asarray(start + np.mod(change + np.pi, 2 * np.pi) - np.pi)
