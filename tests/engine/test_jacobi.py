"""The fixed-step algorithm: who sees what after how many macro steps."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from both_loops import simulate

from cosim.engine import Channel, Component, Connection, Fmu, PartialResultError, Result, System
from cosim.errors import InputError

Get = Callable[..., Fmu]


def jacobi(system: System, *, stop: float = 0.1, interval: float = 0.01, step: float | None = 0.01) -> Result:
    arguments = {} if step is None else {"step": step}
    return simulate(system, stop=stop, output_interval=interval, tolerance=1e-6, algorithm="jacobi", **arguments)


@pytest.mark.parametrize("version", [2, 3])
def test_a_controller_acts_one_macro_step_after_it_was_stepped(fmu: Get, version: int) -> None:
    system = System(
        [
            Component("plant", fmu("integrator", version), {"x0": 1.0}),
            Component("c", fmu("sampler", version), {"K": -4.0}),
        ],
        [Connection(("plant", "x"), ("c", "u")), Connection(("c", "y"), ("plant", "u"))],
    )
    result = jacobi(system, interval=0.02)
    x, y, rows = 1.0, 0.0, [1.0]
    for _ in range(10):
        x, y = x + 0.01 * y, -4.0 * x
        rows.append(x)
    np.testing.assert_allclose(result.columns["plant.x"], rows[::2], rtol=1e-13)
    assert result.statistics["steps"] == {"plant": 10, "c": 10}
    assert result.statistics["exchanges"] == 11
    assert result.statistics["roles"] == {"plant": "continuous", "c": "continuous"}


def test_both_ends_of_a_loop_see_the_beginning_of_the_step(fmu: Get) -> None:
    """x'' = -x by two integrators: the explicit Euler method, whose amplitude grows as (1 + h^2)^(k/2)."""
    system = System(
        [Component("p", fmu("integrator"), {"x0": 1.0}), Component("v", fmu("integrator"))],
        [Connection(("p", "x"), ("v", "u"), factor=-1.0), Connection(("v", "x"), ("p", "u"))],
    )
    result = jacobi(system, stop=1.0)
    amplitude = np.hypot(result.columns["p.x"], result.columns["v.x"])
    np.testing.assert_allclose(amplitude, (1.0 + 1e-4) ** (np.arange(101) / 2.0), rtol=1e-12)


def test_a_channel_acts_from_the_next_communication_point(fmu: Get) -> None:
    system = System(
        [Component("plant", fmu("integrator"))], channels=[Channel(("plant", "u"), [0.0, 0.013], [1.0, 0.0])]
    )
    result = jacobi(system)
    np.testing.assert_allclose(result.columns["plant.x"], [0.0, 0.01, *[0.02] * 9], rtol=1e-13)
    assert result.columns["plant.u"].tolist() == [1.0, 1.0, *[0.0] * 9]


def test_a_linear_channel_is_integrated_exactly(fmu: Get) -> None:
    channel = Channel(("plant", "u"), [0.0, 0.1], [0.0, 1.0], linear=True)
    result = jacobi(System([Component("plant", fmu("integrator"))], channels=[channel]), interval=0.05)
    np.testing.assert_allclose(result.columns["plant.x"], 5.0 * result.time**2, rtol=0, atol=1e-15)
    np.testing.assert_allclose(result.columns["plant.u"], 10.0 * result.time, rtol=1e-13)


def test_rows_between_which_nothing_is_read_that_nobody_takes(fmu: Get) -> None:
    fine, coarse = (
        jacobi(
            System(
                [Component("a", fmu("integrator"), {"x0": 1.0}), Component("b", fmu("integrator"))],
                [Connection(("a", "x"), ("b", "u")), Connection(("b", "x"), ("a", "u"), factor=-1.0)],
            ),
            interval=interval,
            step=0.001,
        )
        for interval in (0.001, 0.05)
    )
    for name, column in coarse.columns.items():
        assert column.tobytes() == fine.columns[name][::50].tobytes()


def test_failures_and_their_rows(fmu: Get) -> None:
    for fault, what in (("error", "fmi3DoStep returned Error"), ("not_a_number", "its output y is not a number")):
        system = System([Component("f", fmu("faulty"), {"fault": fault, "t_fault": 0.05})])
        with pytest.raises(PartialResultError) as caught:
            jacobi(system)
        assert what in str(caught.value)
        assert caught.value.result.time.tolist() == [0.0, 0.01, 0.02, 0.03, 0.04]


def test_what_makes_no_macro_step(fmu: Get) -> None:
    system = System([Component("plant", fmu("integrator"))])

    def refuse(**arguments: float) -> str:
        with pytest.raises(InputError) as caught:
            jacobi(system, **arguments)
        return str(caught.value)

    needed = "a macro step is above 2e-09 s"
    assert refuse(step=0.0) == f"step is 0.0; {needed}"
    assert refuse(step=float("nan")) == f"step is nan; {needed}"
    assert refuse(step=0.003) == "output_interval is 0.01 s; it must be a multiple of the macro step, 0.003 s"
    assert refuse(step=0.01, stop=0.105) == "stop is 0.105 s; it must be a multiple of the macro step, 0.01 s"
    with pytest.raises(InputError) as caught:
        jacobi(system, step=None)
    assert str(caught.value) == "there is no step; the algorithm jacobi needs the length of its macro steps"
