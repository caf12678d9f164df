"""The reference itself: geometry and plant against FACTS, closed forms, energy and a second derivation."""

from __future__ import annotations

from dataclasses import astuple

import numpy as np
import pytest
from numpy.typing import NDArray

from .geometry import FourBar, catalogue_linkage
from .plant import LinkageLoad, Motor, Plant, RigLoad, WormGear, linkage_plant, on_park, rig_plant
from .simulation import simulate

LINKAGE = catalogue_linkage()
SIDES = pytest.mark.parametrize("bars", [LINKAGE.ds, LINKAGE.ps], ids=["ds", "ps"])
PLANTS = pytest.mark.parametrize("plant", [linkage_plant(), rig_plant()], ids=["linkage", "rig"])
LOSSES = ("resistance", "rotor", "gear", "joints", "load")


@pytest.mark.parametrize(
    ("bars", "lengths_mm", "ground_deg", "swing_deg", "turning_deg", "steepest"),
    [
        (LINKAGE.ds, (55, 435.9377, 76.44, 449.5446), 8.85185, 94.851, (1.008, 184.184), 0.745),
        (LINKAGE.ps, (55, 464.5583, 67.11, 461.5111), 180 - 9.40264, 111.293, (174.539, 356.198), 0.906),
    ],
    ids=["ds", "ps"],
)
def test_geometry_of_facts(
    *,
    bars: FourBar,
    lengths_mm: tuple[float, ...],
    ground_deg: float,
    swing_deg: float,
    turning_deg: tuple[float, float],
    steepest: float,
) -> None:
    np.testing.assert_allclose(1e3 * np.array(astuple(bars)[:4]), lengths_mm, atol=5e-5)
    assert np.rad2deg(bars.ground) == pytest.approx(ground_deg, abs=5e-6)
    assert np.rad2deg(bars.swing()) == pytest.approx(swing_deg, abs=5e-4)
    np.testing.assert_allclose(np.sort(np.rad2deg(bars.turning_points())), turning_deg, atol=5e-4)
    crank = np.linspace(0, 2 * np.pi, 20001)
    assert np.abs(bars.slopes(crank)[0]).max() == pytest.approx(steepest, abs=1e-3)
    assert np.ptp(bars.rocker(crank)) == pytest.approx(bars.swing(), abs=1e-7)
    np.testing.assert_allclose(bars.slopes(bars.turning_points())[0], 0, atol=1e-13)
    assert bars.is_crank_rocker()


def test_without_corr3d_only_the_driver_side_is_a_crank_rocker() -> None:
    plain = catalogue_linkage((0.0, 0.0, 0.0))
    assert plain.ds.is_crank_rocker()
    assert not plain.ps.is_crank_rocker()


@SIDES
def test_bars_keep_their_lengths_and_angles_close_the_loop(bars: FourBar) -> None:
    crank = np.linspace(-7, 20, 500)
    pin, joint, pivot = bars.pin(crank), bars.joint(crank), np.array(bars.pivot)[:, None]
    np.testing.assert_allclose(np.hypot(*(joint - pin)), bars.f, rtol=1e-13)
    np.testing.assert_allclose(np.hypot(*(joint - pivot)), bars.b, rtol=1e-13)
    closure = bars.a * np.exp(1j * crank) + bars.f * np.exp(1j * bars.coupler(crank))
    np.testing.assert_allclose(closure, complex(*bars.pivot) + bars.b * np.exp(1j * bars.rocker(crank)), atol=1e-15)
    assert np.abs(np.diff(bars.rocker(crank))).max() < 0.1


@SIDES
def test_slopes_and_curvatures_are_derivatives(bars: FourBar) -> None:
    crank, h = np.linspace(0, 2 * np.pi, 300), 1e-3

    def derivative(value: NDArray[np.float64]) -> NDArray[np.float64]:
        """Sixth-order central difference of values at crank + (-3 .. 3) h."""
        return np.asarray(np.array([-1, 9, -45, 0, 45, -9, 1]) / (60 * h) @ value)

    at = crank + h * np.arange(-3, 4)[:, None]
    np.testing.assert_allclose(bars.slopes(crank)[0], derivative(bars.rocker(at)), atol=1e-11)
    np.testing.assert_allclose(bars.slopes(crank)[1], derivative(bars.coupler(at)), atol=1e-11)
    for n in (0, 1):
        np.testing.assert_allclose(bars.curvatures(crank)[n], derivative(bars.slopes(at)[n]), atol=1e-11)


