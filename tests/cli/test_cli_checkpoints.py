"""``cosim run --checkpoint`` and ``--resume``: what lands where, what is told, and what is refused."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from typer.testing import Result

from cosim import engine
from cosim.cli import _run
from cosim.engine import Checkpoint
from cosim.errors import InputError

Cosim = Callable[..., Result]
SAVED = object.__new__(Checkpoint)


@pytest.fixture(autouse=True)
def pretended(monkeypatch: pytest.MonkeyPatch, simulated: list[dict[str, object]]) -> None:
    """Loading gives a checkpoint of nothing, and a simulation hands back as many as it is asked for."""

    def load(path: Path) -> Checkpoint:
        if path.name != "some.cosim":
            raise InputError("is not a checkpoint", file=path)
        return SAVED

    pretend = _run.simulate

    def simulate(*system: engine.System, **options: object) -> engine.Result:
        result = pretend(*system, **options)  # type: ignore[arg-type]
        times = options.get("checkpoint_at", ())
        assert isinstance(times, tuple)
        result.checkpoints = (SAVED,) * len(set(times))
        if "resume" in options:
            result.statistics["resumed_at_s"] = 0.5
        return result

    monkeypatch.setattr(Checkpoint, "load", staticmethod(load))
    monkeypatch.setattr(_run, "simulate", simulate)


def test_checkpoints_are_asked_for(cosim: Cosim, scenario: Path, simulated: list[dict[str, object]]) -> None:
    done = cosim("run", scenario, "--no-plots", "--json", "--checkpoint", "500 ms", "--checkpoint", "0.25s")
    assert (done.exit_code, done.stderr) == (0, "")
    assert simulated[0]["checkpoint_at"] == (0.5, 0.25)
    assert simulated[0]["checkpoint_to"] == Path("results/x")
    assert "resume" not in simulated[0]
    summary = json.loads(done.stdout)["runs"][0]["summary"]
    assert summary["checkpoints"] == ["checkpoint_0.25s.cosim", "checkpoint_0.5s.cosim"]
    assert summary["resumed_from"] is None


def test_going_on(cosim: Cosim, scenario: Path, simulated: list[dict[str, object]]) -> None:
    done = cosim("run", scenario, "--no-plots", "--resume", "some.cosim")
    assert (done.exit_code, done.stderr) == (0, "")
    assert simulated[0]["resume"] is SAVED
    assert "checkpoint_at" not in simulated[0]
    assert done.stdout.startswith("x: 1 s, from 0.5 s on, in 0.25 s, 2 times real time; ")
    summary = Path("results/x/summary.json").read_text()
    assert '"resumed_from": {\n    "checkpoint": "some.cosim",\n    "time_s": 0.5\n  }' in summary


def test_an_earlier_run_is_kept_if_the_file_is_none(cosim: Cosim, scenario: Path) -> None:
    cosim("run", scenario, "--no-plots")
    done = cosim("run", scenario, "--no-plots", "--resume", "other.cosim")
    assert (done.exit_code, done.stderr) == (2, "error: other.cosim: is not a checkpoint\n")
    assert Path("results/x/results.csv").is_file()


def test_an_interrupted_run_says_how_to_go_on(cosim: Cosim, scenario: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def simulate(*_: object, **__: object) -> engine.Result:
        ramp = np.linspace(0.0, 0.5, 2)
        rows = {"plant.i_motor": ramp}
        part = engine.Result(ramp, rows, complete=False, message="interrupted", checkpoints=(SAVED,))
        raise engine.SimulationInterrupted("the simulation was interrupted at t = 0.5 s", part)

    monkeypatch.setattr(_run, "simulate", simulate)
    done = cosim("run", scenario, "--no-plots", "--checkpoint", "0.7s", "--checkpoint", "0.3s")
    assert done.exit_code == 130
    assert done.stderr == (
        f"error: {scenario}: the simulation was interrupted at t = 0.5 s; what was computed before is in "
        f"{Path('results/x')}, marked incomplete; go on with --resume {Path('results/x/checkpoint_0.3s.cosim')}\n"
    )


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--checkpoint", "2"), "--checkpoint 2: write a time above 0, such as '60 s' or '5 min'"),
        (
            ("y.csv", "--resume", "some.cosim"),
            "--resume some.cosim goes on with one run, but there are 2 scenarios; give one",
        ),
        (
            ("--explain-timing", "--checkpoint", "1s"),
            "--explain-timing does not run anything; leave out --checkpoint and --resume",
        ),
    ],
)
def test_what_cannot_be_meant(cosim: Cosim, scenario: Path, options: tuple[str, ...], message: str) -> None:
    done = cosim("run", scenario, *options)
    assert (done.exit_code, done.stderr) == (2, f"error: {message}\n")
