"""The drawing of B.2.4 against the simulated linkage and an independent implementation of its geometry."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cosim.engine import Fmu
from cosim.fmu import catalogue
from cosim.thesis._kinematics import Drawing, drawing
from cosim.thesis._runs import scenario_run
from reference.geometry import catalogue_linkage

pytest.importorskip("rumoca")

CRANK = np.linspace(0.0, 2.0 * np.pi, 400)


@pytest.fixture(scope="module")
def drawn() -> Drawing:
    return drawing(Fmu.read(catalogue.ensure("linkage")))


def test_joints_lie_where_the_reference_has_them(drawn: Drawing) -> None:
    linkage = catalogue_linkage()
    for side, other in ((drawn.ps, linkage.ps), (drawn.ds, linkage.ds)):
        assert side.ground == pytest.approx(other.pivot, abs=1e-12)
        np.testing.assert_allclose(side.pin(CRANK), other.pin(CRANK), atol=1e-12)
        np.testing.assert_allclose(side.joint(CRANK), other.joint(CRANK), atol=1e-12)


def test_rockers_stand_as_in_the_simulation(drawn: Drawing) -> None:
    scenario = Path(__file__).parents[2] / "scenarios" / "linkage_full_voltage.csv"
    columns = scenario_run(scenario, catalogue.ensure, "stop=3 s", "output_interval=10 ms").columns
    for side, name in ((drawn.ps, "ps"), (drawn.ds, "ds")):
        x, y = side.joint(columns["plant.phi_crank"]) - np.reshape(side.ground, (2, 1))
        turned = np.exp(1j * columns[f"plant.phi_{name}"])
        np.testing.assert_allclose((x + 1j * y) / side.b, turned, atol=1e-5)


def test_a_wiper_is_fixed_to_its_rocker(drawn: Drawing) -> None:
    """Its ends keep their distances from B, and turn with the rocker, by as much and in the same direction."""
    for side in (drawn.ps, drawn.ds):
        ground = np.reshape(side.ground, (2, 1))
        rocker = _turned(side.joint(CRANK) - ground)
        for end, (length, _) in zip(side.wiper_points(CRANK), side.wiper, strict=True):
            np.testing.assert_allclose(np.hypot(*(end - ground)), length, atol=1e-12)
            np.testing.assert_allclose(_turned(end - ground), rocker, atol=1e-9)


def _turned(vector: np.ndarray) -> np.ndarray:
    angle = np.unwrap(np.arctan2(vector[1], vector[0]))
    return np.asarray(angle - angle[0])
