"""Where the simulated counts of table 4.1 agree with the published ones and where not, in words made from numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise

import numpy as np

from cosim.assessment import Counts, score
from cosim.thesis._evidence import Evidence
from cosim.thesis._readings import ANSWER, DIP, STRICT, T_RAMP, Reading
from cosim.thesis._runs import SAMPLE_TIMES, RigRun
from cosim.thesis._table import PUBLISHED

Key = tuple[float, str]
CLOSE = 1
"""Numbers of failures that differ by no more than this agree."""


def counts_of(runs: Sequence[RigRun], reading: Reading) -> Mapping[Key, Counts]:
    """Return the counts of the runs, by sampling time [s] and load, as ``reading`` has them."""
    return {(run.sample_time, run.load): score(run.result, reading.rules).counts for run in runs}


def published(key: Key) -> tuple[int, int, int, int]:
    """Return parks, all parks, turns, all turns of a published line."""
    park, turn = (tuple(map(int, cell.split("/"))) for cell in PUBLISHED[key])
    return park[0], park[1], turn[0], turn[1]


def sentences(evidence: Evidence) -> list[str]:
    """Return one sentence for each thing that can be compared: whether it agrees, and why not."""
    strict, dip = counts_of(evidence.rig, STRICT), counts_of(evidence.rig, DIP)
    full = counts_of(evidence.rig_full_stop, DIP)
    return [
        _revolutions(evidence, strict),
        _strict(evidence, strict),
        _dip(evidence, dip),
        _full_stop(evidence, full),
        _turns(strict),
        _trend(dip, full),
        _fifty(evidence, dip),
    ]


def _close(simulated: Callable[[Key], int], other: Callable[[Key], int]) -> list[Key]:
    return [key for key in PUBLISHED if abs(simulated(key) - other(key)) <= CLOSE]


def _range(values: Sequence[int]) -> str:
    low, high = min(values), max(values)
    return f"{low}" if low == high else f"{low} to {high}"


def _revolutions(evidence: Evidence, counts: Mapping[Key, Counts]) -> str:
    agree = _close(lambda key: counts[key].park_total, lambda key: published(key)[1])
    return (
        f"**Park signals in 20 s**: {_range([c.park_total for c in counts.values()])} simulated, "
        f"{_range([published(key)[1] for key in PUBLISHED])} published; within {CLOSE} in {len(agree)} of "
        f"{len(PUBLISHED)} runs. The one at the start, on which a run begins, is not counted here. Eleven in 20 s need "
        f"revolutions of {20 / 11:.2f} s, and the motor at no load makes one in {evidence.no_load_revolution:.2f} s: "
        "the load was pushed, or the start counted."
    )


def _strict(evidence: Evidence, counts: Mapping[Key, Counts]) -> str:
    agree = _close(*_failed_parks(counts))
    gaps = [r.ended_before for run in evidence.rig for r in run.score.revolutions if r.ended_before]
    return (
        f"**Parks at the word of the text**: {_range([c.park_deceleration for c in counts.values()])} predicted, "
        f"{_range([published(key)[0] for key in PUBLISHED])} published; failures differ by at most {CLOSE} in "
        f"{len(agree)} of {len(PUBLISHED)} runs. Soft_stop is over {1e3 * min(gaps):.0f} to {1e3 * max(gaps):.0f} ms "
        "before the contact closes, or it begins at the signal. RUN.turn_point_dec, which the text names, holds at "
        f"{sum(c.park_literal for c in counts.values())} of {sum(c.park_total for c in counts.values())} signals."
    )


def _dip(evidence: Evidence, counts: Mapping[Key, Counts]) -> str:
    agree = _close(*_failed_parks(counts))
    drift = drift_per_revolution(evidence.rig)
    reason = (
        f"The dip comes {1e3 * drift:.0f} ms earlier with each revolution, until the park signal finds the chart in "
        "RUN and starts it anew"
    )
    if abs(drift - T_RAMP / 2) < 0.1 * T_RAMP:
        reason += (
            ": that is Ts/2. The chart of figure 3.11 reserves 2 Ts for stop and start and takes Ts/2 and Ts, so that "
            "the revolution it predicts is Ts/2 too short, and every time anew, as it counts from its own prediction"
        )
    return (
        f"**Parks as a plot shows them**: {_range([c.park_deceleration for c in counts.values()])} predicted; failures "
        f"differ by at most {CLOSE} in {len(agree)} of {len(PUBLISHED)} runs. {reason}."
    )


def _full_stop(evidence: Evidence, counts: Mapping[Key, Counts]) -> str:
    agree = _close(*_failed_parks(counts))
    missed = [c.park_total - c.park_deceleration for c in counts.values()]
    which = ", ".join(f"{1e3 * time:.0f} ms {load}" for time, load in agree) or "none"
    firsts = [score(run.result, DIP.rules).revolutions[0] for run in evidence.rig_full_stop]
    drift = drift_per_revolution(evidence.rig_full_stop)
    return (
        f"**With Soft_stop as long as figure 3.12 draws it**, Ts, the dip moves by {1e3 * abs(drift):.0f} ms per "
        f"revolution: {_range([c.park_deceleration for c in counts.values()])} are predicted, {_range(missed)} not, "
        f"among them the first revolution in {sum(not r.park_deceleration for r in firsts)} of {len(firsts)} runs. "
        f"Failures differ by at most {CLOSE} in {len(agree)} of {len(PUBLISHED)} runs: {which}. "
        "Nothing was tuned to that: the two figures of the source contradict each other, and both are shown."
    )


def _turns(counts: Mapping[Key, Counts]) -> str:
    agree = _close(
        lambda key: counts[key].turn_total - counts[key].turn, lambda key: published(key)[3] - published(key)[2]
    )
    found, every = sum(c.turn for c in counts.values()), sum(c.turn_total for c in counts.values())
    missed = [published(key)[3] - published(key)[2] for key in PUBLISHED]
    return (
        f"**Turns**: {found} of {every} are found in the simulation, where {_range(missed)} of 10 are missed in the "
        f"published lines; failures differ by at most {CLOSE} in {len(agree)} of {len(PUBLISHED)} runs. The simulated "
        "current is that of the model, without the ripple of about 0.5 A that the source reports for figure 4.18, far "
        "more than the 3 % by which the threshold lies above the least current."
    )


def _trend(dip: Mapping[Key, Counts], full: Mapping[Key, Counts]) -> str:
    def share(passed: Callable[[Key], int], every: Callable[[Key], int], time: float) -> float:
        keys = [key for key in PUBLISHED if key[0] == time]
        return 100.0 * sum(map(passed, keys)) / sum(map(every, keys))

    first, last = SAMPLE_TIMES[0], SAMPLE_TIMES[-1]
    shown = [share(lambda key: published(key)[0], lambda key: published(key)[1], time) for time in (first, last)]
    found = [
        [share(lambda key: c[key].park_deceleration, lambda key: c[key].park_total, time) for time in (first, last)]  # noqa: B023
        for c in (dip, full)
    ]
    differ = all(abs(b - a) < 0.5 * abs(shown[1] - shown[0]) for a, b in found)
    return (
        f"**Over the sampling time**, from 1 to 50 ms, the published share of parks goes from {shown[0]:.0f} to "
        f"{shown[1]:.0f} %, the simulated one from {found[0][0]:.0f} to {found[0][1]:.0f} % (Soft_stop Ts/2) and from "
        f"{found[1][0]:.0f} to {found[1][1]:.0f} % (Ts). "
        + (
            "The published trend is not found: the prediction of the park uses time alone, which the current's "
            "sampling cannot touch; it can have come from anything else on the rig that the source does not tell."
            if differ
            else "The trend is the published one."
        )
    )


def _fifty(evidence: Evidence, counts: Mapping[Key, Counts]) -> str:
    answers = counts_of(evidence.rig, ANSWER)
    keys = [key for key in PUBLISHED if key[0] == SAMPLE_TIMES[-1]]
    return (
        "**At 50 ms** the published lines count decelerations after the signal as predictions ("
        + ", ".join(PUBLISHED[key][0] for key in keys)
        + "), which the text calls faulty. Read as a plot shows them they are "
        + ", ".join(f"{counts[key].park_deceleration}/{counts[key].park_total}" for key in keys)
        + "; with what answers the signal counted in, the reading `answer`, they are "
        + ", ".join(f"{answers[key].park_deceleration}/{answers[key].park_total}" for key in keys)
        + "."
    )


def _failed_parks(counts: Mapping[Key, Counts]) -> tuple[Callable[[Key], int], Callable[[Key], int]]:
    return (
        lambda key: counts[key].park_total - counts[key].park_deceleration,
        lambda key: published(key)[1] - published(key)[0],
    )


def drift_per_revolution(runs: Sequence[RigRun]) -> float:
    """Return by how much earlier the dip comes with each revolution, the median over undisturbed runs [s].

    Of revolutions that follow each other and both end in Soft_start: there the chart counted on from its own
    prediction, and not from a park signal.
    """
    steps = []
    for run in runs:
        if run.load == "normal":
            gaps = [r.ended_before if r.state_at_park == "Soft_start" else None for r in run.score.revolutions]
            steps += [b - a for a, b in pairwise(gaps[1:]) if a is not None and b is not None]
    return float(np.median(steps)) if steps else 0.0
