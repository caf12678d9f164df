"""The source's conclusion as a rule: is 20 ms the best of the sampling times, apart from those that react too late?"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from enum import Enum

from cosim.thesis._runs import SAMPLE_TIMES
from cosim.thesis._sensitivity_runs import LOADS, Reading, Table

CLAIMED = 0.020
"""The sampling time that the source recommends [s]."""
_EQUAL = 1e-9
"""Shares closer than this are one."""


class Verdict(Enum):
    """What a table of counts says of 20 ms, a better sampling time being one that passes more than one prediction more.

    The source judges by the sum of its counts and leaves 50 ms aside, "due to the deceleration phases happens after the
    park signal and not on it".
    """

    BEST = "20 ms is best"
    SHARED = "none is better than 20 ms, not all are as good"
    SAME = "all sampling times are as good"
    SHORTER = "a shorter sampling time is better"
    LONGER = "50 ms is better"
    LATE = "20 ms decelerates after the park signal"


def verdict(counts: Mapping[float, tuple[int, int]], late: Collection[float]) -> Verdict:
    """Return what counts say of 20 ms.

    Args:
        counts: predictions passed, and all there are, by sampling time [s].
        late: sampling times at which most decelerations come after the park signal; they do not compete.
    """
    if CLAIMED in late:
        return Verdict.LATE
    shares = {time: passed / total for time, (passed, total) in counts.items() if time not in late}
    one = 1 / counts[CLAIMED][1] + _EQUAL
    ahead = {time: shares[CLAIMED] - share for time, share in shares.items() if time != CLAIMED}
    if min(ahead.values(), default=0.0) < -one:
        return Verdict.SHORTER if min(ahead, key=lambda time: ahead[time]) < CLAIMED else Verdict.LONGER
    if min(ahead.values(), default=0.0) > one:
        return Verdict.BEST
    return Verdict.SAME if max(ahead.values(), default=0.0) <= one else Verdict.SHARED


def counts_of(table: Table, reading: Reading) -> dict[float, tuple[int, int]]:
    """Return parks and turns passed, and all there are, of both loads, by sampling time [s]."""
    found = {}
    for time in SAMPLE_TIMES:
        outcomes = [table.outcomes[time, load] for load in LOADS]
        passed = [outcome.passed[reading.key] for outcome in outcomes]
        found[time] = (sum(p.park + p.turn for p in passed), 2 * sum(outcome.total for outcome in outcomes))
    return found


def late_of(table: Table) -> set[float]:
    """Return the sampling times [s] at which more than half of the decelerations come after the park signal."""
    found = set()
    for time in SAMPLE_TIMES:
        outcomes = [table.outcomes[time, load] for load in LOADS]
        if 2 * sum(outcome.answers for outcome in outcomes) > sum(outcome.total for outcome in outcomes):
            found.add(time)
    return found


def judge_table(table: Table, reading: Reading) -> Verdict:
    """Return what table 4.1 under one setting says of 20 ms, by one reading."""
    return verdict(counts_of(table, reading), late_of(table))


def advantage(table: Table, reading: Reading) -> float:
    """Return the share of predictions that 20 ms passes, less that of the best other one that is not late."""
    late = late_of(table)
    shares = {time: passed / total for time, (passed, total) in counts_of(table, reading).items()}
    return shares[CLAIMED] - max(share for time, share in shares.items() if time != CLAIMED and time not in late)


def passed_share(table: Table, reading: Reading) -> float:
    """Return the share of predictions passed, as the mean of the sampling times."""
    shares = [passed / total for passed, total in counts_of(table, reading).values()]
    return sum(shares) / len(shares)


def park_share(table: Table, reading: Reading, time: float) -> float:
    """Return the share of parks that a sampling time [s] predicts, both loads together."""
    outcomes = [table.outcomes[time, load] for load in LOADS]
    return sum(o.passed[reading.key].park for o in outcomes) / sum(o.total for o in outcomes)
