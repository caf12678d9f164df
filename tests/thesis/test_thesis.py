"""What ``cosim thesis`` makes, against the source's figure 3.12 and table 4.1."""

from __future__ import annotations

import csv
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

from cosim.fmu import catalogue
from cosim.thesis import Reproduction, reproduce
from cosim.thesis._runs import profile_run
from cosim.thesis._table import PUBLISHED

pytest.importorskip("rumoca")

SCENARIOS = Path(__file__).parents[2] / "scenarios"


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


def test_every_figure_is_a_picture(made: Reproduction) -> None:
    names = [path.name for path in made.files]
    assert names == [
        *(f"figure_{number}.png" for number in ("3_5", "3_6", "3_12", *(f"4_{k}" for k in range(9, 19)))),
        "table_4_1.csv",
    ]
    for path in made.files[:-1]:
        assert path.read_bytes().startswith(b"\x89PNG")


def test_table_4_1_has_the_published_counts_beside_the_simulated_ones(made: Reproduction) -> None:
    with made.files[-1].open(encoding="utf-8", newline="") as file:
        lines = list(csv.DictReader(file))
    assert list(lines[0]) == [
        "sample_time_s", "load", "park_literal", "park_deceleration", "park_total", "turn", "turn_total",
        "published_park", "published_turn",
    ]  # fmt: skip
    for line, run in zip(lines, made.rig, strict=True):
        assert (float(line["sample_time_s"]), line["load"]) == (run.sample_time, run.load)
        assert (line["published_park"], line["published_turn"]) == PUBLISHED[run.sample_time, run.load]
        counts = run.score.counts
        assert {key: int(line[key]) for key in asdict(counts)} == asdict(counts)


def test_the_rig_runs_are_as_the_source_describes_them(made: Reproduction) -> None:
    """9 to 13 park signals in 25 s; after the start the filtered current lies between 0 and about 3 A."""
    for run in made.rig:
        park, time = run.result.columns["plant.park"], run.result.time
        assert 9 <= np.count_nonzero(np.diff(park) > 0) <= 13
        current = run.result.columns["controller.i_filtered"][time > 1.0]
        assert current.min() >= -1e-12  # a sum from which what has left was taken
        assert current.max() < 3.0
