"""What ``cosim thesis`` makes, against the source's figure 3.12 and table 4.1."""

from __future__ import annotations

import csv
import re
from dataclasses import asdict
from importlib.util import module_from_spec, spec_from_file_location
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from cosim.assessment import Rules, score
from cosim.engine import Fmu
from cosim.errors import InputError
from cosim.fmu import catalogue
from cosim.thesis import Reproduction, reproduce
from cosim.thesis._measured import read_measured
from cosim.thesis._readings import T_RAMP
from cosim.thesis._runs import profile_run, scenario_run
from cosim.thesis._table import PUBLISHED
from measurement.workbooks import Columns, write
from thesis.pages import differences

pytest.importorskip("rumoca")

SCENARIOS = Path(__file__).parents[2] / "scenarios"
DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Reproduction:
    return reproduce(tmp_path_factory.mktemp("results") / "thesis", SCENARIOS, catalogue.ensure)


def test_the_trajectory_of_figure_3_12_is_exact_at_its_corners() -> None:
    """With one tick of 1 ms after each of the chart's conditions that are strict (">"): it decides on whole ticks."""
    result = profile_run(catalogue.ensure)
    tick = 0.001
    corners = {
        0.0: 0.7, 0.1: 1.0, 0.9 + tick: 1.0, 1.0 + tick: 0.3, 1.1 + tick: 1.0, 1.9 + tick: 1.0, 2.0 + tick: 0.7,
    }  # fmt: skip
    duty = dict(zip(np.round(result.time, 6), result.columns["controller.duty"], strict=True))
    for start in (0.0, 2.0 + tick):
        within = {time: value for time, value in corners.items() if start + time <= result.time[-1]}
        assert {time: duty[round(start + time, 6)] for time in within} == pytest.approx(within, abs=1e-12)
    slopes = np.unique(np.round(np.diff(result.columns["controller.duty"]), 9))
    assert slopes == pytest.approx([-0.007, -0.003, 0.0, 0.003, 0.007], abs=1e-9)


def file(made: Reproduction, name: str) -> Path:
    (path,) = (path for path in made.files if path.name == name)
    return path


def table(made: Reproduction, name: str) -> list[dict[str, str]]:
    with file(made, name).open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def test_every_figure_is_a_picture(made: Reproduction) -> None:
    numbers = ("3_5", "3_6", "3_12", "4_8", *(f"4_{k}" for k in range(9, 19)))
    assert {f"figure_{number}.png" for number in numbers} | {"wiper_system.png"} <= {p.name for p in made.files}
    for path in made.files:
        assert path.stat().st_size > 0
        if path.suffix == ".png":
            assert path.read_bytes().startswith(b"\x89PNG")


def test_table_4_1_has_the_published_counts_beside_the_simulated_ones(made: Reproduction) -> None:
    lines = table(made, "table_4_1.csv")
    assert list(lines[0])[:9] == [
        "sample_time_s", "load", "park_literal", "park_deceleration", "park_total", "turn", "turn_total",
        "published_park", "published_turn",
    ]  # fmt: skip
    for line, run in zip(lines, made.rig, strict=True):
        assert (float(line["sample_time_s"]), line["load"]) == (run.sample_time, run.load)
        assert (line["published_park"], line["published_turn"]) == PUBLISHED[run.sample_time, run.load]
        counts = run.score.counts
        assert {key: int(line[key]) for key in asdict(counts)} == asdict(counts)
        chosen = score(run.result, Rules(early=0.1))
        assert int(line["park_chosen"]) == chosen.counts.park_deceleration
        assert int(line["park_chosen_without_first"]) == chosen.counts_without_first.park_deceleration
        assert int(line["park_total_without_first"]) == counts.park_total - 1


