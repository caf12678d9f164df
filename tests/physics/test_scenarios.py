"""Every scenario that comes with the project runs, and pins a physical number; the same inputs give the same bytes.

The numbers come from the independent reference (``reference.closed_loop`` and ``reference.simulation``).
"""

from __future__ import annotations

import csv
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from physics.test_scenario_pins import PINS as OTHER_PINS

FOLDER = Path(__file__).parents[2] / "scenarios"


@dataclass(frozen=True)
class Pin:
    """What a scenario must end with."""

    phi_crank: float
    """Angle of the gear's output shaft at 25 s [rad]."""
    peak_torque: float
    """Largest crank torque after the first second [N.m]."""
    parks: int
    """How often the park contact closes after the start."""


PINS = {
    "linkage_20ms": Pin(68.738532, 15.0385, 10),
    "linkage_disturbed": Pin(68.733570, 19.3094, 10),
    "linkage_full_voltage": Pin(71.476766, 15.0385, 11),
    "rig_20ms": Pin(78.544300, 5.7571, 12),
    "rig_full_voltage": Pin(80.438185, 5.7571, 12),
}


def run(scenario: Path, out: Path, *, cwd: Path) -> bytes:
    """Run a scenario as a user does and return the bytes of its results.csv."""
    command = [sys.executable, "-c", "from cosim.cli import main; main()", "run", str(scenario)]
    command += ["--out", str(out), "--no-plots", "--quiet"]
    subprocess.run(command, cwd=cwd, check=True, env={**os.environ, "PYTHONHASHSEED": str(len(str(out)) % 7)})
    return (out / scenario.stem / "results.csv").read_bytes()


def test_every_scenario_has_a_pin() -> None:
    assert {path.stem for path in FOLDER.glob("*.csv")} == {*PINS, *OTHER_PINS}


@pytest.mark.parametrize("name", sorted(PINS))
def test_a_scenario_ends_where_the_reference_ends(name: str, tmp_path: Path) -> None:
    lines = run(FOLDER / f"{name}.csv", tmp_path / "results", cwd=tmp_path).decode().splitlines()
    header = next(csv.reader(lines))
    rows = np.array([[float(cell) for cell in row] for row in csv.reader(lines[1:])])
    columns = {cell.split(" [")[0]: rows[:, k] for k, cell in enumerate(header)}
    pin = PINS[name]
    assert header[0] == "time [s]"
    assert (columns["time"][0], columns["time"][-1], len(rows)) == (0.0, 25.0, 25001)
    assert columns["plant.phi_crank"][-1] == pytest.approx(pin.phi_crank, abs=1e-4)
    assert columns["plant.tau_crank"][1000:].max() == pytest.approx(pin.peak_torque, abs=2e-3)
    assert int((np.diff(columns["plant.park"]) > 0).sum()) == pin.parks
    assert columns["plant.i_motor"].min() >= 0.0


def test_the_same_inputs_give_the_same_bytes(tmp_path: Path) -> None:
    scenario = FOLDER / "linkage_20ms.csv"
    elsewhere = tmp_path / "somewhere else"
    elsewhere.mkdir()
    first = run(scenario, tmp_path / "first", cwd=tmp_path)
    assert run(scenario, tmp_path / "again", cwd=tmp_path) == first
    assert run(scenario, elsewhere / "results", cwd=elsewhere) == first