def five_bodies(load: LinkageLoad, phi: float, w: float, torque: float) -> float:
    """Crank acceleration by Newton and Euler: five free bodies, seven revolute joints, Lagrange multipliers.

    Coordinates x, y, angle of the centres of crank, DS coupler, DS rocker, PS coupler, PS rocker. A joint at the
    distance s along a bar from its centre accelerates with r'' + s (angle'' e_perp - angle'^2 e).
    """
    sides = load.linkage.ds, load.linkage.ps
    slopes = [tuple(map(float, bars.slopes(phi))) for bars in sides]
    lengths = [sides[0].a, *(x for bars in sides for x in (bars.f, bars.b))]
    angles = [phi, *(float(x) for bars in sides for x in (bars.coupler(phi), bars.rocker(phi)))]
    speeds = w * np.array([1.0, *(x for psi1, chi1 in slopes for x in (chi1, psi1))])
    masses = [load.bar_mass(x) for x in lengths]
    inertia = np.array([[m, m, m * x**2 / 12] for m, x in zip(masses, lengths, strict=True)]).ravel()

    forces = np.zeros(15)
    forces[2] = torque
    jacobian, curvature = np.zeros((14, 15)), np.zeros(14)
    row = 0

    def joint(body: int, s: float, other: int | None = None, s_other: float = 0.0) -> None:
        nonlocal row
        for sign, b, arm in ((1.0, body, s), (-1.0, other, s_other)):
            if b is None:
                continue
            e = np.array([np.cos(angles[b]), np.sin(angles[b])])
            jacobian[row : row + 2, 3 * b : 3 * b + 2] = sign * np.eye(2)
            jacobian[row : row + 2, 3 * b + 2] = sign * arm * np.array([-e[1], e[0]])
            curvature[row : row + 2] += sign * arm * speeds[b] ** 2 * e
        row += 2

    def passive(body: int, other: int | None) -> None:
        rate, angle = speeds[body], angles[body]
        if other is not None:
            rate, angle = rate - speeds[other], angle - angles[other]
        resisting = load.damping * rate + load.stiffness * angle
        forces[3 * body + 2] -= resisting
        if other is not None:
            forces[3 * other + 2] += resisting

    joint(0, -lengths[0] / 2)
    for coupler, rocker in ((1, 2), (3, 4)):
        joint(coupler, -lengths[coupler] / 2, 0, lengths[0] / 2)
        joint(rocker, lengths[rocker] / 2, coupler, lengths[coupler] / 2)
        joint(rocker, -lengths[rocker] / 2)
        passive(coupler, 0)
        passive(rocker, coupler)
        passive(rocker, None)
        shape = 1 - abs(0.7 * np.cos(phi))
        forces[3 * rocker + 2] -= load.ext_load * shape * np.tanh(speeds[rocker] / load.w_sign)
    system = np.block([[np.diag(inertia), jacobian.T], [jacobian, np.zeros((14, 14))]])
    return float(np.linalg.solve(system, np.concatenate([forces, curvature]))[2])


@pytest.mark.parametrize("seed", range(20))
def test_reduced_equation_is_that_of_five_jointed_bodies(seed: int) -> None:
    # A stiffness that can be seen, so that its sign and its relative angles are checked too.
    load = LinkageLoad(stiffness=2.0)
    rng = np.random.default_rng(seed)
    phi, w, torque = rng.uniform(-10, 10), rng.uniform(-4, 4), rng.uniform(-20, 20)
    reduced = load.reduced(phi, w)
    acceleration = (torque - sum(reduced[1:])) / reduced.inertia
    assert acceleration == pytest.approx(five_bodies(load, phi, w, torque), rel=1e-9, abs=1e-6)


def test_derived_motor_constants() -> None:
    motor = Motor()
    assert motor.d_rotor == pytest.approx(2.754e-4, abs=5e-8)
    assert motor.inductance == pytest.approx(3.7614e-3)


@pytest.mark.parametrize("w_worm", [-200.0, -1e-3, -1e-9, 0.0, 1e-12, 3e-3, 0.02, 250.0])
@pytest.mark.parametrize("drive", [-0.3, -1e-7, 0.0, 1e-9, 1e-5, 0.2])
def test_worm_torque_satisfies_its_implicit_law(w_worm: float, drive: float) -> None:
    gear = WormGear()
    inertia, reflected = 3e-3, 0.533
    gain = gear.solve(drive, inertia, reflected, w_worm)
    tau = drive / (inertia + reflected * gain)
    assert gain == pytest.approx(gear.gain(tau * w_worm), rel=1e-12)


def test_worm_gear_far_from_zero_power_has_its_efficiencies() -> None:
    assert WormGear().gain(1.0) == pytest.approx(0.74, rel=1e-15)
    assert WormGear().gain(-1.0) == pytest.approx(1 / 0.65, rel=1e-15)
    assert WormGear().gain(0.0) == 1.0


def test_park_contact_lasts_two_degrees() -> None:
    turns = 2 * np.pi * np.arange(-2, 3)
    assert all(on_park(x) for x in turns + np.deg2rad(1.999))
    assert not any(on_park(x) for x in turns + np.deg2rad(2.001))
    assert not any(on_park(x) for x in turns - np.deg2rad(0.001))


@PLANTS
def test_energy_is_conserved(plant: Plant) -> None:
    # Duty ramps, a freewheeling stretch with the bridge open, and the surroundings braking and pushing.
    table = simulate(
        plant,
        [(0.0, 1.0), (1.0, 0.3), (1.2, 0.0), (1.5, 0.8)],
        np.linspace(0, 2.5, 251),
        tau_disturbance=[(0.0, 0.0), (1.8, -6.0), (2.1, 12.0)],
        initial=(0.0, 0.3, 0.0),
        energy=True,
    )
    supplied = table["work_electrical"] + table["work_disturbance"]
    lost = np.sum([table[f"work_{name}"] for name in LOSSES], axis=0)
    stored = table["stored_energy"] - table["stored_energy"][0]
    np.testing.assert_allclose(supplied, stored + lost, atol=1e-7)
    for name in LOSSES:
        assert np.diff(table[f"work_{name}"]).min() >= -1e-9, f"{name} must only lose energy"


