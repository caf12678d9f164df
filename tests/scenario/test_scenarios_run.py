"""Every scenario that is shipped runs, and pins a number that physics or the thesis gives."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray

from cosim.cli._isolation import Isolation
from cosim.cli._run import Options, run_files
from cosim.cli._screen import Screen
from cosim.scenario import read

pytestmark = pytest.mark.slow

SCENARIOS = sorted((Path(__file__).parents[2] / "scenarios").glob("*.csv"))
Columns = dict[str, NDArray[np.float64]]

# Table 3.4 and 3.3 of the thesis; the damping follows from the no-load current.
R, K, V0, I0 = 1.91, 0.113, 28.0, 0.58
DAMPING = K**2 * I0 / (V0 - R * I0)
NO_LOAD_SPEED = (V0 - R * I0) / K
RATIO, EFFICIENCY = 73.0, 0.74


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Columns]:
    """Run all scenarios once; gives their columns by the names without units."""
    folder = tmp_path_factory.mktemp("results")
    screen = Screen(quiet=True, as_json=False)
    assert run_files(SCENARIOS, folder, Options.of(None, None), screen, Isolation(), plots=False) == 0
    frames = {path.stem: pd.read_parquet(folder / path.stem / "results.parquet") for path in SCENARIOS}
    return {
        stem: {header.rpartition(" [")[0]: frame[header].to_numpy() for header in frame.columns}
        for stem, frame in frames.items()
    }


def parks(run: Columns) -> NDArray[np.int64]:
    """Rows at which the park contact closes, at the ends of revolutions."""
    return np.flatnonzero(np.diff(run["plant.park"]) == 1) + 1


def revolutions(run: Columns) -> NDArray[np.float64]:
    """Times from park to park [s]."""
    return np.diff(run["time"][parks(run)])


@pytest.mark.parametrize("path", SCENARIOS, ids=[path.stem for path in SCENARIOS])
def test_it_reaches_its_end_and_the_current_never_reverses(runs: dict[str, Columns], path: Path) -> None:
    run, scenario = runs[path.stem], read(path)
    assert (len(run["time"]), run["time"][-1]) == (round(scenario.stop / scenario.output_interval) + 1, scenario.stop)
    assert run["plant.i_motor"].min() >= 0.0
    # At most the stall current, at the start, when there is no back-EMF yet; the high-speed coil has its own.
    settings = {setting.name: setting.value for setting in scenario.settings}
    resistance = float(settings.get("plant.motor.R", f"{R} Ohm").removesuffix(" Ohm"))
    # Most controllers switch 0.7 of the supply on or more; the one of the speed K_p w_ref = 0.2 * 2 of it.
    if scenario.controller == "speed_control":
        low, high = 0.8 * 0.4 * V0 / resistance, 0.4 * V0 / resistance
    else:
        low, high = 5.0, V0 / resistance
    assert low < run["plant.i_motor"].max() < high


@pytest.mark.parametrize("stem", ["linkage_full_voltage", "linkage_20ms", "linkage_disturbed"])
def test_the_rockers_swing_as_the_linkage_geometry_says(runs: dict[str, Columns], stem: str) -> None:
    """FACTS, linkage: 94.851 deg and 111.293 deg; rows at 1 ms miss the turning points by less than 0.01 deg."""
    for name, swing in (("plant.phi_ds", 94.851), ("plant.phi_ps", 111.293)):
        assert np.degrees(np.ptp(runs[stem][name])) == pytest.approx(swing, abs=0.01)


def test_linkage_full_voltage_balances_torque_over_revolutions(runs: dict[str, Columns]) -> None:
    """K i - d w = tau / (n eta) on average over whole revolutions, in which the rotor gains no momentum."""
    run = runs["linkage_full_voltage"]
    whole = slice(parks(run)[3], parks(run)[-1])
    current, speed, torque = (run[f"plant.{name}"][whole].mean() for name in ("i_motor", "w_motor", "tau_crank"))
    assert K * current - DAMPING * speed == pytest.approx(torque / (RATIO * EFFICIENCY), rel=2e-3)


def test_rig_full_voltage_turns_almost_at_no_load_speed(runs: dict[str, Columns]) -> None:
    """Gravity does no work over a revolution, so only the gear's losses slow the rig down, by about 1 %."""
    run = runs["rig_full_voltage"]
    whole = slice(parks(run)[3], parks(run)[-1])
    assert run["plant.w_motor"][whole].mean() == pytest.approx(NO_LOAD_SPEED, rel=0.02)
    assert run["plant.w_motor"][whole].mean() < NO_LOAD_SPEED
    np.testing.assert_allclose(run["plant.phi_arm"] - run["plant.phi_crank"], 1.5 * np.pi, rtol=0, atol=1e-9)


def test_linkage_20ms_is_slower_than_full_voltage_by_its_ramps(runs: dict[str, Columns]) -> None:
    """Two turning points and a start and stop with a mean duty of 0.65 to 0.85 for 0.35 s cost about 0.1 s."""
    lost = revolutions(runs["linkage_20ms"])[2:].mean() - revolutions(runs["linkage_full_voltage"])[2:].mean()
    assert lost == pytest.approx(0.1, abs=0.05)


def test_rig_20ms_parks_as_often_as_table_4_1_says(runs: dict[str, Columns]) -> None:
    """9 or 10 parks in 20 s at 20 ms, normal and disturbed: revolutions of 2.0 to 2.2 s."""
    assert revolutions(runs["rig_20ms"])[1:].mean() == pytest.approx(2.1, abs=0.15)


def test_linkage_disturbed_recovers_within_a_revolution(runs: dict[str, Columns]) -> None:
    """Chapter 6: the effect of a disturbance is gone after about one revolution, so no revolution is far off."""
    run = runs["linkage_disturbed"]
    usual = revolutions(runs["linkage_20ms"])[2:].mean()
    assert np.abs(revolutions(run) - usual).max() < 0.05 * usual
    for instant, change in ((3000, 1), (6000, -1), (9000, 1), (12000, -1)):
        # Braking loads the gear at once, pushing relieves it.
        jump = run["plant.tau_crank"][instant + 2] - run["plant.tau_crank"][instant - 1]
        assert 1.0 < change * jump < 5.0
