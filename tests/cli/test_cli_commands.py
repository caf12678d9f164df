"""The other commands, the options common to all, and that starting up stays light."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
import typer
from typer.testing import Result

from cosim import __version__
from cosim.cli import main
from cosim.cli._screen import Screen, reporting

Cosim = Callable[..., Result]
HEAVY = {"casadi", "matplotlib", "pandas", "pyarrow", "pint", "rumoca", "scipy", "fmpy", "numpy", "rich.table"}


def test_build(cosim: Cosim) -> None:
    done = cosim("build")
    assert (done.exit_code, done.stdout) == (0, f"{Path('fmus/linkage.fmu')}\n{Path('fmus/rig.fmu')}\n")
    done = cosim("build", "LinkagePlant", "--out", "there", "--json")
    assert json.loads(done.stdout) == {"fmus": [str(Path("there/LinkagePlant.fmu"))]}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ("build", "linkgae"),
            "no built-in plant or controller 'linkgae'",
        ),
        (
            ("build", "--platform", "sparc"),
            "--platform sparc: no platform 'sparc'; there are host, all, x86_64-linux, aarch64-linux, x86_64-windows, "
            "x86_64-darwin, aarch64-darwin",
        ),
        (
            ("build", "--fmi", "1.0"),
            "--fmi 1.0: FMUs are built for FMI 3.0 or 2.0; accepted are 3.0, 2.0, both",
        ),
        (
            ("build", "--platform", "all,x86_64-linux"),
            "--platform all,x86_64-linux: 'all' stands alone; give it without others, or a list of x86_64-linux, "
            "aarch64-linux, x86_64-windows, x86_64-darwin, aarch64-darwin",
        ),
        (("check", "x.fmu", "--timeout", "30"), "--timeout 30: write a time above 0, such as '60 s' or '5 min'"),
        (("info", "x.fmu"), "x.fmu: there is no such FMU"),
        (("export", "x.mo", "P.M"), "x.mo: there is no such Modelica file or folder"),
    ],
)
def test_what_is_refused(cosim: Cosim, arguments: tuple[str, ...], message: str) -> None:
    done = cosim(*arguments)
    assert (done.exit_code, done.stdout, done.stderr) == (2, "", f"error: {message}\n")
    done = cosim(*arguments, "--json")
    assert done.exit_code == 2
    assert json.loads(done.stdout) == {"error": message, "exit_code": 2}


def test_export(cosim: Cosim) -> None:
    Path("x.mo").touch()
    done = cosim("export", "x.mo", "P.Model", "--out", "there")
    assert (done.exit_code, done.stdout) == (0, f"{Path('there/Model.fmu')}\n")
    done = cosim("export", "x.mo", "P.Model", "--explain")
    assert (done.exit_code, done.stdout) == (0, "explained: dae of P.Model\nModel.fmu\n")
    assert sys.modules["cosim.fmu"].compiled == ["P.Model", "P.Model"]  # once for each command
    done = cosim("export", "x.mo", "P.Model", "--explain", "--json")
    paths = {"fmu": "Model.fmu", "fmus": ["Model.fmu"]}
    assert json.loads(done.stdout) == paths | {"explanation": "explained: dae of P.Model", "warnings": []}


def test_a_doubtful_model_is_exported_with_one_warning(cosim: Cosim) -> None:
    Path("x.mo").touch()
    done = cosim("export", "x.mo", "P.Doubtful", "--explain")
    assert done.exit_code == 0
    assert done.stderr == "warning: x.mo:3:3: v = i: v is in V, but i is in A\n"
    assert cosim("export", "x.mo", "P.Doubtful", "--quiet").stderr == ""
    done = cosim("export", "x.mo", "P.Doubtful", "--json")
    assert json.loads(done.stdout)["warnings"] == ["x.mo:3:3: v = i: v is in V, but i is in A"]


def test_fmi_versions(cosim: Cosim) -> None:
    Path("x.mo").touch()
    assert cosim("build", "linkage", "--fmi", "2.0").stdout == f"{Path('fmus/linkage.fmi2.fmu')}\n"
    done = cosim("build", "linkage", "--fmi", "both")
    assert done.stdout == f"{Path('fmus/linkage.fmu')}\n{Path('fmus/linkage.fmi2.fmu')}\n"
    done = cosim("export", "x.mo", "P.Model", "--fmi", "both", "--json")
    assert json.loads(done.stdout)["fmus"] == ["Model.fmu", "Model.fmi2.fmu"]


def test_a_model_that_does_not_compile(cosim: Cosim) -> None:
    Path("x.mo").touch()
    done = cosim("export", "x.mo", "P.Wrong")
    assert (done.exit_code, done.stderr) == (2, "error: x.mo:7: an equation is missing\n")


@pytest.mark.parametrize("arguments", [("run",), ("run", "x.csv", "--nonsense"), ("nonsense",)])
def test_wrong_usage_is_wrong_input(cosim: Cosim, arguments: tuple[str, ...]) -> None:
    assert cosim(*arguments).exit_code == 2


def test_version_and_help(cosim: Cosim) -> None:
    assert cosim("--version").stdout == f"cosim {__version__}\n"
    shown = " ".join(cosim("--help").stdout.split())
    assert "Exit codes: 0 done, 1 a requirement is not met, 2 the input is wrong, 3 a build" in shown


def test_as_a_module() -> None:
    done = subprocess.run([sys.executable, "-m", "cosim", "--version"], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, f"cosim {__version__}\n")


def test_main_exits_with_the_code(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        main(["info", "nowhere.fmu"])
    assert end.value.code == 2
    assert capsys.readouterr().err == "error: nowhere.fmu: there is no such FMU\n"


def test_progress_shows_only_on_a_terminal_and_only_when_long(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with Screen(quiet=False, as_json=False).progress("x", 10.0) as move:
        assert move is None
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    monkeypatch.setenv("TERM", "xterm")
    with Screen(quiet=True, as_json=False).progress("x", 10.0) as move:
        assert move is None
    with Screen(quiet=False, as_json=False).progress("x", 10.0) as move:
        assert move is not None
        move(1.0)
    assert capsys.readouterr().err == ""
    monkeypatch.setattr("cosim.cli._screen._LONG_RUN", 0.0)
    with Screen(quiet=False, as_json=False).progress("a long run", 10.0) as move:
        assert move is not None
        move(2.0)
    assert "a long run" in capsys.readouterr().err


def test_ctrl_c_in_any_command(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(typer.Exit) as end, reporting(Screen(quiet=False, as_json=False)):
        raise KeyboardInterrupt
    assert end.value.exit_code == 130
    assert capsys.readouterr().err == "error: interrupted\n"


@pytest.mark.parametrize("arguments", [("--help",), ("run", "--help"), ("build", "--fmi", "1.0")])
def test_starting_up_imports_nothing_heavy(arguments: tuple[str, ...]) -> None:
    code = (
        "import sys, atexit\n"
        f"atexit.register(lambda: print('heavy:', sorted({HEAVY!r} & set(sys.modules)), flush=True))\n"
        f"from cosim.cli import main\nmain({list(arguments)!r})"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.stdout.splitlines()[-1] == "heavy: []"


def test_a_run_leaves_the_compiler_alone(tmp_path: Path) -> None:
    code = (
        "import sys\nimport cosim.cli._run\n"
        "heavy = {'casadi', 'matplotlib', 'pandas', 'pyarrow', 'pint', 'rumoca'} & set(sys.modules)\n"
        "assert not heavy, heavy"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=tmp_path)


@pytest.mark.parametrize(
    ("folder", "reason"), [("taken", "there is a file of this name already"), ("taken/fmus", "Not a directory")]
)
def test_a_path_that_cannot_be_used_is_a_message(
    cosim: Cosim, monkeypatch: pytest.MonkeyPatch, folder: str, reason: str
) -> None:
    """Whatever a command does with it: here the folder to build into is a file."""

    def build(*_: object, **__: object) -> list[Path]:
        Path(folder).mkdir(parents=True)
        return []

    Path("taken").touch()
    monkeypatch.setattr("cosim.cli._builtin.build_all", build)
    done = cosim("build", "--out", "taken", "--json")
    assert done.exit_code == 2
    message = f"{Path(folder)}: cannot be read or written: {reason}; give another path"
    assert done.stderr == f"error: {message}\n"
    assert json.loads(done.stdout) == {"error": message, "exit_code": 2}


@pytest.mark.parametrize("group", [(), ("measurements",)])
def test_help_tells_all_of_what_each_command_does(
    cosim: Cosim, monkeypatch: pytest.MonkeyPatch, group: tuple[str, ...]
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    commands = cosim(*group, "--help").stdout.partition("Commands:\n")[2].splitlines()
    assert commands
    assert not [line for line in commands if line.endswith("...")]
