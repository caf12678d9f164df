"""Faults from the command line to what a run leaves behind: columns, summary, pictures, a score, an SSP."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from cosim.assessment import trace
from cosim.cli._app import app

SCENARIO = """# title: Three seconds
# system: rig
# controller: voltage_profile
# stop: 3 s
# fault: i_motor bias 0.5 A from 1 s to 2 s
# fault: tau_disturbance noise 0.5 N.m seed 4 every 10 ms from 0.5 s
time [s],tau_disturbance [N.m]
0,0
1.5,-2
"""
Cosim = Callable[..., str]


@pytest.fixture
def cosim(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Cosim:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "x.csv").write_text(SCENARIO, encoding="utf-8")

    def run(*arguments: object) -> str:
        done = CliRunner().invoke(app, [str(argument) for argument in arguments])
        assert done.exit_code == 0, done.output
        return done.stdout

    return run


def test_a_run_records_what_the_inputs_got_and_says_why(cosim: Cosim) -> None:
    cosim("run", "x.csv", "--fault", "park override 0 from 1.5 s")
    table = pd.read_csv("results/x/results.csv")
    time = table["time [s]"].to_numpy()
    lifted = (time > 0.9999) & (time < 1.9999)
    bias = table["controller.i_motor [A]"] - table["plant.i_motor [A]"]
    np.testing.assert_allclose(bias, np.where(lifted, 0.5, 0.0), atol=1e-15)
    noise = table["plant.tau_disturbance [N.m]"] - np.where(time > 1.4999, -2.0, 0.0)
    assert not noise[time < 0.4999].any()
    assert len(np.unique(noise[(time > 0.4999) & (time < 2.9999)])) == 250
    assert not table["controller.park [1]"][time > 1.4999].any()
    assert table["plant.park [1]"][time > 1.4999].any()
    summary = json.loads(Path("results/x/summary.json").read_text(encoding="utf-8"))
    assert summary["faults"] == [
        {"target": "controller.i_motor", "kind": "bias", "amount": 0.5, "unit": "A", "from_s": 1.0, "to_s": 2.0,
         "every_s": None, "seed": None},
        {"target": "plant.tau_disturbance", "kind": "noise", "amount": 0.5, "unit": "N.m", "from_s": 0.5, "to_s": None,
         "every_s": 0.01, "seed": 4},
        {"target": "controller.park", "kind": "override", "amount": 0.0, "unit": None, "from_s": 1.5, "to_s": None,
         "every_s": None, "seed": None},
    ]  # fmt: skip
    assert Path("results/x/overview.png").is_file()


@pytest.mark.parametrize("source", ["results/x", "results/x/results.csv"])
def test_the_contact_of_the_plant_is_scored(cosim: Cosim, source: str) -> None:
    """And not what a fault has made of it, though both are called park."""
    cosim("run", "x.csv", "--no-plots", "--fault", "park override 0 from 1.5 s")
    assert trace(source).column("park") == "plant.park"
    assert trace(source).column("tau_disturbance") == "plant.tau_disturbance"


def test_an_ssp_with_its_scenario_runs_with_the_same_faults(cosim: Cosim) -> None:
    cosim("run", "x.csv", "--no-plots")
    cosim("export-ssp", "x.csv", "--out", "y.ssp")
    assert (
        "# fault: plant.tau_disturbance noise 0.5 N.m seed 4 every 0.01 s from 0.5 s\n" in Path("y_ssp.csv").read_text()
    )
    cosim("run", "y_ssp.csv", "--no-plots")
    first, second = (pd.read_csv(f"results/{name}/results.csv") for name in ("x", "y_ssp"))
    assert set(first.columns) <= set(second.columns)
    for name in first.columns:
        assert first[name].equals(second[name]), name


def test_faults_are_explained(cosim: Cosim) -> None:
    told = cosim("run", "x.csv", "--explain-timing")
    assert "plant.i_motor -> controller.i_motor\n    what arrives, and when, is up to its faults\n" in told
    assert told.endswith(
        "Faults, in the order in which they act:\n"
        "  controller.i_motor bias 0.5 A from 1 s to 2 s\n"
        "  plant.tau_disturbance noise 0.5 N.m seed 4 every 0.01 s from 0.5 s\n\n\n"
    )
