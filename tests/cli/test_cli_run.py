"""``cosim run``: what lands where, what is printed, and the exit codes."""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from typer.testing import Result

from cosim import engine
from cosim.cli import _run
from cosim.engine import SimulationInterrupted
from cosim.errors import BuildError, FmuWarning, InputError, SimulationError

Cosim = Callable[..., Result]
LINE = "x: 1 s in 0.25 s, 4 times real time; 3 exchanges; 40 solver steps; 0 events; results in {}\n"


def partial(error: BaseException, rows: int) -> BaseException:
    ramp = np.linspace(0, 1, rows)
    result = engine.Result(ramp, {"plant.i_motor": ramp}, complete=False, message=str(error))
    error.__dict__["result"] = result
    return error


@pytest.fixture
def fail(monkeypatch: pytest.MonkeyPatch) -> Callable[[BaseException], None]:
    def arrange(error: BaseException) -> None:
        def simulate(*_: object, **__: object) -> engine.Result:
            raise error

        monkeypatch.setattr(_run, "simulate", simulate)

    return arrange


def test_a_run(cosim: Cosim, scenario: Path, built: list[str], simulated: list[dict[str, object]]) -> None:
    done = cosim("run", scenario)
    assert (done.exit_code, done.stderr) == (0, "")
    assert done.stdout == LINE.format(Path("results/x"))
    assert sorted(path.name for path in Path("results/x").iterdir()) == [
        "overview.png",
        "results.csv",
        "results.parquet",
        "summary.json",
    ]
    assert Path("results/x/results.csv").read_text().splitlines()[:2] == ["time [s],plant.i_motor [A]", "0.0,0.0"]
    assert built == ["linkage"]
    asked = {"stop": 1.0, "output_interval": 0.001, "tolerance": 1e-6, "progress": None, "parameters": {}}
    isolation = {"isolate": "auto", "call_timeout": 60.0, "memory_limit": None}
    coupling = {"algorithm": "auto", "step": None, "extrapolation": None, "coupling_error": True}
    assert simulated == [asked | isolation | coupling]


def test_options(cosim: Cosim, scenario: Path, simulated: list[dict[str, object]]) -> None:
    settings = ("--set", "plant.ext_load=400 N.cm", "--set", "stop=2 s", "--set", "tolerance=1e-8")
    done = cosim("run", scenario, "--out", "elsewhere", "--no-plots", "--quiet", *settings)
    assert (done.exit_code, done.output) == (0, "")
    assert sorted(path.name for path in Path("elsewhere/x").iterdir()) == [
        "results.csv",
        "results.parquet",
        "summary.json",
    ]
    assert simulated[0]["parameters"] == {"ext_load": 4.0}
    assert (simulated[0]["stop"], simulated[0]["tolerance"]) == (2.0, 1e-8)


def test_json(cosim: Cosim, scenario: Path) -> None:
    done = cosim("run", scenario, "--json", "--no-plots")
    document = json.loads(done.stdout)
    assert (done.exit_code, done.stderr) == (0, "")
    assert document["exit_code"] == 0
    (run,) = document["runs"]
    assert (run["scenario"], run["exit_code"], run["message"]) == (str(scenario), 0, None)
    assert (run["folder"], run["notes"]) == (str(Path("results/x")), [])
    assert run["summary"] == json.loads(Path("results/x/summary.json").read_text())


def test_wrong_input_is_refused_before_the_run(
    cosim: Cosim, scenario: Path, simulated: list[dict[str, object]]
) -> None:
    scenario.write_text(scenario.read_text().replace("0,1", "0,one"))
    done = cosim("run", scenario)
    assert (done.exit_code, done.stdout) == (2, "")
    assert done.stderr == (
        f"error: {scenario}:6:2: 'one' in column 'duty [1]' is not a number; "
        "accepted are finite numbers such as 12, -0.5 or 3e-2, and an empty cell for 'unchanged'\n"
    )
    assert simulated == []
    assert not Path("results").exists()


