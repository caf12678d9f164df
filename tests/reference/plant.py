"""Minimal-coordinate model of the wiper drive: current i, crank angle phi and crank speed w.

Balance of the rotor (worm side, w_W = n w), of the gear's output shaft, and of the armature:

    J_r n w'         = k i - d_r n w - tau_W
    I(phi) w'        = tau_G + tau_disturbance - B(phi, w)
    (L + 2 L_f) i'   = v_motor - R i - k n w             while the bridge conducts, else i = 0

``I`` and ``B`` are Lagrange's equation of the load in the one coordinate phi: with the kinetic energy I(phi) w^2 / 2,
B holds I'(phi) w^2 / 2 and the damping, load and potential torques, each reduced to the crank by its slope. The
provenance of every number is in FACTS, which the defaults repeat: table 3.1 (bars), 3.2 (load), 3.3 (worm gear), 3.4
(motor); section 4 (rig).

Decisions at open spots: the crank angle of the geometry and that of eq. 3.1 are both the gear output angle; a joint
spring is relaxed where its relative angle (rocker, rocker - coupler, coupler - crank, each unwrapped from its atan2
value at phi = 0) is zero; the crank bar is one bar; the rig carries neither linkage nor eq. 3.1.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import atan2, copysign, cos, cosh, fmod, pi, sin, sqrt, tanh
from typing import NamedTuple, Protocol

import numpy as np

from .geometry import FourBar, Linkage, catalogue_linkage

DEG = pi / 180
PARK_WIDTH = 2 * DEG
"""Section 3.2.1: the park contact's share of a revolution of the output shaft [rad]."""


class Reduced(NamedTuple):
    """The load reduced to the crank: inertia [kg.m2] and the torques [N.m] that resist positive rotation."""

    inertia: float
    convective: float
    """I'(phi) w^2 / 2."""
    damping: float
    load: float
    conservative: float
    """Derivative of the potential energy."""


class Load(Protocol):
    """What the gear drives."""

    def reduced(self, phi: float, w: float) -> Reduced:
        """Inertia and resisting torques at a crank angle [rad] and speed [rad/s]."""

    def potential(self, phi: float) -> float:
        """Potential energy [J]."""

    def outputs(self, phi: float, w: float) -> dict[str, float]:
        """Outputs that only this load has, by their names in the FMU interface."""


class _Side(NamedTuple):
    """Constants of one four-bar for the scalar formulas."""

    f2: float
    b2: float
    branch: float
    b_x: float
    b_y: float
    m_coupler: float
    j_rocker: float
    """About the ground joint B."""
    psi0: float
    chi0: float


