"""The runs of a study: simulated once each, in parallel, and judged by every reading of the scorer."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cosim.assessment import Revolution, Rules, Score, score
from cosim.engine import Result, simulate
from cosim.thesis._readings import DIP, STRICT, T_RAMP
from cosim.thesis._runs import SAMPLE_TIMES
from cosim.thesis._sensitivity_design import Case
from cosim.thesis._sensitivity_factors import Bench, Level, Setting, chart_period, relevant

Array = NDArray[np.float64]

LOADS = ("normal", "disturbed")
STOP = 21.0
"""End of the runs [s]: what is scored are 20 s, and a deceleration is looked for up to a quarter revolution later."""
SAME = 1e-9
"""Times closer than this are one [s]."""


@dataclass(frozen=True)
class Reading:
    """A way to read section 4.5: the scorer's rules, under a name for columns and one for texts."""

    key: str
    label: str
    rules: Rules
    literal: bool = False
    """Whether parks are counted literally, in turn_point_dec only."""


ANSWERED = Rules(early=T_RAMP, late=T_RAMP)
"""A deceleration may also come up to a ramp after the signal, as the source's table counts at 50 ms."""
READINGS = (
    Reading("literal", "turn_point_dec at the signal", STRICT.rules, literal=True),
    Reading("strict", "any deceleration at the signal", STRICT.rules),
    Reading("dip", "… or up to 0.1 s before it", DIP.rules),
    Reading("answered", "… or up to 0.1 s after it", ANSWERED),
    Reading("strict_separate", "at the signal, repeats allowed", replace(STRICT.rules, repeats="separate")),
    Reading("dip_separate", "0.1 s before it, repeats allowed", replace(DIP.rules, repeats="separate")),
    Reading("answered_separate", "0.1 s after it, repeats allowed", replace(ANSWERED, repeats="separate")),
)
"""Criterion 1 in four ways, and criterion 3 in two: whether a repeated state fails park or turn, or is only told."""


@dataclass(frozen=True)
class Passed:
    """Parks and turns that one reading passes."""

    park: int
    turn: int


@dataclass(frozen=True)
class Outcome:
    """What a run gave: counts by reading, and the margins behind them.

    ``leads`` [s], for each revolution but the first: from the end of the deceleration that the chart plans to the park
    signal, negative if it would end after it. ``drift`` [s] is the median of its growth from one revolution to the
    next. ``turns`` [deg], for the same: how far past half a revolution the voltage is least. ``half_duty`` is the mean
    duty ratio at half a revolution. ``answers`` counts revolutions at whose signal no deceleration had begun, but one
    followed.
    """

    passed: dict[str, Passed]
    total: int
    answers: int
    leads: tuple[float, ...]
    drift: float
    turns: tuple[float, ...]
    half_duty: float


@dataclass(frozen=True)
class Table:
    """Table 4.1 under one setting: an outcome for each sampling time [s] and load."""

    case: Case
    outcomes: dict[tuple[float, str], Outcome]


def run_tables(bench: Bench, cases: Sequence[Case]) -> list[Table]:
    """Simulate and judge the ten runs of each case; runs that cannot differ are made once.

    Raises:
        CosimError: a simulation fails.
    """
    wanted: dict[tuple[Level, ...], tuple[Setting, float, str]] = {}
    for case in cases:
        for sample_time, load in _cells():
            wanted.setdefault(relevant(case.setting, sample_time, load), (case.setting, sample_time, load))
    with ThreadPoolExecutor(os.cpu_count()) as threads:
        made = dict(zip(wanted, threads.map(lambda cell: outcome(bench, *cell), wanted.values()), strict=True))
    return [Table(case, {cell: made[relevant(case.setting, *cell)] for cell in _cells()}) for case in cases]


def outcome(bench: Bench, setting: Setting, sample_time: float, load: str) -> Outcome:
    """Simulate one run and judge it."""
    result = run(bench, setting, sample_time, load)
    return judge(result, setting, sample_time)


def run(bench: Bench, setting: Setting, sample_time: float, load: str, stop: float = STOP) -> Result:
    """Simulate one run up to ``stop`` [s], with the tolerance of the scenarios."""
    system = bench.system(setting, sample_time, load, stop)
    return simulate(system, stop=stop, output_interval=1e-3, tolerance=1e-8)


