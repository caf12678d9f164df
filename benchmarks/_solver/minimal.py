"""The linkage plant derived by hand in minimal coordinates: the floor for what a compiler can make of the model.

The equations are Lagrange's, as in ``tests/reference/plant.py``, but the four angles of couplers and rockers and the
crank's acceleration stay unknowns, as in the compiled model: they satisfy the closure of the loops and the balance of
torques at the gear. All numbers are constants and the bridge conducts.
"""

from __future__ import annotations

import sys
from pathlib import Path

import casadi as ca

sys.path.insert(0, str(Path(__file__).parents[2] / "tests"))
from reference.geometry import FourBar
from reference.plant import LinkageLoad, Motor, WormGear

UNKNOWNS = [
    "phi_crank",
    "w_crank",
    "bridge.i",
    "phi_ds",
    "linkage.ds.coupler.phi",
    "phi_ps",
    "linkage.ps.coupler.phi",
    "der(der(phi_crank))",
]
"""Names of the compiled model's unknowns, in the order in which the functions here take them."""


def functions() -> tuple[ca.Function, ca.Function]:
    """(v, u) to f, and to f, its dense Jacobian and its derivative by time, which is zero."""
    v, u = ca.SX.sym("v", len(UNKNOWNS)), ca.SX.sym("u", 3)
    f = equations(v, u)
    derivatives = [f, ca.densify(ca.jacobian(f, v)), ca.densify(ca.SX(len(UNKNOWNS), 1))]
    return (
        ca.Function("minimal_rhs", [v, u], [ca.cse(f)]),
        ca.Function("minimal_linearise", [v, u], ca.cse(derivatives)),
    )


def equations(v: ca.SX, u: ca.SX) -> ca.SX:
    """Derivatives of angle, speed and current, then the residuals."""
    phi, w, i, psi_ds, chi_ds, psi_ps, chi_ps, acceleration = ca.vertsplit(v)
    duty, v_supply, tau_disturbance = ca.vertsplit(u)
    load, motor, gear = LinkageLoad(), Motor(), WormGear()
    a = load.linkage.ds.a
    r = a * ca.vertcat(ca.cos(phi), ca.sin(phi))
    shape = load.ext_load * (1 - ca.fabs(0.7 * ca.cos(phi)))
    inertia, shaft, residuals = load.bar_mass(a) * a**2 / 3, -tau_disturbance, []
    for bars, psi, chi in ((load.linkage.ds, psi_ds, chi_ds), (load.linkage.ps, psi_ps, chi_ps)):
        closure, own_inertia, resisting = side(load, bars, r, shape, phi, w, psi, chi)
        residuals.append(closure)
        inertia += own_inertia
        shaft += resisting
    n = gear.ratio
    tau_worm = motor.k * i - motor.d_rotor * n * w - motor.J_rotor * n * acceleration
    power = tau_worm * n * w
    level = ca.tanh(4 * power / gear.p_threshold)
    gain = ca.if_else(power > 0, 1 - (1 - gear.eta_wg) * level, 1 - (1 / gear.eta_gw - 1) * level)
    current = (duty * v_supply - motor.R * i - motor.k * n * w) / motor.inductance
    balance = inertia * acceleration + shaft - n * gain * tau_worm
    return ca.vertcat(w, acceleration, current, *residuals, balance)


def side(
    load: LinkageLoad, bars: FourBar, r: ca.SX, shape: ca.SX, phi: ca.SX, w: ca.SX, psi: ca.SX, chi: ca.SX
) -> tuple[ca.SX, ca.SX, ca.SX]:
    """One four-bar: closure of its loop, inertia and resisting torque reduced to the crank."""
    a2, f2, b2 = bars.a**2, bars.f**2, bars.b**2
    coupler = bars.f * ca.vertcat(ca.cos(chi), ca.sin(chi))
    rocker = bars.b * ca.vertcat(ca.cos(psi), ca.sin(psi))
    mass, j_rocker = load.bar_mass(bars.f), load.bar_mass(bars.b) * b2 / 3 + load.arm_inertia

    def cross(x: ca.SX, y: ca.SX) -> ca.SX:
        return x[0] * y[1] - x[1] * y[0]

    ru, rv, uv = ca.dot(r, coupler), ca.dot(r, rocker), ca.dot(coupler, rocker)
    across = cross(coupler, rocker)
    psi1, chi1 = cross(coupler, r) / across, cross(rocker, r) / across
    psi2 = (ru + f2 * chi1**2 - uv * psi1**2) / across
    chi2 = (rv + uv * chi1**2 - b2 * psi1**2) / across
    inertia = mass * (a2 + ru * chi1 + f2 * chi1**2 / 3) + j_rocker * psi1**2
    half_slope = mass * ((ru * chi2 - cross(r, coupler) * chi1 * (chi1 - 1)) / 2 + f2 * chi1 * chi2 / 3)
    half_slope += j_rocker * psi1 * psi2
    squares = psi1**2 + (psi1 - chi1) ** 2 + (chi1 - 1) ** 2
    springs = psi * psi1 + (psi - chi) * (psi1 - chi1) + (chi - phi) * (chi1 - 1)
    resisting = half_slope * w**2 + load.damping * squares * w + load.stiffness * springs
    resisting += shape * ca.tanh(psi1 * w / load.w_sign) * psi1
    return r + coupler - ca.DM(bars.pivot) - rocker, inertia, resisting
