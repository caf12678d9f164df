"""A run's folder: the summary, the plots, and that nothing of an earlier run stays."""

from __future__ import annotations

import json
import subprocess
import sys
import warnings
from importlib.metadata import PackageNotFoundError
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cosim import __version__
from cosim.engine import Channel, Result, System
from cosim.errors import InputError
from cosim.report import Run, plot, replacing, summarize, write

RUN = Run(stop=10.0, output_interval=0.01, tolerance=1e-6, title="A run", scenario="x.csv")
PNG = b"\x89PNG"


def test_the_summary(result: Result, system: System) -> None:
    summary = summarize(result, system, RUN)
    assert {key: summary[key] for key in ("title", "scenario", "complete", "message")} == {
        "title": "A run",
        "scenario": "x.csv",
        "complete": True,
        "message": None,
    }
    assert (summary["stop"], summary["reached"], summary["rows"]) == (10.0, 10.0, 1001)
    assert (summary["output_interval"], summary["tolerance"]) == (0.01, 1e-6)
    assert (summary["wall_s"], summary["real_time_factor"], summary["exchanges"]) == (0.5, 20.0, 10001)
    assert (summary["solver_steps"], summary["rejected_steps"], summary["events"]) == (12345, 6, 10008)
    assert summary["enumerations"] == {
        "controller.state": ["IDLE", "Soft_start", "RUN", "turn_point_dec", "turn_point_acc", "Soft_stop"]
    }
    assert summary["components"]["plant"] == {  # type: ignore[index]
        "fmu": "LinkagePlant.fmu",
        "model": "LinkagePlant",
        "fmi_version": "3.0",
        "sha256": "L" * 64,
        "generation_tool": "cosim",
        "role": "continuous",
        "do_steps": 10001,
        "solver": {"steps": 12345, "rejected_steps": 6, "state_events": 7, "time_events": 0},
    }
    assert summary["versions"]["cosim"] == __version__  # type: ignore[index]


def test_every_parameter_has_value_unit_and_provenance(result: Result, system: System) -> None:
    assert summarize(result, system, RUN)["parameters"] == {
        "plant.ext_load": {"value": 4.0, "unit": "N.m", "provenance": "set by the user", "set": True},
        "plant.J_rotor": {"value": 1e-4, "unit": "kg.m2", "provenance": "[A] 70 W-class motor", "set": False},
        "plant.i_max": {"value": "inf", "unit": "A", "provenance": None, "set": False},
        "controller.T_sample": {"value": 0.02, "unit": "s", "provenance": "[S] 3.5", "set": False},
    }


def test_a_parameter_that_was_set_names_what_set_it(result: Result, system: System) -> None:
    system.components[0].origins["ext_load"] = "set by --set"
    parameters: Any = summarize(result, system, RUN)["parameters"]
    assert parameters["plant.ext_load"]["provenance"] == "set by --set"


def test_versions_are_those_of_all_that_makes_the_numbers(
    result: Result, system: System, monkeypatch: pytest.MonkeyPatch
) -> None:
    def version(package: str) -> str:
        if package == "rumoca":
            raise PackageNotFoundError
        return f"{package} 1"

    monkeypatch.setattr("cosim.report._summary.version", version)
    versions: Any = summarize(result, system, RUN)["versions"]
    assert set(versions) == {"cosim", "python", "platform", "fmpy", "numpy", "pyarrow", "casadi", "ziglang"}


def test_the_summary_without_statistics(system: System) -> None:
    summary = summarize(Result(np.empty(0), {}, complete=False, message="it failed"), system, RUN)
    assert (summary["complete"], summary["message"], summary["reached"]) == (False, "it failed", 0.0)
    assert (summary["wall_s"], summary["real_time_factor"], summary["solver_steps"]) == (None, None, None)


def test_a_folder(result: Result, system: System, tmp_path: Path) -> None:
    summary = write(result, system, RUN, tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "detail.png",
        "motion.png",
        "others.png",
        "overview.png",
        "results.csv",
        "results.parquet",
        "summary.json",
    ]
    assert json.loads((tmp_path / "summary.json").read_text()) == summary


