"""A system that we export as an SSP, in ecos: the same numbers as when we read it back."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from cosim.engine import System, simulate
from cosim.fmu import catalogue
from cosim.fmu.versions import FmiVersion
from cosim.scenario import assemble, read
from cosim.ssp import read_ssp, write_ssp

from .conftest import Need

OUTPUTS = ("phi_crank", "w_crank", "i_motor")
STEP, STEPS = 1e-3, 1000


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
def test_ecos_runs_our_ssp(need: Need, fmi: FmiVersion, tmp_path: Path) -> None:
    """It steps all FMUs at once and hands on what they put out at the step's beginning: our Jacobi algorithm."""
    need("ecospy")
    plant, controller = (catalogue.ensure(name, fmi) for name in ("rig", "voltage_profile"))
    (tmp_path / "a.csv").write_text(f"# system: {plant}\n# controller: {controller}\n# stop: 1 s\ntime [s]\n")
    system = assemble(read(tmp_path / "a.csv"), catalogue.ensure)
    path = tmp_path / "a.ssp"
    write_ssp(system, path, name="a", stop=1.0)
    read_back = read_ssp(path)
    ours = simulate(
        System(read_back.components, read_back.connections),
        stop=STEP * STEPS + 1.0,
        output_interval=STEP,
        tolerance=1e-6,
        algorithm="jacobi",
        step=STEP,
    )
    script = str(Path(__file__).parent / "ecos_ssp.py")
    names = [f"plant::{name}" for name in OUTPUTS]
    command = [sys.executable, script, str(path), str(STEP), str(STEPS), *names]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    theirs = np.array(json.loads(done.stdout.splitlines()[-1]))
    for column, name in enumerate(OUTPUTS):
        np.testing.assert_allclose(
            theirs[:, column], ours.columns[f"plant.{name}"][1 : STEPS + 1], rtol=1e-9, atol=1e-9, err_msg=name
        )
