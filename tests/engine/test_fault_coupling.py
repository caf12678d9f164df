"""Faults on connections between continuous components: the algorithms keep their order and their tolerance."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from both_loops import simulate
from coupled_systems import CoupledSystems, linear
from numpy.typing import NDArray

from cosim.engine import Algorithm, Fault


def motor_with(share: float) -> NDArray[np.float64]:
    """The matrix of i and w; the rotor gets a share of the torque."""
    R, L, k, J, d = 1.0, 0.5, 1.0, 0.25, 0.1
    return np.array([[-R / L, -k / L], [share * k / J, -d / J]])


def oscillator_with(share: float) -> NDArray[np.float64]:
    """The matrix of x1, v1, x2, v2; the coupling sees a share of x1, which it feeds through to its force."""
    c, d, cc, dc = 10.0, 0.2, 5.0, 0.3
    force = np.array([-share * cc, -dc, cc, dc])
    one, two = np.array([-c, -d, 0.0, 0.0]) + force, (np.array([0.0, 0.0, -c, -d]) - force) / 2.0
    return np.array([[0.0, 1.0, 0.0, 0.0], one, [0.0, 0.0, 0.0, 1.0], two])


def after_two_seconds(
    matrix: Callable[[float], NDArray[np.float64]], b: list[float], start: list[float]
) -> NDArray[np.float64]:
    """The state, the share having been one half from 0.4 s to 1.2 s."""
    state = np.array(start)
    for length, share in ((0.4, 1.0), (0.8, 0.5), (0.8, 1.0)):
        state = linear(matrix(share), np.array(b), state, np.array([length]))[-1]
    return state


@pytest.mark.parametrize(("algorithm", "power", "finest"), [("gauss-seidel", 1, 2e-3), ("iterated", 2, 2e-5)])
def test_the_error_of_coupling_falls_with_a_fault_as_without(
    coupled: CoupledSystems, algorithm: Algorithm, power: int, finest: float
) -> None:
    """A motor in two parts, whose rotor gets half the torque for a while."""
    system = coupled.system("motor", 3)
    system.faults = [Fault(("rotor", "tau"), "scale", 0.5, 0.4, 1.2)]
    w = after_two_seconds(motor_with, [2.0, 0.0], [0.0, 0.0])[1]
    errors = []
    for interval in (8e-3, 4e-3):
        result = simulate(system, stop=2.0, output_interval=interval, tolerance=1e-8, algorithm=algorithm)
        errors.append(abs(result.columns["rotor.w"][-1] - w))
    assert errors[1] < finest
    assert errors[0] / errors[1] == pytest.approx(2.0**power, rel=0.2)


@pytest.mark.parametrize(
    ("name", "target", "state", "column"),
    [
        ("motor", ("rotor", "tau"), after_two_seconds(motor_with, [2.0, 0.0], [0.0, 0.0]), "rotor.w"),
        (
            "oscillator",
            ("second", "x1"),
            after_two_seconds(oscillator_with, [0.0] * 4, [1.0, 0.0, 0.0, 0.0]),
            "first.v",
        ),
    ],
)
def test_adaptive_macro_steps_meet_their_tolerance_with_a_fault(
    coupled: CoupledSystems, name: str, target: tuple[str, str], state: NDArray[np.float64], column: str
) -> None:
    """Also where the fault makes an output jump, as the oscillator's force does when a share of x1 is left."""
    system = coupled.system(name, 3)
    system.faults = [Fault(target, "scale", 0.5, 0.4, 1.2)]
    result = simulate(system, stop=2.0, output_interval=0.01, tolerance=1e-4)
    assert result.statistics["algorithm"]["name"] == "adaptive"  # type: ignore[index]
    values = result.columns[column]
    assert abs(values[-1] - state[1]) < 1e-4 * np.abs(values).max()
