"""All runs that the claims of the source are held against, made once."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from cosim.assessment import Counts, score
from cosim.engine import Fmu, Result
from cosim.thesis._experiments import (
    Aftermath,
    Budget,
    SlowUnit,
    TurnPosition,
    aftermaths,
    load_budgets,
    no_load_revolution,
    slow_units,
    turn_positions,
)
from cosim.thesis._pwm import Pwm, pwm_runs
from cosim.thesis._readings import Reading
from cosim.thesis._runs import (
    FULL_STOP,
    SAMPLE_TIMES,
    Locate,
    RigRun,
    linkage_runs,
    preset_run,
    profile_run,
    rig_runs,
)
from cosim.thesis._same_rate import Pair, same_rate


@dataclass(frozen=True)
class Evidence:
    """The runs, and what was measured in them."""

    reading: Reading
    linkage: Mapping[str, Result]
    profile: Result
    pwm: Pwm
    rig: Sequence[RigRun]
    rig_full_stop: Sequence[RigRun]
    preset: Result
    budgets: Mapping[str, Budget]
    aftermaths: Sequence[Aftermath]
    slow: Sequence[SlowUnit]
    turns: Sequence[TurnPosition]
    pairs: Mapping[str, Pair]
    no_load_revolution: float
    """Time of a revolution of the crank at no load and full voltage [s]."""

    @cached_property
    def counts(self) -> Mapping[tuple[float, str], Counts]:
        """The counts of table 4.1 by sampling time [s] and load, as they are read beside the strict reading."""
        return {(run.sample_time, run.load): score(run.result, self.reading.rules).counts for run in self.rig}

    def without_first(self, reading: Reading) -> Mapping[tuple[float, str], Counts]:
        """Return the counts of table 4.1 without the first revolution, as ``reading`` has them."""
        return {(run.sample_time, run.load): score(run.result, reading.rules).counts_without_first for run in self.rig}

    @cached_property
    def shares(self) -> Mapping[float, float]:
        """Parks and turns predicted, of all there are, by sampling time [s]; both loads together."""
        found = {}
        for sample_time in SAMPLE_TIMES:
            both = [counts for (time, _), counts in self.counts.items() if time == sample_time]
            passed = sum(c.park_deceleration + c.turn for c in both)
            found[sample_time] = passed / sum(c.park_total + c.turn_total for c in both)
        return found


def gather(scenarios: Path, locate: Locate, reading: Reading, say: Callable[[str], None]) -> Evidence:
    """Simulate everything; ``say`` is told what comes next."""
    say("the linkage and the profile")
    linkage, profile = linkage_runs(scenarios, locate), profile_run(locate)
    say("figure 4.8, the switched bridge")
    pwm = pwm_runs(scenarios, locate)
    say("figures 4.9 to 4.18 and table 4.1, the rig")
    rig, full_stop = rig_runs(scenarios, locate), rig_runs(scenarios, locate, FULL_STOP)
    say("the claims, the profile against constant voltage")
    return Evidence(
        reading=reading,
        linkage=linkage,
        profile=profile,
        pwm=pwm,
        rig=rig,
        rig_full_stop=full_stop,
        preset=preset_run(scenarios, locate),
        budgets=load_budgets(scenarios, locate),
        aftermaths=aftermaths(scenarios, locate),
        slow=slow_units(scenarios, locate),
        turns=turn_positions(scenarios, locate),
        pairs=same_rate(scenarios, locate),
        no_load_revolution=no_load_revolution(Fmu.read(locate("rig"))),
    )
