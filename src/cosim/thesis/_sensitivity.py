"""How the counts of table 4.1, and what the source concludes from them, move with what the source leaves open."""

from __future__ import annotations

import csv
import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from cosim.thesis._runs import SAMPLE_TIMES, Locate
from cosim.thesis._sensitivity_design import alone, factorial, together
from cosim.thesis._sensitivity_effects import Array, Effects, effects
from cosim.thesis._sensitivity_factors import FACTORS, Bench
from cosim.thesis._sensitivity_runs import LOADS, READINGS, Outcome, Reading, Table, run_tables
from cosim.thesis._sensitivity_verdict import CLAIMED, Verdict, advantage, judge_table, passed_share
from cosim.thesis._table import PUBLISHED


@dataclass(frozen=True)
class Responses:
    """Effects on a response by all readings, by their key."""

    by_reading: Mapping[str, Effects]

    @cached_property
    def main(self) -> Array:
        """Effects of the factors, shape (readings, factors)."""
        return np.array([found.main for found in self.by_reading.values()])

    @property
    def mean(self) -> Array:
        """Effect of each factor, as the mean of the readings."""
        return np.asarray(self.main.mean(axis=0))

    @property
    def parts(self) -> list[float]:
        """Each factor's part of the variation, with its interactions, as the mean of the readings."""
        return [float(v) for v in np.mean([found.share for found in self.by_reading.values()], axis=0)]

    @property
    def margin(self) -> float:
        """What effects of no consequence stay below, as the mean of the readings."""
        return float(np.mean([found.margin for found in self.by_reading.values()]))

    @property
    def ranking(self) -> list[int]:
        """The factors' numbers, that with the largest part first."""
        return [int(k) for k in np.argsort([-part for part in self.parts], kind="stable")]

    def partner(self, factor: int) -> tuple[int, float] | None:
        """Return the factor with which one acts most strongly, of the pairs that are clear, and their effect."""
        pairs: dict[int, float] = {}
        for found in self.by_reading.values():
            for pair, effect in found.pairs.items():
                if factor in pair:
                    other = sum(pair) - factor
                    pairs[other] = pairs.get(other, 0.0) + effect / len(self.by_reading)
        return max(pairs.items(), key=lambda item: abs(item[1]), default=None)


@dataclass(frozen=True)
class Study:
    """Table 4.1 under each setting, and what follows for the conclusion."""

    tables: tuple[Table, ...]

    def of(self, *designs: str) -> list[Table]:
        """Return the tables of the settings of some designs."""
        return [table for table in self.tables if table.case.design in designs]

    @cached_property
    def verdicts(self) -> dict[str, list[Verdict]]:
        """The verdicts on the settings of the factorial, by the key of the reading."""
        return {reading.key: [judge_table(t, reading) for t in self.of("factorial")] for reading in READINGS}

    @property
    def all_verdicts(self) -> Counter[Verdict]:
        """How often each verdict falls, over all settings of the factorial and all readings."""
        return Counter(verdict for found in self.verdicts.values() for verdict in found)

    @cached_property
    def advantages(self) -> Responses:
        """Effects on the share of predictions by which 20 ms is ahead of the best other sampling time."""
        return self._responses(advantage)

    @cached_property
    def passes(self) -> Responses:
        """Effects on the share of predictions passed, as the mean of the sampling times."""
        return self._responses(passed_share)

    @cached_property
    def margins(self) -> dict[str, Effects]:
        """Effects on the margins of 20 ms, by their names in `MARGINS`; one that a setting does not have is neutral."""
        found = {}
        for name, measure in MARGINS.items():
            values = np.array([measure(table) for table in self.of("factorial")])
            found[name] = effects(np.where(np.isnan(values), np.nanmean(values), values))
        return found

    @property
    def ranking(self) -> list[int]:
        """The factors' numbers, that which decides most on the advantage first."""
        return self.advantages.ranking

    def _responses(self, response: Callable[[Table, Reading], float]) -> Responses:
        found = {r.key: effects([response(table, r) for table in self.of("factorial")]) for r in READINGS}
        return Responses(found)

    @cached_property
    def nearest(self) -> tuple[Table, Reading, float]:
        """Return the setting and the reading whose shares differ least from the published ones, and by how much."""
        return min(
            ((table, reading, distance(table, reading)) for table in self.tables for reading in READINGS),
            key=lambda found: found[2],
        )


