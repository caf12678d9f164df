"""The runs that test the source's claims, against balances and what can be counted otherwise."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cosim.engine import Fmu, Result
from cosim.fmu import catalogue
from cosim.thesis._experiments import (
    AFTER,
    PULSE,
    PULSE_AT,
    aftermath,
    budget,
    load_budgets,
    no_load_revolution,
    slow_units,
)
from cosim.thesis._runs import scenario_run

pytest.importorskip("rumoca")

SCENARIOS = Path(__file__).parents[2] / "scenarios"


def test_the_crank_gives_what_load_and_damping_take() -> None:
    """The joints are viscous: what they take goes with the speed, whatever the load."""
    found = load_budgets(SCENARIOS, catalogue.ensure)
    assert found["without"].load_torque == 0.0
    # not more than 3 N.m on both rockers, at the greatest ratio of rocker and crank
    assert 0.0 < found["with"].load_torque < 2 * 3.0 * 0.906
    slower = found["without"].revolution / found["with"].revolution
    assert found["with"].damping_torque == pytest.approx(found["without"].torque * slower, rel=0.01)
    assert found["with"].electrical > found["with"].torque * 2 * np.pi / found["with"].revolution


def test_a_budget_is_one_of_means_over_whole_revolutions() -> None:
    """A made run: constant speed, torque with a ripple that has no mean, one rocker that takes 0.5 N.m per speed."""
    time = np.arange(10001) * 1e-3
    turned = np.pi * time  # one revolution in 2 s
    ripple = np.sin(turned)
    ones = np.ones_like(time)
    columns = {
        "w_crank": np.pi * ones, "tau_crank": 3.0 + ripple, "v_motor": 28.0 * ones, "i_motor": 2.0 * ones,
        "tau_ds": 0.5 * ripple, "w_ds": np.pi * ripple, "tau_ps": 0.0 * ones, "w_ps": 0.0 * ones,
        "park": (turned % (2 * np.pi) < np.deg2rad(2)).astype(np.int64),
    }  # fmt: skip
    found = budget(Result(time, {f"plant.{name}": values for name, values in columns.items()}))
    assert found.revolution == pytest.approx(2.0)
    assert found.electrical == pytest.approx(56.0)
    assert found.torque == pytest.approx(3.0, rel=1e-3)
    assert found.load_torque == pytest.approx(0.25, rel=1e-3)
    assert found.damping_torque == pytest.approx(2.75, rel=1e-3)
    assert found.current == pytest.approx(2.0)


def test_an_aftermath_is_measured_at_the_same_crank_angles() -> None:
    """A crank that is late after the pulse, and as fast as ever at each angle, is not disturbed any more."""
    time = np.arange(24001) * 1e-3
    speed = np.full_like(time, np.pi)
    during = (time >= PULSE_AT) & (time < PULSE_AT + PULSE)
    braked = np.where(during, 0.8 * np.pi, speed)
    runs = []
    for w in (speed, braked):
        angle = np.concatenate([[0.0], np.cumsum(w[:-1]) * 1e-3])
        runs.append(Result(time, {"plant.phi_crank": angle, "plant.w_crank": w}))
    found = aftermath("braked", *runs)
    assert found.difference.shape == (1 + AFTER,)
    assert found.difference[0] == 1.0
    np.testing.assert_allclose(found.difference[1:], 0.0, atol=1e-9)


def test_a_unit_with_one_rate_sees_the_contacts_that_a_tick_falls_into() -> None:
    """Counted otherwise: by the times at which the crank angle passes the edges of the contact."""
    unit = slow_units(SCENARIOS, catalogue.ensure, (0.02,))[0]
    run = scenario_run(SCENARIOS / "rig_20ms_one_rate.csv", catalogue.ensure)
    edges = 2 * np.pi * np.arange(1, unit.contacts + 1)
    closes, opens = (np.interp(edges + late, run.columns["plant.phi_crank"], run.time) for late in (0.0, np.deg2rad(2)))
    assert np.all(opens - closes < 0.02)
    seen = np.floor(opens / 0.02) > np.floor(closes / 0.02)
    assert int(seen.sum()) == unit.seen < unit.contacts
    falls = np.diff(run.columns["controller.period"]) != 0
    # each opening that the chart sees gives it a new period; the first is that of the start
    assert np.count_nonzero(falls) <= unit.seen + 1


def test_the_no_load_speed_is_that_of_table_3_4() -> None:
    revolution = no_load_revolution(Fmu.read(catalogue.ensure("rig")))
    assert revolution == pytest.approx(2 * np.pi * 73 * 0.113 / (28 - 1.91 * 0.58))
