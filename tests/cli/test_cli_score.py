"""``cosim score``: what is printed, as text and as JSON, and what is refused."""

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
NAMES = ("IDLE", "Soft_start", "RUN", "turn_point_dec", "turn_point_acc", "Soft_stop")
ENTRIES = [(0.0, 2), (0.1, 3), (0.9, 4), (1.0, 5), (1.1, 3), (1.9, 6), (2.0, 2), (2.1, 3), (3.9, 6)]


@pytest.fixture
def made(tmp_path: Path) -> Path:
    """A run whose second revolution does not turn, and decelerates 20 ms too early for its park signal."""
    time = np.arange(4001) * 1e-3
    starts, states = (np.array(values) for values in zip(*ENTRIES, strict=True))
    state = states[np.searchsorted(np.round(starts * 1000), np.arange(4001), side="right") - 1]
    state[3951:] = 2
    park = (time % 1.985 < 0.0119).astype(int)
    columns = {"plant.park": park, "controller.state": state}
    folder = tmp_path / "made"
    folder.mkdir()
    result = engine.Result(time, columns, {}, {"controller.state": NAMES})
    write_parquet(result, folder / "results.parquet", {"complete": True})
    return folder


def test_the_text(cosim: Cosim, made: Path) -> None:
    done = cosim("score", made)
    assert (done.exit_code, done.stderr) == (0, "")
    lines = done.stdout.splitlines()
    assert lines[0] == "made: 2 revolutions in 20 s"
    assert lines[3].split() == ["all", "0/2", "1/2", "1/2"]
    assert lines[4].split() == ["without", "the", "first", "0/1", "0/1", "0/1"]
    assert (
        "3.970 s              2  1 park            in Soft_start; the deceleration had ended 19 ms before the signal"
        in lines
    )
    assert "3.970 s              2  2 turn            no turn_point_acc since the last park signal" in lines
    assert lines[-2] == "note: the run covers 4 s of the 20 s that are scored"


def test_the_document(cosim: Cosim, made: Path) -> None:
    done = cosim("score", made, made / "results.parquet", "--json", "--set", "early=20 ms", "--set", "repeats=separate")
    assert done.exit_code == 0
    document = json.loads(done.stdout)
    first, second = document["results"]
    assert document["exit_code"] == 0
    assert first["rules"] == {
        "span": 20.0, "early": 0.02, "late": 0.0, "position": 0.125, "repeats": "separate", "unfinished": False
    }  # fmt: skip
    assert first["counts"] == second["counts"]
    assert first["counts"] == {
        "park_literal": 0, "park_deceleration": 2, "park_total": 2, "turn": 1, "turn_total": 2
    }  # fmt: skip
    assert first["revolutions"][1]["failures"][-1] == {
        "criterion": 2, "revolution": 2, "time": 3.97, "reason": "no turn_point_acc since the last park signal",
        "reading": "both",
    }  # fmt: skip


def test_a_result_that_cannot_be_scored_does_not_keep_the_next_from_it(cosim: Cosim, made: Path) -> None:
    done = cosim("score", "nothing", made, "--json")
    assert done.exit_code == 2
    assert done.stderr == "error: nothing: no such result; give a folder that cosim run wrote, such as results/x\n"
    refused, scored = json.loads(done.stdout)["results"]
    assert refused["error"].startswith("nothing: no such result")
    assert scored["counts"]["park_total"] == 2


def test_columns_can_be_named(cosim: Cosim, made: Path) -> None:
    done = cosim("score", made, "--column", "park=plant.contact")
    assert done.exit_code == 2
    assert done.stderr == (
        "error: made: no column 'plant.contact' to take for 'park'; there are plant.park, controller.state\n"
    )
    assert cosim("score", made, "--column", "park=plant.park", "--quiet").output == ""


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--set", "early"], "--set early: write name=value, such as --set 'early=50 ms'"),
        (["--set", "size=1"], "--set size=1: there is no 'size'; accepted are span, early, late, position"),
        (["--set", "early=5 m"], "--set early=5 m: early is in s"),
        (["--set", "early=soon"], "'soon' is not a number with a unit"),
        (["--set", "unfinished=2"], "--set unfinished=2: accepted are true and false"),
        (["--set", "repeats=sum"], "--set: repeats 'sum': accepted are grouped and separate"),
        (["--column", "park"], "--column park: write signal=column"),
        (["--column", "prk=plant.park"], "--column prk=plant.park: there is no 'prk'; accepted are park, state, "),
    ],
)  # fmt: skip
def test_wrong_options_are_refused(cosim: Cosim, made: Path, options: list[str], message: str) -> None:
    done = cosim("score", made, *options)
    assert done.exit_code == 2
    assert message in done.stderr
