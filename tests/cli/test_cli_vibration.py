"""``cosim score --vibration``: the table, the ratios, the document, and what is refused."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from typer.testing import Result

from cosim import engine
from cosim.report import write_parquet

Cosim = Callable[..., Result]


@pytest.fixture
def runs(tmp_path: Path) -> tuple[Path, Path]:
    """Two runs, of which the second one has half the torque."""
    time = np.arange(10001) * 1e-3
    park = (time % 2.0 < 0.012).astype(int)
    for name, size in (("strong", 4.0), ("weak", 2.0)):
        torque = size * np.sin(2 * np.pi * 2.0 * time)
        result = engine.Result(time, {"plant.tau_crank": torque, "plant.park": park}, {"plant.tau_crank": "N.m"})
        (tmp_path / name).mkdir()
        write_parquet(result, tmp_path / name / "results.parquet", {"complete": True})
    return tmp_path / "strong", tmp_path / "weak"


def test_the_table(cosim: Cosim, runs: tuple[Path, Path]) -> None:
    done = cosim("score", runs[0], "--against", runs[1])
    assert (done.exit_code, done.stderr) == (0, "")
    lines = done.stdout.splitlines()
    rows = {line.partition("  ")[0]: line.split()[-3:] for line in lines[1:] if "[" in line}
    assert lines[0].split() == ["strong", "weak", "ratio"]
    assert rows["crank torque, peak [N.m]"] == ["4", "2", "2"]
    assert rows["crank torque, RMS [N.m]"] == ["2.828", "1.414", "2"]
    assert "strong, strongest lines of the crank torque: 4 N.m at 2 Hz" in done.stdout
    assert "note: weak: not measured for want of a column: what needs i_motor, v_motor, w_motor, w_crank" in lines


def test_the_document(cosim: Cosim, runs: tuple[Path, Path]) -> None:
    settings = ["--set", "window=20 ms", "--set", "bands=1,5", "--set", "lines=1", "--set", "until=8 s"]
    done = cosim("score", *runs, "--against", runs[1], "--json", *settings)
    assert done.exit_code == 0
    document = json.loads(done.stdout)
    first, second = document["results"]
    assert document["baseline"]["measures"] == second["measures"]
    assert (first["method"]["window"], first["method"]["bands"], first["method"]["until"]) == (0.02, [1.0, 5.0], 8.0)
    assert first["comparison"]["ratios"]["torque_rate_peak"] == pytest.approx(2.0)
    assert second["comparison"]["ratios"]["torque_rate_peak"] == 1.0
    assert first["measures"]["torque_peak"] == {"label": "crank torque, peak", "value": 4.0, "unit": "N.m"}
    ((frequency, amplitude),) = first["lines"]["torque"]
    assert (frequency, amplitude) == pytest.approx((2.0, 4.0), rel=1e-3)


def test_a_result_that_cannot_be_measured(cosim: Cosim, runs: tuple[Path, Path]) -> None:
    done = cosim("score", "nothing", runs[0], "--vibration", "--json")
    assert done.exit_code == 2
    refused, measured = json.loads(done.stdout)["results"]
    assert refused["error"].startswith("nothing: no such result")
    assert measured["measures"]["torque_peak"]["value"] == pytest.approx(4.0)
    assert cosim("score", runs[0], "--against", "nothing").exit_code == 2


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("bands=1,x", "--set bands=1,x: 'x' is not a number"),
        ("bands=1,5 Hz", "--set bands=1,5 Hz: write plain numbers, without a unit"),
        ("early=1 s", "--set early=1 s: there is no 'early'; accepted are window, start, around, since"),
        ("window=0 s", "window 0.0: must be positive"),
    ],
)
def test_wrong_methods_are_refused(cosim: Cosim, runs: tuple[Path, Path], setting: str, message: str) -> None:
    done = cosim("score", runs[0], "--vibration", "--set", setting)
    assert done.exit_code == 2
    assert message in done.stderr
