"""Verdicts follow from numbers: the same rule says otherwise of other numbers."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cosim.assessment import Counts
from cosim.thesis._claims import (
    Verdict,
    best_sampling_time,
    filtering,
    gone_after_a_revolution,
    negligible_load,
    power,
    todays_hardware,
)
from cosim.thesis._evidence import Evidence
from cosim.thesis._experiments import Aftermath, Budget, SlowUnit, TurnPosition


def evidence(**parts: Any) -> Any:  # noqa: ANN401
    """Only what a rule looks at."""
    return SimpleNamespace(**parts)


def budgets(load: float, electrical: float) -> dict[str, Budget]:
    made = Budget(revolution=2.0, electrical=electrical, torque=10.0, load_torque=load, current=2.0)
    return {"with": made, "without": made}


@pytest.mark.parametrize(("load", "verdict"), [(0.9, Verdict.HOLDS), (1.0, Verdict.FAILS), (2.0, Verdict.FAILS)])
def test_a_load_is_negligible_from_one_order_of_magnitude_on(load: float, verdict: Verdict) -> None:
    assert negligible_load(evidence(budgets=budgets(load, 72.0))).verdict is verdict


@pytest.mark.parametrize(("watts", "verdict"), [(50.0, Verdict.FAILS), (60.0, Verdict.HOLDS), (90.0, Verdict.FAILS)])
def test_roughly_72_watts_are_within_a_fifth(watts: float, verdict: Verdict) -> None:
    assert power(evidence(budgets=budgets(1.0, watts))).verdict is verdict


@pytest.mark.parametrize(
    ("parks", "verdict"),
    [
        ({0.001: 5, 0.002: 5, 0.01: 5, 0.02: 9, 0.05: 5}, Verdict.HOLDS),
        ({0.001: 5, 0.002: 9, 0.01: 5, 0.02: 5, 0.05: 5}, Verdict.FAILS),
        ({0.001: 5, 0.002: 5, 0.01: 5, 0.02: 5, 0.05: 5}, Verdict.UNDECIDED),
    ],
)
def test_the_best_sampling_time_must_be_ahead_by_more_than_one_prediction(
    parks: dict[float, int], verdict: Verdict
) -> None:
    counts = {
        (time, load): Counts(0, park, 10, 10, 10) for time, park in parks.items() for load in ("normal", "disturbed")
    }
    shares = Evidence.shares.func(evidence(counts=counts))
    assert best_sampling_time(evidence(counts=counts, shares=shares)).verdict is verdict


@pytest.mark.parametrize(
    ("left", "verdict"),
    [([0.0, 0.0], Verdict.HOLDS), ([0.0, 0.3], Verdict.PARTLY), ([0.1, 0.3], Verdict.FAILS)],
)
def test_a_disturbance_is_gone_when_all_of_it_is(left: list[float], verdict: Verdict) -> None:
    nothing = np.zeros(0)
    cases = [Aftermath(f"case {k}", np.array([1.0, 0.5, x]), nothing, (nothing, nothing)) for k, x in enumerate(left)]
    assert gone_after_a_revolution(evidence(aftermaths=cases)).verdict is verdict


@pytest.mark.parametrize(
    ("by_window", "by_time", "verdict"),
    [(0.1, 0.0, Verdict.FAILS), (0.0, 0.1, Verdict.HOLDS), (0.0, 0.0, Verdict.UNDECIDED)],
)
def test_it_is_the_window_if_that_alone_moves_the_turn(by_window: float, by_time: float, verdict: Verdict) -> None:
    def turn(sample_time: float, n_window: int) -> TurnPosition:
        share = 0.5 + by_window * (sample_time * n_window > 0.5) + by_time * (sample_time >= 0.02)
        return TurnPosition(sample_time, n_window, share)

    turns = [turn(0.001, 50), turn(0.02, 50), turn(0.02, 3), turn(0.01, 100)]
    assert filtering(evidence(turns=turns)).verdict is verdict


@pytest.mark.parametrize(("seen", "verdict"), [(12, Verdict.HOLDS), (11, Verdict.FAILS)])
def test_a_unit_must_see_every_contact(seen: int, verdict: Verdict) -> None:
    assert todays_hardware(evidence(slow=[SlowUnit(0.05, 12, seen, 0, 10)])).verdict is verdict
