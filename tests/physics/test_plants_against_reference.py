"""The compiled plants against an independent model: minimal coordinate, closed-form kinematics, SciPy."""

from __future__ import annotations

import numpy as np
import pytest

from physics.conftest import Run, Simulate
from reference.geometry import catalogue_linkage
from reference.plant import linkage_plant, rig_plant
from reference.simulation import simulate as reference

COMMON = ("phi_crank", "w_crank", "i_motor", "tau_crank", "w_motor", "v_motor")
SIDES = ("phi_ds", "w_ds", "tau_ds", "phi_ps", "w_ps", "tau_ps")
PLANTS = {"linkage": linkage_plant, "rig": rig_plant}


@pytest.fixture(scope="module", params=["linkage", "rig"])
def pair(request: pytest.FixtureRequest, simulate: Simulate) -> tuple[str, Run, Run]:
    """Full voltage from rest for 6 s: the name of the plant, the FMU's run at tolerance 1e-6, the reference's."""
    name: str = request.param
    names = COMMON + (SIDES if name == "linkage" else ("phi_arm",))
    run = simulate(name, names, 6.0, 1e-3, 1e-6, (("duty", 1.0),))
    expected = reference(PLANTS[name](), 1.0, run["time"])
    return name, run, expected


@pytest.mark.parametrize(
    ("variable", "tolerance"),
    [("phi_crank", 1e-4), ("i_motor", 2e-3), ("tau_crank", 2e-2), ("w_crank", 1e-3), ("w_motor", 1e-1)],
)
def test_full_voltage_follows_the_reference(pair: tuple[str, Run, Run], variable: str, tolerance: float) -> None:
    _, run, expected = pair
    assert np.abs(run[variable] - expected[variable]).max() < tolerance


def test_load_torques_follow_equation_3_1(pair: tuple[str, Run, Run]) -> None:
    name, run, expected = pair
    if name == "rig":
        np.testing.assert_allclose(run["phi_arm"], run["phi_crank"] + 1.5 * np.pi, atol=1e-12)
        return
    for side in ("ds", "ps"):
        law = 3.0 * (1.0 - np.abs(0.7 * np.cos(run["phi_crank"]))) * np.tanh(run[f"w_{side}"] / 1e-3)
        np.testing.assert_allclose(run[f"tau_{side}"], law, atol=1e-9)
        assert np.abs(run[f"phi_{side}"] - expected[f"phi_{side}"]).max() < 1e-4


def test_rockers_follow_the_closed_form_for_a_minute(simulate: Simulate) -> None:
    run = simulate(
        "linkage",
        ("phi_crank", "phi_ds", "phi_ps", "linkage.ds.coupler.phi", "linkage.ps.coupler.phi"),
        60.0,
        1e-2,
        1e-6,
        (("duty", 1.0),),
    )
    linkage = catalogue_linkage()
    for side, bars in (("ds", linkage.ds), ("ps", linkage.ps)):
        crank, rocker, coupler = run["phi_crank"], run[f"phi_{side}"], run[f"linkage.{side}.coupler.phi"]
        expected = np.unwrap([bars.rocker(angle) for angle in crank])
        expected += 2.0 * np.pi * np.round((rocker[0] - expected[0]) / (2.0 * np.pi))
        assert np.abs(rocker - expected).max() < 1e-6
        closure = (
            bars.a * np.exp(1j * crank)
            + bars.f * np.exp(1j * coupler)
            - bars.g * np.exp(1j * bars.ground)
            - bars.b * np.exp(1j * rocker)
        )
        assert np.abs(closure).max() < 1e-9


def test_steady_full_voltage_has_the_figures_of_the_facts(simulate: Simulate) -> None:
    names = ("phi_crank", "i_motor", "tau_crank", "phi_ds", "phi_ps")
    run = simulate("linkage", names, 12.0, 1e-3, 1e-6, (("duty", 1.0),))
    turn = (run["phi_crank"] >= 4.0 * np.pi) & (run["phi_crank"] < 6.0 * np.pi)
    period = np.ptp(run["time"][turn])
    current, torque, angle = run["i_motor"][turn], run["tau_crank"][turn], np.degrees(run["phi_crank"][turn]) % 360.0
    assert period == pytest.approx(2.1958, abs=2e-3)
    assert (current.min(), current.max()) == (pytest.approx(1.457, abs=2e-3), pytest.approx(2.938, abs=2e-3))
    assert current.mean() == pytest.approx(2.302, abs=2e-3)
    assert (torque.min(), torque.max()) == (pytest.approx(5.544, abs=2e-3), pytest.approx(15.038, abs=5e-3))
    for side, swing, turning in (("ds", 94.851, (1.008, 184.184)), ("ps", 111.293, (356.198, 174.539))):
        rocker = np.degrees(run[f"phi_{side}"][turn])
        assert np.ptp(rocker) == pytest.approx(swing, abs=2e-3)
        # a turning point is flat: half a degree of crank hardly moves the rocker, so a millisecond's grid finds it
        assert sorted((angle[rocker.argmax()], angle[rocker.argmin()])) == pytest.approx(sorted(turning), abs=0.2)
