"""Measurements in .mat, CSV and MDF files."""

from __future__ import annotations

import warnings
from pathlib import Path

import h5py
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.io import loadmat, savemat

from cosim.errors import InputError, MeasurementWarning
from cosim.measurement import read
from cosim.measurement._matlab5 import read_matlab5
from measurement.workbooks import SP, TP, extract_motor, made_up, write


def saved(version: str, path: Path, **changes: object) -> Path:
    """What the source's script saves, as MATLAB writes it: columns, in 7.3 the other way round."""
    columns = made_up()
    extracted = extract_motor(columns)
    assert extracted is not None
    variables: dict[str, object] = {
        name: np.array(getattr(extracted, name))[:, None] for name in ("V_meas", "A_calc", "A_avg", "t", "T", "S")
    }
    variables |= {"A_max": extracted.A_max, "XYZ": np.array(columns.XYZ)[:, None], "Tp": np.array(TP)[:, None]}
    variables |= {"Sp": np.array(SP)[:, None], **changes}
    variables = {name: value for name, value in variables.items() if value is not None}
    if version == "5":
        savemat(path, variables)
    else:
        with h5py.File(path, "w", userblock_size=512) as file:
            for name, value in variables.items():
                file[name] = np.atleast_2d(np.asarray(value)).T
    return path


@pytest.mark.parametrize("version", ["5", "7.3"])
def test_a_mat_file_holds_what_the_workbook_does(tmp_path: Path, version: str) -> None:
    book = read(write(tmp_path / "Wet Glass Warm Motor HS.xlsx", made_up()))
    mat = read(saved(version, tmp_path / "Wet Glass Warm Motor HScorrected.mat"))
    for column in book.frame.columns:
        np.testing.assert_allclose(mat.values(column), book.values(column), rtol=0, atol=1e-12)
    same = ("glass", "motor", "speed", "onset", "current_peak", "torque_line", "speed_line", "units", "synthetic")
    assert {key: mat.meta[key] for key in same} == {key: book.meta[key] for key in same}  # type: ignore[literal-required]
    assert mat.name == "wet glass, warm motor, high speed"