def test_rig_swings_as_a_pendulum_without_losses() -> None:
    # Reversible gear, next to no motor constant and so no damping: small swings last 2 pi sqrt(I / (m g r)).
    load = RigLoad()
    plant = Plant(load, Motor(k=1e-9), WormGear(eta_wg=1.0, eta_gw=1.0))
    inertia = load.mass * load.radius**2 + plant.motor.J_rotor * plant.gear.ratio**2
    period = 2 * np.pi * np.sqrt(inertia / (load.mass * load.gravity * load.radius))
    table = simulate(plant, 0.0, np.array([0.0, period / 4, period / 2, period]), initial=(0.0, 1e-4, 0.0))
    np.testing.assert_allclose(table["phi_crank"], 1e-4 * np.array([1, 0, -1, 1]), atol=2e-12)
    np.testing.assert_allclose(table["phi_arm"] - table["phi_crank"], np.deg2rad(270), rtol=1e-15)


def test_diode_blocks_reverse_current_and_shows_the_back_emf() -> None:
    table = simulate(linkage_plant(), [(0.0, 1.0), (0.5, 0.2)], np.linspace(0, 0.6, 601))
    after = table["time"] > 0.5
    blocking = after & (table["i_motor"] == 0)
    assert table["i_motor"].min() == 0.0
    assert blocking.any()
    np.testing.assert_allclose(table["v_motor"][blocking], 0.113 * table["w_motor"][blocking], rtol=1e-12)
    assert (table["v_motor"][blocking] > 0.2 * 28).all()
    np.testing.assert_allclose(table["v_motor"][after & ~blocking], 0.2 * 28)


def test_electrical_start_is_the_first_order_response() -> None:
    # For a few microseconds the rotor stands still: i = V / R (1 - exp(-t / tau_e)).
    motor = Motor(J_rotor=1e3)
    t = np.linspace(0, 0.01, 11)
    table = simulate(Plant(RigLoad(), motor), 0.5, t)
    np.testing.assert_allclose(table["i_motor"], 14 / motor.R * -np.expm1(-t * motor.R / motor.inductance), rtol=1e-6)


def test_full_voltage_on_the_linkage() -> None:
    table = simulate(linkage_plant(), 1.0, np.linspace(0, 4.5, 4501))
    start, stop = np.interp([2 * np.pi, 4 * np.pi], table["phi_crank"], table["time"])
    assert stop - start == pytest.approx(2.1958, abs=1e-3)
    turn = (table["time"] > start) & (table["time"] < stop)
    current, torque = table["i_motor"][turn], table["tau_crank"][turn]
    assert (current.min(), current.max(), current.mean()) == pytest.approx((1.457, 2.937, 2.302), abs=2e-3)
    assert (torque.min(), torque.max(), torque.mean()) == pytest.approx((5.544, 15.038, 10.94), abs=5e-3)
    for name, bars in (("ds", LINKAGE.ds), ("ps", LINKAGE.ps)):
        rocker = np.gradient(table[f"phi_{name}"], table["time"])
        np.testing.assert_allclose(rocker[50:-50], table[f"w_{name}"][50:-50], atol=1e-4)
        assert np.ptp(table[f"phi_{name}"]) == pytest.approx(bars.swing(), abs=1e-5)
        assert (table[f"tau_{name}"] * table[f"w_{name}"] >= 0).all()


def test_full_voltage_on_the_rig() -> None:
    table = simulate(rig_plant(), 1.0, np.linspace(0, 4.0, 4001))
    start, stop = np.interp([2 * np.pi, 4 * np.pi], table["phi_crank"], table["time"])
    assert stop - start == pytest.approx(1.9504, abs=1e-3)


@PLANTS
def test_tolerance_convergence(plant: Plant) -> None:
    t = np.linspace(0, 1.2, 1201)
    fine = simulate(plant, 1.0, t)
    errors = []
    for rtol in (1e-5, 1e-7, 1e-9):
        coarse = simulate(plant, 1.0, t, rtol=rtol, atol=rtol / 100)
        errors.append(np.abs(coarse["i_motor"] - fine["i_motor"]).max())
    assert errors[2] <= errors[0]
    assert errors[2] < 1e-7


@pytest.mark.slow
@PLANTS
def test_an_implicit_method_agrees(plant: Plant) -> None:
    t = np.linspace(0, 3, 31)
    fine, other = simulate(plant, 1.0, t), simulate(plant, 1.0, t, method="Radau", rtol=1e-9, atol=1e-11)
    for name in ("i_motor", "phi_crank", "w_crank"):
        np.testing.assert_allclose(other[name], fine[name], atol=1e-6)
