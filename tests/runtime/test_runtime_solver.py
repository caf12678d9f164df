"""Integration: against closed forms and against scipy's Radau at tight tolerance."""

from __future__ import annotations

import math

import numpy as np
import pytest
from runtime_harness import Sample
from scipy.integrate import solve_ivp


@pytest.mark.parametrize(("tolerance", "bound"), [(1e-4, 5e-4), (1e-6, 5e-6), (1e-8, 5e-8), (1e-10, 5e-10)])
def test_error_of_the_oscillator_follows_the_tolerance(tolerance: float, bound: float) -> None:
    sample = Sample("oscillator").start(tolerance)
    sample.step(10.0)
    assert sample.time == 10.0
    assert sample.get(1) == pytest.approx(math.cos(20.0), abs=bound)
    assert sample.get(2) == pytest.approx(-2.0 * math.sin(20.0), abs=2.0 * bound)


def test_steps_grow_as_the_fifth_root_of_the_tolerance() -> None:
    """A tolerance 1e5 times smaller needs ten times as many steps."""
    steps = {}
    for tolerance in (1e-6, 1e-11):
        sample = Sample("oscillator").start(tolerance)
        sample.step(10.0)
        steps[tolerance] = sample.counters(10)["steps"]
    assert 8.0 < steps[1e-11] / steps[1e-6] < 12.0


def error_of_one_step(h: float, look_at: float) -> float:
    """Of the chain's outer states, at a point inside or at the end of a single step of length h."""
    solution = solve_ivp(
        lambda t, x: chain_rate(t, x, 0.3), (0, h * look_at), [1, 2, 3, 4], method="DOP853", rtol=1e-13, atol=1e-13
    )
    sample = Sample("chain").enter(0.999, 0.0, stop=h)
    sample.set(5, 0.3)
    sample.exit().step_to(h * look_at)
    assert sample.counters(6)["steps"] == 1
    return float(np.abs(np.array(sample.get(1, 2)) - solution.y[[0, 3], -1]).max())


@pytest.mark.parametrize(("look_at", "order"), [(1.0, 5), (0.3, 4), (0.7, 4)])
def test_order_of_a_step_and_of_its_dense_output(look_at: float, order: int) -> None:
    """On a nonlinear, time-dependent system of index 1; the error of one step has one power of h more."""
    errors = [error_of_one_step(h, look_at) for h in (0.1, 0.05, 0.025)]
    powers = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert powers == pytest.approx(order + 1, abs=0.5)


def test_small_communication_steps_end_exactly_and_do_not_shrink_the_step_size() -> None:
    sample = Sample("oscillator").start(1e-4)
    for k in range(1000):
        sample.step_to((k + 1) * 1e-3)
        assert sample.get(0) == (k + 1) * 1e-3
    before = sample.counters(10)["steps"]
    sample.step(1.0)
    assert sample.counters(10)["steps"] - before < 15
    assert sample.get(1) == pytest.approx(math.cos(4.0), abs=1e-4)


def test_tiny_communication_steps_do_not_spoil_the_step_size() -> None:
    sample = Sample("oscillator").start(1e-10)
    sample.step_to(1.0)
    before = sample.counters(10)["steps"]
    for k in range(10):
        sample.step_to(1.0 + (k + 1) * 0.1 + 1e-9)
        sample.step(1e-9)
    assert sample.counters(10)["steps"] - before < 210  # 164 without the tiny steps


def test_start_time_far_from_zero() -> None:
    """Seconds since 1970: one bit of the time is 2.4e-7 s."""
    sample = Sample("oscillator").start(1e-6, start=1.7e9)
    sample.step(1.0)
    assert sample.get(1) == pytest.approx(math.cos(2.0), abs=1e-5)
    assert sample.counters(10)["steps"] < 40


def test_start_time_and_parameters_are_used() -> None:
    sample = Sample("oscillator").start(1e-8, start=100.0, v5=3.0, v6=0.5)
    assert sample.get(0, 1, 5, 7) == [100.0, 0.5, 3.0, 9.0]
    sample.step(2.0)
    assert sample.get(1) == pytest.approx(0.5 * math.cos(6.0), abs=1e-7)


def test_input_is_held_over_the_step() -> None:
    """A constant force shifts the point of rest: x = u / omega^2 + (1 - u / omega^2) cos(omega t)."""
    sample = Sample("oscillator").start(1e-8)
    sample.set(4, 2.0)
    sample.step(3.0)
    assert sample.get(1) == pytest.approx(0.5 + 0.5 * math.cos(6.0), abs=1e-7)