@dataclass
class LinkageLoad:
    """Both four-bars with uniform slender bars, damped joints and the simple load (eq. 3.1) on each rocker."""

    linkage: Linkage = field(default_factory=catalogue_linkage)
    density: float = 8000.0
    width: float = 0.020
    thickness: float = 0.008
    damping: float = 1.5e-2 / DEG
    """Of each of the six passive joints [N.m.s/rad]."""
    stiffness: float = 1e-9 / DEG
    """Of each of the six passive joints [N.m/rad]."""
    ext_load: float = 3.0
    w_sign: float = 1e-3
    """sgn(w) = tanh(w / w_sign) [rad/s]."""
    arm_inertia: float = 0.0
    """Of a wiper arm about B [kg.m2]."""

    def __post_init__(self) -> None:
        a = self.linkage.ds.a
        self._a = a
        self._j_crank = self.bar_mass(a) * a**2 / 3
        self._sides = self._side(self.linkage.ds), self._side(self.linkage.ps)

    def bar_mass(self, length: float) -> float:
        """Mass of a bar [kg]."""
        return self.density * self.width * self.thickness * length

    def _side(self, bars: FourBar) -> _Side:
        return _Side(
            f2=bars.f**2,
            b2=bars.b**2,
            branch=float(bars.branch),
            b_x=bars.pivot[0],
            b_y=bars.pivot[1],
            m_coupler=self.bar_mass(bars.f),
            j_rocker=self.bar_mass(bars.b) * bars.b**2 / 3 + self.arm_inertia,
            psi0=float(bars.rocker(0.0)),
            chi0=float(bars.coupler(0.0)),
        )

    def _bars(self, side: _Side, r_x: float, r_y: float) -> tuple[float, float, float, float]:
        """Coupler vector u = C - D and rocker vector v = C - B for the crank vector r."""
        g_x, g_y = side.b_x - r_x, side.b_y - r_y
        d2 = g_x * g_x + g_y * g_y
        along = (side.f2 - side.b2 + d2) / (2 * d2)
        across = side.branch * sqrt(side.f2 / d2 - along * along)
        u_x, u_y = along * g_x + across * g_y, along * g_y - across * g_x
        return u_x, u_y, u_x - g_x, u_y - g_y

    def reduced(self, phi: float, w: float) -> Reduced:
        """Lagrange's equation in phi.

        The slopes follow from the loop closure with the vectors r (crank), u (coupler) and v (rocker); x is the
        planar cross product: psi' = (u x r) / (u x v), chi' = (v x r) / (u x v). The centre of a coupler moves
        with the velocity r_perp w + u_perp chi' w / 2, so that its kinetic energy is
        m (a^2 + r.u chi' + f^2 chi'^2 / 3) w^2 / 2, the rotation m f^2 / 12 included.
        """
        r_x, r_y = self._a * cos(phi), self._a * sin(phi)
        a2 = self._a * self._a
        shape = self.ext_load * (1 - abs(0.7 * cos(phi)))
        inertia, half_slope, squares, load, springs = self._j_crank, 0.0, 0.0, 0.0, 0.0
        for side in self._sides:
            u_x, u_y, v_x, v_y = self._bars(side, r_x, r_y)
            uv_cross, ru_cross = u_x * v_y - u_y * v_x, r_x * u_y - r_y * u_x
            ru, rv, uv = r_x * u_x + r_y * u_y, r_x * v_x + r_y * v_y, u_x * v_x + u_y * v_y
            psi1 = -ru_cross / uv_cross
            chi1 = (v_x * r_y - v_y * r_x) / uv_cross
            psi2 = (ru + side.f2 * chi1 * chi1 - uv * psi1 * psi1) / uv_cross
            chi2 = (rv + uv * chi1 * chi1 - side.b2 * psi1 * psi1) / uv_cross
            inertia += side.m_coupler * (a2 + ru * chi1 + side.f2 * chi1 * chi1 / 3) + side.j_rocker * psi1 * psi1
            half_slope += side.m_coupler * (
                (ru * chi2 - ru_cross * chi1 * (chi1 - 1)) / 2 + side.f2 * chi1 * chi2 / 3
            ) + (side.j_rocker * psi1 * psi2)
            squares += psi1 * psi1 + (psi1 - chi1) ** 2 + (chi1 - 1) ** 2
            load += shape * tanh(psi1 * w / self.w_sign) * psi1
            psi, chi = _near(atan2(v_y, v_x), side.psi0), _near(atan2(u_y, u_x), side.chi0)
            springs += psi * psi1 + (psi - chi) * (psi1 - chi1) + (chi - phi) * (chi1 - 1)
        return Reduced(inertia, half_slope * w * w, self.damping * squares * w, load, self.stiffness * springs)

    def potential(self, phi: float) -> float:
        """Energy of the joint springs [J]."""
        total = 0.0
        for bars in (self.linkage.ds, self.linkage.ps):
            psi, chi = float(bars.rocker(phi)), float(bars.coupler(phi))
            total += psi**2 + (psi - chi) ** 2 + (chi - phi) ** 2
        return self.stiffness * total / 2

    def outputs(self, phi: float, w: float) -> dict[str, float]:
        """Rocker angles, speeds and the torque of eq. 3.1, which has the sign of the speed."""
        result = {}
        for name, bars in (("ds", self.linkage.ds), ("ps", self.linkage.ps)):
            speed = float(bars.slopes(phi)[0]) * w
            result[f"phi_{name}"] = float(bars.rocker(phi))
            result[f"w_{name}"] = speed
            result[f"tau_{name}"] = (1 - abs(0.7 * cos(phi))) * tanh(speed / self.w_sign) * self.ext_load
        return result


