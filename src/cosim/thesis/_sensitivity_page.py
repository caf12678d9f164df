"""The study in words: every number and every verdict in it is computed."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence

import numpy as np

from cosim.thesis._runs import SAMPLE_TIMES
from cosim.thesis._sensitivity import MARGINS, Study, distance
from cosim.thesis._sensitivity_factors import FACTORS, SLOW, Factor, Setting, chart_period
from cosim.thesis._sensitivity_runs import LOADS, READINGS, Table
from cosim.thesis._sensitivity_verdict import Verdict, judge_table, late_of, park_share

STANDS, MOSTLY = 0.95, 0.5
"""Shares of the verdicts from which on a conclusion stands, and mostly stands."""
DUTY_MIN = 0.35
"""Least duty ratio on the rig, chapter 4."""
COMMAND = "cosim thesis --sensitivity"


def page(study: Study, picture: str) -> str:
    """Return the page as Markdown; ``picture`` is the path of the picture as the page links it."""
    parts = [
        "# Which open choices decide the source's conclusion",
        f"Made by `{COMMAND}`; every number is computed.",
        f"{conclusion(study)}\n\n{deciding(study)}",
        f"![Margins, verdicts and effects of the open choices]({picture})",
        "## What decides",
        _ranking(study),
        _level_table(study),
        "## Why",
        _law(),
        _drift_table(study),
        "## The margins behind the counts",
        _margin_table(study),
        "## What else the source says of sampling times",
        _statements(study),
        "## By reading",
        _reading_table(study),
        _where_best(study),
        _published(study),
        "## How it was found out",
        _method(study),
        _factor_table(),
    ]
    return "\n\n".join(parts) + "\n"


def conclusion(study: Study) -> str:
    """Return in a paragraph whether the source's conclusion stands, by rule."""
    counts, total = study.all_verdicts, sum(study.all_verdicts.values())
    share = counts[Verdict.BEST] / total
    stands = "stands" if share >= STANDS else "mostly stands" if share >= MOSTLY else "does not stand"
    others = ", ".join(
        f"{_percent(counts[verdict], total)} that {verdict.value}"
        for verdict in Verdict
        if verdict is not Verdict.BEST and counts[verdict]
    )
    return (
        f"**That 20 ms is the best sampling time {stands} over the ranges of what the source leaves open.** Of "
        f"{total} verdicts, on {len(study.of('factorial'))} settings by {len(READINGS)} readings of the criteria, "
        f"{_percent(counts[Verdict.BEST], total)} say so; {others}."
    )


def deciding(study: Study) -> str:
    """Return in a paragraph which open choice decides, and how verdicts divide over its levels."""
    advantages, passes = study.advantages, study.passes
    first = advantages.ranking[0]
    factor = FACTORS[first]
    halves = "; ".join(
        f'at "{factor.format(level)}", {_most(_by_level(study, first, level))}' for level in (factor.low, factor.high)
    )
    small = [
        FACTORS[k].label
        for k in advantages.ranking
        if abs(advantages.mean[k]) < advantages.margin and abs(passes.mean[k]) < passes.margin
    ]
    mover = passes.ranking[0]
    return (
        f"**What decides on sampling times is the {factor.label}**, which has a part in "
        f"{100 * advantages.parts[first]:.0f} % of the variation of 20 ms's advantage over the best other one: "
        f"{halves}. "
        f"**What moves the counts themselves most is: {FACTORS[mover].label}**, with a part of "
        f"{100 * passes.parts[mover]:.0f} % and {100 * passes.mean[mover]:+.0f} points from "
        f"{FACTORS[mover].format(FACTORS[mover].low)} to {FACTORS[mover].format(FACTORS[mover].high)}. "
        f"By themselves do no more than scatter, to both: {'; '.join(small) or 'none'}."
    )


def _by_level(study: Study, factor: int, level: object) -> Counter[Verdict]:
    key = FACTORS[factor].key
    return Counter(
        judge_table(table, reading)
        for table in study.of("factorial")
        if table.case.setting[key] == level
        for reading in READINGS
    )


def _most(counts: Counter[Verdict]) -> str:
    """The verdict that falls most often, and how often."""
    verdict, number = counts.most_common(1)[0]
    return f"{number} of {sum(counts.values())} verdicts are that {verdict.value}"


def _percent(part: int, total: int) -> str:
    return f"{100 * part / total:.0f} %"


