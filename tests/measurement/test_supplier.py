"""The supplier's workbooks against a literal transcription of the script in the source text."""

from __future__ import annotations

import math
import warnings
from pathlib import Path

import numpy as np
import pytest

from cosim.errors import InputError, MeasurementWarning
from cosim.measurement import Measurement, correlation_onset, moving_average, read, threshold_onset, zero_phase
from measurement.workbooks import SP, TP, Cell, Columns, extract_motor, made_up, write


def quietly(path: Path, **options: str) -> Measurement:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MeasurementWarning)
        return read(path, **options)  # type: ignore[arg-type]


def agrees(measurement: Measurement, columns: Columns) -> None:
    expected = extract_motor(columns)
    assert expected is not None
    assert measurement.meta["onset"] == expected.onset
    assert measurement.meta["current_peak"] == expected.A_max
    pairs = (("time", "t"), ("torque", "T"), ("speed", "S"), ("current", "A_avg"), ("voltage", "V_meas"))
    for column, name in (*pairs, ("current_instantaneous", "A_calc")):
        np.testing.assert_allclose(
            measurement.values(column), getattr(expected, name), rtol=0, atol=1e-12, equal_nan=True, err_msg=column
        )


@pytest.mark.parametrize("seed", range(5))
def test_a_workbook_gives_what_the_script_gives(tmp_path: Path, seed: int) -> None:
    columns = made_up(start=250 + 20 * seed, seed=seed)
    measurement = read(write(tmp_path / "Dry Glass Cold Motor LS.xlsx", columns))
    agrees(measurement, columns)
    meta = measurement.meta
    assert (meta["glass"], meta["motor"], meta["speed"]) == ("dry", "cold", "LS")
    assert meta["torque_line"] == TP and meta["speed_line"] == SP and not meta["synthetic"]
    assert measurement.name == "dry glass, cold motor, low speed"
    assert measurement.sample_time == pytest.approx(0.002)


def test_cells_without_a_number_are_treated_as_the_script_does(tmp_path: Path) -> None:
    """The torque becomes zero before the onset is looked for, the speed stays undefined."""
    columns = made_up()
    holes: list[Cell] = [*columns.A_avg]
    for k in (5, 290, 301, 700, 701, 1100):
        holes[k] = None
    holes[900] = "overflow"
    columns = columns._replace(A_avg=holes)
    path = write(tmp_path / "x.xlsx", columns)
    with pytest.warns(MeasurementWarning) as caught:
        measurement = read(path)
    agrees(measurement, columns)
    assert [str(w.message) for w in caught] == [
        f"{path}: text where a number is expected, in G902 ('overflow'): not a number",
        f"{path}: empty cells in G7, G292, G303 and 3 more: not a number",
        f"{path}: column G (averaged current) is not a number in row 7, 292, 303 and 4 more: a torque of zero is taken "
        "there",
    ]
    undefined = [k for k in (290, 301, 700, 701, 900, 1100) if k >= measurement.meta["onset"]]
    assert (np.flatnonzero(np.isnan(measurement.values("speed"))) + measurement.meta["onset"]).tolist() == undefined
    mended = quietly(path, missing="interpolate")
    assert not np.isnan(mended.values("speed")).any()
    first = mended.meta["onset"]
    middle = (holes[699] + (holes[702] - holes[699]) / 3 - TP[1]) / TP[0]  # type: ignore[operator]
    start = (columns.A_avg[first] - TP[1]) / TP[0]  # type: ignore[operator]
    assert mended.values("torque")[700 - first] == pytest.approx(middle - start, abs=1e-12)


def test_a_sample_whose_torque_is_exactly_zero_is_no_onset(tmp_path: Path) -> None:
    columns = made_up()
    at_rest: list[Cell] = [TP[1] if k < 310 else cell for k, cell in enumerate(columns.A_avg)]
    columns = columns._replace(A_avg=at_rest)
    measurement = read(write(tmp_path / "x.xlsx", columns))
    agrees(measurement, columns)
    assert measurement.meta["onset"] == 310


def test_rows_above_the_numbers_are_left_out(tmp_path: Path) -> None:
    """As xlsread does it: rows 1 and 2 of the numbers hold Tp and Sp, wherever in the sheet they stand."""
    columns = made_up()
    agrees(read(write(tmp_path / "none.xlsx", columns, [])), columns)
    agrees(read(write(tmp_path / "names.xlsx", columns, ["a", "b", "c", "", "", "", "averaged"])), columns)


def test_no_onset_is_refused_where_the_script_would_fail(tmp_path: Path) -> None:
    columns = made_up(start=2000)
    assert extract_motor(columns) is None
    path = write(tmp_path / "x.xlsx", columns)
    with pytest.raises(InputError) as caught:
        read(path)
    assert str(caught.value) == (
        f"{path}: no onset: in 1200 samples the torque never rises by 0.3 N.m within 100 samples (the script of the "
        "source text stops there with an index error); check the columns, or read it with the onset 'none'"
    )
    assert len(read(path, onset="none").frame) == 1200


