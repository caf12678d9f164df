"""``cosim disturbance`` writes a scenario that runs, and refuses what makes none."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from cosim.scenario import read

BASE = Path(__file__).parents[2] / "scenarios" / "rig_20ms.csv"


def command(*arguments: str) -> subprocess.CompletedProcess[str]:
    run = [sys.executable, "-m", "cosim", "disturbance", *arguments]
    return subprocess.run(run, capture_output=True, text=True, check=False)


def test_it_writes_the_base_with_pulses(tmp_path: Path) -> None:
    out = tmp_path / "new" / "x.csv"
    run = command("--base", str(BASE), "--out", str(out), "--size", "400 N.cm", "--variation", "0", "--json")
    assert run.returncode == 0, run.stderr
    assert json.loads(run.stdout)["pulses"] == 8
    scenario = read(out)
    assert scenario.stop == read(BASE).stop
    (torque,) = scenario.columns
    assert (torque.times[1:4], torque.values[1:4]) == ((3.0, 3.3, 6.0), (-4.0, 0.0, 4.0))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--size", "5 s"], "--size 5 s: expected a quantity in N.m, such as 2 N.m"),
        ([], "give --stop, the time up to which there are pulses, or --base, a scenario that has one"),
        (["--stop", "9 s", "--length", "4 s"], "make the pulses shorter, their spacing larger or"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_without_a_file(tmp_path: Path, arguments: list[str], message: str) -> None:
    run = command("--out", str(tmp_path / "x.csv"), *arguments)
    assert run.returncode == 2
    assert message in run.stderr
    assert not (tmp_path / "x.csv").exists()
