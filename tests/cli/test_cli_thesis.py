"""``cosim thesis``: what is refused before anything is built or simulated."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import Result

Cosim = Callable[..., Result]


@pytest.mark.parametrize(
    ("option", "message"),
    [
        (["--measured", "nothing.csv"], "nothing.csv: there is no such measurement"),
        (["--measured", "force.csv"], "force.csv: no column for the torque or current among time, force"),
        (["--set", "earl=1"], "--set earl=1: there is no 'earl'; accepted are span, early, late"),
        (["--set", "early=-1 s"], "--set: early -1.0 s: a tolerance of the park prediction must not be negative"),
    ],
)
def test_what_is_wrong_is_refused_at_once(
    cosim: Cosim, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, option: list[str], message: str
) -> None:
    monkeypatch.setattr(sys.modules["cosim.fmu.catalogue"], "data_folder", lambda: tmp_path, raising=False)
    (tmp_path / "force.csv").write_text("time [s],force [N]\n0,1\n1,2\n", encoding="utf-8")
    done = cosim("thesis", *option)
    assert done.exit_code == 2
    assert f"error: {message}" in done.stderr
    assert not (tmp_path / "results").exists()
