"""The blocks of docs/checkpoints.md run, one after another."""

from __future__ import annotations

import json
import re
import shlex
import zipfile
from pathlib import Path

import pytest
from typer.testing import CliRunner

from cosim.cli._app import app

PAGE = Path(__file__).parents[2] / "docs" / "checkpoints.md"
SCENARIO = """# system: linkage
# controller: voltage_profile
# stop: 3 s
time [s],tau_disturbance [N.m]
0,0
"""


def test_every_block_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    Path("warm.csv").write_text(SCENARIO)
    names: dict[str, object] = {}
    printed = ""
    page = PAGE.read_text(encoding="utf-8")
    for language, text in re.findall(r"^```(\w*)\n(.*?)^```", page, re.MULTILINE | re.DOTALL):
        if language == "python":
            exec(compile(text, str(PAGE), "exec"), names)
            printed += capsys.readouterr().out
        elif language == "sh":
            for line in text.splitlines():
                command, *words = shlex.split(line)
                assert command == "cosim"
                done = CliRunner().invoke(app, [*words, "--no-plots"])
                assert done.exit_code == 0, (line, done.output)
        else:
            assert text == printed
    with zipfile.ZipFile("state.cosim") as archive:
        document = json.loads(archive.read("checkpoint.json"))
        entries = {name.partition("/")[0] for name in archive.namelist()}
    described = set(re.findall(r"`([^`\n]*)`", page))
    assert {*document, *document["components"][0]} <= described
    assert entries <= {name.partition("/")[0] for name in described}
