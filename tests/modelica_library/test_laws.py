"""Components against the laws they state."""

from __future__ import annotations

import numpy as np
import pytest

from .conftest import Simulate


def test_motor_start_follows_the_closed_form(simulate: Simulate) -> None:
    run = simulate("Tests.MotorStart", 0.1, step=5e-4)
    assert np.abs(run["i_error"]).max() < 1e-5
    assert np.abs(run["w_error"]).max() < 1e-4


def test_motor_without_load_draws_the_no_load_current(simulate: Simulate) -> None:
    run = simulate("Tests.MotorStart", 1.0, step=0.01)
    assert run["bridge.i"][-1] == pytest.approx(0.58, abs=1e-6)


def test_current_never_reverses_when_the_supply_is_switched_off(simulate: Simulate) -> None:
    run = simulate("Tests.BridgeRunOut", 0.3, step=5e-4)
    time, current, speed = run["time"], run["bridge.i"], run["motor.rotor.w"]
    assert current.min() > -1e-9
    coast = (time > 0.11) & (time < 0.1995)
    assert np.all(current[coast] == 0)
    # the diode blocks, so the rotor sees its friction alone and the terminals show the back-EMF
    friction = 0.113**2 * 0.58 / (28 - 1.91 * 0.58)
    decay = speed[coast][0] * np.exp(-friction / 1e-4 * (time[coast] - time[coast][0]))
    assert speed[coast] == pytest.approx(decay, rel=1e-5)
    assert run["bridge.v"][coast] == pytest.approx(0.113 * speed[coast], rel=1e-6)
    assert current[-1] > 0.5


def test_current_limit_holds_and_lets_go(simulate: Simulate) -> None:
    run = simulate("Tests.BridgeLimit", 0.3, step=5e-4)
    time, current, voltage = run["time"], run["bridge.i"], run["bridge.v"]
    held = run["bridge.limiting"] == 1
    assert np.all(current[held] == 5)
    assert current.max() < 5 + 1e-6
    # the limit lets go a millivolt beyond the drive
    assert voltage.max() < 28 + 1.01e-3
    # it lets go where the whole supply is needed: v = R i + k w
    last = time[held][-1]
    assert pytest.approx(1.91 * 5 + 0.113 * np.interp(last, time, run["motor.rotor.w"]), abs=0.2) == 28


def test_shorted_motor_brakes_and_the_measured_current_stays_positive(simulate: Simulate) -> None:
    run = simulate("Tests.BridgeBrake", 0.3, step=5e-4)
    shorted = (run["time"] > 0.1005) & (run["time"] < 0.1995)
    assert np.abs(run["bridge.v"][shorted]).max() < 1e-12
    assert run["bridge.i"][shorted].min() < -10
    assert run["motor.rotor.w"][shorted][-1] < 1
    assert run["bridge.i_switch"].min() >= 0
    assert run["bridge.i_switch"][-1] > 0.5


@pytest.mark.parametrize(("name", "efficiency"), [("GearDriving", 1 / 0.74), ("GearBackDriven", 0.65)])
def test_gear_loses_the_share_of_its_direction(simulate: Simulate, name: str, efficiency: float) -> None:
    run = simulate(f"Tests.{name}", 2.0, step=0.01)
    assert run["gear.tau_worm"][-1] * 73 / run["gear.tau_gear"][-1] == pytest.approx(efficiency, rel=1e-6)
    assert run["gear.P_loss"].min() > -1e-9


def test_pendulum_keeps_its_energy(simulate: Simulate) -> None:
    run = simulate("Tests.Pendulum", 5.0, step=0.01)
    assert np.ptp(run["E"]) < 1e-6
    # m = 2.35 kg at 0.25 m, hanging: small oscillations of period 2 pi sqrt(l/g)
    crossings = run["time"][1:][np.diff(np.sign(run["arm.w"])) > 0]
    assert np.diff(crossings).mean() == pytest.approx(2 * np.pi * np.sqrt(0.25 / 9.80665), rel=1e-2)


@pytest.mark.parametrize("branch", [1, -1])
def test_bars_and_joints_follow_the_circle_intersection(simulate: Simulate, branch: int) -> None:
    run = simulate("Tests.SingleFourBar", 4.5, step=0.01, modifier=f"branch={branch}")
    assert np.abs(run["x_error"]).max() < 1e-9
    assert np.abs(run["y_error"]).max() < 1e-9


@pytest.mark.parametrize("name", ["LinkageEnergy", "RigEnergy"])
def test_energy_is_conserved(simulate: Simulate, name: str) -> None:
    run = simulate(f"Tests.{name}", 3.0, step=0.01)
    assert run["E_in"][-1] > 60
    assert np.abs(run["E_error"]).max() < 1e-4
