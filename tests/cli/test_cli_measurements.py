"""``cosim measurements``: what files hold, and stand-in data; the plant only pretends, the files are real."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from typer.testing import Result

from cosim import engine
from cosim.engine import System
from cosim.measurement import read

Cosim = Callable[..., Result]


@pytest.fixture(autouse=True)
def plant(cosim: Cosim, monkeypatch: pytest.MonkeyPatch) -> list[dict[str, object]]:
    """A motor whose current rises, then swings; gives the parameters that it was simulated with."""
    asked: list[dict[str, object]] = []

    def simulate(system: System, *, stop: float, output_interval: float, **_: object) -> engine.Result:
        asked.append(dict(system.components[0].parameters))
        time = np.arange(round(stop / output_interval) + 1) * output_interval
        return engine.Result(time, {"plant.i_motor": (1 - np.exp(-9 * time)) * (2.5 + np.sin(8 * time))}, {})

    class Plant(SimpleNamespace):
        def __enter__(self) -> Plant:
            return self

        def __exit__(self, *_: object) -> None:
            pass

    fmu: Any = Plant()
    monkeypatch.setattr(engine, "simulate", simulate)
    monkeypatch.setattr(engine, "Component", lambda name, _, values: SimpleNamespace(name=name, parameters=values))
    monkeypatch.setattr(engine, "System", lambda parts, channels: SimpleNamespace(components=parts, channels=channels))
    monkeypatch.setattr(engine.Fmu, "read", staticmethod(lambda path: fmu))
    return asked


@pytest.mark.parametrize(("law", "naive"), [("naive", True), ("simple", False)])
def test_eight_workbooks_are_written_and_shown(
    cosim: Cosim, plant: list[dict[str, object]], law: str, naive: bool
) -> None:
    done = cosim("measurements", "synthesize", "--rows", 2000, "--out", "made", "--law", law)
    assert done.exit_code == 0, done.output
    assert done.stdout.endswith("8 synthetic workbooks in made: no measurements\n")
    files = sorted(Path("made").glob("*.xlsx"))
    assert len(files) == 8 and {run["naive_load"] for run in plant} == {naive}
    done = cosim("measurements", "show", files[0], files[1], "--out", "pictures")
    assert done.exit_code == 0, done.output
    assert "dry glass, cold motor, high speed (synthetic)" in done.stdout
    assert sorted(path.name for path in Path("pictures").iterdir()) == [
        "Dry_Glass_Cold_Motor_HS.png", "Dry_Glass_Cold_Motor_LS.png",
    ]  # fmt: skip
    shown = json.loads(cosim("measurements", "show", files[0], "--json").stdout)["measurements"][0]
    measurement = read(files[0])
    assert shown["synthetic"] and shown["samples"] == len(measurement.frame)
    assert shown["torque_at_onset"] == measurement.meta["torque_at_onset"]


def test_what_cannot_be_made_or_shown(cosim: Cosim) -> None:
    for arguments, message in (
        (("synthesize", "--rows", 10), "10 rows; a workbook can have from 1000 to 50000"),
        (("show", "none.csv"), "none.csv: there is no such measurement"),
        (("show", "i.csv", "--out", "x"), "i.csv: the torque was not measured; there is nothing to draw"),
        (
            ("show", "i.csv", "--measured-column", "current=x"),
            "i.csv: no column 'x' for the current; there are time, i",
        ),
    ):
        Path("i.csv").write_text("time,i\n0,1\n1,2\n")
        done = cosim("measurements", *arguments)
        assert (done.exit_code, done.stderr) == (2, f"error: {message}\n")


def test_repairs_are_told_and_numbers_that_are_none_stay_valid_json(cosim: Cosim) -> None:
    Path("x.csv").write_text("time,shaft\n0,1\n1,\n2,3\n")
    show = ("measurements", "show", "x.csv", "--measured-column", "torque=shaft")
    done = cosim(*show, "--json")
    assert done.exit_code == 0
    shown = json.loads(done.stdout, parse_constant=pytest.fail)["measurements"][0]
    assert shown["repairs"] == ["the torque is missing in line 3: not a number there"]
    assert shown["current_peak"] is None and shown["onset_difference_s"] is None
    assert "warning: x.csv: the torque is missing in line 3: not a number there" in cosim(*show).stderr