@dataclass
class RigLoad:
    """Lifetime-test rig of chapter 4 (figure 4.4): a point mass on an arm that hangs at phi = 0.

    The arm's angle from the horizontal is phi + 270 deg, its height r sin(phi + 270 deg) = -r cos(phi), so that
    gravity resists with m g r sin(phi).
    """

    mass: float = 2.35
    radius: float = 0.25
    gravity: float = 9.80665

    def reduced(self, phi: float, w: float) -> Reduced:
        """Constant inertia, gravity."""
        moment = self.mass * self.gravity * self.radius
        return Reduced(self.mass * self.radius**2, 0.0, 0.0, 0.0, moment * sin(phi))

    def potential(self, phi: float) -> float:
        """Energy in the gravity field, zero when the arm is level [J]."""
        return -self.mass * self.gravity * self.radius * cos(phi)

    def outputs(self, phi: float, w: float) -> dict[str, float]:
        """Angle of the arm from the horizontal."""
        return {"phi_arm": phi + 1.5 * pi}


@dataclass
class WormGear:
    """Table 3.3: Simscape Driveline's *Worm Gear*, viscously loss-less."""

    ratio: float = 73.0
    eta_wg: float = 0.74
    eta_gw: float = 0.65
    p_threshold: float = 1e-3

    def gain(self, power: float) -> float:
        """tau_G / (n tau_W) at the power tau_W w_W [W] that flows from worm to gear."""
        level = abs(tanh(4 * power / self.p_threshold))
        return 1 + (self._excess(power)) * level

    def _excess(self, power: float) -> float:
        return self.eta_wg - 1 if power > 0 else 1 / self.eta_gw - 1

    def solve(self, drive: float, inertia: float, reflected: float, w_worm: float) -> float:
        """Gain that solves tau_W (inertia + reflected gain(tau_W w_worm)) = drive.

        The left side grows with tau_W: where the gain bends, P gain'(P) is above -0.12, the gain above 0.74. Far
        from zero power the answer is the efficiency itself; else Newton's method within a bracket.
        """
        excess = self._excess(drive * w_worm)
        scale = 4 * abs(w_worm) / self.p_threshold
        goal = abs(drive)
        full, none = goal / (inertia + reflected * (1 + excess)), goal / (inertia + reflected)
        # tanh(20) is 1 to the last digit.
        if scale * full > 20 and scale * none > 20:
            return 1 + excess
        low, high = min(full, none), max(full, none)
        tau = low
        for _ in range(200):
            x = scale * tau
            bend = 0.0 if x > 300 else x / cosh(x) ** 2
            gain = 1 + excess * tanh(x)
            residual = tau * (inertia + reflected * gain) - goal
            if residual > 0:
                high = tau
            else:
                low = tau
            step = residual / (inertia + reflected * (gain + excess * bend))
            following = tau - step
            if not low <= following <= high:
                following = (low + high) / 2
            if abs(following - tau) <= 1e-15 * goal / inertia or following == tau:
                break
            tau = following
        return 1 + excess * tanh(scale * following)


@dataclass
class Motor:
    """Table 3.4, with the rotor damping that Simscape derives from the no-load current."""

    R: float = 1.91
    L: float = 3.75e-3
    L_filter: float = 5.7e-6
    k: float = 0.113
    J_rotor: float = 1e-4
    i_no_load: float = 0.58
    v_no_load: float = 28.0

    @property
    def inductance(self) -> float:
        """Armature and both filter inductances in series [H]."""
        return self.L + 2 * self.L_filter

    @property
    def d_rotor(self) -> float:
        """K^2 i0 / (V0 - R i0) [N.m.s/rad]."""
        return self.k**2 * self.i_no_load / (self.v_no_load - self.R * self.i_no_load)


class Rates(NamedTuple):
    """Right-hand side and the torques found on the way."""

    di: float
    dw: float
    tau_worm: float
    tau_crank: float