def test_onset_too_late_for_the_script(tmp_path: Path) -> None:
    """A rise within the last hundred samples: the script would look beyond the end."""
    columns = made_up(count=600, start=590)
    assert extract_motor(columns) is None
    with pytest.raises(InputError, match="no onset"):
        read(write(tmp_path / "x.xlsx", columns))


def test_correlation_finds_the_onset_that_noise_hides_from_the_threshold() -> None:
    rng = np.random.default_rng(3)
    torque = np.concatenate((np.zeros(800), np.full(800, 6.0))) + 0.5 * rng.standard_normal(1600)
    early, exact = threshold_onset(torque), correlation_onset(torque)
    assert early is not None and early < 10  # a single low sample is 0.3 below any mean
    assert exact is not None and abs(exact - 800) <= 2
    assert correlation_onset(np.zeros(500)) is None and correlation_onset(torque[:150]) is None


def test_the_moving_average_is_late_by_27_samples_the_zero_phase_filter_is_not() -> None:
    k = np.arange(4000)
    wave = np.sin(2 * np.pi * k / 400)
    # the corner of each of the two passes, of order 2
    corner = 0.443 / 55 / (np.sqrt(2) - 1) ** 0.25
    flat = 1.0 / (1.0 + (np.tan(np.pi / 400) / np.tan(np.pi * corner)) ** 4)
    for smoothed, delay, law in ((moving_average(wave), 27.0, np.sinc(55 / 400)), (zero_phase(wave), 0.0, flat)):
        expected = np.sin(2 * np.pi * (k - delay) / 400)[500:3500]
        gain = float(smoothed[500:3500] @ expected / (expected @ expected))
        assert gain == pytest.approx(law, abs=2e-4)
        np.testing.assert_allclose(smoothed[500:3500], gain * expected, atol=1e-9)
    literal = [sum(wave[max(0, i - 54) : i + 1]) / 55 for i in range(200)]
    np.testing.assert_allclose(moving_average(wave)[:200], literal, atol=1e-14)


def test_both_filters_lose_half_the_power_at_the_same_frequency() -> None:
    k = np.arange(20000)
    wave = np.sin(2 * np.pi * 0.443 / 55 * k)
    for smoothed in (moving_average(wave), zero_phase(wave)):
        assert np.std(smoothed[2000:-2000]) / np.std(wave) == pytest.approx(np.sqrt(0.5), rel=2e-3)


def refused(path: Path) -> str:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MeasurementWarning)
        with pytest.raises(InputError) as caught:
            read(path)
    return str(caught.value)


def cells(columns: Columns, name: str, *changes: tuple[int, Cell]) -> Columns:
    changed: list[Cell] = [*getattr(columns, name)]
    for k, cell in changes:
        changed[k] = cell
    return columns._replace(**{name: changed})


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        (made_up()._replace(Tp=(0.0, 1.0)), "J2 is 0; the current per torque [A/(N.m)] is expected there"),
        (made_up()._replace(Tp=(None, 1.0)), "J2 has nothing; the slope of current over torque is expected there"),
        (made_up()._replace(Sp=(1.0, "x")), "M3 has 'x'; the intercept of speed over torque is expected there"),
        (made_up()._replace(A_avg=[None] * 1200), "column G has no numbers"),
        (made_up(80, 10), "has 80 rows of numbers; more than 100 are needed to find the onset"),
        (
            cells(made_up(), "XYZ", (40, 39.0)),
            "row 42: the sample index in column B goes from 39 to 39; it must increase",
        ),
        (cells(made_up(), "XYZ", (0, None)), "column B has no sample index in row 2"),
        (
            made_up()._replace(XYZ=[0.002 * k for k in range(1200)]),
            "column B steps by 0.002; a sample index, which steps by 1, is expected there",
        ),
        (
            made_up()._replace(XYZ=made_up().A_calc, A_calc=made_up().XYZ),
            "a sample index, which steps by 1, is expected there; column C does: are the columns swapped?",
        ),
    ],
)
def test_what_cannot_be_used_is_refused_with_its_place(tmp_path: Path, columns: Columns, message: str) -> None:
    text = refused(write(tmp_path / "x.xlsx", columns))
    assert text.startswith(f"{tmp_path / 'x.xlsx'}: ") and message in text


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        (
            cells(made_up(), "XYZ", *((k, float(k + 7)) for k in range(600, 1200))),
            "the sample index in column B jumps at row 602 (by 8): samples are missing there",
        ),
        (
            cells(made_up(), "XYZ", (600, None)),
            "column B (sample index) is not a number in row 602: counted on from its neighbours",
        ),
        (
            made_up()._replace(A_calc=made_up().A_avg, A_avg=made_up().A_calc),
            "column G, the averaged current, is rougher than column C, the current: they may be swapped",
        ),
        (
            made_up()._replace(A_calc=made_up().V_meas, V_meas=made_up().A_calc),
            "the voltage, 1.",
        ),
    ],
)
def test_what_looks_wrong_is_said(tmp_path: Path, columns: Columns, message: str) -> None:
    with pytest.warns(MeasurementWarning) as caught:
        read(write(tmp_path / "x.xlsx", columns))
    assert any(message in str(w.message) for w in caught)


