"""The scenarios beside those of ``test_scenarios``: each ends where the independent reference ends.

The numbers are those of ``reference.closed_loop`` and ``reference.simulation``, run with what the file says: for the
s-curve with the chart's ramps bent, for 1 kHz and 10 Hz with every pulse of the bridge as a step of its input.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from cosim.engine import Result, simulate
from cosim.fmu import catalogue
from cosim.scenario import assemble, read

FOLDER = Path(__file__).parents[2] / "scenarios"


@dataclass(frozen=True)
class Pin:
    """What a scenario must end with: crank angle [rad], greatest crank torque after 1 s [N.m], park signals."""

    phi_crank: float
    peak_torque: float
    parks: int
    within: float = 1e-4
    """Of the crank angle, absolute [rad]."""
    torque_within: float = 2e-3
    """Of the torque [N.m]."""


PINS = {
    "linkage_s_curve": Pin(68.951163, 15.0384, 10),
    "linkage_low_speed": Pin(71.476766, 15.0385, 11),
    "linkage_high_speed": Pin(96.471579, 18.5609, 15),
    "linkage_interval": Pin(28.224899, 15.0383, 4),
    "linkage_parking": Pin(31.753184, 15.0373, 5),
    "rig_1ms": Pin(77.930082, 5.7571, 12),
    "rig_2ms": Pin(77.930082, 5.7571, 12),
    "rig_10ms": Pin(77.942620, 5.7571, 12),
    "rig_50ms": Pin(78.655028, 5.7571, 12),
    "rig_20ms_one_rate": Pin(79.260185, 5.7571, 12),
    "rig_1ms_disturbed": Pin(77.887193, 11.4076, 12),
    "rig_2ms_disturbed": Pin(77.887193, 11.4076, 12),
    "rig_10ms_disturbed": Pin(77.889175, 11.4076, 12),
    "rig_20ms_disturbed": Pin(78.514255, 11.3952, 12),
    "rig_50ms_disturbed": Pin(78.591670, 11.3842, 12),
    # the reference of rig_20ms: what the hardware does wrong moves the end by less than a degree a revolution
    "rig_ecu": Pin(78.544300, 5.7571, 12, within=12 * np.pi / 180, torque_within=0.05),
    # the reference whose controller is shown what the faults make of contact and current: test_faulty_scenarios
    "rig_park_stuck_open": Pin(78.652019, 5.7571, 12),
    "rig_park_stuck_closed": Pin(78.517156, 5.7571, 12),
    "rig_noisy_current": Pin(78.556825, 5.7571, 12),
    "rig_late_current": Pin(78.807250, 5.7571, 12),
    # the reference's plant in pieces of 10 ms, with the PI controller written in three lines
    "rig_speed_control": Pin(49.059565, 5.8279, 7),
    # the reference with the averaged bridge: means agree within 0.5 % in continuous conduction
    "rig_pwm_100khz": Pin(12.044776, 5.7594, 1, within=5e-3 * 12.044776, torque_within=5e-3 * 5.7594),
    "rig_pwm_1khz": Pin(12.711983, 4.4261, 2),
    "rig_pwm_10hz": Pin(14.133574, 8.8681, 2, torque_within=1e-2),
}


def run(name: str) -> Result:
    scenario = read(FOLDER / f"{name}.csv")
    return simulate(
        assemble(scenario, catalogue.ensure),
        stop=scenario.stop,
        output_interval=scenario.output_interval,
        tolerance=scenario.tolerance,
    )


@pytest.mark.parametrize("name", PINS)
def test_a_scenario_ends_where_the_reference_ends(name: str) -> None:
    result, pin = run(name), PINS[name]
    columns = result.columns
    assert result.complete
    assert columns["plant.phi_crank"][-1] == pytest.approx(pin.phi_crank, abs=pin.within)
    assert columns["plant.tau_crank"][1000:].max() == pytest.approx(pin.peak_torque, abs=pin.torque_within)
    assert int((np.diff(columns["plant.park"]) > 0).sum()) == pin.parks
    assert columns["plant.i_motor"].min() >= 0.0


@pytest.mark.parametrize(("speed", "k", "R"), [("low", 0.113, 1.91), ("high", 0.0791, 1.337)])
def test_both_coils_keep_their_balance_of_voltages(speed: str, k: float, R: float) -> None:
    """Over whole revolutions the inductance takes nothing: V = R i + k n w in the mean."""
    result = run(f"linkage_{speed}_speed")
    closes = np.flatnonzero(np.diff(result.columns["plant.park"]) > 0)
    turns = slice(closes[2], closes[-1])
    current, motor_speed = (result.columns[f"plant.{name}"][turns].mean() for name in ("i_motor", "w_motor"))
    assert R * current + k * motor_speed == pytest.approx(28.0, rel=1e-3)


def test_an_integral_controller_keeps_the_mean_speed() -> None:
    """Over whole revolutions, once they repeat, the integral returns: so the mean of the samples is the wanted one."""
    result = run("rig_speed_control")
    closes = np.flatnonzero(np.diff(result.columns["plant.park"]) > 0) // 10 * 10
    samples = result.columns["plant.w_crank"][closes[3] : closes[-1] : 10]
    assert samples.mean() == pytest.approx(2.0, rel=5e-4)
    assert samples.max() > 2.2  # it is the mean alone: the weight makes the speed swing
    assert 0.0 < result.columns["controller.duty"].min() < result.columns["controller.duty"].max() < 1.0


def test_in_interval_mode_the_wiper_stops_at_each_contact_and_waits() -> None:
    result = run("linkage_interval")
    time, columns = result.time, result.columns
    closes = time[1:][np.diff(columns["plant.park"]) > 0]
    for on, parked in zip((0.0, 6.0, 12.0, 18.0), closes, strict=True):
        assert on + 1.0 < parked < on + 4.0
        waits = (time > parked + 1.0) & (time < on + 5.999)
        assert np.all(columns["controller.duty"][waits] == 0)
        assert np.abs(columns["plant.w_crank"][waits]).max() < 1e-3
    # the contact opens in the coast; the period learned from then on contains the pause, and no turn is near in it
    assert columns["controller.period"][-1] == pytest.approx(3.0, abs=0.1)
    assert not np.any(columns["controller.state"][time > 12.0] == 4)
