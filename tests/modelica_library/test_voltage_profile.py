"""The voltage profile's rules, one by one."""

from __future__ import annotations

import numpy as np
import pytest

from .conftest import Columns, Simulate

IDLE, SOFT_START, RUN, DEC, ACC, SOFT_STOP = 1, 2, 3, 4, 5, 6
BLOCK = "Controllers.VoltageProfile"
CALM = "if time < 0.79 then 1 else 2"
"""A current that invites no turn while 1 A is in the window."""


def entries(run: Columns) -> list[tuple[float, int]]:
    """Time and name of every state entered, the first tick's included."""
    state = run["state"]
    changed = np.nonzero(np.diff(state))[0] + 1
    return [(0.0, int(state[0])), *((round(float(run["time"][k]), 6), int(state[k])) for k in changed)]


def test_duty_follows_figure_3_12(simulate: Simulate) -> None:
    run = simulate("Tests.ProfileTrajectory", 2.0, step=1e-3)
    time, duty = run["time"], run["controller.duty"]
    drawn = np.interp(time, [0, 0.1, 0.9, 1, 1.1, 1.9, 2], [0.7, 1, 1, 0.3, 1, 1, 0.7])
    # the figure is continuous, the chart holds for 1 ms and compares with ">", which takes one more tick
    assert np.abs(duty - drawn).max() < 3 * 0.007
    assert duty[0] == 0.7
    assert duty.min() == pytest.approx(0.3, abs=1e-12)


def test_states_change_on_their_ticks(simulate: Simulate) -> None:
    run = simulate(BLOCK, 2.0, step=5e-4, modifier="i_motor=0.5, park=time < 0.05, enable=true")
    assert entries(run) == [(0, SOFT_START), (0.1, RUN), (0.901, DEC), (1.001, ACC), (1.101, RUN), (1.901, SOFT_STOP),
                            (1.951, SOFT_START)]  # fmt: skip


def test_no_turn_while_the_current_is_above_the_threshold(simulate: Simulate) -> None:
    # 0.6 A is in the window until 1.8 s, and 0.7 A is more than 3 % above it
    run = simulate(BLOCK, 3.0, step=1e-3, modifier="i_motor=if time < 0.79 then 0.6 else 0.7, park=false, enable=true")
    assert entries(run)[:3] == [(0, SOFT_START), (0.1, RUN), (1.78, DEC)]


def test_idle_takes_one_tick_if_asked(simulate: Simulate) -> None:
    run = simulate(BLOCK, 2.0, step=5e-4, modifier="i_motor=0.5, park=false, enable=true, idle_step=true")
    assert entries(run)[-3:] == [(1.901, SOFT_STOP), (1.951, IDLE), (1.952, SOFT_START)]
    gap = (run["time"] > 1.9511) & (run["time"] < 1.9519)
    assert np.all(run["duty"][gap] == 0)


def test_period_is_half_the_time_between_falling_edges(simulate: Simulate) -> None:
    park = "time < 0.05 or time > 2.0505 and time < 2.0704 or time > 2.1 and time < 2.15"
    run = simulate(BLOCK, 2.3, step=5e-4, modifier=f"i_motor=2, park={park}, enable=true")

    def at(instant: float) -> float:
        return float(run["period"][np.searchsorted(run["time"], instant)])

    assert at(1.0) == 1.0  # 0.025 s is no half revolution
    assert at(2.09) == pytest.approx((2.071 - 0.05) / 2, abs=1e-12)
    assert at(2.2) == 1.0  # nor is 0.04 s


def test_park_ends_the_revolution_before_the_prediction(simulate: Simulate) -> None:
    run = simulate(BLOCK, 1.7, step=5e-4, modifier=f"i_motor={CALM}, park=time < 0.3 or time > 1.4995, enable=true")
    # the contact on which it began is still closed on entry into RUN and does not count
    assert entries(run) == [(0, SOFT_START), (0.1, RUN), (1.5, SOFT_STOP), (1.55, SOFT_START), (1.65, RUN)]


def test_current_is_blanked_held_and_compared_with_the_least_of_the_window(simulate: Simulate) -> None:
    run = simulate(BLOCK, 2.0, step=1e-3, modifier="i_motor=1 + time, park=false, enable=true")
    time, seen = run["time"], run["i_real"]
    assert np.all(seen[time < 0.2995] == 0)
    late = time > 0.3205
    held = 1 + 0.02 * np.floor(time[late] / 0.02 + 1e-6)
    off_grid = np.abs(time[late] / 0.02 - np.round(time[late] / 0.02)) > 1e-3
    assert seen[late][off_grid] == pytest.approx(held[off_grid], abs=1e-9)
    # 50 samples of 20 ms after the last zero, at 0.28 s, the window holds current only
    assert np.all(run["i_limit"][time < 1.2795] == pytest.approx(1.03 * 0.58))
    assert run["i_limit"][np.searchsorted(time, 1.29)] == pytest.approx(1.03 * 1.3)