def _leads(table: Table) -> Array:
    return 1e3 * np.array([lead for load in LOADS for lead in table.outcomes[CLAIMED, load].leads])


def _middle(values: Sequence[float] | Array) -> float:
    return float(np.median(values)) if len(values) else math.nan


def _spread(values: Array) -> float:
    return float(np.subtract(*np.percentile(values, (75, 25)))) if len(values) else math.nan


MARGINS: dict[str, Callable[[Table], float]] = {
    "park lead [ms]": lambda table: _middle(_leads(table)),
    "its quartiles' distance [ms]": lambda table: _spread(_leads(table)),
    "turn past half a revolution [deg]": lambda table: _middle(
        [turn for load in LOADS for turn in table.outcomes[CLAIMED, load].turns]
    ),
    "duty ratio at half a revolution": lambda table: _middle(
        [table.outcomes[CLAIMED, load].half_duty for load in LOADS]
    ),
}
"""What lies behind the counts of 20 ms: medians over the revolutions of both loads."""


def distance(table: Table, reading: Reading) -> float:
    """Return the mean difference of the shares of parks and turns from those of the published table 4.1."""
    found = []
    for cell, outcome in table.outcomes.items():
        passed = outcome.passed[reading.key]
        for count, published in zip((passed.park, passed.turn), PUBLISHED[cell], strict=True):
            right, of = map(int, published.split("/"))
            found.append(abs(count / outcome.total - right / of))
    return sum(found) / len(found)


def study(scenarios: Path, locate: Locate, say: Callable[[str], None] = lambda _: None) -> Study:
    """Run all settings.

    Args:
        scenarios: the folder of the shipped scenarios.
        locate: gives the FMU of a built-in plant or controller.
        say: is told what comes next.

    Raises:
        CosimError: an FMU cannot be built, or a simulation fails.
    """
    cases = [*alone(), *together(), *factorial()]
    say(f"table 4.1 under {len(cases)} settings")
    return Study(tuple(run_tables(Bench.load(scenarios, locate), cases)))


def write_runs(tables: Sequence[Table], path: Path) -> None:
    """Write each run with its factors and responses as CSV."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([*columns()])
        writer.writerows(rows(tables))


def columns() -> list[str]:
    """Return the columns of the table of runs."""
    counts = [f"{what}_{reading.key}" for reading in READINGS for what in ("park", "turn")]
    margins = ["lead_mean_ms", "lead_sd_ms", "drift_ms", "turn_mean_deg", "turn_sd_deg", "half_duty"]
    return ["design", "case", *(f.key for f in FACTORS), "sample_time_s", "load", "total", *counts, "answers", *margins]


def rows(tables: Sequence[Table]) -> Iterator[list[object]]:
    """Yield a line for each run, in the order of :func:`columns`; margins that there are not stay empty."""
    for table in tables:
        case = table.case
        for time in SAMPLE_TIMES:
            for load in LOADS:
                outcome = table.outcomes[time, load]
                counts = [n for r in READINGS for n in (outcome.passed[r.key].park, outcome.passed[r.key].turn)]
                levels = [case.setting[factor.key] for factor in FACTORS]
                yield [
                    case.design, case.name, *levels, time, load, outcome.total, *counts, outcome.answers,
                    *_margins(outcome),
                ]  # fmt: skip


def _margins(outcome: Outcome) -> list[object]:
    leads, turns = 1e3 * np.array(outcome.leads), np.array(outcome.turns)
    found = [
        *((leads.mean(), leads.std()) if len(leads) else (math.nan, math.nan)),
        1e3 * outcome.drift,
        *((turns.mean(), turns.std()) if len(turns) else (math.nan, math.nan)),
        outcome.half_duty,
    ]
    return ["" if math.isnan(value) else round(float(value), 4) for value in found]