def _ranking(study: Study) -> str:
    advantages, passes = study.advantages, study.passes
    lines = [
        "Predictions passed: the share of all parks and turns, of both loads, in points of a hundred, as the mean of "
        "the sampling times. Advantage of 20 ms: that share at 20 ms, less that of the best other sampling time. An "
        "effect is the mean at the second level less that at the first, as the mean of the readings; the range is "
        "theirs. The part is that of the variation in which a choice takes part, by itself or together with another.",
        "",
        "| open choice | levels | advantage: part | effect | range | strongest together with | passed: part | effect |",
        "|---|---|---:|---:|---:|---|---:|---:|",
    ]
    for k in study.ranking:
        factor, main = FACTORS[k], 100 * advantages.main[:, k]
        pair = advantages.partner(k)
        partner = "–" if pair is None else f"{FACTORS[pair[0]].label} ({100 * pair[1]:+.1f})"
        lines.append(
            f"| {factor.label} | {factor.format(factor.low)}, {factor.format(factor.high)} | "
            f"{100 * advantages.parts[k]:.0f} % | {main.mean():+.1f} | {main.min():+.1f} … {main.max():+.1f} | "
            f"{partner} | {100 * passes.parts[k]:.0f} % | {100 * passes.mean[k]:+.1f} |"
        )
    lines += [
        "",
        f"Effects below about {100 * advantages.margin:.1f} points on the advantage and {100 * passes.margin:.1f} on "
        "what is passed are no more than what the others scatter by (Lenth 1989).",
    ]
    return "\n".join(lines)


def _level_table(study: Study) -> str:
    lines = [f"| | {' | '.join(verdict.value for verdict in Verdict)} |", "|---|" + "---:|" * len(Verdict)]
    for k in study.ranking[:4]:
        for level in (FACTORS[k].low, FACTORS[k].high):
            counts = _by_level(study, k, level)
            total = sum(counts.values())
            cells = " | ".join(_percent(counts[verdict], total) for verdict in Verdict)
            lines.append(f"| {FACTORS[k].label}: {FACTORS[k].format(level)} | {cells} |")
    return "\n".join(lines)


def _law() -> str:
    return (
        "Figure 3.11 has a cycle of its own: a ramp of Soft_start, RUN until it has lasted longer than two periods "
        "less two ramps, and Soft_stop; each ends on a tick of the chart. With the ramp T, a Soft_stop of s T, the "
        "tick h, and ⌈ ⌉ for rounding up to ticks, the deceleration at the revolution's end comes earlier each "
        "time by\n\n"
        "    ⌈2 T⌉ − ⌈T⌉ − ⌈s T⌉ − h,\n\n"
        "which is T (1 − s) − h where T and s T are whole ticks. A Soft_stop shorter than a ramp brings it forward, "
        'the tick that the strict ">" waits for holds it back; only where the two are about equal does a park that was '
        "predicted once stay predicted. The sampling time of the current is not in it. It decides through the tick, "
        "where that is the sampling time."
    )


def drift_law(setting: Setting, sample_time: float) -> float:
    """Return by how much the planned deceleration comes earlier from one revolution to the next [s].

    RUN lasts as many ticks as there are in two periods, less ⌈2 T⌉, and one: its condition is strict.
    """
    ramp, ratio, tick = float(setting["T_ramp_s"]), float(setting["soft_stop"]), chart_period(setting, sample_time)

    def up(length: float) -> int:
        return math.ceil(length / tick - 1e-6)

    return tick * (up(2 * ramp) - up(ramp) - up(ratio * ramp) - 1)


def _drift_table(study: Study) -> str:
    shown = [study.tables[0], *(t for t in study.of("together") if t.case.setting["park"] != "sampled")]
    lines = [
        "Growth of the lead per revolution, by the law and in the run without disturbance (median of the revolutions "
        "that no park signal cut short; – where there is none) [ms]:",
        "",
        f"| setting | {' | '.join(f'{1e3 * time:.0f} ms' for time in SAMPLE_TIMES)} |",
        "|---|" + "---:|" * len(SAMPLE_TIMES),
    ]
    for table in shown:
        cells = []
        for time in SAMPLE_TIMES:
            drift = table.outcomes[time, "normal"].drift
            simulated = "–" if math.isnan(drift) else f"{1e3 * drift:.0f}"
            cells.append(f"{1e3 * drift_law(table.case.setting, time):.0f}, {simulated}")
        lines.append(f"| {table.case.name} | {' | '.join(cells)} |")
    return "\n".join(lines)


def _margin_table(study: Study) -> str:
    margins, middle = study.margins, study.tables[0]
    most = "; ".join(
        f"{name.split(' [')[0]}: {FACTORS[int(np.argmax(np.abs(found.main)))].label}" for name, found in margins.items()
    )
    lines = [
        "At 20 ms, medians of the revolutions of both loads. The lead is from the end of the planned deceleration to "
        "the park signal. The turn is where the voltage is least; a linkage's wipers turn near half a revolution, "
        f"where the duty ratio should be {DUTY_MIN:g}. Effects are differences between the two levels. What moves them "
        f"most, by itself: {most}.",
        "",
        f"| | {' | '.join(MARGINS)} |",
        "|---|" + "---:|" * len(MARGINS),
        f"| {middle.case.name} | {' | '.join(_number(measure(middle), '') for measure in MARGINS.values())} |",
    ]
    for k in study.ranking:
        factor = FACTORS[k]
        cells = " | ".join(_number(float(found.main[k]), "+") for found in margins.values())
        levels = f"{factor.format(factor.low)} → {factor.format(factor.high)}"
        lines.append(f"| effect of {factor.label}, {levels} | {cells} |")
    scatter = " | ".join(_number(found.margin, "") for found in margins.values())
    lines.append(f"| scatter stays below | {scatter} |")
    return "\n".join(lines)


