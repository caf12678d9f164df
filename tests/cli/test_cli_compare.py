"""``cosim compare``: a result beside measurements; figures, verdict and exit code."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from typer.testing import Result

from cosim import engine
from cosim.report import write_parquet

Cosim = Callable[..., Result]
SPEED = 5.0
TIME = np.arange(0.0, 12.0, 0.002)


def torque(time: np.ndarray) -> np.ndarray:
    return np.asarray((1 - np.exp(-4 * time)) * (12 + 6 * np.sin(2 * SPEED * time) + 2 * np.cos(SPEED * time)))


@pytest.fixture
def result(tmp_path: Path) -> Path:
    columns = {"plant.tau_crank": torque(TIME), "plant.phi_crank": SPEED * TIME, "plant.i_motor": torque(TIME)}
    run = engine.Result(TIME, columns, {"plant.tau_crank": "N.m", "plant.phi_crank": "rad", "plant.i_motor": "A"})
    (tmp_path / "x").mkdir()
    write_parquet(run, tmp_path / "x" / "results.parquet", {"complete": True})
    return tmp_path / "x"


def measured(path: Path, gain: float = 1.0, offset: float = 0.0, late: float = 0.0, synthetic: bool = False) -> Path:
    """The same motor, seen ``late`` seconds later, by a meter with a gain and an offset."""
    time = np.arange(0.0, 14.0, 0.002)
    seen = np.where(time < late, 0.0, torque(np.maximum(time - late, 0.0)))
    lines = [f"# synthetic: {str(synthetic).lower()}", "time [s],torque [N.m],speed [rad/s]"]
    lines += [f"{t!r},{(v - offset) / gain!r},{SPEED}" for t, v in zip(time.tolist(), seen.tolist(), strict=True)]
    path.write_text("\n".join(lines) + "\n")
    return path


def document(folder: Path) -> dict[str, object]:
    found = json.loads((folder / "comparison.json").read_text())
    assert isinstance(found, dict)
    return found


def test_a_result_compared_with_itself_has_no_error(cosim: Cosim, result: Path) -> None:
    done = cosim("compare", result, measured(Path("m.csv")), "--require", "--limit", "rmse_nm=1e-12")
    assert done.exit_code == 0, done.output
    found = document(result)
    for name in ("rmse_nm", "nrmse", "bias_nm", "peak_error_nm", "valley_error_nm", "lag_s", "offset_nm"):
        assert found[name] == pytest.approx(0.0, abs=1e-12), name
    for name in ("correlation", "gain", "coherence_mean", "envelope_inside"):
        assert found[name] == pytest.approx(1.0, abs=1e-6), name
    assert (found["tube_pass"], found["samples"], found["peak_timing_worst_s"]) == (True, len(TIME), 0.0)
    assert (result / "comparison_m.png").stat().st_size > 20000
    options = {"lag_most": 5.0, "start": 0.0, "stop": None, "tube_x": 0.05, "tube_y": 0.0, "tube_y_relative": 0.1}
    choices = {"align": "correlation", "quantity": "torque", "smoothing": "none", "torque_zero": "onset"}
    assert found["options"] == options | choices


def test_a_known_shift_gain_and_offset_are_found(cosim: Cosim, result: Path) -> None:
    """To one sample, 0.1 % and 1 mN.m."""
    path = measured(Path("m.csv"), gain=1.2, offset=0.35, late=0.274)
    assert cosim("compare", result, path, "--no-plots").exit_code == 0
    found = document(result)
    assert found["lag_s"] == pytest.approx(0.274, abs=0.002)
    assert found["gain"] == pytest.approx(1.2, rel=1e-3)
    assert found["offset_nm"] == pytest.approx(0.35, abs=1e-3)
    assert found["correlation"] == pytest.approx(1.0, abs=1e-9)


def test_over_the_crank_angle_a_slower_motor_is_the_same(cosim: Cosim, result: Path) -> None:
    time = np.arange(0.0, 20.0, 0.004)
    angle = 0.6 * SPEED * time + 1.0
    rows = [
        f"{t!r},{12 + 6 * np.sin(2 * a) + 2 * np.cos(a)!r},{0.6 * SPEED!r}" for t, a in zip(time, angle, strict=True)
    ]
    Path("slow.csv").write_text(
        "\n".join(["time,torque,speed [rad/s]", *(row.replace("np.float64(", "").replace(")", "") for row in rows)])
    )
    done = cosim("compare", result, "slow.csv", "--set", "align=angle", "--set", "start=2 s", "--no-plots")
    assert done.exit_code == 0, done.output
    found = document(result)
    assert found["correlation"] == pytest.approx(1.0, abs=1e-4)
    assert found["rmse_nm"] == pytest.approx(0.0, abs=0.05)
    period = 2 * np.pi / (0.6 * SPEED)
    # at 2 s the result is at 10 rad, the measurement at 7 rad: turned back by 3 rad, modulo one revolution
    assert found["lag_s"] == pytest.approx((3.0 / (2 * np.pi) % 1.0) * period, abs=period / 700)


def test_over_the_angle_a_start_up_does_not_count(cosim: Cosim, result: Path) -> None:
    """Neither in the figures nor in the envelope of the measurement, which would be too wide."""
    assert cosim("compare", result, measured(Path("m.csv"), offset=0.2), "--set", "align=angle", "--set", "start=3 s",
                 "--no-plots").exit_code == 0  # fmt: skip
    found = document(result)
    assert found["offset_nm"] == pytest.approx(0.2, abs=5e-3) and found["gain"] == pytest.approx(1.0, abs=1e-3)
    assert found["envelope_inside"] < 0.1


def test_speeds_that_differ_are_told(cosim: Cosim, result: Path) -> None:
    rows = [f"{t!r},{v!r},{0.9 * SPEED}" for t, v in zip(TIME.tolist(), torque(0.9 * TIME).tolist(), strict=True)]
    Path("slow.csv").write_text("\n".join(["time,torque,speed", *rows]) + "\n")
    done = cosim("compare", result, "slow.csv", "--set", "align=none", "--no-plots")
    turns = SPEED * TIME[-1] / (2 * np.pi)
    expected = (
        f"note: slow.csv: the crank makes {turns:.4g} revolutions in the result, {0.9 * turns:.4g} in the measurement "
        "meanwhile, so that the two drift apart; align=angle compares them over the crank angle"
    )
    assert expected in done.stdout
    assert "drift apart" not in cosim("compare", result, measured(Path("m.csv")), "--no-plots").stdout


def test_the_verdict_gives_the_exit_code(cosim: Cosim, result: Path) -> None:
    path = measured(Path("m.csv"), gain=1.5)
    assert cosim("compare", result, path, "--no-plots").exit_code == 0
    done = cosim(
        "compare", result, path, "--no-plots", "--require", "--limit", "bias_nm=1", "--limit", "correlation=0.9"
    )
    assert done.exit_code == 1
    first, second = done.stderr.splitlines()
    assert first.startswith("error: required, but not so: m.csv: the result leaves the tube for ")
    bias = torque(TIME).mean() * (1 - 1 / 1.5)
    assert second == f"error: required, but not so: m.csv: bias_nm is {bias:.5g}, at most 1 is required"
    wide = cosim("compare", result, path, "--no-plots", "--require", "--set", "tube_y=20 N.m")
    assert wide.exit_code == 0


def test_the_tube_is_as_high_as_its_quantity_says(cosim: Cosim, result: Path) -> None:
    path = Path("i.csv")
    rows = [f"{t!r},{v!r}" for t, v in zip(TIME.tolist(), (torque(TIME) + 0.5).tolist(), strict=True)]
    path.write_text("\n".join(["time,current [A]", *rows]) + "\n")
    common = ("compare", result, path, "--no-plots", "--require", "--set", "tube_y_relative=0", "--set")
    assert cosim(*common, "tube_y=600 mA", "--set", "quantity=current", "--set", "tube_x=0").exit_code == 0
    assert cosim(*common, "tube_y=400 mA", "--set", "quantity=current", "--set", "tube_x=0").exit_code == 1
    done = cosim(*common, "tube_y=1 N.m", "--set", "quantity=current")
    assert (done.exit_code, done.stderr) == (2, "error: --set tube_y=1 N.m: tube_y is in A\n")


def test_a_workbook_whose_torque_does_not_begin_at_zero(cosim: Cosim, result: Path) -> None:
    """The script subtracts the torque at the onset, -a/b of the line for a motor that stands still."""
    import openpyxl

    b, a = 0.125, 0.5
    before = 200
    current = np.concatenate((np.zeros(before), b * (torque(TIME) + 4.0) + a))
    book = openpyxl.Workbook(write_only=True)
    sheet = book.create_sheet("Data")
    for k, amperes in enumerate(current.tolist()):
        lines = [(b, -0.4), (a, 50.0)][k] if k < 2 else (None, None)
        sheet.append([24.0, k, amperes, None, None, None, amperes, None, None, lines[0], None, None, lines[1]])
    book.save("x.xlsx")
    difference = -a / b
    common = ("compare", result, "x.xlsx", "--no-plots", "--set", "start=0.1 s")
    done = cosim(*common)
    assert done.exit_code == 0, done.output
    assert "by the workbook's line it is -4 N.m there, which torque_zero=line takes into account" in done.stdout
    assert document(result)["offset_nm"] == pytest.approx(difference - 4.0, abs=0.1)
    done = cosim(*common, "--set", "torque_zero=line")
    assert "takes into account" not in done.stdout
    assert document(result)["offset_nm"] == pytest.approx(-4.0, abs=0.1)
    done = cosim("compare", result, measured(Path("m.csv")), "--set", "torque_zero=line", "--no-plots")
    assert done.exit_code == 0 and document(result)["bias_nm"] == pytest.approx(0.0, abs=1e-9)


def test_results_in_csv_and_a_column_by_option(cosim: Cosim, result: Path, tmp_path: Path) -> None:
    rows = [f"{t!r},{v!r}" for t, v in zip(TIME.tolist(), torque(TIME).tolist(), strict=True)]
    (tmp_path / "run.csv").write_text("\n".join(["time [s],plant.tau_crank [N.m]", *rows]) + "\n")
    Path("m.csv").write_text("\n".join(["time,shaft", *rows]) + "\n")
    done = cosim("compare", "run.csv", "m.csv", "--no-plots")
    assert (done.exit_code, done.stderr) == (
        2,
        "error: m.csv: no column for the torque or current among time, shaft; say which it is: write '# torque: time' "
        "above the header, or --measured-column 'torque=time'\n",
    )
    for run in ("run.csv", result / "results.parquet"):
        done = cosim("compare", run, "m.csv", "--measured-column", "torque=shaft", "--no-plots", "--out", "there")
        assert done.exit_code == 0, done.output
        assert document(Path("there"))["rmse_nm"] == pytest.approx(0.0, abs=1e-12)
    done = cosim("compare", "run.csv", "m.csv", "--measured-column", "torque")
    assert done.stderr == ("error: --measured-column torque: write quantity=name, such as --measured-column torque=M\n")


@pytest.mark.parametrize("kind", ["mat", "mf4"])
def test_other_kinds_of_measurements(cosim: Cosim, result: Path, kind: str) -> None:
    if kind == "mat":
        from scipy.io import savemat

        savemat("x.mat", {"t": TIME, "T": torque(TIME)})
    else:
        asammdf = pytest.importorskip("asammdf")
        with asammdf.MDF() as mdf:
            mdf.append([asammdf.Signal(1000.0 * torque(TIME), TIME, name="torque", unit="mN.m")])
            mdf.save("x.mf4")
    done = cosim("compare", result, f"x.{kind}", "--no-plots", "--require", "--limit", "rmse_nm=1e-9")
    assert done.exit_code == 0, done.output


def test_pictures_of_files_with_the_same_name(cosim: Cosim, result: Path) -> None:
    for folder in ("a", "b"):
        Path(folder).mkdir()
        measured(Path(folder, "m.csv"))
    assert cosim("compare", result, "a/m.csv", "b/m.csv").exit_code == 0
    assert sorted(path.name for path in result.glob("*.png")) == ["comparison_m.png", "comparison_m_2.png"]


def test_several_measurements_and_where_the_files_go(cosim: Cosim, result: Path, tmp_path: Path) -> None:
    paths = [measured(Path("dry glass cold motor ls.csv")), measured(Path("m.csv"), gain=1.1, synthetic=True)]
    done = cosim("compare", result, *paths, "--out", tmp_path / "there", "--json")
    assert done.exit_code == 0, done.output
    printed = json.loads(done.stdout)
    written = document(tmp_path / "there")
    assert printed["comparisons"] == written["comparisons"]
    first, second = printed["comparisons"]
    assert (first["measurement"], second["measurement"]) == ("dry glass, cold motor, low speed", "m.csv (synthetic)")
    assert second["synthetic"] and second["gain"] == pytest.approx(1.1, rel=1e-3)
    pictures = sorted(path.name for path in (tmp_path / "there").glob("*.png"))
    assert pictures == ["comparison_dry_glass_cold_motor_ls.png", "comparison_m.png"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ("m.csv", "--set", "align=phase"),
            "--set: align: there is no 'phase'; accepted are correlation, onset, ",
        ),
        (("m.csv", "--set", "quantity=current"), "m.csv: the current was not measured; there is torque, speed"),
        (("m.csv", "--set", "tube_x=-1 s"), "--set: tube_x: -1; a finite number, not negative, is expected"),
        (("m.csv", "--set", "start=3 s", "--set", "stop=2 s"), "--set: the part from 3 s to 2 s has no length"),
        (("m.csv", "--set", "start=50 s"), "x: 0 samples from 50 s to inf s; it lasts from 0 s to 11.998 s"),
        (("m.csv", "--limit", "rmse=1"), "--limit rmse: there is no such figure; there are rmse_nm, nrmse, bias_nm, "),
        (("missing.csv", "--limit", "rmse_a=1"), "--limit rmse_a: there is no such figure; there are rmse_nm, nrmse, "),
        (("m.csv", "--limit", "rmse_nm"), "--limit rmse_nm: write NAME=NUMBER, such as --limit rmse_nm=1.5 or "),
        (("n.csv",), "n.csv: there is no such measurement"),
    ],
)
def test_what_cannot_be_compared(cosim: Cosim, result: Path, arguments: tuple[str, ...], message: str) -> None:
    measured(Path("m.csv"))
    done = cosim("compare", result, *arguments)
    assert done.exit_code == 2
    assert done.stderr.startswith(f"error: {message}")
