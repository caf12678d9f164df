"""results.csv and results.parquet: exact numbers, headers with units, the same bytes each time, and fast."""

from __future__ import annotations

import csv
import json
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cosim.engine import Result
from cosim.report import write_csv, write_parquet

HEADER = [
    "time [s]",
    "plant.i_motor [A]",
    "plant.park [1]",
    "plant.phi_crank [rad]",
    "plant.tau_crank [N.m]",
    "plant.phi_ds [rad]",
    "plant.w_ds [rad/s]",
    "controller.duty [1]",
    "controller.state [1]",
    "controller.i_filtered [A]",
    "controller.i_limit [A]",
]


def test_header_rows_and_line_ends(result: Result, tmp_path: Path) -> None:
    write_csv(result, tmp_path / "results.csv")
    text = (tmp_path / "results.csv").read_bytes().decode()
    assert "\r" not in text
    assert '"' not in text
    assert text.endswith("\n")
    rows = list(csv.reader(text.splitlines()))
    assert rows[0] == HEADER
    assert len(rows) == 1 + 1001
    assert (rows[1][0], rows[-1][0]) == ("0.0", "10.0")
    assert (rows[1][HEADER.index("plant.park [1]")], rows[1][HEADER.index("controller.state [1]")]) == ("1", "1")


def test_the_same_result_gives_the_same_bytes(result: Result, tmp_path: Path) -> None:
    for name in ("a.csv", "b.csv"):
        write_csv(result, tmp_path / name)
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()


@settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.floats(), min_size=1, max_size=40))
def test_numbers_are_what_repr_gives(tmp_path: Path, values: list[float]) -> None:
    array = np.array(values)
    write_csv(Result(np.arange(float(len(values))), {"a.x": array}), tmp_path / "x.csv")
    lines = (tmp_path / "x.csv").read_text().splitlines()
    assert lines[1:] == [f"{float(row)!r},{value!r}" for row, value in enumerate(values)]


@pytest.mark.parametrize(
    "edge", [1e-4, 9.999999999999999e-05, 1e16, 9999999999999998.0, 5e-324, 1.7976931348623157e308]
)
def test_numbers_at_the_edges_of_notations(tmp_path: Path, edge: float) -> None:
    write_csv(Result(np.array([0.0, 1.0]), {"a.x": np.array([edge, -edge])}), tmp_path / "x.csv")
    assert (tmp_path / "x.csv").read_text() == f"time [s],a.x [1]\n0.0,{edge!r}\n1.0,{-edge!r}\n"


def test_more_rows_than_are_written_at_once(tmp_path: Path) -> None:
    steps = np.linspace(0, 20, 20_001)
    squares = np.square(steps)
    write_csv(Result(steps, {"a.x": squares}), tmp_path / "x.csv")
    rows = np.loadtxt(tmp_path / "x.csv", delimiter=",", skiprows=1)
    assert np.array_equal(rows, np.column_stack([steps, squares]))


def test_a_name_with_a_comma_is_quoted(tmp_path: Path) -> None:
    write_csv(Result(np.array([0.0]), {"a.x[1,2]": np.array([1.0])}, {"a.x[1,2]": "V"}), tmp_path / "x.csv")
    assert (tmp_path / "x.csv").read_text() == 'time [s],"a.x[1,2] [V]"\n0.0,1.0\n'


def test_no_rows_is_a_header(tmp_path: Path) -> None:
    write_csv(Result(np.empty(0), {"a.x": np.empty(0)}), tmp_path / "x.csv")
    assert (tmp_path / "x.csv").read_text() == "time [s],a.x [1]\n"


def test_25_seconds_are_written_in_well_below_a_second(tmp_path: Path) -> None:
    """25,001 rows of 20 columns, every number with all its digits; measured 0.15 s, the bound leaves room for CI."""
    noise = np.random.default_rng(0).standard_normal((19, 25_001))
    columns = {f"plant.x{index}": row for index, row in enumerate(noise)}
    best = float("inf")
    for _ in range(3):
        started = time.perf_counter()
        write_csv(Result(np.linspace(0, 25, 25_001), columns), tmp_path / "x.csv")
        best = min(best, time.perf_counter() - started)
    assert best < 0.8


def test_parquet_has_the_same_columns_with_metadata(result: Result, tmp_path: Path) -> None:
    write_parquet(result, tmp_path / "x.parquet", {"complete": True, "parameters": {"plant.m": {"value": 1}}})
    frame = pd.read_parquet(tmp_path / "x.parquet")
    assert list(frame.columns) == HEADER
    assert np.array_equal(frame["plant.i_motor [A]"], result.columns["plant.i_motor"])
    assert frame["controller.state [1]"].dtype == np.int64
    schema = pq.read_schema(tmp_path / "x.parquet")
    assert schema.field("plant.w_ds [rad/s]").metadata == {b"unit": b"rad/s"}
    state = schema.field("controller.state [1]").metadata
    assert json.loads(state[b"literals"])[:2] == ["IDLE", "Soft_start"]
    assert json.loads(schema.metadata[b"cosim"]) == {"complete": True, "parameters": {"plant.m": {"value": 1}}}