@dataclass
class Plant:
    """Bridge, motor, worm gear and load."""

    load: Load = field(default_factory=LinkageLoad)
    motor: Motor = field(default_factory=Motor)
    gear: WormGear = field(default_factory=WormGear)

    def __post_init__(self) -> None:
        motor, n = self.motor, self.gear.ratio
        self._constants = (n, motor.k, motor.R, motor.inductance, motor.d_rotor * n, motor.J_rotor * n)

    def conducts(self, i: float, w: float, drive: float) -> bool:
        """One-quadrant bridge with an ideal freewheel diode; ``drive`` is duty * v_supply [V]."""
        return i > 0 or drive > self.back_emf(w)

    def back_emf(self, w: float) -> float:
        """Induced voltage at the crank speed w [V]."""
        return self.motor.k * self.gear.ratio * w

    def rates(self, i: float, phi: float, w: float, drive: float, tau_disturbance: float, *, conducting: bool) -> Rates:
        """Time derivatives of i and w.

        With tau_G = n gamma tau_W, the two mechanical balances give
        w' = (n gamma A - B) / (I + n^2 gamma J_r) and tau_W = (I A + n J_r B) / (I + n^2 gamma J_r), where
        A = k i - d_r n w and B are the torques without inertia; gamma depends on tau_W through the power.
        """
        n, k, resistance, inductance, damping, j_n = self._constants
        inertia, convective, friction, load, conservative = self.load.reduced(phi, w)
        shaft = convective + friction + load + conservative - tau_disturbance
        rotor = k * i - damping * w
        drive_torque = inertia * rotor + j_n * shaft
        gamma = self.gear.solve(drive_torque, inertia, j_n * n, n * w)
        total = inertia + j_n * n * gamma
        tau_worm = drive_torque / total
        di = (drive - resistance * i - k * n * w) / inductance if conducting else 0.0
        return Rates(di, (n * gamma * rotor - shaft) / total, tau_worm, n * gamma * tau_worm)

    def outputs(self, i: float, phi: float, w: float, drive: float, tau_disturbance: float) -> dict[str, float]:
        """Outputs of the FMU interface; ``park`` is 0 or 1."""
        conducting = self.conducts(i, w, drive)
        rates = self.rates(i, phi, w, drive, tau_disturbance, conducting=conducting)
        return {
            "i_motor": i,
            "v_motor": drive if conducting else self.back_emf(w),
            "park": float(on_park(phi)),
            "phi_crank": phi,
            "w_crank": w,
            "w_motor": self.gear.ratio * w,
            "tau_crank": rates.tau_crank,
            **self.load.outputs(phi, w),
        }

    def stored_energy(self, i: float, phi: float, w: float) -> float:
        """Magnetic, kinetic and potential energy [J]."""
        inertia = self.load.reduced(phi, w).inertia + self.motor.J_rotor * self.gear.ratio**2
        return (self.motor.inductance * i**2 + inertia * w**2) / 2 + self.load.potential(phi)

    def powers(self, i: float, phi: float, w: float, drive: float, tau_disturbance: float) -> dict[str, float]:
        """Power supplied (``electrical``, ``disturbance``) and lost (the others) [W]."""
        conducting = self.conducts(i, w, drive)
        rates = self.rates(i, phi, w, drive, tau_disturbance, conducting=conducting)
        reduced, w_worm = self.load.reduced(phi, w), self.gear.ratio * w
        return {
            "electrical": drive * i if conducting else 0.0,
            "disturbance": tau_disturbance * w,
            "resistance": self.motor.R * i**2,
            "rotor": self.motor.d_rotor * w_worm**2,
            "gear": rates.tau_worm * w_worm - rates.tau_crank * w,
            "joints": reduced.damping * w,
            "load": reduced.load * w,
        }


def on_park(phi: float) -> bool:
    """Park contact: mod(phi, 2 pi) < 2 deg."""
    return float(np.mod(phi, 2 * pi)) < PARK_WIDTH


def linkage_plant() -> Plant:
    """The drive on the linkage, with the parameters of FACTS."""
    return Plant(LinkageLoad())


def rig_plant() -> Plant:
    """The drive on the lifetime-test rig, with the parameters of FACTS."""
    return Plant(RigLoad())


def _near(angle: float, reference: float) -> float:
    """The angle within half a turn of the reference."""
    change = fmod(angle - reference, 2 * pi)
    return reference + (change if abs(change) <= pi else change - copysign(2 * pi, change))