def judge(result: Result, setting: Setting, sample_time: float) -> Outcome:
    """Count by all readings, and measure the margins."""
    scored = score(result, Rules(repeats="separate"))
    later = scored.revolutions[1:]
    leads = _leads(result, later, setting, chart_period(setting, sample_time))
    return Outcome(
        passed={reading.key: passed(scored, reading) for reading in READINGS},
        total=len(scored.revolutions),
        answers=sum(r.ended_before is None and r.began_after is not None for r in scored.revolutions),
        leads=tuple(leads[~np.isnan(leads)].tolist()),
        drift=_drift(leads, later),
        turns=tuple((r.turn_position - 0.5) * 360.0 for r in later if r.turn_position is not None),
        half_duty=_half_duty(result, later),
    )


def passed(scored: Score, reading: Reading) -> Passed:
    """Count by a reading what was scored at the text's word and with repeats separate: the scorer runs once."""
    parks = turns = 0
    for revolution in scored.revolutions:
        repeated = {state for state, count in revolution.occurrences.items() if count > 1}
        grouped = reading.rules.repeats == "grouped"
        park = revolution.park_literal if reading.literal else _predicted(revolution, reading.rules)
        parks += park and not (grouped and repeated & {"Soft_start", "Soft_stop"})
        turns += revolution.turn and not (grouped and repeated & {"turn_point_acc", "turn_point_dec"})
    return Passed(parks, turns)


def _predicted(revolution: Revolution, rules: Rules) -> bool:
    before, after = revolution.ended_before, revolution.began_after
    early = before is not None and before <= rules.early + SAME
    return early or (rules.late > 0 and after is not None and after <= rules.late + SAME)


def _leads(result: Result, revolutions: Sequence[Revolution], setting: Setting, tick: float) -> Array:
    """Return how long before each park signal the deceleration ends that the chart plans [s], NaN without a turn.

    Out of RUN, entered at t, figure 3.11 goes after 2 period - 2 T_ramp, out of Soft_stop after its length; the chart
    decides at the first tick past the one, and at the first that has reached the other. The park signal cuts short what
    is planned; the plan tells by how much it was late.
    """
    ramp, ratio = float(setting["T_ramp_s"]), float(setting["soft_stop"])
    names = result.literals["controller.state"]
    state, period = result.columns["controller.state"], result.columns["controller.period"]
    soft_start, running = (names.index(name) + 1 for name in ("Soft_start", "RUN"))  # an enumeration counts from 1
    entries = result.time[1:][(state[1:] == running) & (state[:-1] == soft_start)]
    leads = np.full(len(revolutions), np.nan)
    for k, revolution in enumerate(revolutions):
        if revolution.turn_time is None or not (entries <= revolution.turn_time + SAME).any():
            continue
        entered = float(entries[entries <= revolution.turn_time + SAME][-1])
        known = float(period[int(np.searchsorted(result.time, revolution.end - SAME)) - 1])
        begins = max(entered + tick * _ticks_past(2 * known - 2 * ramp, tick), revolution.turn_time + tick)
        leads[k] = revolution.end - begins - tick * _ticks_past(ratio * ramp - 2 * SAME, tick)
    return leads


def _drift(leads: Array, revolutions: Sequence[Revolution]) -> float:
    """Return the median growth of the lead [s] over revolutions that begin as planned; NaN if there are none.

    One begins so if the deceleration before it was not cut short: it had begun at the park signal, none answered that.
    """
    grown = [
        leads[k + 1] - leads[k]
        for k, revolution in enumerate(revolutions[:-1])
        if revolution.ended_before is not None and revolution.began_after is None
    ]
    known = [growth for growth in grown if not math.isnan(growth)]
    return float(np.median(known)) if known else math.nan


def _ticks_past(length: float, tick: float) -> int:
    """The number of the first tick that is past ``length`` [s]."""
    return math.floor((length + SAME) / tick) + 1


def _half_duty(result: Result, revolutions: Sequence[Revolution]) -> float:
    """Return the mean duty ratio half a revolution after the park signals."""
    angle, duty, time = result.columns["plant.phi_crank"], result.columns["controller.duty"], result.time
    found = []
    for revolution in revolutions:
        start, end = np.searchsorted(time, (revolution.start - SAME, revolution.end - SAME))
        row = start + int(np.searchsorted(angle[start:end], angle[start] + math.pi))
        found.append(float(duty[min(row, end)]))
    return float(np.mean(found)) if found else math.nan


def _cells() -> list[tuple[float, str]]:
    return [(sample_time, load) for sample_time in SAMPLE_TIMES for load in LOADS]