def test_a_refusal_by_the_engine_names_the_file(
    cosim: Cosim, scenario: Path, fail: Callable[[BaseException], None]
) -> None:
    fail(InputError("there is no room"))
    done = cosim("run", scenario)
    assert (done.exit_code, done.stderr) == (2, f"error: {scenario}: there is no room\n")
    fail(InputError("there is no room", file="x.fmu"))
    assert cosim("run", scenario).stderr == "error: x.fmu: there is no room\n"


def test_an_unknown_plant(cosim: Cosim, scenario: Path) -> None:
    done = cosim("run", scenario, "--set", "system=linkgae")
    assert done.exit_code == 2
    assert done.stderr == f"error: {scenario}: no built-in plant or controller 'linkgae'\n"


def test_a_refused_run_keeps_the_results_of_an_earlier_one(cosim: Cosim, scenario: Path) -> None:
    """A slip of the pen must not cost what was computed; the summary says what the results are of."""
    folder = Path("results/x")
    assert cosim("run", scenario).exit_code == 0
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    assert cosim("run", scenario, "--set", "ext_load=4 V").exit_code == 2
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


def test_a_refused_run_makes_no_folder(cosim: Cosim, scenario: Path) -> None:
    assert cosim("run", scenario, "--set", "ext_load=4 V").exit_code == 2
    assert not Path("results").exists()


def test_an_option_that_does_not_fit(cosim: Cosim, scenario: Path) -> None:
    done = cosim("run", scenario, "--set", "ext_load=4 V")
    assert done.exit_code == 2
    assert done.stderr == "error: --set: '4 V' is in V, 'plant.ext_load' is in N.m; write for example 4 N.m\n"


def test_the_worst_code_counts_and_the_rest_runs(cosim: Cosim, scenario: Path, tmp_path: Path) -> None:
    good = tmp_path / "good.csv"
    good.write_text(scenario.read_text())
    done = cosim("run", tmp_path / "none.csv", good, "--no-plots", "--json")
    assert done.exit_code == 2
    assert done.stderr == f"error: {tmp_path / 'none.csv'}: there is no such scenario file\n"
    assert [run["exit_code"] for run in json.loads(done.stdout)["runs"]] == [2, 0]


def test_two_files_of_one_name(cosim: Cosim) -> None:
    done = cosim("run", "a/x.csv", "b/x.csv")
    assert done.exit_code == 2
    assert done.stderr == (
        f"error: {Path('a/x.csv')} and {Path('b/x.csv')} would both write into the folder 'x'; "
        "run them with different --out\n"
    )


def test_a_failed_simulation_keeps_its_rows(
    cosim: Cosim, scenario: Path, fail: Callable[[BaseException], None]
) -> None:
    fail(partial(SimulationError("the simulation failed at t = 1 s: plant: a step is too small"), 2))
    done = cosim("run", scenario)
    assert (done.exit_code, done.stdout) == (3, "")
    assert done.stderr == (
        f"error: {scenario}: the simulation failed at t = 1 s: plant: a step is too small; "
        f"what was computed before is in {Path('results/x')}, marked incomplete\n"
    )
    assert len(Path("results/x/results.csv").read_text().splitlines()) == 3
    summary = json.loads(Path("results/x/summary.json").read_text())
    assert (summary["complete"], summary["message"]) == (
        False,
        "the simulation failed at t = 1 s: plant: a step is too small",
    )


def test_a_failure_without_rows_leaves_nothing_of_an_earlier_run(
    cosim: Cosim, scenario: Path, fail: Callable[[BaseException], None]
) -> None:
    assert cosim("run", scenario, "--no-plots").exit_code == 0
    fail(SimulationError("plant: no start"))
    done = cosim("run", scenario)
    assert (done.exit_code, done.stderr) == (3, f"error: {scenario}: plant: no start\n")
    assert list(Path("results/x").iterdir()) == []