def test_a_failed_run_keeps_its_rows_and_is_marked(result: Result, system: System, tmp_path: Path) -> None:
    result.complete, result.message = False, "the simulation failed at t = 10 s"
    write(result, system, RUN, tmp_path, plots=False)
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert (summary["complete"], summary["message"]) == (False, "the simulation failed at t = 10 s")
    assert len((tmp_path / "results.csv").read_text().splitlines()) == 1 + 1001


def test_only_the_files_of_an_earlier_run_make_room(result: Result, system: System, tmp_path: Path) -> None:
    folder = tmp_path / "results" / "x"
    with replacing(folder):
        assert list(folder.iterdir()) == []
    write(result, system, RUN, folder)
    (folder / "notes.txt").touch()
    with replacing(folder):
        assert not (folder / "results.csv").exists()
    assert [path.name for path in folder.iterdir()] == ["notes.txt"]


def test_what_is_refused_puts_back_what_was_there(result: Result, system: System, tmp_path: Path) -> None:
    write(result, system, RUN, tmp_path)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    with pytest.raises(InputError), replacing(tmp_path):
        raise InputError("the step is no step")
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_a_folder_that_cannot_be_made(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(InputError) as error, replacing(tmp_path / "file" / "x"):
        pass
    assert str(error.value) == (
        f"{tmp_path / 'file' / 'x'}: cannot write results there: Not a directory; choose another --out"
    )


def test_plots_of_a_drive(result: Result, tmp_path: Path) -> None:
    paths = plot(result, tmp_path, "A run")
    assert [path.name for path in paths] == ["overview.png", "detail.png", "motion.png", "others.png"]
    assert all(path.read_bytes().startswith(PNG) for path in paths)


def test_a_short_run_has_no_detail(result: Result, tmp_path: Path) -> None:
    short = Result(result.time[:500], {name: values[:500] for name, values in result.columns.items()})
    assert "detail.png" not in [path.name for path in plot(short, tmp_path)]


def test_plots_of_any_other_system(tmp_path: Path) -> None:
    time = np.linspace(0, 1, 11)
    columns = {f"tank.h{index}": time * index for index in range(9)} | {"tank.q": time, "tank.n": time.astype(int)}
    units = {name: "m" for name in columns if ".h" in name} | {"tank.q": "strange/unit/here"}
    assert [path.name for path in plot(Result(time, columns, units), tmp_path)] == ["overview.png"]


def test_odd_titles_names_and_values_are_drawn(tmp_path: Path) -> None:
    time = np.linspace(0, 1, 11)
    odd = np.array([np.nan, np.inf, -np.inf, 1e308, -1e308, 0, 1, 2, 3, 4, 5])
    columns = {"a.$x$_{": time, "a.inf": odd, "a.nan": np.full(11, np.nan)}
    with warnings.catch_warnings():
        warnings.simplefilter("error", UserWarning)
        assert len(plot(Result(time, columns), tmp_path, "from $5 to $6_{ \u96e8")) == 1


def test_nothing_to_draw(tmp_path: Path) -> None:
    assert plot(Result(np.array([0.0]), {"a.x": np.array([1.0])}), tmp_path) == []
    assert plot(Result(np.array([0.0, 1.0]), {}), tmp_path) == []


def test_plots_and_parquet_are_imported_only_when_used() -> None:
    code = "import sys, cosim.report; assert not {'matplotlib', 'pyarrow', 'pandas'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_the_summary_tells_what_holding_a_linear_channel_errs(result: Result, system: System) -> None:
    ramp = Channel(("plant", "v_supply"), [0.0, 1.0, 1.0, 3.0], [28.0, 28.0, 24.0, 6.0], linear=True)
    held = Channel(("plant", "duty"), [0.0, 1.0], [0.0, 1.0])
    driven = System(system.components, [], [ramp, held])
    summary = summarize(result, driven, Run(stop=3.0, output_interval=0.1, tolerance=1e-6))
    # 18 V in 2 s are 0.9 V in 0.1 s, of which the middle is at most half away; the step at 1 s is exact
    held_for, error = 0.1, pytest.approx(0.45)
    assert summary["linear_channels"] == {"plant.v_supply": {"held_for_s": held_for, "largest_input_error": error}}