def test_a_reading_that_asks_for_less_counts_no_less(made: Reproduction) -> None:
    lines = table(made, "table_4_1_readings.csv")
    assert len(lines) == 10 * 2 * 3
    found = {(s["soft_stop"], s["sample_time_s"], s["load"], s["reading"]): int(s["park"]) for s in lines}
    for chart, sample_time, load, reading in found:
        if reading == "strict":
            strict, dip, answer = (found[chart, sample_time, load, name] for name in ("strict", "dip", "answer"))
            assert strict <= dip <= answer


def test_with_the_soft_stop_of_figure_3_12_every_revolution_but_the_first_is_predicted(made: Reproduction) -> None:
    """The chart reserves two ramps for stop and start; with half a ramp for the stop its dip comes Ts/2 too early,
    earlier by as much with each revolution, with a whole one it stays where it is."""
    lines = [line for line in table(made, "table_4_1_readings.csv") if line["reading"] == "dip"]
    for line in lines:
        if line["load"] == "normal":
            predicted = line["park_without_first"] == line["park_total_without_first"]
            assert predicted == (line["soft_stop"] == "Ts")
            assert int(line["park"]) == int(line["park_without_first"])
    for run in made.rig:
        if run.load == "normal":
            gaps = [r.ended_before for r in run.score.revolutions if r.state_at_park == "Soft_start"]
            drift = [b - a for a, b in pairwise(gaps) if a is not None and b is not None and b > a]
            assert np.median(drift) == pytest.approx(T_RAMP / 2, abs=5e-3)


def test_a_first_revolution_passes_if_the_half_revolution_is_preset() -> None:
    """Preset so that the park signal falls into Soft_stop: the scorer knows no number of a revolution."""
    scenario = SCENARIOS / "rig_20ms.csv"
    learning, preset = (
        score(scenario_run(scenario, catalogue.ensure, "stop=4 s", *settings)).revolutions[0]
        for settings in ((), ("controller.T_default=1.045 s",))
    )
    assert not learning.park_deceleration
    assert learning.turn
    assert preset.park_deceleration
    assert preset.turn
    assert not [failure for failure in preset.failures if failure.reading == "both"]


def test_every_parameter_is_in_the_table_with_its_provenance(made: Reproduction) -> None:
    lines = table(made, "parameters.csv")
    for model in ("linkage", "rig", "voltage_profile"):
        fmu = Fmu.read(catalogue.ensure(model))
        listed = {line["name"]: line for line in lines if model in line["models"].split()}
        assert {v.name for v in fmu.variables.values() if v.causality == "parameter"} <= set(listed)
        for name, line in listed.items():
            start = fmu.variables[name].start
            if isinstance(start, float):
                assert float(line["value"]) == pytest.approx(start, rel=1e-9)
            assert line["unit"] == ("" if (unit := fmu.variables[name].unit) in (None, "1") else unit)
    assert all(line["provenance"].startswith(("[S]", "[A]")) for line in lines)
    assert all(len(line["provenance"]) > len("[S] ") for line in lines)


def test_a_measured_torque_is_averaged_as_the_source_does(tmp_path: Path) -> None:
    """55 samples of 2 ms: a step comes through as a ramp of 0.11 s; a constant stays what it is."""
    path = tmp_path / "bench.csv"
    time = np.arange(0.0, 2.0, 0.002)
    torque = np.where(time < 1.0, 0.0, 10.0)
    rows = "\n".join(f"{t!r},{m!r}" for t, m in zip(time.tolist(), torque.tolist(), strict=True))
    path.write_text(f"time [s],torque [N.m]\n{rows}\n", encoding="utf-8")
    found = read_measured(path)
    assert found.label == "Measured data, bench.csv"
    ramp = np.clip((time - 0.999) / 0.11, 0.0, 1.0) * 10.0
    np.testing.assert_allclose(found.torque, ramp, atol=0.1)
    assert found.torque[-1] == pytest.approx(10.0)


