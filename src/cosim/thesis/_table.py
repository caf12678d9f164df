"""Table 4.1: how many parks and turning points the profile predicts, published and simulated side by side."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from cosim.assessment import score
from cosim.thesis._readings import READINGS, STRICT, Reading
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
"""The table's own columns, all revolutions, read at its word."""
MORE = (
    "park_chosen", "turn_chosen", "park_deceleration_without_first", "park_chosen_without_first",
    "park_total_without_first", "turn_without_first", "turn_total_without_first",
)  # fmt: skip
"""The reading that was chosen beside it, and the counts without the first revolution."""
READING_COLUMNS = (
    "sample_time_s", "load", "soft_stop", "reading", "park", "park_total", "turn", "turn_total", "park_without_first",
    "park_total_without_first", "turn_without_first", "turn_total_without_first",
)  # fmt: skip


def rows(runs: Sequence[RigRun], reading: Reading) -> Iterator[tuple[object, ...]]:
    """Yield the lines of the table, in the order of :data:`COLUMNS` and :data:`MORE`."""
    for run in runs:
        counts, without = run.score.counts, run.score.counts_without_first
        other = score(run.result, reading.rules)
        yield (
            run.sample_time, run.load, counts.park_literal, counts.park_deceleration, counts.park_total, counts.turn,
            counts.turn_total, *PUBLISHED[run.sample_time, run.load], other.counts.park_deceleration,
            other.counts.turn, without.park_deceleration, other.counts_without_first.park_deceleration,
            without.park_total, without.turn, without.turn_total,
        )  # fmt: skip


def write_table(runs: Sequence[RigRun], reading: Reading, path: Path) -> None:
    """Write the table as CSV."""
    _write(path, (*COLUMNS, *MORE), rows(runs, reading))


def write_readings(charts: Mapping[str, Sequence[RigRun]], reading: Reading, path: Path) -> None:
    """Write the counts of every reading as CSV: for the runs of each chart, named after its Soft_stop."""
    readings = dict.fromkeys((*READINGS, reading))
    _write(
        path,
        READING_COLUMNS,
        (
            (run.sample_time, run.load, chart, each.name, *_counts(run, each))
            for chart, runs in charts.items()
            for run in runs
            for each in readings
        ),
    )


def _counts(run: RigRun, reading: Reading) -> tuple[int, ...]:
    found = run.score if reading is STRICT else score(run.result, reading.rules)
    every, without = found.counts, found.counts_without_first
    return (
        every.park_deceleration, every.park_total, every.turn, every.turn_total, without.park_deceleration,
        without.park_total, without.turn, without.turn_total,
    )  # fmt: skip


def _write(path: Path, head: Sequence[str], lines: Iterator[tuple[object, ...]]) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(head)
        writer.writerows(lines)
