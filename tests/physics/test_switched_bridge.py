"""The switched bridge against closed forms, and against the averaged one where their means must agree.

Closed forms for a motor at constant speed, with the back-EMF E, tau = L/R and pulses of d T out of T:

* the current flows on from period to period: mean (d V - E)/R as for the averaged bridge; between pulses it goes
  between i_low and i_high, both fixed points of the two exponentials;
* it does not: it rises from zero to i_peak = (V - E)/R (1 - exp(-d T/tau)), freewheels for
  t_f = tau log(1 + R i_peak/E), and as the inductor's mean voltage is zero, R mean = d (V - E) - E t_f/T.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmpy import simulate_fmu

R, L, K, V = 1.91, 3.75e-3 + 2 * 5.7e-6, 0.113, 28.0
TAU = L / R

Simulate = Callable[..., Any]


@pytest.fixture(scope="module")
def simulate(exported: Callable[[str], Path]) -> Simulate:
    def simulate(model: str, stop: float, step: float, outputs: tuple[str, ...], **start: float) -> Any:  # noqa: ANN401
        return simulate_fmu(
            str(exported(f"Tests.{model}")), stop_time=stop, output_interval=step, relative_tolerance=1e-8,
            start_values=start, output=list(outputs),
        )  # fmt: skip

    return simulate


def extremes(d: float, period: float, emf: float) -> tuple[float, float]:
    """Least and greatest current of the steady cycle in continuous conduction."""
    rise, fall = np.exp(-d * period / TAU), np.exp(-(1 - d) * period / TAU)
    up, down = (V - emf) / R, -emf / R
    low = (down * (1 - fall) + up * (1 - rise) * fall) / (1 - rise * fall)
    return low, up + (low - up) * rise


def mean(d: float, period: float, emf: float) -> float:
    """Mean current of the steady cycle, whichever way it conducts."""
    low, _ = extremes(d, period, emf)
    if low >= 0:
        return (d * V - emf) / R
    peak = (V - emf) / R * (1 - np.exp(-d * period / TAU))
    freewheels = TAU * np.log(1 + R * peak / emf)
    return float((d * (V - emf) - emf * freewheels / period) / R)


@pytest.mark.parametrize("duty", [0.3, 0.5, 0.8])
def test_ripple_at_1_khz_is_that_of_the_closed_form(simulate: Simulate, duty: float) -> None:
    period, emf = 1e-3, K * 30.0
    run = simulate("SwitchedMotor", 0.06, 1e-5, ("switched.i",), duty=duty, f_pwm=1e3, w=30.0)
    settled = run["switched.i"][run["time"] > 0.05]
    low, high = extremes(duty, period, emf)
    assert settled.min() == pytest.approx(low, rel=1e-5)
    assert settled.max() == pytest.approx(high, rel=1e-5)
    # the rule of thumb of a current that rises in straight lines
    assert np.ptp(settled) == pytest.approx(V * duty * (1 - duty) * period / L, rel=0.03)


@pytest.mark.parametrize(
    ("frequency", "speed"),
    [(1e5, 30.0), (1e5, 120.0), (1e5, 123.8), (1e3, 30.0), (1e3, 110.0), (1e3, 121.0), (10.0, 10.0), (10.0, 60.0)],
)
def test_means_agree_while_the_current_flows_on_and_part_as_computed_where_it_does_not(
    simulate: Simulate, frequency: float, speed: float
) -> None:
    period, d = 1 / frequency, 0.5
    stop = max(20 * period, 0.04)
    run = simulate("SwitchedMotor", stop, stop / 2, ("q_a", "q_s"), duty=d, f_pwm=frequency, w=speed)
    averaged, switched = (np.diff(run[name])[-1] / (stop / 2) for name in ("q_a", "q_s"))
    emf = K * speed
    assert averaged == pytest.approx((d * V - emf) / R, rel=1e-5)
    assert switched == pytest.approx(mean(d, period, emf), rel=1e-5)
    flows_on = extremes(d, period, emf)[0] > 0
    assert flows_on == (switched == pytest.approx(averaged, rel=1e-4))
    if frequency > 100:  # far below L/R the rule of thumb is good
        assert flows_on == (averaged > V * d * (1 - d) * period / (2 * L))


@pytest.mark.slow
def test_at_100_khz_the_rig_draws_the_mean_current_of_the_averaged_bridge(simulate: Simulate) -> None:
    run = simulate("RigCharge", 0.8, 0.01, ("q_a", "q_s", "averaged.phi_crank", "switched.phi_crank"))
    assert run["q_s"][-1] == pytest.approx(run["q_a"][-1], rel=5e-3)
    moving = run["averaged.phi_crank"] > 0.1
    np.testing.assert_allclose(run["switched.phi_crank"][moving], run["averaged.phi_crank"][moving], rtol=2e-3)


@pytest.mark.parametrize("duty", [0.0, 0.25, 0.6, 1.0])
def test_the_supply_is_on_for_the_duty_ratio_of_each_period_to_the_instant(simulate: Simulate, duty: float) -> None:
    run = simulate("SwitchedMotor", 0.02, 5e-5, ("switched.modulator.on",), duty=duty, f_pwm=1e3, w=0.0)
    row = np.arange(len(run["time"])) % 20
    inside = row > 0  # a row at a tick is taken before it, as nobody computes ticks at the end of a step
    assert np.array_equal(run["switched.modulator.on"][inside], (row < duty * 20)[inside])