def test_a_workbooks_torque_is_told_to_be_zero_at_its_onset(tmp_path: Path) -> None:
    each = np.where(np.arange(2000) < 400, 1.0, 3.0)
    average = np.convolve(np.concatenate((np.full(54, 1.0), each)), np.full(55, 1.0 / 55.0), "valid")
    index = np.arange(2000.0)
    columns = Columns(np.full(2000, 24.0).tolist(), index.tolist(), each.tolist(), average.tolist(), Tp=(0.173, 0.58))
    found = read_measured(write(tmp_path / "Dry Glass Cold Motor LS.xlsx", columns))
    there = (1.0 - 0.58) / 0.173
    assert found.label.endswith(f"(made zero at its onset; {there:.2g} N.m there by its line)"), found.label


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, "there is no such measurement"),
        ("time [s],force [N]\n0,1\n1,2\n", "no column for the torque or current among time, force"),
        ("time [s],current [A]\n0,1\n1,2\n", "has no torque, which --measured draws into figure 3.6"),
        ("time [s],torque [N.m]\n0,1\n0,2\n", "'time' must increase from row to row"),
        ("time [s],torque [kg]\n0,1\n1,2\n", "the torque is in kg"),
    ],
)
def test_a_measured_torque_that_cannot_be_read_is_refused(tmp_path: Path, content: str | None, message: str) -> None:
    path = tmp_path / "bench.csv"
    if content is not None:
        path.write_text(content, encoding="utf-8")
    with pytest.raises(InputError, match=re.escape(message)):
        read_measured(path)


@pytest.mark.parametrize("name", ["thesis.md", "claims.md"])
def test_the_pages_of_the_documentation_are_those_of_a_fresh_run(made: Reproduction, name: str) -> None:
    spec = spec_from_file_location("documentation", DOCS / "thesis.py")
    assert spec is not None
    assert spec.loader is not None
    documentation = module_from_spec(spec)
    spec.loader.exec_module(documentation)
    page = (DOCS / name).read_text(encoding="utf-8")
    fresh = documentation.linked(file(made, name).read_text(encoding="utf-8"))
    assert differences(page, fresh) == [], "run python docs/thesis.py"
    shown = re.findall(r"\]\((pictures/\S+)\)", page)
    assert shown
    assert all((DOCS / picture).is_file() for picture in shown)


@pytest.mark.parametrize(
    ("old", "new", "agree"),
    [
        ("mean 10.83 N.m", "mean 10.84 N.m", True),
        ("mean 10.83 N.m", "mean 11.05 N.m", False),
        ("2 ms | 5/10 | 3 %", "2 ms | 5/10 | 4 %", True),
        ("2 ms | 5/10 |", "2 ms | 6/10 |", False),
        ("does not hold", "holds", False),
        ("0.05 % more, -4 mA", "0.06 % more, -4 mA", True),
        ("0.05 % more, -4 mA", "0.07 % more, -4 mA", False),
        ("5.7e-06 H", "5.9e-06 H", False),
    ],
)
def test_a_page_that_has_drifted_is_seen(old: str, new: str, agree: bool) -> None:
    assert (differences(old, new) == []) == agree


def test_every_claim_has_a_verdict_numbers_and_a_picture(made: Reproduction) -> None:
    assert len(made.findings) >= 10
    names = {path.name for path in made.files}
    for finding in made.findings:
        assert re.search(r"\d", finding.numbers)
        assert finding.picture in names


def test_the_rig_runs_are_as_the_source_describes_them(made: Reproduction) -> None:
    """9 to 13 park signals in 25 s; after the start the filtered current lies between 0 and about 3 A."""
    for run in made.rig:
        park, time = run.result.columns["plant.park"], run.result.time
        assert 9 <= np.count_nonzero(np.diff(park) > 0) <= 13
        current = run.result.columns["controller.i_filtered"][time > 1.0]
        assert current.min() >= -1e-12  # a sum from which what has left was taken
        assert current.max() < 3.0
