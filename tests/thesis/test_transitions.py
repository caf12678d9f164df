"""Figure 3.11 transition by transition: what leads out of each state, at which tick, and what does not."""

from __future__ import annotations

import numpy as np
import pytest

from cosim.engine import Channel, Component, Fmu, System, simulate
from cosim.fmu import catalogue

pytest.importorskip("rumoca")

IDLE, START, RUN, DEC, ACC, STOP = "IDLE", "Soft_start", "RUN", "turn_point_dec", "turn_point_acc", "Soft_stop"
TICK = 1e-3
Steps = list[tuple[float, float]]
OPEN: Steps = [(0.0, 0.0)]
LOW: Steps = [(0.0, 0.5)]
"""Below 1.03 times the no-load current, the least threshold there is."""
RISEN: Steps = [(0.0, 0.6), (0.79, 0.7)]
"""More than 3 % above the least current of the last second, until 0.6 A has left the window at 1.78 s."""
TURNING = [(0.0, START), (0.1, RUN), (0.901, DEC), (1.001, ACC), (1.101, RUN)]
"""After Ts, after more than period - 2 Ts in RUN.RUN with period = 1 s, and twice after Ts."""


def contact(*closings: float) -> Steps:
    """A contact that closes at these times [s], for 12 ms each."""
    return [(0.0, 0.0), *((at + late, value) for at in closings for late, value in ((0.0, 1.0), (0.012, 0.0)))]


def entries(park: Steps, current: Steps, enable: Steps, stop: float) -> list[tuple[float, str]]:
    """Return when each state is entered [s], the first one included."""
    inputs = {"park": park, "i_motor": current, "enable": enable}
    channels = [
        Channel(("c", name), *(list(part) for part in zip(*steps, strict=True))) for name, steps in inputs.items()
    ]
    system = System([Component("c", Fmu.read(catalogue.ensure("voltage_profile")))], [], channels)
    result = simulate(system, stop=stop, output_interval=TICK, tolerance=1e-6)
    state = result.columns["c.state"]
    changed = [0, *(np.flatnonzero(np.diff(state)) + 1).tolist()]
    names = result.literals["c.state"]
    return [(round(float(result.time[k]), 6), names[state[k] - 1]) for k in changed]


@pytest.mark.parametrize(
    ("park", "current", "enable", "stop", "expected"),
    [
        pytest.param(OPEN, LOW, [(0.0, 0.0)], 0.3, [(0.0, IDLE)], id="IDLE stays while it is not enabled"),
        pytest.param(OPEN, LOW, [(0.0, 0.0), (0.2, 1.0)], 0.25, [(0.0, IDLE), (0.2, START)], id="enable ends IDLE"),
        pytest.param(contact(0.05), LOW, [(0.0, 1.0)], 0.3, TURNING[:2], id="Soft_start knows no park signal"),
        pytest.param(OPEN, LOW, [(0.0, 1.0)], 1.8, TURNING, id="the turn, in time"),
        pytest.param(OPEN, RISEN, [(0.0, 1.0)], 1.779, TURNING[:2], id="no turn at a current above the threshold"),
        pytest.param(OPEN, RISEN, [(0.0, 1.0)], 1.8, [*TURNING[:2], (1.78, DEC)], id="a turn once it is below"),
        pytest.param(contact(0.5), LOW, [(0.0, 1.0)], 0.52, [*TURNING[:2], (0.5, STOP)], id="park leads out of RUN"),
        pytest.param(contact(0.901), LOW, [(0.0, 1.0)], 0.95, [*TURNING[:2], (0.901, STOP)], id="park before the turn"),
        pytest.param(contact(0.95), LOW, [(0.0, 1.0)], 0.97, [*TURNING[:3], (0.95, STOP)], id="park leads out of dec"),
        pytest.param(contact(1.05), LOW, [(0.0, 1.0)], 1.07, [*TURNING[:4], (1.05, STOP)], id="park leads out of acc"),
        pytest.param(OPEN, LOW, [(0.0, 1.0)], 1.92, [*TURNING, (1.901, STOP)], id="the end is predicted once turned"),
        pytest.param(OPEN, [(0.0, 0.6), (0.79, 0.7), (1.7, 0.9)], [(0.0, 1.0)], 2.6, TURNING[:2], id="and not before"),
        pytest.param(OPEN, LOW, [(0.0, 1.0)], 2.0, [*TURNING, (1.901, STOP), (1.951, START)], id="anew after Ts/2"),
        pytest.param(
            contact(1.92), LOW, [(0.0, 1.0)], 2.0, [*TURNING, (1.901, STOP), (1.951, START)],
            id="Soft_stop knows no park signal",
        ),
        pytest.param(
            contact(0.7), LOW, [(0.0, 1.0), (0.4, 0.0)], 1.0, [*TURNING[:2], (0.7, IDLE)],
            id="switched off it runs on to the contact",
        ),
        pytest.param(
            OPEN, LOW, [(0.0, 1.0), (1.5, 0.0)], 2.5, TURNING, id="switched off no end is predicted",
        ),
    ],
)  # fmt: skip
def test_a_transition(
    park: Steps, current: Steps, enable: Steps, stop: float, expected: list[tuple[float, str]]
) -> None:
    assert entries(park, current, enable, stop) == expected


def test_half_a_revolution_is_measured_from_opening_to_opening() -> None:
    """The period of the next revolution: its turn comes period - 2 Ts after RUN is entered."""
    found = entries(contact(0.1, 1.3), LOW, [(0.0, 1.0)], 2.0)
    start = next(time for time, state in found if state == START and time > 1.3)
    turn = next(time for time, state in found if state == DEC and time > start)
    assert turn == pytest.approx(start + 0.1 + (1.2 / 2 - 0.2) + TICK, abs=1e-9)
