"""Stand-in data: marked as such, in the supplier's layout, from known parameters; and what the table of a file says."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import openpyxl
import pytest

from cosim.engine import Fmu
from cosim.errors import InputError
from cosim.fmu import catalogue
from cosim.measurement import CONDITIONS, Errors, draw_smoothing, inspect, read, synthesize

ROWS = 3000


@pytest.fixture(scope="module")
def plant() -> Fmu:
    return Fmu.read(catalogue.ensure("linkage"))


@pytest.fixture(scope="module")
def books(plant: Fmu, tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    return synthesize(tmp_path_factory.mktemp("synthetic"), plant, rows=ROWS)


def test_eight_workbooks_of_the_layout_and_marked(books: list[Path]) -> None:
    assert len({path.name for path in books}) == 8
    for path, conditions in zip(books, CONDITIONS, strict=True):
        measurement = read(path)
        meta = measurement.meta
        assert (meta["glass"], meta["motor"], meta["speed"]) == (
            conditions.glass.lower(), conditions.motor.lower(), conditions.speed,
        )  # fmt: skip
        assert meta["synthetic"] and measurement.name.endswith("(synthetic)") and not meta["repairs"]
        assert meta["onset"] + len(measurement.frame) == ROWS
    book = openpyxl.load_workbook(books[0], read_only=True)
    assert book.sheetnames == ["Data", "Synthetic"]
    assert next(book["Synthetic"].iter_rows())[0].value == "SYNTHETIC DATA"
    rows = list(book["Data"].iter_rows(values_only=True))
    assert len(rows) == ROWS + 1
    filled = [k for k, cell in enumerate(rows[1]) if cell is not None]
    assert filled == [0, 1, 2, 6, 9, 12]  # columns A, B, C, G, J, M


def test_the_supplier_s_lines_tell_torque_and_speed_of_steady_running(plant: Fmu, books: list[Path]) -> None:
    """The motor's own balance: V = R i + k n w, within what the logger adds; its friction makes 0.58 A at no load."""
    for path, conditions in zip(books, CONDITIONS, strict=True):
        measurement, parameters = read(path), conditions.parameters()
        steady = measurement.values("time") > 1.0
        current, voltage = (measurement.values(name)[steady].mean() for name in ("current", "voltage"))
        speed = (voltage - parameters["motor.R"] * current) / (parameters["k_emf"] * 73.0)
        assert measurement.speed()[steady].mean() == pytest.approx(speed, rel=0.01)


def test_the_same_seed_gives_the_same_numbers_another_one_others(plant: Fmu, books: list[Path], tmp_path: Path) -> None:
    again = synthesize(tmp_path / "again", plant, rows=ROWS)
    other = synthesize(tmp_path / "other", plant, rows=ROWS, seed=2)
    assert read(again[3]).frame.equals(read(books[3]).frame)
    assert not read(other[3]).frame.equals(read(books[3]).frame)


def test_perfect_instruments_see_the_run_itself(plant: Fmu, tmp_path: Path) -> None:
    perfect = Errors(current_noise=0, current_offset=0, current_drift=0, current_step=1e-9, voltage_noise=0,
                     voltage_step=1e-9)  # fmt: skip
    measurement = read(synthesize(tmp_path, plant, rows=ROWS, errors=perfect)[0], onset="none")
    current, voltage = measurement.values("current_instantaneous"), measurement.values("voltage")
    np.testing.assert_allclose(voltage, perfect.supply - perfect.supply_resistance * current, atol=2e-3)
    average = [current[max(0, k - 49) : k + 1].sum() / 50 for k in range(len(current))]
    np.testing.assert_allclose(measurement.values("current"), average, atol=2e-6)


def test_what_cannot_be_made(plant: Fmu, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"^60000 rows; a workbook can have from 1000 to 50000$"):
        synthesize(tmp_path, plant, rows=60000)
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match=r"Dry Glass Cold Motor HS.xlsx: cannot be written: "):
        synthesize(tmp_path / "file", plant, rows=ROWS)


def test_the_difference_that_processing_makes(books: list[Path], tmp_path: Path) -> None:
    """The source's onset lies before the step by up to its window of 0.2 s; its average is late by 27 samples."""
    inspection = inspect(books[1])
    assert 0.1 < inspection.onset_difference <= 0.2
    assert inspection.delay == pytest.approx(27 * 0.002, abs=0.002)
    document = json.loads(json.dumps(inspection.to_dict()))
    assert document["synthetic"] and document["moving_average_delay_s"] == inspection.delay
    draw_smoothing(inspection.measurement, tmp_path / "x.png")
    assert (tmp_path / "x.png").stat().st_size > 20000
