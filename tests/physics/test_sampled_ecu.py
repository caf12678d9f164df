"""The sampled part of the controller unit against the whole one, and the latch of the park contact against its law."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from cosim.engine import Channel, Component, Connection, Fmu, Result, System, simulate
from cosim.fmu import catalogue

I_FULL_OVER_V_REF = 2.0
"""Amperes per volt at the converter: one over 10 mOhm times 50."""


def closed_loop(controller: str, parameters: dict[str, Any], stop: float = 9.0) -> Result:
    components = [
        Component("plant", Fmu.read(catalogue.ensure("rig"))),
        Component("controller", Fmu.read(catalogue.ensure(controller)), parameters),
    ]
    wires = [
        Connection(("controller", "duty"), ("plant", "duty")),
        Connection(("plant", "i_motor"), ("controller", "i_motor")),
        Connection(("plant", "park"), ("controller", "park")),
    ]
    return simulate(System(components, wires), stop=stop, output_interval=1e-3, tolerance=1e-8)


@pytest.mark.parametrize(
    "parameters",
    [
        {},
        {"T_filter": 0.125, "duty_min": 0.35, "seed": 3},
        {"T_compute": 0.02, "T_measure": 0.02, "n_read": 20, "stop_ratio": 1.0, "T_filter": 0.125},
        {"T_compute": 0.02, "T_measure": 0.001, "n_read": 1, "n_window": 25},
    ],
)
def test_it_is_the_whole_unit_with_the_rest_of_its_hardware_off(parameters: dict[str, Any]) -> None:
    """To the last bit, noise included: the numbers come from the same generator at the same ticks."""
    sampled = closed_loop("ecu_sampled", {**parameters, "i_noise": 0.1}).columns
    whole = closed_loop("ecu", {**parameters, "v_noise": 0.1 / I_FULL_OVER_V_REF}).columns
    assert len(set(sampled["controller.state"])) >= 5
    for name, values in sampled.items():
        assert np.array_equal(whole[name], values), name


def periods(contacts: list[tuple[float, float]], **parameters: Any) -> list[float]:  # noqa: ANN401
    """The half revolutions that the chart measures in 4 s, from when the contact is closed (from, to) [s]."""
    rows = [row for start, end in contacts for row in ((start, 1.0), (end, 0.0))]
    channels = [
        Channel(("controller", "i_motor"), [0.0], [2.0]),
        Channel(("controller", "park"), [time for time, _ in rows], [value for _, value in rows]),
    ]
    unit = Component("controller", Fmu.read(catalogue.ensure("ecu_sampled")), parameters)
    result = simulate(System([unit], [], channels), stop=4.0, output_interval=1e-3, tolerance=1e-6)
    period = result.columns["controller.period"]
    return [float(p) for p in period[np.flatnonzero(np.diff(period)) + 1]]


SHORT = [(0.0, 0.012), (1.503, 1.515), (3.027, 3.039)]
"""Contacts of 12 ms, as at full voltage; the last two lie between ticks of 20 ms."""


def test_a_contact_between_two_ticks_is_lost_when_sampled_and_seen_when_latched() -> None:
    slow = {"T_compute": 0.02, "T_measure": 0.02}
    assert periods(SHORT, **slow) == []
    # latched into the ticks at 0.02, 1.52 and 3.04 s; what a tick has read is forgotten at the next
    assert periods(SHORT, **slow, n_read=20) == pytest.approx([(1.54 - 0.04) / 2, (3.06 - 1.54) / 2], abs=1e-9)


def test_the_latch_holds_a_contact_up_to_one_tick_and_no_longer() -> None:
    """A contact over many ticks opens for the chart at the first tick of which no reading has seen it closed."""
    long = [(0.0, 0.1), (1.0, 1.45), (2.0, 2.403)]
    slow = {"T_compute": 0.02, "T_measure": 0.02}
    # closed last at readings of 0.099, 1.449 and 2.402 s: latched into the ticks at 0.1, 1.46 and 2.42 s
    assert periods(long, **slow, n_read=20) == pytest.approx([(1.48 - 0.12) / 2, (2.44 - 1.48) / 2], abs=1e-9)
    # sampled: not closed any more at the ticks of 0.1, 1.46 and 2.42 s
    assert periods(long, **slow) == pytest.approx([(1.46 - 0.1) / 2, (2.42 - 1.46) / 2], abs=1e-9)
