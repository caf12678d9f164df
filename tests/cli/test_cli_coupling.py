"""What ``cosim run`` tells of delays and coupling errors."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import Result

from cosim import engine
from cosim.cli import _run
from cosim.engine import SimulationInterrupted, System

Cosim = Callable[..., Result]


def entry(source: str, target: str, **other: object) -> dict[str, Any]:
    nothing = dict.fromkeys(("error", "unit", "relative", "order"))
    return {"source": source, "target": target, "delay_s": 0.0, **nothing, "target_outputs": {}, "note": "", **other}


SAMPLED = [entry("p.w", "c.w", note="none: sampled"), entry("c.u", "p.u", note="none: sampled")]


@pytest.fixture
def account(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    def arrange(*entries: dict[str, Any], error: type[BaseException] | None = None) -> None:
        def simulate(_: System, **__: object) -> engine.Result:
            column = {"plant.i_motor": np.array([0.0, 1.0])}
            statistics: dict[str, object] = {"wall_s": 0.25, "coupling": list(entries)}
            result = engine.Result(np.array([0.0, 1.0]), column, statistics=statistics)
            if error is not None:
                raise SimulationInterrupted("interrupted while the coupling error was estimated", result)
            return result

        monkeypatch.setattr(_run, "simulate", simulate)

    return arrange


def told(done: Result) -> list[str]:
    assert done.exit_code == 0, done.stderr
    return [line.rstrip() for line in done.stdout.splitlines()[1:]]


def test_a_line_if_all_is_sampled(cosim: Cosim, scenario: Path, account: Callable[..., None]) -> None:
    account(*SAMPLED)
    assert told(cosim("run", scenario)) == ["coupling error: none, all 2 connections are sampled"]
    account()
    assert told(cosim("run", scenario)) == []


def test_a_table_of_what_is_not(cosim: Cosim, scenario: Path, account: Callable[..., None]) -> None:
    behind = {"output": "b.y", "error": 0.1, "unit": "m", "relative": 0.05}
    found = [
        *SAMPLED,
        entry("a.x", "b.x", delay_s=-1e-3, error=0.0, unit="m", relative=0.0, order=1, target_outputs=behind),
        entry("b.F", "a.F", error=12.34, unit="N", relative=0.00123, order=2),
        entry("b.ratio", "d.ratio", delay_s=None, note="not estimated: d takes steps of 0.1 s only"),
    ]
    account(*found)
    assert told(cosim("run", scenario)) == [
        "Coupling error, estimated",
        "connection             delay      error  of range  falls with",
        "b.F -> a.F               0 s       12 N    0.12 %         h^2",
        "a.x -> b.x          -0.001 s        0 m       0 %         h^1",
        "b.ratio -> d.ratio            not known",
        "not estimated: d takes steps of 0.1 s only",
        "b.y, which is not handed on, is off by 5 % of its range",
        "2 more connections are sampled, without such an error",
    ]
    assert json.loads(Path("results/x/summary.json").read_text())["coupling"] == found
    assert cosim("run", scenario, "--quiet").stdout == ""
    assert json.loads(cosim("run", scenario, "--json").stdout)["runs"][0]["summary"]["coupling"] == found


def test_the_worst_of_many(cosim: Cosim, scenario: Path, account: Callable[..., None]) -> None:
    account(*(entry(f"a.x{k}", f"b.x{k}", error=k, relative=k / 100, order=1) for k in range(20)))
    lines = told(cosim("run", scenario))
    assert [line.split(" ")[0] for line in lines[2:14]] == [f"a.x{k}" for k in range(19, 7, -1)]
    assert lines[14:] == ["8 more connections are in summary.json"]


def test_energies(cosim: Cosim, scenario: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ends = {"effort": "m.tau", "flow": "l.w"}
    known = {"given_J": 10.0, "taken_J": 9.75, "error_J": -0.25, "exchanged_J": 12.5, "relative": -0.02, "note": ""}
    unknown: dict[str, object] = {**dict.fromkeys(known), "note": "not measured: l acts at instants"}
    statistics: dict[str, object] = {"power": [{**ends, **known}, {**ends, **unknown}]}
    result = engine.Result(np.array([0.0, 1.0]), {"plant.i_motor": np.zeros(2)}, statistics=statistics)
    monkeypatch.setattr(_run, "simulate", lambda *_, **__: result)
    assert told(cosim("run", scenario)) == [
        "energy of m.tau * l.w: 12.5 J exchanged, -0.25 J added by the coupling, -2 % of it",
        "energy of m.tau * l.w: not measured: l acts at instants",
    ]
    assert json.loads(Path("results/x/summary.json").read_text())["power"] == statistics["power"]


def test_it_can_be_switched_off(cosim: Cosim, scenario: Path, simulated: list[dict[str, object]]) -> None:
    assert cosim("run", scenario, "--no-coupling-error").exit_code == 0
    assert simulated[0]["coupling_error"] is False


def test_ctrl_c_in_the_second_run(cosim: Cosim, scenario: Path, account: Callable[..., None]) -> None:
    account(error=SimulationInterrupted)
    done = cosim("run", scenario)
    assert done.exit_code == 130
    assert done.stderr == (
        f"error: {scenario}: interrupted while the coupling error was estimated; "
        f"its results are in {Path('results/x')}\n"
    )
    assert json.loads(Path("results/x/summary.json").read_text())["complete"]
