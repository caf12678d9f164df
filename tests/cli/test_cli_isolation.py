"""The options of ``cosim run`` for a process of its own, and a crash as the user of the command meets it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import Result

sys.path.insert(0, str(Path(__file__).parents[1] / "fmus"))
from fmu_builder import CRASH, build

Cosim = Callable[..., Result]


def test_the_options_reach_the_engine(cosim: Cosim, scenario: Path, simulated: list[dict[str, object]]) -> None:
    options = ("--isolate", "never", "--call-timeout", "5 min", "--memory-limit", "1.5 GiB")
    assert cosim("run", scenario, "--no-plots", *options).exit_code == 0
    asked = {key: simulated[0][key] for key in ("isolate", "call_timeout", "memory_limit")}
    assert asked == {"isolate": "never", "call_timeout": 300.0, "memory_limit": 1.5 * 2**30}


@pytest.mark.parametrize(
    ("option", "value", "message"),
    [
        ("--isolate", "sometimes", "accepted are auto, always, never"),
        ("--call-timeout", "60", "write a time above 0, such as '60 s' or '5 min'"),
        ("--call-timeout", "60 N", "write a time above 0, such as '60 s' or '5 min'"),
        ("--call-timeout", "0 s", "write a time above 0, such as '60 s' or '5 min'"),
        ("--memory-limit", "4", "write a size of 100 MB or more, such as '4 GB'"),
        ("--memory-limit", "4 GV", "write a size of 100 MB or more, such as '4 GB'"),
        ("--memory-limit", "4 MB", "write a size of 100 MB or more, such as '4 GB'"),
    ],
)
def test_options_that_cannot_be_meant(
    cosim: Cosim, scenario: Path, simulated: list[dict[str, object]], option: str, value: str, message: str
) -> None:
    done = cosim("run", scenario, option, value)
    assert (done.exit_code, done.stderr) == (2, f"error: {option} {value}: {message}\n")
    assert simulated == []


@pytest.mark.skipif(sys.platform == "win32", reason="sends a signal")
def test_control_c_ends_a_command_whose_fmu_hangs_and_keeps_the_rows(tmp_path: Path) -> None:
    fmu = build(CRASH, 2, tmp_path)
    scenario = tmp_path / "x.csv"
    scenario.write_text(
        f"# system: {fmu.name}\n# controller: none\n# stop: 0.1 s\n# output_interval: 10 ms\ntime [s]\n0\n"
    )
    command = [sys.executable, "-m", "cosim", "run", str(scenario), "--no-plots"]
    environment = os.environ | {"CRASH": "DoStep touch", "CRASH_FILE": str(tmp_path / "reached")}
    with subprocess.Popen(command, env=environment, cwd=tmp_path, stderr=subprocess.PIPE, text=True) as running:
        deadline = time.perf_counter() + 60.0
        while not (tmp_path / "reached").exists() and time.perf_counter() < deadline:
            time.sleep(0.02)
        running.send_signal(signal.SIGINT)
        _, said = running.communicate(timeout=30.0)
    assert running.returncode == 130
    assert said == (
        f"error: {scenario}: the simulation was interrupted at t = 0.04 s; what was computed before is in "
        f"{Path('results/x')}, marked incomplete\n"
    )
    assert len((tmp_path / "results/x/results.csv").read_text().splitlines()) == 6
    summary = json.loads((tmp_path / "results/x/summary.json").read_text())
    assert (summary["complete"], summary["rows"]) == (False, 5)


def test_a_crash_ends_the_command_with_3_and_keeps_the_rows(tmp_path: Path) -> None:
    fmu = build(CRASH, 3, tmp_path)
    scenario = tmp_path / "x.csv"
    scenario.write_text(
        f"# system: {fmu.name}\n# controller: none\n# stop: 0.1 s\n# output_interval: 10 ms\ntime [s]\n0\n"
    )
    done = subprocess.run(
        [sys.executable, "-m", "cosim", "run", str(scenario), "--no-plots", "--json"],
        env=os.environ | {"CRASH": "DoStep segmentation"},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 3
    message = (
        f"{scenario}: the simulation failed at t = 0.04 s: plant (crash): crashed in fmi3DoStep, with SIGSEGV (it used "
        "memory that it does not have, by a null pointer); the FMU gave no reason; try it in another tool, and report "
        f"it to whoever exported it; what was computed before is in {Path('results/x')}, marked incomplete"
    )
    assert done.stderr == f"error: {message}\n"
    (run,) = json.loads(done.stdout)["runs"]
    assert (run["exit_code"], run["message"], run["summary"]["complete"]) == (3, message, False)
    assert (tmp_path / "results/x/results.csv").read_text().splitlines() == [
        "time [s],plant.y [s]",
        *(f"{t},{t}" for t in (0.0, 0.01, 0.02, 0.03, 0.04)),
    ]