@pytest.mark.parametrize("compressed", [False, True])
def test_arrays_of_all_kinds_of_numbers_are_read_as_scipy_reads_them(tmp_path: Path, compressed: bool) -> None:
    rng = np.random.default_rng(4)
    kinds = ("f8", "f4", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8")
    arrays = {f"x_{kind}": (100 * rng.random((7, 3))).astype(kind) for kind in kinds}
    others = {"text": "abc", "structure": {"a": 1.0}, "imaginary": np.array([[1j]]), "scalar": 3.5, "empty": []}
    savemat(tmp_path / "x.mat", arrays | others, do_compression=compressed)
    found = read_matlab5(tmp_path / "x.mat")
    scipys = loadmat(tmp_path / "x.mat")
    assert set(found) == {*arrays, "scalar", "empty"}
    for name, values in found.items():
        np.testing.assert_array_equal(values, scipys[name])


@pytest.mark.parametrize("version", ["5", "7.3"])
def test_a_mat_file_that_lacks_something(tmp_path: Path, version: str) -> None:
    path = tmp_path / "x.mat"
    for changes, message in (
        ({"T": None}, "no variable T; it holds A_avg, A_calc, A_max, S, Sp, Tp, V_meas, XYZ, t"),
        ({"T": np.ones((7, 1))}, "T has 7 samples, t has"),
        ({"t": np.ones((1, 1))}, "t has 1 samples; at least two are needed"),
        ({"t": np.zeros((1100, 1))}, "t does not increase from sample 1 (0) to 2 (0)"),
    ):
        others = ("T", "S", "V_meas", "A_calc", "A_avg") if "t" in changes else ()
        as_long = {name: np.zeros_like(changes["t"]) for name in others}
        with pytest.raises(InputError) as caught:
            read(saved(version, path, **as_long, **changes))
        assert str(caught.value).startswith(f"{path}: {message}")


@pytest.mark.parametrize("version", ["5", "7.3"])
def test_a_mat_file_knows_what_the_script_has_subtracted(tmp_path: Path, version: str) -> None:
    book = read(write(tmp_path / "x.xlsx", made_up()))
    mat = read(saved(version, tmp_path / "x.mat"))
    assert mat.meta["torque_at_onset"] == pytest.approx(book.meta["torque_at_onset"], abs=1e-12)
    later = saved(version, tmp_path / "y.mat", t=7.0 + book.values("time")[:, None])
    np.testing.assert_allclose(read(later).values("time"), book.values("time"), atol=1e-12)


CSV = """\
# glass: wet
# motor: warm
# speed_step: HS
# torque: M [shaft]
time [ms];M [shaft] [kN.mm];plant.w_crank [rpm];i_motor [mA]
100;1,5;30;2500
102;2,5;;2600
104;3,5;32;2700
"""


def test_csv_with_units_a_mapping_and_gaps(tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    path.write_text(CSV)
    with pytest.warns(MeasurementWarning, match=r"the speed is missing in line 7: not a number there"):
        measurement = read(path, columns={"torque": "M [shaft]"})
    assert measurement.values("time").tolist() == pytest.approx([0.0, 0.002, 0.004])
    assert measurement.values("torque").tolist() == pytest.approx([1.5, 2.5, 3.5])
    np.testing.assert_allclose(measurement.speed(), [np.pi, np.nan, 32 * np.pi / 30], equal_nan=True)
    assert measurement.values("current").tolist() == pytest.approx([2.5, 2.6, 2.7])
    assert not measurement.has("voltage")
    assert measurement.name == "wet glass, warm motor, high speed"
    assert read_quietly(path).values("torque").tolist() == pytest.approx([1.5, 2.5, 3.5])


def read_quietly(path: Path) -> object:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MeasurementWarning)
        return read(path)


def test_a_result_of_a_run_reads_as_a_measurement(tmp_path: Path) -> None:
    path = tmp_path / "results.csv"
    path.write_text("time [s],plant.tau_crank [N.m],plant.w_crank [rad/s]\n0,1,2\n0.5,3,4\n")
    measurement = read(path)
    assert measurement.values("torque").tolist() == [1.0, 3.0] and measurement.speed().tolist() == [2.0, 4.0]
    path.write_text("time [s],plant.T_motor [N.m],plant.tau_crank [N.m]\n0,1,2\n0.5,3,4\n")
    assert read(path).values("torque").tolist() == [2.0, 4.0]  # that of the shaft, not that before the gear


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", ": an empty file; expected a header such as 'time [s],torque [N.m]' and rows below it"),
        ("time,x\n0,1\n1,2\n", ": no column for the torque or current among time, x; say which it is: write "
         "'# torque: time' above the header, or --measured-column 'torque=time'"),
        ("a,torque\n0,1\n", ": no column for the time among a, torque; say which it is: write '# time: a' "
         "above the header, or --measured-column 'time=a'"),
        ("time,torque [V]\n0,1\n1,2\n", ":1:2: the torque is in V: "),
        ("time,torque\n0,1\n1,x\n", ":3:2: 'x' in column 'torque' is not a number; "),
        ("time,torque\n0,1\n1,2\n0.5,2\n", ":4: the row has the time 0.5 s after 1 s; 'time' must increase"),
        ("time,torque\n0,1\n,2\n", ":3: the row has no time; 'time' must increase from row to row"),
        ("time,torque\n0,1\n", ":1: 1 rows are too few; at least two are needed"),
        ("# torque: M\ntime,torque\n0,1\n1,2\n", ": no column 'M' for the torque; there are time, torque"),
        ("time,a.torque,b.torque\n0,1,1\n1,2,2\n", ": 'a.torque' and 'b.torque' may both be the torque; say which it "
         "is: write '# torque: a.torque' above the header, or --measured-column 'torque=a.torque'"),
        ("# glass: damp\ntime,torque\n0,1\n1,2\n", ":1: glass: there is no 'damp'; accepted are dry, wet"),
        ("#synthetic: maybe\ntime,torque\n0,1\n1,2\n", ":1: synthetic: there is no 'maybe'; accepted are true, false"),
        ("# torque: a\ntime,a,a\n0,1,1\n1,2,2\n", ": several columns are called 'a'"),
    ],
)  # fmt: skip
def test_csv_that_cannot_be_used(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "x.csv"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        read(path)
    assert str(caught.value).startswith(f"{path}{message}")


def test_mdf(tmp_path: Path) -> None:
    asammdf = pytest.importorskip("asammdf")
    time = np.linspace(10.0, 12.0, 201)
    coarse = time[::10]
    signals = [
        asammdf.Signal(np.sin(time), time, name="Motor torque", unit="N.m"),
        asammdf.Signal(1000.0 * time, time, name="plant.i_motor", unit="mA"),
        asammdf.Signal(60.0 * coarse, coarse, name="speed", unit="rpm"),
    ]
    with asammdf.MDF() as mdf:
        mdf.append(signals[:2])
        mdf.append(signals[2:])
        path = Path(mdf.save(tmp_path / "x.mf4"))
    measurement = read(path)
    np.testing.assert_allclose(measurement.values("time"), time - 10.0, atol=1e-12)
    np.testing.assert_allclose(measurement.values("torque"), np.sin(time))
    np.testing.assert_allclose(measurement.values("current"), time)
    np.testing.assert_allclose(measurement.speed(), 2 * np.pi * time, rtol=1e-12)
    with pytest.raises(InputError, match=r"x.mf4: no channel 'M'; there are Motor torque, plant.i_motor, speed"):
        read(path, columns={"torque": "M"})


def test_gaps_and_empty_channels_of_mdf(tmp_path: Path) -> None:
    asammdf = pytest.importorskip("asammdf")
    time, torque = np.arange(5) / 10.0, np.array([0.0, 1.0, np.nan, 3.0, 4.0])

    def written(name: str, *signals: object) -> Path:
        with asammdf.MDF() as mdf:
            for signal in signals:
                mdf.append([signal])
            return Path(mdf.save(tmp_path / name))

    path = written("gap.mf4", asammdf.Signal(torque, time, name="torque"))
    with pytest.warns(MeasurementWarning, match=r"gap.mf4: the torque is missing at 0.2 s: not a number there"):
        np.testing.assert_array_equal(read(path).values("torque"), torque)
    nothing = asammdf.Signal(np.empty(0), np.empty(0), name="speed")
    path = written("none.mf4", asammdf.Signal(time, time, name="torque"), nothing)
    with pytest.raises(InputError, match=r"none.mf4: the channel 'speed' has no samples"):
        read(path)


def test_the_columns_of_a_workbook_are_fixed(tmp_path: Path) -> None:
    path = write(tmp_path / "x.xlsx", made_up())
    with pytest.raises(InputError, match=r"the columns of .xlsx files are fixed"):
        read(path, columns={"torque": "G"})


VALUES = st.one_of(st.none(), st.floats(), st.integers(-5, 5), st.text(max_size=4), st.booleans())


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.lists(VALUES, max_size=15), max_size=130), st.booleans())
def test_no_workbook_ends_in_a_traceback(tmp_path: Path, rows: list[list[object]], below: bool) -> None:
    """Whatever the cells hold, alone or in place of the first rows of a good workbook."""
    import openpyxl
    from openpyxl.utils.exceptions import IllegalCharacterError

    book = openpyxl.Workbook(write_only=True)
    sheet = book.create_sheet("x")
    good = made_up(150, 20)
    try:
        for k in range(150 if below else len(rows)):
            usual: list[object] = [None] * 14
            for position, cells in zip((0, 1, 2, 6), good[:4], strict=True):
                usual[position] = cells[k] if k < 150 else None
            usual[9], usual[12] = (TP[k], SP[k]) if k < 2 else (None, None)
            sheet.append(rows[k] if k < len(rows) else usual)
        book.save(tmp_path / "x.xlsx")
    except (IllegalCharacterError, ValueError):
        return  # not even a workbook can hold this
    readable(tmp_path / "x.xlsx")


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.tuples(st.integers(0, 6000), st.integers(0, 255)), min_size=1, max_size=12), st.sampled_from("xmh"))
def test_no_damaged_file_ends_in_a_traceback(tmp_path: Path, changes: list[tuple[int, int]], kind: str) -> None:
    name = {"x": "good.xlsx", "m": "good.mat", "h": "good_too.mat"}[kind]
    path = tmp_path / name
    if not path.exists():
        write(path, made_up(150, 20)) if kind == "x" else saved("5" if kind == "m" else "7.3", path)
    data = bytearray(path.read_bytes())
    for place, value in changes:
        data[place % len(data)] = value
    damaged = tmp_path / f"damaged{path.suffix}"
    damaged.write_bytes(data)
    readable(damaged)


@settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.one_of(
        st.binary(max_size=300),
        st.text(alphabet="time,torque;[]N.m#:\n-0123456789eE nan", max_size=300).map(str.encode),
    )
)
def test_no_text_ends_in_a_traceback(tmp_path: Path, data: bytes) -> None:
    path = tmp_path / "x.csv"
    path.write_bytes(data)
    readable(path)


def readable(path: Path) -> None:
    """It is read, or refused in words that begin with its name."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            measurement = read(path)
        except InputError as error:
            assert str(error).startswith(str(path))
        else:
            assert len(measurement.frame) >= 2
