"""Random park and current sequences through the controller: what it does, and what the scorer sees of it."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.assessment import Rules, Trace, score
from cosim.engine import simulate
from cosim.fmu import catalogue
from cosim.scenario import assemble, read
from reference.controller import Controller, Parameters, State

from .naive import DECELERATIONS, cycles_of

TICK = 5e-3
"""The chart's period, coarse to be quick; the current is held for 20 ms [s]."""
TURNS = {"turn_point_acc", "turn_point_dec"}
Levels = list[tuple[float, float]]

lengths = st.floats(0.02, 1.5)
contact = st.lists(st.tuples(lengths, st.floats(TICK, 0.05)), min_size=3, max_size=12)
"""How long the contact is open, then closed [s]."""
currents = st.lists(st.tuples(lengths, st.floats(0.0, 8.0)), min_size=1, max_size=15)
parameters = st.builds(
    Parameters,
    T_compute=st.just(TICK),
    T_filter=st.sampled_from([0.0, 0.125]),
    duty_min=st.sampled_from([0.0, 0.35]),
    T_soft_stop=st.sampled_from([None, 0.1]),
    idle_step=st.booleans(),
)


def held(levels: Levels, time: np.ndarray) -> np.ndarray:
    """The levels one after another, the last one for ever."""
    ends = np.cumsum([length for length, _ in levels])
    values = [value for _, value in levels]
    return np.array([*values, values[-1]])[np.searchsorted(ends, time, side="right")]


def drive(chart: Parameters, opened: Levels, current: Levels) -> tuple[Trace, np.ndarray]:
    """Run the controller on a contact and a current; return what it did, and its duty ratio."""
    bounds = np.cumsum([0.03, *(length for pair in opened for length in pair)])
    time = np.arange(round(float(bounds[-1]) / TICK) + 2) * TICK
    park = np.searchsorted(bounds, time, side="right") % 2 == 0
    seen = held(current, time)
    controller = Controller(chart)
    outputs = [controller.step(float(t), float(i), bool(on), True) for t, i, on in zip(time, seen, park, strict=True)]
    state = np.array([out.state.value for out in outputs])
    return Trace("random", time, {"state": state, "park": park}), np.array([out.duty for out in outputs])


@settings(max_examples=60, deadline=None)
@given(parameters, contact, currents)
def test_whatever_the_contact_and_the_current_do(chart: Parameters, opened: Levels, current: Levels) -> None:
    run, duty = drive(chart, opened, current)
    states = run.labels("state").tolist()
    assert duty.min() >= 0.0
    assert duty.max() <= 1.0
    assert all(y >= chart.duty_min for y, state in zip(duty, states, strict=True) if state != "IDLE")

    # no dead end: enabled, every state but RUN is left within the longest ramp, one tick for rounding
    changes = np.flatnonzero([True, *(a != b for a, b in pairwise(states)), True])
    stays = [(states[a], (b - a) * TICK) for a, b in pairwise(changes)]
    assert all(length <= 0.1 + 1.5 * TICK for state, length in stays if state != "RUN")

    # the scorer sees what a look at every row sees
    rules = Rules(position=np.inf, repeats="separate")
    found = score(run, rules)
    rows = int((run.time <= rules.span + 1e-9).sum())
    cycles = cycles_of(states, run.switch("park").tolist(), rows)
    assert len(found.revolutions) == len(cycles)
    for revolution, cycle in zip(found.revolutions, cycles, strict=True):
        assert {f.reason.split()[0] for f in revolution.failures if f.criterion == 3} == cycle.repeated
        assert revolution.park_literal == (cycle.at_park == "turn_point_dec")
        assert revolution.park_deceleration == (cycle.at_park in DECELERATIONS)
        assert revolution.turn == ("turn_point_acc" in cycle.entered)


@settings(max_examples=40, deadline=None)
@given(parameters, contact, currents, st.floats(0.0, 0.2), st.floats(0.0, 0.2))
def test_wider_tolerances_never_fail_what_passed(
    chart: Parameters, opened: Levels, current: Levels, early: float, late: float
) -> None:
    run, _ = drive(chart, opened, current)
    strict, wide = score(run), score(run, Rules(early=early, late=late, position=0.5, repeats="separate"))
    for a, b in zip(strict.revolutions, wide.revolutions, strict=True):
        assert a.park_literal <= a.park_deceleration
        assert a.park_literal <= b.park_literal
        assert a.park_deceleration <= b.park_deceleration
        assert a.turn <= b.turn
    grouped = score(run, Rules(early=early, late=late)).counts
    assert grouped.park_deceleration <= wide.counts.park_deceleration


@settings(max_examples=8, deadline=None)
@given(
    st.lists(st.tuples(st.floats(0.1, 2.0), st.floats(-8.0, 8.0)), min_size=1, max_size=10),
    st.sampled_from([1, 5, 20, 50]),
    st.sampled_from(["linkage", "rig"]),
)
def test_whatever_a_hand_on_the_load_does(pulses: Levels, sample_time: int, system: str) -> None:
    # the FMUs in closed loop, braked and pushed at random at the gear's output shaft
    ends = np.cumsum([length for length, _ in pulses])
    rows = [
        f"{at!r},{torque!r}" for at, torque in zip([0.0, *ends.tolist()], [*(t for _, t in pulses), 0.0], strict=True)
    ]
    text = f"# system: {system}\n# controller: voltage_profile\n# sample_time: {sample_time} ms\n# stop: 20 s\n"
    with TemporaryDirectory() as folder:
        file = Path(folder) / "pushed.csv"
        file.write_text(text + "time [s],tau_disturbance [N.m]\n" + "\n".join(rows) + "\n")
        result = simulate(assemble(read(file), catalogue.ensure), stop=20.0, output_interval=1e-3, tolerance=1e-6)
    duty = result.columns["controller.duty"]
    assert duty.min() >= 0.0
    assert duty.max() <= 1.0
    states = [result.literals["controller.state"][k - 1] for k in result.columns["controller.state"]]
    cycles = cycles_of(states, (result.columns["plant.park"] > 0).tolist(), len(states))
    found = score(result, Rules(position=np.inf))
    assert len(found.revolutions) == len(cycles)
    for revolution, cycle in zip(found.revolutions, cycles, strict=True):
        assert {f.reason.split()[0] for f in revolution.failures if f.criterion == 3} == cycle.repeated
        assert revolution.turn == ("turn_point_acc" in cycle.entered and not cycle.repeated & TURNS)


def test_every_state_of_the_chart_is_known() -> None:
    assert {state.value.rpartition(".")[2] for state in State} == {
        "IDLE", "Soft_start", "RUN", "turn_point_dec", "turn_point_acc", "Soft_stop"
    }  # fmt: skip