def test_an_interrupted_run_keeps_its_rows_and_stops_the_rest(
    cosim: Cosim, scenario: Path, tmp_path: Path, fail: Callable[[BaseException], None]
) -> None:
    nothing = engine.Result(np.empty(0), {})
    fail(partial(SimulationInterrupted("the simulation was interrupted at t = 1 s", nothing), 2))
    done = cosim("run", scenario, tmp_path / "never.csv")
    assert done.exit_code == 130
    assert done.stderr == (
        f"error: {scenario}: the simulation was interrupted at t = 1 s; "
        f"what was computed before is in {Path('results/x')}, marked incomplete\n"
    )


def test_ctrl_c_before_the_simulation(cosim: Cosim, scenario: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(_run, "read", interrupt)
    done = cosim("run", scenario)
    assert (done.exit_code, done.stderr) == (130, f"error: {scenario}: interrupted\n")


def test_a_build_that_fails(cosim: Cosim, scenario: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(name: str) -> Path:
        raise BuildError("the C compiler is missing; install wiper-cosim[build]")

    monkeypatch.setattr(_run, "locate", broken)
    done = cosim("run", scenario)
    assert (done.exit_code, done.stderr) == (3, "error: the C compiler is missing; install wiper-cosim[build]\n")


def test_a_sample_time_without_effect_is_noted(cosim: Cosim, scenario: Path) -> None:
    done = cosim("run", scenario, "--no-plots", "--set", "sample_time=10 ms")
    assert done.exit_code == 0
    assert done.stderr == f"note: {scenario}: 'sample_time' has no effect, there is no controller\n"


def test_results_that_cannot_be_written(cosim: Cosim, scenario: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(_run, "write", full)
    done = cosim("run", scenario)
    assert (done.exit_code, done.stderr) == (
        3,
        f"error: {Path('results/x')}: the results cannot be written: No space left on device; choose another --out\n",
    )


def test_explaining_the_timing_runs_nothing(
    cosim: Cosim, scenario: Path, simulated: list[dict[str, object]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_run, "explain_timing", lambda system, **asked: f"rows every {asked['output_interval']} s")
    done = cosim("run", scenario, "--explain-timing")
    assert (done.exit_code, done.stdout) == (0, f"{scenario}\n\nrows every 0.001 s\n\n")
    assert simulated == []
    assert not Path("results").exists()
    document = json.loads(cosim("run", scenario, "--explain-timing", "--json").stdout)
    assert document["runs"][0]["timing"] == "rows every 0.001 s"


def test_explaining_the_timing_of_a_wrong_scenario(cosim: Cosim, tmp_path: Path) -> None:
    wrong = tmp_path / "wrong.csv"
    wrong.write_text("# system: linkage\n", encoding="utf-8")
    done = cosim("run", wrong, "--explain-timing")
    assert done.exit_code == 2
    assert "wrong.csv" in done.stderr


def test_what_is_wrong_with_an_fmu_without_harm_is_told(
    cosim: Cosim, scenario: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = "x.fmu: modelDescription.xml has a byte order mark"

    assemble = _run.assemble

    def warned(*arguments: object) -> engine.System:
        warnings.warn(text, FmuWarning, stacklevel=2)
        return assemble(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(_run, "assemble", warned)
    done = cosim("run", scenario.name, "--no-plots")
    assert (done.exit_code, done.stderr) == (0, f"note: {text}\n")
    assert json.loads(cosim("run", scenario.name, "--no-plots", "--json").stdout)["runs"][0]["notes"] == [text]


def test_a_refused_run_leaves_the_results_of_the_one_before(
    cosim: Cosim, scenario: Path, tmp_path: Path, fail: Callable[[BaseException], None]
) -> None:
    assert cosim("run", scenario, "--out", tmp_path, "--no-plots").exit_code == 0
    folder = tmp_path / scenario.stem
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    assert "results.csv" in before
    fail(InputError("there is no step"))
    assert cosim("run", scenario, "--out", tmp_path, "--no-plots").exit_code == 2
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
    fail(SimulationError("it failed"))
    assert cosim("run", scenario, "--out", tmp_path, "--no-plots").exit_code == 3
    assert list(folder.iterdir()) == []
