"""What of a measurement is fitted, and how what is not determined is put into words."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cosim.calibration import Data, Direction, data_of
from cosim.calibration._data import distinct
from cosim.calibration._grid import intervals
from cosim.errors import InputError
from cosim.measurement import Measurement, read

SAMPLE = 0.002


def measured(folder: Path, torque: bool = False, affine: bool = False, without: str = "") -> Measurement:
    """A motor that is switched on after 0.5 s; the noise of the current is 0.05 A."""
    rng = np.random.default_rng(4)
    time = SAMPLE * np.arange(5000)
    on = time >= 0.5
    current = np.where(on, 2.0 + 8.0 * np.exp(-(time - 0.5) / 0.02), 0.0) + 0.05 * rng.standard_normal(len(time))
    columns = {"time [s]": time, "current [A]": current, "voltage [V]": np.full(len(time), 24.0)}
    if torque:
        columns["torque [N.m]"] = 6.0 * current + 1.0 if affine else 9.0 + np.sin(4.0 * time)
    columns = {name: values for name, values in columns.items() if not without or not name.startswith(without)}
    path = folder / "drive.csv"
    rows = zip(*columns.values(), strict=True)
    path.write_text("\n".join([",".join(columns), *(",".join(f"{v:.9g}" for v in row) for row in rows)]) + "\n")
    return read(path)


def test_the_fit_begins_where_the_motor_is_switched_on(tmp_path: Path) -> None:
    measurement = measured(tmp_path)
    data = data_of(measurement)
    assert data.time[0] == pytest.approx(0.5, abs=SAMPLE)
    assert data.time[-1] - data.time[0] == pytest.approx(7.0, abs=SAMPLE)
    assert data.from_rest
    assert data.noise[0] == pytest.approx(0.05, rel=0.1)
    # from a time before that it is the same, from a later one the motor runs already
    assert data_of(measurement, 0.2).time[0] == data.time[0]
    later = data_of(measurement, 1.0, 2.0)
    assert not later.from_rest
    assert (later.time[0], later.time[-1]) == pytest.approx((1.0, 2.0))


def test_a_torque_counts_unless_it_is_computed_from_the_current(tmp_path: Path) -> None:
    assert data_of(measured(tmp_path, torque=True)).torque is not None
    computed = data_of(measured(tmp_path, torque=True, affine=True))
    assert computed.torque is None
    assert computed.notes == ("drive.csv: the torque is computed from the current and tells nothing of its own",)


def test_what_cannot_be_fitted_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "drive.csv"
    with pytest.raises(InputError) as caught:
        data_of(measured(tmp_path, torque=True, without="current"))
    assert str(caught.value) == f"{path}: the current was not measured; current and voltage are needed to fit"
    with pytest.raises(InputError) as caught:
        data_of(measured(tmp_path, without="voltage"))
    assert str(caught.value) == f"{path}: the voltage was not measured; current and voltage are needed to fit"
    with pytest.raises(InputError) as caught:
        data_of(measured(tmp_path), 50.0)
    assert str(caught.value) == (
        f"{path}: 0 samples from 50 s to 57 s; 100 are needed (the measurement goes from 0 s to 9.998 s, "
        "the motor is on from 0.5 s)"
    )


def test_the_supply_is_smoothed_only_after_the_start() -> None:
    time = SAMPLE * np.arange(2000)
    rng = np.random.default_rng(1)
    supply = 24.0 - 3.0 * np.exp(-time / 0.004) + 0.02 * rng.standard_normal(len(time))
    data = Data("x", time, supply, supply, None, (1.0, 1.0), True)
    start, late = time < 0.02, time > 0.5
    assert data.supply_at(time)[start] == pytest.approx(supply[start])
    assert np.std(data.supply_at(time)[late] - 24.0) < 0.5 * np.std(supply[late] - 24.0)


def test_intervals_are_short_after_a_start_and_cover_the_window() -> None:
    rest, running = intervals(0.5, 2.0, True), intervals(0.5, 2.0, False)
    for borders in (rest, running):
        assert (borders[0], borders[-1]) == (0.5, 2.0)
        assert (np.diff(borders) > 0.0).all()
        assert np.diff(borders).max() <= 0.02 + 1e-12
    assert np.diff(rest)[0] == pytest.approx(0.0005)


def test_measurements_of_the_same_name_are_told_apart() -> None:
    empty = np.zeros(0)
    one = Data("dry glass", empty, empty, empty, None, (1.0, 1.0), False, source="a/one.xlsx")
    two, again = replace(one, source="b/two.xlsx"), replace(one, source="c/two.xlsx")
    assert [d.name for d in distinct([one, two])] == ["dry glass, one.xlsx", "dry glass, two.xlsx"]
    names = [d.name for d in distinct([one, two, again, replace(one, name="wet glass")])]
    assert names == ["dry glass, one.xlsx", "dry glass, two.xlsx [2]", "dry glass, two.xlsx [3]", "wet glass"]


@pytest.mark.parametrize(
    ("coefficients", "error", "expected"),
    [
        (
            {"a": 0.58, "b": 0.577, "c": 0.575, "d": 0.01},
            5.0,
            "cannot be told apart: a, b, c; scaling all by the same factor changes nothing that was measured "
            "(standard error 5 times the values)",
        ),
        (
            {"a": 0.9, "b": -0.45},
            2.0,
            "cannot be told apart: a, b; raising a by 1 % and lowering b by 0.5 % changes nothing that was measured "
            "(standard error 2 times the values)",
        ),
        (
            {"a": 1.0, "b": 0.01},
            0.4,
            "a is not determined: changing it changes what was measured only a little "
            "(standard error 0.4 times the values)",
        ),
    ],
)
def test_what_is_not_determined_is_said_in_words(coefficients: dict[str, float], error: float, expected: str) -> None:
    direction = Direction(coefficients, 1.0, error)
    assert not direction.determined
    assert direction.told() == expected