def test_missing_samples_keep_their_time(tmp_path: Path) -> None:
    columns = cells(made_up(), "XYZ", *((k, float(k + 7)) for k in range(600, 1200)))
    measurement = quietly(write(tmp_path / "x.xlsx", columns))
    agrees(measurement, columns)
    assert np.diff(measurement.values("time")).max() == pytest.approx(0.016)


def test_the_torque_that_has_been_subtracted_is_kept(tmp_path: Path) -> None:
    """The source makes the torque zero at the onset, where its line gives about -a/b if the motor stands still."""
    columns = made_up()
    path = write(tmp_path / "x.xlsx", columns)
    for onset in ("threshold", "correlation", "none"):
        measurement = quietly(path, onset=onset)
        by_the_line = (measurement.values("current") - TP[1]) / TP[0]
        restored = measurement.values("torque") + measurement.meta["torque_at_onset"]
        np.testing.assert_allclose(restored, by_the_line, rtol=0, atol=1e-12)


def changed(path: Path, cells: dict[str, object]) -> Path:
    """A good workbook with some other cells; its first row of numbers is row 2."""
    import openpyxl

    write(path, made_up(400, 150))
    book = openpyxl.load_workbook(path)
    for place, value in cells.items():
        book.active[place] = value
    book.save(path)
    return path


def test_merged_titles_units_dates_and_empty_rows_do_no_harm(tmp_path: Path) -> None:
    import datetime

    import openpyxl

    columns = made_up(400, 150)
    path = write(tmp_path / "x.xlsx", columns)
    book = openpyxl.load_workbook(path)
    sheet = book.active
    sheet.insert_rows(1, 3)
    sheet["A1"], sheet["E1"], sheet["A3"] = "Prüfstand", datetime.date(2019, 3, 1), "[V]"
    sheet.merge_cells("A1:C1")
    sheet["G420"] = " "
    book.save(path)
    agrees(read(path), columns)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({f"G{k}": f"=C{k}" for k in range(2, 402)}, "column G has no numbers; if it has formulas, save the workbook"),
        (
            {f"G{k}": "1,5" for k in range(2, 402)},
            "column G has no numbers but text such as G2 ('1,5'); turn it into numbers in the spreadsheet",
        ),
        (
            {"B1": 500},
            "J1 has 'Tp'; the slope of current over torque is expected there, row 1 being the first one with a number",
        ),
        (
            {"A402": "mean", "G402": 3.0},
            "column B has no sample index in row 402; delete rows at the beginning or end that are no samples",
        ),
        ({"G50": 1e300}, "G50 has 1e+300; no measured value is that large"),
        ({"J2": 1e-300}, "the lines of columns J and M, 1e-300 and 0.82, -0.42 and 36.5, are not those of a motor"),
        (
            {"XFD1048576": 1},
            "xl/worksheets/sheet1.xml has a cell XFD1048576, far from the layout's A1:N50001; delete the rows and",
        ),
    ],
)  # fmt: skip
def test_odd_workbooks_are_refused_with_place_and_remedy(
    tmp_path: Path, changes: dict[str, object], message: str
) -> None:
    assert refused(changed(tmp_path / "x.xlsx", changes)).startswith(f"{tmp_path / 'x.xlsx'}: {message}")


def test_cells_beyond_the_last_column_are_not_left_out_in_silence(tmp_path: Path) -> None:
    path = changed(tmp_path / "x.xlsx", {"P3": 1, "P4": "x"})
    with pytest.warns(MeasurementWarning, match="2 rows have cells right of column N, which are not read"):
        read(path)


def test_what_is_no_workbook(tmp_path: Path) -> None:
    import openpyxl

    (tmp_path / "x.xlsx").write_bytes(b"PK\x03\x04 and then nothing")
    assert "x.xlsx: " in refused(tmp_path / "x.xlsx")
    book = openpyxl.Workbook()
    book.save(tmp_path / "empty.xlsx")
    assert refused(tmp_path / "empty.xlsx").endswith("the sheet 'Sheet' has no numbers in A1:N50001")
    assert refused(tmp_path / "none.xlsx").endswith("there is no such measurement")
    (tmp_path / "x.doc").write_bytes(b"")
    assert refused(tmp_path / "x.doc").endswith("'.doc' files cannot be read; accepted are .xlsx, .mat, .csv and .mf4")


def test_rows_beyond_the_layout_are_not_dropped_in_silence(tmp_path: Path) -> None:
    columns = made_up(50010, 300)
    path = write(tmp_path / "x.xlsx", columns)
    with pytest.warns(MeasurementWarning, match="10 rows below row 50001 are not read; the layout ends there"):
        measurement = read(path)
    assert measurement.meta["onset"] + len(measurement.frame) == 50000
    assert math.isclose(measurement.values("time")[-1], (49999 - measurement.meta["onset"]) * 0.002)
