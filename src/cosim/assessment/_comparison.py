"""Two runs side by side: the ratio of each vibration measure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from cosim.assessment._vibration import Vibration

SAME_RATE = 0.01
"""Relative difference of the times of a revolution up to which two wipe rates are one."""
_COUNTED = ("turns",)


@dataclass(frozen=True)
class Comparison:
    """``ratios`` of a run to a baseline by the measures' keys; below 1 the run has less of it.

    ``notes`` say what keeps the comparison from being one: the thesis's question is asked at the same wipe rate.
    """

    name: str
    baseline: str
    ratios: Mapping[str, float]
    notes: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, object]:
        """Return everything as plain texts and numbers, for JSON."""
        ratios, notes = dict(self.ratios), list(self.notes)
        return {"name": self.name, "baseline": self.baseline, "ratios": ratios, "notes": notes}


def compare(run: Vibration, baseline: Vibration) -> Comparison:
    """Return the ratio of each measure of ``run`` to that of ``baseline``.

    Measures that only one of them has, and those that are zero in the baseline, have no ratio. Notes tell of wipe rates
    that differ by more than 1 % or are unknown, and of measures taken in different ways.
    """
    ratios = {
        key: measure.value / baseline[key]
        for key, measure in run.measures.items()
        if key not in _COUNTED and key in baseline.measures and baseline[key] != 0
    }
    notes = []
    rate = ratios.get("revolution_time")
    if rate is None:
        notes.append("the wipe rates are not known, for want of two closings of the park contact in each run")
    elif abs(rate - 1) > SAME_RATE:
        notes.append(
            f"not at the same wipe rate: a revolution takes {run['revolution_time']:.4g} s in {run.name} and "
            f"{baseline['revolution_time']:.4g} s in {baseline.name}"
        )
    if run.method != baseline.method:
        notes.append("the two were measured in different ways")
    return Comparison(run.name, baseline.name, ratios, tuple(notes))
