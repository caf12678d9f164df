"""``cosim linearize``: the example of its documentation, the options, and what is refused before anything is built."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from cosim.cli import _linearize
from cosim.cli._app import app
from cosim.linear import LinearSystem, Signal

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "linearize.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_example_of_the_documentation(tmp_path: Path) -> None:
    pytest.importorskip("rumoca")
    pytest.importorskip("control")
    model, shell, shown = re.findall(r"```(?:modelica|sh|text)\n(.*?)```", PAGE, re.DOTALL)
    (tmp_path / "motor.mo").write_text(model)
    command, *arguments = shlex.split(shell)
    assert command == "cosim"
    done = subprocess.run(
        [sys.executable, "-m", "cosim", *arguments], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert _rounded(done.stdout) == _rounded(shown)
    document = json.loads((tmp_path / "linear" / "Motor_linear.json").read_text())
    assert document["states"][2]["unit"] == "rad/s"
    assert document["poles"][2]["real"] == pytest.approx(-194.86562)


def _rounded(text: str) -> list[str]:
    """What is below rounding errors is zero."""
    return [
        re.sub(r"\s+", " ", re.sub(r"-?\d\.?\d*e-(?:0[9]|[1-9]\d)|-0(?= |$)", "0", line)) for line in text.splitlines()
    ]


def test_the_text_of_a_large_system_stays_readable() -> None:
    states = tuple(Signal(f"x{k}", "1", 0.0) for k in range(9))
    system = LinearSystem(
        model="P.Wide", at="2 s", time=2.0, states=states, inputs=(), outputs=(), A=np.diag(np.arange(1.0, 10.0)),
        B=np.zeros((9, 0)), C=np.zeros((0, 9)), D=np.zeros((0, 0)), slope=np.zeros(9),
        held={f"d{k}": 1.0 for k in range(15)},
    )  # fmt: skip
    lines = _linearize.describe(system).splitlines()
    assert lines[0] == "P.Wide, linearized at t = 2 s"
    assert "no outputs: the model has no Real output; name variables with --output" in lines
    assert f"held: {', '.join(f'd{k} = 1' for k in range(12))}, and 3 more" in lines
    assert "A: 9 rows, 9 columns; --out DIR or --json gives them" in lines
    assert lines[-1].split() == ["9", "9", "1.43239", "-1", "-0.1111", "unstable"]


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[dict[str, object]]:
    """What the command asks for, instead of doing it."""
    calls: list[dict[str, object]] = []

    def record(file: Path, model: str, **options: object) -> LinearSystem:
        calls.append({"model": model} | options)
        raise _linearize.InputError("that was it")

    monkeypatch.chdir(tmp_path)
    Path("x.mo").touch()
    monkeypatch.setattr(_linearize, "linearize", record)
    return calls


def test_options(asked: list[dict[str, object]]) -> None:
    CliRunner().invoke(
        app,
        "linearize x.mo P.M --at steady --set R=2 --set R=3 --set a.b=1 --input v=4 --output y --steady-except phi "
        "--settle 20".split(),
    )
    CliRunner().invoke(app, ["linearize", "x.mo", "P.M", "--at", "20 ms", "--input", "v = 4 V"])
    CliRunner().invoke(app, ["linearize", "x.mo", "P.M"])
    assert asked == [
        {"model": "P.M", "at": "steady", "parameters": {"R": "3", "a.b": "1"}, "inputs": {"v": "4"}, "outputs": ["y"],
         "steady_except": ["phi"], "settle": 20.0},
        {"model": "P.M", "at": 0.02, "parameters": {}, "inputs": {"v": "4 V"}, "outputs": None, "steady_except": [],
         "settle": None},
        {"model": "P.M", "at": "initial", "parameters": {}, "inputs": {}, "outputs": None, "steady_except": [],
         "settle": None},
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["y.mo", "P.M"], "y.mo: there is no such Modelica file or folder"),
        (["x.mo", "P.M", "--at", "soon"], "--at soon: give a time from 0 on, such as '2.5 s' or initial or steady"),
        (["x.mo", "P.M", "--at", "3 m"], "--at 3 m: give a time from 0 on, such as '2.5 s' or initial or steady"),
        (["x.mo", "P.M", "--settle", "-1"], "--settle -1: give a time from 0 on, such as '2.5 s'"),
        (["x.mo", "P.M", "--input", "v"], "--input v: write name=value, such as --input 'v_supply=28 V'"),
        (["x.mo", "P.M", "--set", "=3"], "--set =3: write name=value, such as --set 'v_supply=28 V'"),
    ],
)
def test_what_is_refused(asked: list[dict[str, object]], arguments: list[str], message: str) -> None:
    done = CliRunner().invoke(app, ["linearize", *arguments])
    assert (done.exit_code, done.stdout, done.stderr) == (2, "", f"error: {message}\n")
    assert asked == []
