"""Figure 4.8: the scenarios of the switched bridge against closed forms and the averaged bridge."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cosim.fmu import catalogue
from cosim.thesis._pwm import Machine, Pwm, pwm_runs

pytest.importorskip("rumoca")

SCENARIOS = Path(__file__).parents[2] / "scenarios"


@pytest.fixture(scope="module")
def pwm() -> Pwm:
    return pwm_runs(SCENARIOS, catalogue.ensure)


def test_the_steady_cycle_is_one_of_both_exponentials() -> None:
    """The closed forms against an integration of L di/dt = v - R i - E over many periods."""
    machine = Machine(R=1.91, L=3.7614e-3, k=0.113, V=28.0)
    d, period, n = 0.7, 1e-3, 2000
    for emf in (5.0, 17.0, 19.0, 26.0):
        current, step = 0.0, period / n
        decay = np.exp(-step / machine.tau)
        for _ in range(20):
            path = [current]
            for k in range(n):
                v = machine.V if k < d * n else 0.0
                aim = (v - emf) / machine.R
                current = max(0.0, aim + (current - aim) * decay)
                path.append(current)
        low, high = machine.extremes(d, period, np.array(emf))
        assert [min(path), max(path)] == pytest.approx([float(low), float(high)], abs=2e-3)
        assert np.trapezoid(path) / n == pytest.approx(float(machine.mean(d, period, np.array(emf))), abs=2e-3)


def test_at_100_khz_the_mean_current_is_that_of_the_averaged_bridge(pwm: Pwm) -> None:
    for since in (0.0, 2.0):
        assert pwm.mean_current("100khz", since) == pytest.approx(pwm.mean_current("averaged", since), rel=5e-3)


def test_the_ripple_at_1_khz_is_within_2_percent_of_the_closed_form(pwm: Pwm) -> None:
    assert pwm.ripple_error() < 0.02


def test_means_agree_above_half_the_ripple_and_part_below(pwm: Pwm) -> None:
    found, machine = pwm.periods("1khz"), pwm.machine
    above = found.averaged > 1.05 * machine.half_ripple(pwm.duty, 1e-3)
    below = found.averaged < 0.95 * machine.half_ripple(pwm.duty, 1e-3)
    assert above.any()
    assert below.any()
    np.testing.assert_allclose(found.mean[above], found.averaged[above], rtol=5e-3)
    assert np.all(found.mean[below] > found.averaged[below])
    np.testing.assert_allclose(found.mean, machine.mean(pwm.duty, 1e-3, found.emf), rtol=0.03)


def test_at_10_hz_the_current_stops_in_every_period(pwm: Pwm) -> None:
    found = pwm.periods("10hz")
    assert np.all(found.trough == 0.0)
    assert not pwm.flowing("10hz", 0.1).any()
    assert pwm.mean_current("10hz", 2.0) > 1.2 * pwm.mean_current("averaged", 2.0)