def test_moving_average_spans_the_filter_time(simulate: Simulate) -> None:
    modifier = "i_motor=if time < 0.1 then 0 else 1, park=false, enable=true, T_filter=0.125"
    run = simulate(BLOCK, 0.4, step=1e-3, modifier=modifier)
    time = run["time"]
    ramp = np.clip(np.floor((time - 0.1) / 1e-3 + 1e-6) + 1, 0, 125) / 125
    settled = np.abs(time / 1e-3 - np.round(time / 1e-3)) > 1e-3
    assert run["i_filtered"][settled] == pytest.approx(ramp[settled], abs=1e-12)
    assert run["i_filtered"][-1] == pytest.approx(1, abs=1e-12)


def test_floor_holds_in_every_state_but_idle(simulate: Simulate) -> None:
    modifier = "i_motor=0.5, park=false, enable=time > 0.2, duty_min=0.35"
    run = simulate(BLOCK, 2.5, step=1e-3, modifier=modifier)
    assert np.all(run["duty"][run["state"] == IDLE] == 0)
    assert run["duty"][run["state"] != IDLE].min() == 0.35


def test_switched_off_the_wiper_runs_on_to_the_contact(simulate: Simulate) -> None:
    park = "time < 0.05 or time > 2.5995 and time < 2.62"
    run = simulate(BLOCK, 3.0, step=1e-3, modifier=f"i_motor=0.5, park={park}, enable=time < 1.5")
    # the prediction at 1.901 s is ignored, the contact at 2.6 s is not
    assert entries(run)[-2:] == [(1.101, RUN), (2.6, IDLE)]
    assert run["duty"][-1] == 0


def test_delay_shifts_the_duty_ratio_by_whole_ticks(simulate: Simulate) -> None:
    modifier = "i_motor=0.5, park=false, enable=true"
    runs = [simulate(BLOCK, 2.0, step=5e-4, modifier=f"{modifier}, T_delay={delay}") for delay in (0, 0.005)]
    middle = np.arange(0.0075, 2, 1e-3)
    now, late = (run["duty"][np.searchsorted(run["time"], middle - shift) - 1]
                 for run, shift in zip(runs, (0.005, 0), strict=True))  # fmt: skip
    assert np.array_equal(now, late)
    assert np.all(runs[1]["duty"][runs[1]["time"] < 0.0049] == 0)


@pytest.mark.parametrize(
    ("modifier", "message"),
    [
        ("T_ramp=0", "T_ramp must be positive"),
        ("stop_ratio=0", "stop_ratio must be positive"),
        ("T_sample=0.0205", "T_sample must be a multiple of T_compute"),
        ("T_filter=1.025", "T_filter must not exceed 1024 periods"),
        ("n_window=257", "n_window must lie between 1 and 256"),
        ("T_delay=0.065", "T_delay must be a multiple of T_compute, from 0 to 64"),
    ],
)
def test_parameters_beyond_the_capacity_are_refused(simulate: Simulate, modifier: str, message: str) -> None:
    with pytest.raises(Exception, match=message):
        simulate(BLOCK, 0.01, step=1e-3, modifier=f"i_motor=0.5, park=false, enable=true, {modifier}")


@pytest.mark.slow
def test_closed_loop_on_the_rig_passes_through_every_state(simulate: Simulate) -> None:
    run = simulate("Systems.RigClosedLoop", 5.0, step=0.005, tolerance=1e-6,
                   modifier="v_supply=28, tau_disturbance=0, enable=true")  # fmt: skip
    assert set(run["controller.state"].astype(int)) == {SOFT_START, RUN, DEC, ACC, SOFT_STOP}
    assert run["plant.i_motor"].min() > -1e-9
    assert run["plant.phi_crank"][-1] > 2 * 2 * np.pi


@pytest.mark.slow
def test_closed_loop_on_the_linkage_starts_softly(simulate: Simulate) -> None:
    run = simulate("Systems.ClosedLoop", 0.5, step=0.005, tolerance=1e-6,
                   modifier="v_supply=28, tau_disturbance=0, enable=true")  # fmt: skip
    # 70 % of 28 V over the armature's 1.91 Ohm
    assert 8 < run["plant.i_motor"].max() < 0.7 * 28 / 1.91
