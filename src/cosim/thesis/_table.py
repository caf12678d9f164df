"""Table 4.1: how many parks and turning points the profile predicts, published and simulated side by side."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

from cosim.thesis._runs import RigRun

PUBLISHED = {
    (0.001, "normal"): ("5/10", "6/10"),
    (0.001, "disturbed"): ("6/11", "6/10"),
    (0.002, "normal"): ("5/10", "6/10"),
    (0.002, "disturbed"): ("5/10", "9/10"),
    (0.010, "normal"): ("7/10", "6/10"),
    (0.010, "disturbed"): ("7/10", "9/10"),
    (0.020, "normal"): ("9/9", "6/10"),
    (0.020, "disturbed"): ("9/10", "6/10"),
    (0.050, "normal"): ("9/9", "9/10"),
    (0.050, "disturbed"): ("9/9", "9/10"),
}
"""Park and turn prediction by sampling time [s] and load, as published."""

COLUMNS = (
    "sample_time_s", "load", "park_literal", "park_deceleration", "park_total", "turn", "turn_total",
    "published_park", "published_turn",
)  # fmt: skip


def rows(runs: Sequence[RigRun]) -> list[tuple[object, ...]]:
    """The lines of the table, in the order of :data:`COLUMNS`."""
    found: list[tuple[object, ...]] = []
    for run in runs:
        counts = run.score.counts
        park, turn = PUBLISHED[run.sample_time, run.load]
        found.append((
            run.sample_time, run.load, counts.park_literal, counts.park_deceleration, counts.park_total, counts.turn,
            counts.turn_total, park, turn,
        ))  # fmt: skip
    return found


def write_table(runs: Sequence[RigRun], path: Path) -> None:
    """Write the table as CSV."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(rows(runs))