def _number(value: float, sign: str) -> str:
    return f"{value:{sign}.3g}"


def _statements(study: Study) -> str:
    tables = study.of("factorial")
    more = fewer = 0
    for table in tables:
        one = 1 / sum(table.outcomes[0.020, load].total for load in LOADS)
        for reading in READINGS:
            ahead = park_share(table, reading, 0.020) - park_share(table, reading, 0.001)
            more += ahead > one + 1e-9
            fewer += ahead < -one - 1e-9
    total = len(tables) * len(READINGS)
    slow = [table for table in tables if table.case.setting["chart"] == SLOW]
    fast = [table for table in tables if table.case.setting["chart"] != SLOW]
    return "\n".join([
        f"* \"An increased sampling rate reduces the robustness\": 20 ms predicts more parks than 1 ms in "
        f"{_percent(more, total)} of the verdicts, fewer in {_percent(fewer, total)}, by more than one.",
        "* At 50 ms \"the deceleration phases happens after the park signal and not on it\": "
        f"in {_late(slow, 0.050)} of {len(slow)} settings whose chart "
        f"runs at the sampling time, in {_late(fast, 0.050)} of {len(fast)} whose "
        "chart runs every millisecond.",
        f"* The same would rule out 20 ms in {_late(slow, 0.020)} and {_late(fast, 0.020)} of them.",
    ])  # fmt: skip


def _late(tables: Sequence[Table], time: float) -> int:
    return sum(time in late_of(table) for table in tables)


def _reading_table(study: Study) -> str:
    lines = [f"| reading of a park | {' | '.join(v.value for v in Verdict)} |", "|---|" + "---:|" * len(Verdict)]
    for reading in READINGS:
        counts = Counter(study.verdicts[reading.key])
        cells = " | ".join(str(counts[verdict]) for verdict in Verdict)
        lines.append(f"| {reading.label.replace('…', READINGS[1].label)} (`{reading.key}`) | {cells} |")
    return "\n".join(lines)


def _where_best(study: Study) -> str:
    found = []
    for table in study.of("alone", "together"):
        keys = [f"`{r.key}`" for r in READINGS if judge_table(table, r) is Verdict.BEST]
        if keys:
            found.append(f"{table.case.name} ({', '.join(keys)})")
    return (
        "Of the settings that change one choice or a few that belong together, 20 ms is best with: "
        f"{'; '.join(found) or 'none'}."
    )


def _published(study: Study) -> str:
    table, reading, least = study.nearest
    assumed = min(READINGS, key=lambda r: distance(study.tables[0], r))
    away = distance(study.tables[0], assumed)
    levels = ", ".join(
        f"{factor.label} {factor.format(table.case.setting[factor.key])}"
        for factor in FACTORS
        if table.case.setting[factor.key] != factor.assumed
    )
    return (
        f'The published counts are nearest to those of {table.case.design} setting "{table.case.name}" by reading '
        f"`{reading.key}`: {100 * least:.0f} points away, on average of the twenty counts. It has {levels}. The "
        f"setting of the scenarios is {100 * away:.0f} points away, by reading `{assumed.key}`."
    )


def _method(study: Study) -> str:
    alone, together, factorial = (len(study.of(design)) for design in ("alone", "together", "factorial"))
    return (
        f"Each setting is run as table 4.1 is: five sampling times, with and without a hand on the load. {alone - 1} "
        f"settings change one choice of the scenarios, {together} a few that belong together (one rate: chart, ADC and "
        f"moving average all run at the sampling time); {factorial} are an "
        "orthogonal fraction, 2^(11-5) of resolution IV, of all combinations of two levels: main effects are free of "
        "interactions of two, and all interactions of the chart's rate are free of each other and of all others. "
        "Crossing it with the sampling times keeps their differences, of which the conclusion is one, free of any "
        "confounding. Runs that cannot differ are made once. The levels of the fraction are half and double of what "
        "the source leaves open, a fifth either way of what it gives, and both of two alternatives; shares are of "
        "these corners, no probabilities.\n\n"
        "A sampling time is better if it passes more than one prediction more, of all parks and turns of both loads. "
        "As in the source, one at which more than half of the decelerations come after the park signal does not "
        "compete. `sensitivity.csv` has each run with its levels, counts and margins."
    )


def _factor_table() -> str:
    lines = ["| open choice | in the scenarios | others alone | in the fraction | why |", "|---|---|---|---|---|"]
    lines += [f"| {factor.label} | {_levels(factor)} | {factor.why} |" for factor in FACTORS]
    return "\n".join(lines)


def _levels(factor: Factor) -> str:
    others = ", ".join(factor.format(level) for level in factor.others)
    return f"{factor.format(factor.assumed)} | {others} | {factor.format(factor.low)}, {factor.format(factor.high)}"
