"""Results from folders, files, tables and memory give the same signals; what cannot be read is refused in words."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from cosim.assessment import Rules, Trace, score, trace
from cosim.engine import Result
from cosim.errors import InputError
from cosim.report import write_csv, write_parquet

from .conftest import cycles, make

NAMES = ("IDLE", "Soft_start", "RUN", "turn_point_dec", "turn_point_acc", "Soft_stop")


@pytest.fixture
def result() -> Result:
    made = make(cycles([[(1.95, "Soft_stop")]] * 3), [0, 1.98, 3.98], 5.0)
    state = np.array([NAMES.index(name) + 1 for name in made.labels("state")])
    columns = {"controller.state": state, "plant.park": made.columns["plant.park"], "plant.i_motor": made.time * 1e3}
    return Result(made.time, columns, {"plant.i_motor": "mA"}, {"controller.state": NAMES})


def test_all_ways_to_hand_over_a_run_are_one(result: Result, tmp_path: Path) -> None:
    folder = tmp_path / "run"
    folder.mkdir()
    write_csv(result, folder / "results.csv")
    (folder / "summary.json").write_text(json.dumps({"enumerations": {"controller.state": NAMES}, "complete": True}))
    expected = score(result).counts
    assert expected.park_deceleration == 2
    assert score(folder).counts == expected
    assert score(folder / "results.csv").counts == expected
    (folder / "results.csv").unlink()
    write_parquet(result, folder / "results.parquet", {"complete": False})
    assert score(str(folder)).counts == expected
    assert (score(folder).name, score(folder).notes[0]) == (
        "run",
        "the run ended early: its result is marked incomplete",
    )
    assert trace(folder).signal("i_motor", "A") == pytest.approx(result.time)
    labels = np.array([f"RUN.{name}" if name == "RUN" else name for name in trace(result).labels("state").tolist()])
    table = pd.DataFrame({"time": result.time, "state": labels, "park": result.columns["plant.park"] == 1})
    assert score(table).counts == expected


def test_a_column_is_found_by_its_last_name_its_whole_name_or_an_alias() -> None:
    time = np.arange(3.0)
    columns = {"a.park": time, "b.park": time + 1, "c.x": time + 2}
    plain = Trace("t", time, columns)
    assert plain.column("x") == "c.x"
    assert plain.column("a.park") == "a.park"
    assert plain.column("y") is None
    with pytest.raises(InputError, match=r"t: several columns are called 'park': a.park, b.park; say which one"):
        plain.column("park")
    assert trace(Trace("t", time, columns, aliases={"park": "b.park"})).signal("park", "1")[0] == 1.0
    with pytest.raises(InputError, match=r"t: no column 'z' to take for 'park'; there are a\.park, b\.park, c\.x"):
        Trace("t", time, columns, aliases={"park": "z"})


def frame(**columns: object) -> pd.DataFrame:
    made = make(cycles([[(1.95, "Soft_stop")]]), [0], 1.5)
    base = {"time": made.time, "state": made.labels("state"), "park": made.columns["plant.park"]}
    return pd.DataFrame({name: values for name, values in (base | columns).items() if values is not None})


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (frame(time=None), r"no column 'time \[s\]'"),
        (frame(park=None), "no column 'park' nor 'component.park'; there are state; .* --column park=NAME"),
        (frame(state=None), "no column 'state' .* only a run with a controller that has the states of the voltage"),
        (frame(state=3), "the values of 'state' are numbers without names"),
        (frame(state="Cruise"), "the states Cruise are none of the voltage profile's: IDLE, Soft_start"),
        (frame(park="on"), "column 'park' holds something that is no number"),
        (frame(park=np.r_[np.ones(1500), np.nan]), "column 'park' is nan at 1.5 s, not a finite number"),
        (frame(time=np.zeros(1501)), "time must increase from row to row, but row 2 has 0.0"),
        (frame(time=np.arange(1501) * 0.02), r"rows are up to 0.02 s apart.*output_interval=1ms, at most 5 ms"),
        (frame().head(1), "1 rows are too few"),
    ],
)
def test_what_cannot_be_scored_is_refused_with_a_remedy(table: pd.DataFrame, message: str) -> None:
    with pytest.raises(InputError, match=message):
        score(table)


def test_a_unit_of_another_dimension_is_refused() -> None:
    table = trace(pd.DataFrame({"time [s]": [0.0, 1.0], "plant.i_motor [V]": [0.0, 1.0]}))
    with pytest.raises(InputError, match=r"column 'plant.i_motor' is in V, expected is A"):
        table.signal("i_motor", "A")


def test_values_beyond_the_names_of_an_enumeration_are_refused() -> None:
    with pytest.raises(InputError, match="'s' has values other than 1 to 2, of its 2 names"):
        Trace("t", np.arange(2.0), {"s": np.array([1, 3])}, literals={"s": ("a", "b")}).labels("s")


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("x.csv", b"\xff\xfe\x00", "not a CSV table that can be read"),
        ("x.parquet", b"PAR1", "not a Parquet file that can be read"),
        ("x.xlsx", b"", "results are read from .parquet and .csv files"),
    ],
)
def test_files_that_are_no_results_are_refused(name: str, content: bytes, message: str, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=message):
        trace(tmp_path / name)


def test_a_folder_without_results_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no results.parquet or results.csv in this folder; make it with cosim run"):
        trace(tmp_path)
    with pytest.raises(InputError, match="no such result; give a folder that cosim run wrote"):
        trace(tmp_path / "nothing")


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"span": 0.0}, "span 0.0 s: the length of what is scored must be positive"),
        ({"early": -0.1}, "early -0.1 s: a tolerance"),
        ({"late": float("nan")}, "late nan s"),
        ({"position": float("nan")}, "position nan: a share of a revolution"),
        ({"repeats": "sum"}, "repeats 'sum': accepted are grouped and separate"),
    ],
)
def test_rules_out_of_range_are_refused(wrong: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Rules(**wrong)  # type: ignore[arg-type]
