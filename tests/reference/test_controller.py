"""The reference controller against the chart of FACTS, tick by tick, and the closed loop against the open one."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from .closed_loop import closed_loop
from .controller import Controller, Outputs, Parameters, State
from .plant import Plant, linkage_plant, rig_plant
from .simulation import simulate

FIRST_CONTACT = 20
PLANTS = pytest.mark.parametrize("plant", [linkage_plant(), rig_plant()], ids=["linkage", "rig"])


def contacts(*starts: int, length: int = 12) -> Callable[[int], bool]:
    """Park on at tick 0 for 20 ticks, then at the given ticks."""
    return lambda k: k < FIRST_CONTACT or any(s <= k < s + length for s in starts)


def run(
    count: int,
    park: Callable[[int], bool],
    parameters: Parameters | None = None,
    current: Callable[[int], float] = lambda k: 0.0,
    enable: Callable[[int], bool] = lambda k: True,
) -> list[Outputs]:
    controller = Controller(parameters)
    return [controller.step(k * controller.p.T_compute, current(k), park(k), enable(k)) for k in range(count)]


def changes(outputs: list[Outputs]) -> list[tuple[int, State]]:
    return [(k, o.state) for k, o in enumerate(outputs) if k == 0 or o.state is not outputs[k - 1].state]


def test_trajectory_of_figure_3_12() -> None:
    # The period starts as 1 s; each strict comparison adds one tick to the instants of the figure.
    outputs = run(2100, contacts())
    assert changes(outputs) == [
        (0, State.SOFT_START),
        (100, State.RUN),
        (901, State.TURN_POINT_DEC),
        (1001, State.TURN_POINT_ACC),
        (1101, State.RUN),
        (1901, State.SOFT_STOP),
        (1951, State.SOFT_START),
        (2051, State.RUN),
    ]
    duty = np.array([o.duty for o in outputs])
    corners = np.array([0, 100, 901, 1001, 1101, 1901])
    np.testing.assert_allclose(duty[corners], [0.7, 1, 1, 0.3, 1, 1], atol=1e-12)
    assert duty[1950] == pytest.approx(1 - 0.049 / 0.1 * 2 * 0.3)
    assert duty[1951] == pytest.approx(0.7)
    figure = np.interp(np.arange(1901), corners, [0.7, 1, 1, 0.3, 1, 1])
    np.testing.assert_allclose(duty[:1901], figure, atol=1e-12)


def test_soft_stop_as_figure_3_12_draws_it() -> None:
    outputs = run(2010, contacts(), Parameters(T_soft_stop=0.1))
    assert (2001, State.SOFT_START) in changes(outputs)
    assert outputs[2000].duty == pytest.approx(0.703)


def test_park_ends_the_revolution_and_the_first_contact_does_not() -> None:
    outputs = run(2000, lambda k: k < 150 or 1500 <= k < 1512)
    assert changes(outputs)[-3:] == [(1500, State.SOFT_STOP), (1550, State.SOFT_START), (1650, State.RUN)]
    assert (150, State.SOFT_STOP) not in changes(outputs)


def test_park_precedes_the_inner_transitions() -> None:
    outputs = run(1300, contacts(901))
    assert outputs[901].state is State.SOFT_STOP


def test_period_on_falling_edges() -> None:
    outputs = run(2500, contacts(2000))
    assert [outputs[k].period for k in (0, 20, 2011)] == [1.0, 1.0, 1.0]
    assert outputs[2012].period == pytest.approx((2.012 - 0.020) / 2)


def test_half_tick_periods_are_compared_exactly() -> None:
    # Contacts close to the falling edges at ticks 20 and 2013: the period is 996.5 ticks, so that
    # elapsed > period - 2 Ts first holds at 797 ticks after entry into RUN.
    outputs = run(3100, contacts(2001))
    entries = [k for k, state in changes(outputs) if state is State.TURN_POINT_DEC]
    runs = [k for k, state in changes(outputs) if state is State.RUN]
    assert outputs[2013].period == pytest.approx(0.9965)
    assert entries[-1] - max(k for k in runs if k < entries[-1]) == 797


def test_current_hold_blank_and_window() -> None:
    outputs = run(1500, contacts(), current=lambda k: 2.0 + k * 1e-3, parameters=Parameters(n_window=5))
    real = np.array([o.i_real for o in outputs])
    limit = np.array([o.i_limit for o in outputs])
    assert (real[:300] == 0).all()
    assert real[300] == real[319] == pytest.approx(2.3)
    assert real[320] == pytest.approx(2.32)
    # Zeros leave the window of five samples with the fifth sample after the blank.
    np.testing.assert_allclose(limit[:380], 1.03 * 0.58)
    assert limit[380] == pytest.approx(1.03 * 2.3)
    assert limit[400] == pytest.approx(1.03 * 2.32)


def test_turn_waits_for_a_low_current() -> None:
    outputs = run(1400, contacts(), current=lambda k: 2.0 if k < 1210 else 0.5)
    # 1220 is the first sample of the hold, every 20 ticks, that sees the low current.
    assert (1220, State.TURN_POINT_DEC) in changes(outputs)


def test_moving_average_starts_from_zeros() -> None:
    outputs = run(300, contacts(), Parameters(T_filter=0.125), current=lambda k: 1.0)
    np.testing.assert_allclose([outputs[k].i_filtered for k in (0, 62, 124, 125)], [1 / 125, 63 / 125, 1, 1])


def test_duty_floor_spares_idle_alone() -> None:
    outputs = run(1100, contacts(), Parameters(duty_min=0.35), enable=lambda k: k >= 10)
    assert outputs[9].duty == 0.0
    assert outputs[10].state is State.SOFT_START
    assert min(o.duty for o in outputs[10:]) == 0.35


def test_disabled_drive_runs_on_to_the_contact() -> None:
    outputs = run(3000, contacts(2400), enable=lambda k: k < 500)
    assert changes(outputs)[-1] == (2400, State.IDLE)
    assert not any(o.state is State.SOFT_STOP for o in outputs)
    assert outputs[2399].duty == 1.0
    assert all(o.duty == 0.0 for o in outputs[2400:])


@pytest.mark.parametrize("contact", [None, 1910])
def test_disabled_in_soft_stop(contact: int | None) -> None:
    # Soft_stop runs from 1901 to 1951. If it has met the contact, the drive stops, else it runs on.
    park = contacts(*([contact] if contact else []))
    outputs = run(2000, park, enable=lambda k: k < 1920)
    assert outputs[1951].state is (State.IDLE if contact else State.SOFT_START)


def test_idle_step() -> None:
    outputs = run(2000, contacts(), Parameters(idle_step=True))
    assert changes(outputs)[-2:] == [(1951, State.IDLE), (1952, State.SOFT_START)]
    assert outputs[1951].duty == 0.0


def test_delay_holds_back_every_output() -> None:
    parameters = Parameters(T_delay=0.02)
    plain, late = run(2000, contacts()), run(2000, contacts(), parameters)
    assert late[20:] == plain[:-20]
    assert all(o.duty == 0.0 and o.state is State.IDLE for o in late[:20])


def test_equal_rates_of_20_ms() -> None:
    outputs = run(200, lambda k: k == 0, Parameters(T_compute=0.02))
    # Ramps of 5 ticks; Soft_stop's 2.5 ticks end at the third.
    assert changes(outputs)[:5] == [
        (0, State.SOFT_START),
        (5, State.RUN),
        (46, State.TURN_POINT_DEC),
        (51, State.TURN_POINT_ACC),
        (56, State.RUN),
    ]
    assert changes(outputs)[5:7] == [(96, State.SOFT_STOP), (99, State.SOFT_START)]


def test_wrong_instant_is_refused() -> None:
    with pytest.raises(ValueError, match=r"Tick 0 of the controller is at 0\.0 s, but was called at 0\.5 s\."):
        Controller().step(0.5, 0.0, True, True)


@pytest.mark.slow
@PLANTS
def test_closed_loop_is_the_plant_under_its_own_duty(plant: Plant) -> None:
    # Other integrator, other handling of the diode; the same 2.5 s with the load pushed and braked.
    torque = [(0.0, 0.0), (0.8, 8.0), (1.4005, -5.0)]
    loop = closed_loop(plant, stop=2.5, tau_disturbance=torque)
    values = loop.values
    duty = list(zip(values["time"].tolist(), values["duty"].tolist(), strict=True))
    table = simulate(plant, duty, values["time"], tau_disturbance=torque)
    tight = {"phi_crank": 1e-8, "w_crank": 1e-7, "i_motor": 1e-6, "tau_crank": 1e-5, "v_motor": 1e-6, "park": 0}
    for name, tolerance in tight.items():
        np.testing.assert_allclose(values[name], table[name], rtol=0, atol=tolerance, err_msg=name)


def test_closed_loop_stops_at_the_contact_when_disabled() -> None:
    loop = closed_loop(linkage_plant(), stop=4.0, enable=[(0.0, 1.0), (0.5, 0.0)])
    assert [state for _, state in loop.changes][-1] is State.IDLE
    idle = round(loop.changes[-1][0] / 1e-3)
    assert loop.values["park"][idle] == 1.0
    assert loop.values["phi_crank"][idle] == pytest.approx(2 * np.pi, abs=np.deg2rad(2))
    assert (loop.values["duty"][idle:] == 0).all()
    # What is left is the creep of the joint springs.
    assert loop.values["i_motor"][-1] < 1e-6
    assert abs(loop.values["w_crank"][-1]) < 1e-6


@pytest.mark.slow
@PLANTS
def test_decisions_do_not_depend_on_the_tolerance(plant: Plant) -> None:
    fine, coarse = (closed_loop(plant, stop=25.0, rtol=rtol, atol=rtol / 100) for rtol in (1e-10, 1e-8))
    assert fine.changes == coarse.changes
    np.testing.assert_allclose(fine.values["phi_crank"], coarse.values["phi_crank"], atol=1e-6)