@pytest.mark.parametrize(("tolerance", "bound"), [(1e-4, 1e-3), (1e-6, 1e-5), (1e-8, 1e-7)])
@pytest.mark.parametrize(("mu", "end", "most_steps"), [(1.0, 10.0, 1000), (1000.0, 2000.0, 3000)])
def test_van_der_pol(mu: float, end: float, most_steps: int, tolerance: float, bound: float) -> None:
    reference = solve_ivp(
        lambda _t, y: [y[1], mu * (1.0 - y[0] ** 2) * y[1] - y[0]],
        (0.0, end), [2.0, 0.0], method="Radau", rtol=1e-10, atol=1e-10,
    ).y[:, -1]  # fmt: skip
    sample = Sample("van_der_pol").start(tolerance, v3=mu)
    sample.step(end)
    assert sample.get(1) == pytest.approx(reference[0], abs=bound)
    assert sample.counters(4)["steps"] < most_steps


def test_robertson_as_a_dae_over_nine_decades() -> None:
    def rate(_t: float, y: np.ndarray) -> list[float]:
        flow = 0.04 * y[0] - 1e4 * y[1] * y[2]
        return [-flow, flow - 3e7 * y[1] ** 2, 3e7 * y[1] ** 2]

    reference = solve_ivp(rate, (0.0, 4e5), [1.0, 0.0, 0.0], method="Radau", rtol=1e-10, atol=1e-15).y[:, -1]
    sample = Sample("robertson").start(1e-7)
    sample.step(4e5)
    values = np.array(sample.get(1, 2, 3))
    assert values == pytest.approx(reference, rel=1e-5)
    assert abs(values.sum() - 1.0) < 1e-15
    assert sample.counters(4)["steps"] < 500


def chain_rate(t: float, x: np.ndarray, u: float) -> np.ndarray:
    """The right-hand side of the chain, its flows by Newton to rounding."""
    k = np.arange(4)
    z = np.zeros(4)
    for _ in range(50):
        residual = 4.0 * z + z**3 + 0.2 * z.sum() + (k + 1.0) * x + 0.1 * x.sum()
        z = z - np.linalg.solve(np.diag(4.0 + 3.0 * z**2) + 0.2, residual)
    return np.asarray(z - 0.1 * z.sum() + math.cos(t) + u)


def test_chain_of_coupled_states_and_algebraic_unknowns() -> None:
    reference = solve_ivp(lambda t, x: chain_rate(t, x, 0.3), (0, 3), [1, 2, 3, 4], rtol=1e-10, atol=1e-10).y[:, -1]
    errors = []
    for tolerance in (1e-4, 1e-6, 1e-8):
        sample = Sample("chain").start(tolerance)
        sample.set(5, 0.3)
        sample.step(3.0)
        errors.append(abs(sample.get(1) - reference[0]))
    assert errors[0] < 1e-3
    assert errors[1] < 1e-5
    assert errors[2] < 1e-7


def test_four_bar_keeps_its_branch_and_its_lengths() -> None:
    """Ten revolutions from start values of zero, where the closure equations are singular."""
    sample = Sample("four_bar").start(1e-5)
    a, f, b, g = sample.get(4, 5, 6, 7)
    side = math.copysign(1.0, math.sin(sample.get(2) - sample.get(3)))
    for _ in range(200):
        sample.step(math.pi / 10.0)
        crank, coupler, rocker = sample.get(1, 2, 3)
        dx, dy = g - a * math.cos(crank), -a * math.sin(crank)
        diagonal = math.hypot(dx, dy)
        inside = math.acos((f**2 + diagonal**2 - b**2) / (2.0 * f * diagonal))
        expected = math.atan2(dy, dx) - side * inside
        assert math.remainder(coupler - expected, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-12)
        assert a * math.cos(crank) + f * math.cos(coupler) == pytest.approx(g + b * math.cos(rocker), abs=1e-14)
    assert sample.get(1) == pytest.approx(20.0 * math.pi, rel=1e-12)


def test_published_values_satisfy_the_algebraic_equations() -> None:
    sample = Sample("algebraic").start(1e-3)
    for k in range(40):
        if k % 4 == 0:
            sample.set(4, math.sin(k))
            assert np.abs(sample.get(6, 7)).max() < 1e-12  # already before the step
        sample.step(0.13)
        assert np.abs(sample.get(6, 7)).max() < 1e-12
        assert sample.get(8) == -sample.get(2)
        assert sample.get(5) == sample.get(2) + sample.get(3)


def test_algebraic_equations_are_solved_over_long_ways() -> None:
    """From 21 to -21 past the point where the cubic is flat; exp(-z1) becomes 2e9."""
    sample = Sample("algebraic").start()
    for u in (1e4, -1e4, 1e3, -1e3, 0.0):
        sample.set(4, u)
        z = sample.get(2)
        assert z**3 + z == pytest.approx(2.0 + u + 0.1, rel=1e-12)
        assert sample.get(3) == pytest.approx(math.exp(-z), rel=1e-12)


def test_looking_at_values_does_not_change_the_future() -> None:
    watched, unwatched = Sample("algebraic").start(1e-4), Sample("algebraic").start(1e-4)
    for k in range(20):
        watched.step_to((k + 1) * 0.1)
        watched.get(1, 2, 3, 5, 6, 7, 8)
        unwatched.step_to((k + 1) * 0.1)
    assert watched.get(1, 2, 3) == unwatched.get(1, 2, 3)
