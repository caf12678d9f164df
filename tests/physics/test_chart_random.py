"""The charts under random contacts, currents and switches: as the reference decides, lawful, never stuck."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from cosim.engine import Channel, Component, Fmu, System, simulate
from cosim.fmu import catalogue
from reference.controller import Controller, Parameters, State

Array = np.ndarray
STOP = 12.0
NAMES = [State.IDLE, State.SOFT_START, State.RUN, State.TURN_POINT_DEC, State.TURN_POINT_ACC, State.SOFT_STOP]
"""In the order of the FMU's enumeration, which counts from 1."""
IDLE, SOFT_START, RUN, DEC, ACC, SOFT_STOP = range(1, 7)
ALLOWED = {
    (IDLE, SOFT_START), (SOFT_START, RUN), (RUN, DEC), (DEC, ACC), (ACC, RUN),
    (RUN, SOFT_STOP), (DEC, SOFT_STOP), (ACC, SOFT_STOP), (SOFT_STOP, SOFT_START), (SOFT_STOP, IDLE),
    (SOFT_START, IDLE), (RUN, IDLE), (DEC, IDLE), (ACC, IDLE),
}  # fmt: skip
"""Figure 3.11, IDLE passed through between two revolutions, and parking, which leads from anywhere to IDLE."""


def held(random: np.random.Generator, mean: float, values: list[float]) -> tuple[list[float], list[float]]:
    """Values drawn at random, each held for a random while of this mean, on whole ticks."""
    times = np.cumsum(np.round(random.exponential(mean, round(2 * STOP / mean)), 3) + 1e-3)
    times = np.concatenate([[0.0], times[times < STOP]])
    return times.tolist(), random.choice(values, len(times)).tolist()


def inputs(seed: int) -> dict[str, tuple[list[float], list[float]]]:
    """From contacts that bounce to contacts that never come, from a calm current to a wild one."""
    random = np.random.default_rng(seed)
    return {
        "park": held(random, float(random.choice([0.01, 0.1, 0.5, 3.0])), [0.0, 1.0]),
        "i_motor": held(random, float(random.choice([0.01, 0.3])), [0.0, 0.4, 0.58, 0.6, 1.0, 3.0]),
        "enable": held(random, float(random.choice([1.0, 50.0])), [1.0, 1.0, 0.0]),
    }


def at_ticks(table: tuple[list[float], list[float]]) -> Array:
    times, values = map(np.array, table)
    ticks = np.arange(round(STOP / 1e-3)) * 1e-3
    return np.asarray(values[np.searchsorted(times, ticks + 1e-9, side="right") - 1])


def run(controller: str, seed: int, **parameters: float) -> dict[str, Array]:
    unit = Component("c", Fmu.read(catalogue.ensure(controller)), parameters)
    channels = [Channel(("c", name), *table) for name, table in inputs(seed).items()]
    columns = simulate(System([unit], [], channels), stop=STOP, output_interval=1e-3, tolerance=1e-6).columns
    return {name.removeprefix("c."): values[:-1] for name, values in columns.items()}


@pytest.mark.parametrize("seed", range(12))
def test_the_chart_decides_as_the_reference(seed: int) -> None:
    settings: dict[str, Any] = {"T_sample": [1e-3, 0.02, 0.05][seed % 3], "T_filter": 0.125 * (seed % 2)}
    found = run("voltage_profile", seed, **settings)
    park, current, enable = (at_ticks(inputs(seed)[name]) for name in ("park", "i_motor", "enable"))
    reference = Controller(Parameters(**settings))
    for k in range(len(park)):
        expected = reference.step(k * 1e-3, float(current[k]), bool(park[k]), bool(enable[k]))
        assert NAMES[int(found["state"][k]) - 1] is expected.state, k
        assert found["duty"][k] == pytest.approx(expected.duty, abs=1e-12), k
        assert found["i_limit"][k] == pytest.approx(expected.i_limit, abs=1e-12), k
        assert found["period"][k] == pytest.approx(expected.period, abs=1e-12), k


@pytest.mark.parametrize(
    "controller", ["voltage_profile", *(pytest.param(name, marks=pytest.mark.slow) for name in ("s_curve", "ecu"))]
)
def test_whatever_comes_in_the_duty_ratio_and_the_transitions_stay_lawful_and_nothing_is_a_dead_end(
    controller: str,
) -> None:
    reached: set[tuple[int, int]] = set()
    for seed in range(100, 130):
        columns = run(controller, seed)
        duty, state = columns["duty"], columns["state"].astype(int)
        assert duty.min() >= 0.0 and duty.max() <= 1.0
        assert np.all((duty == 0) == (state == IDLE))
        steps = {(int(a), int(b)) for a, b in pairwise(state) if a != b}
        assert steps <= ALLOWED
        reached |= steps
        # a ramp ends in time, and IDLE as soon as the switch is on
        changes = np.concatenate([[0], np.flatnonzero(np.diff(state)) + 1, [len(state)]])
        for start, end in pairwise(changes):
            if state[start] in (SOFT_START, DEC, ACC, SOFT_STOP):
                assert end - start <= 100
        # it stands still only while it is switched off
        assert not np.any((state == IDLE) & (at_ticks(inputs(seed)["enable"]) > 0))
    assert reached == ALLOWED
