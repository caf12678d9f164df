"""When things happen: sampled feedback against closed forms, channels, the rows of the result."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from both_loops import simulate

from cosim.engine import Channel, Component, Connection, Fmu, Result, System

Get = Callable[..., Fmu]
VERSIONS = [(3, 3), (2, 3), (3, 2), (2, 2)]


def feedback(fmu: Get, controller: int = 3, plant: int = 3, *, period: float, gain: float = -4.0) -> System:
    """der(x) = K x(t_k) over [t_k, t_k + T), x(0) = 1: x_{k+1} = (1 + K T) x_k. The plant stands first on purpose."""
    return System(
        [
            Component("plant", fmu("integrator", plant), {"x0": 1.0}),
            Component("controller", fmu("sampler", controller), {"T_compute": period, "K": gain}),
        ],
        [
            Connection(("plant", "x"), ("controller", "u")),
            Connection(("controller", "y"), ("plant", "u")),
        ],
    )


def integrator(fmu: Get, channel: Channel, version: int = 3) -> System:
    return System([Component("plant", fmu("integrator", version))], channels=[channel])


def run(system: System, stop: float, interval: float = 0.001) -> Result:
    result = simulate(system, stop=stop, output_interval=interval, tolerance=1e-6, algorithm="gauss-seidel")
    assert result.complete
    assert result.message is None
    return result


@pytest.mark.parametrize(("controller", "plant"), VERSIONS)
@pytest.mark.parametrize("period", [0.001, 0.0073, 0.02, 0.0105])
def test_sampled_feedback_has_no_delay(fmu: Get, controller: int, plant: int, period: float) -> None:
    result = run(feedback(fmu, controller, plant, period=period), stop=0.5)
    k = np.floor((result.time + 1e-9) / period)
    x_k = (1.0 - 4.0 * period) ** k
    x = x_k + (result.time - k * period) * -4.0 * x_k
    np.testing.assert_allclose(result.columns["plant.x"], x, rtol=1e-12)
    np.testing.assert_allclose(result.columns["controller.y"], -4.0 * x_k, rtol=1e-12)
    np.testing.assert_allclose(result.columns["controller.t_sample"], k * period, rtol=0, atol=1e-15)
    assert result.columns["controller.count"].tolist() == (k + 1).tolist()


@pytest.mark.parametrize(("controller", "plant"), VERSIONS)
def test_the_output_interval_changes_nothing_but_the_rows(fmu: Get, controller: int, plant: int) -> None:
    fine = run(feedback(fmu, controller, plant, period=0.0073), stop=0.5, interval=0.001)
    coarse = run(feedback(fmu, controller, plant, period=0.0073), stop=0.5, interval=0.1)
    np.testing.assert_allclose(fine.columns["plant.x"][::100], coarse.columns["plant.x"], rtol=1e-13)
    assert fine.statistics["exchanges"] == coarse.statistics["exchanges"] == 69
    assert coarse.statistics["steps"] == {"controller": 68 + (controller == 2), "plant": 68 + 5}


@pytest.mark.parametrize(("controller", "plant"), VERSIONS)
def test_first_and_last_row_hold_the_events_at_their_time(fmu: Get, controller: int, plant: int) -> None:
    result = run(feedback(fmu, controller, plant, period=0.02), stop=0.06, interval=0.01)
    assert result.time.tolist() == [0.0, 0.01, 0.02, 0.03, 0.04, 0.05, 0.06]
    assert result.columns["controller.count"].tolist() == [1, 1, 2, 2, 3, 3, 4]
    assert result.columns["plant.x"][0] == 1.0
    assert result.columns["controller.y"][0] == -4.0
    assert result.columns["controller.y"][-1] == -4.0 * result.columns["plant.x"][-1]
    # What feeds the input through holds the end of the step that led to the row.
    np.testing.assert_array_equal(result.columns["plant.y"][1:], result.columns["controller.y"][:-1])


def test_types_units_and_literals_of_the_columns(fmu: Get) -> None:
    result = run(feedback(fmu, period=0.02), stop=0.1)
    assert list(result.columns) == [
        "plant.x",
        "plant.y",
        "plant.positive",
        "controller.y",
        "controller.t_sample",
        "controller.count",
        "controller.events",
        "controller.side",
        "controller.enabled",
    ]
    assert {name for name, column in result.columns.items() if column.dtype == np.float64} == {
        "plant.x",
        "plant.y",
        "controller.y",
        "controller.t_sample",
    }
    assert {column.dtype for column in result.columns.values()} == {np.dtype(np.float64), np.dtype(np.int64)}
    assert result.units == {"plant.x": "m", "plant.y": "m/s", "controller.y": "m/s", "controller.t_sample": "s"}
    assert result.literals == {"controller.side": ("left", "middle", "right")}
    assert set(result.columns["controller.side"]) == {3}
    assert set(result.columns["plant.positive"]) == {1}


def test_statistics_of_an_event_driven_run(fmu: Get) -> None:
    result = run(feedback(fmu, period=0.02), stop=0.1)
    statistics = dict(result.statistics)
    assert isinstance(statistics.pop("wall_s"), float)
    del statistics["coupling"]  # tests/engine/test_coupling_error.py
    assert statistics == {
        "loop": "native",
        "exchanges": 6,
        "roles": {"controller": "event", "plant": "continuous"},
        "steps": {"controller": 5, "plant": 100},
        "events": {"controller": 6},
        "solver": {"plant": {"steps": 100}, "controller": {}},
    }


def test_instants_closer_than_a_nanosecond_are_one(fmu: Get) -> None:
    # 3 * 0.1 is not 0.3 in doubles, and the channel's steps lie half a nanosecond beside the controller's instants.
    system = feedback(fmu, period=0.1)
    system.channels = [Channel(("controller", "enable"), [0.2 - 5e-10, 0.3 + 5e-10], [0.0, 1.0])]
    result = run(system, stop=0.5, interval=0.1)
    assert result.statistics["exchanges"] == 6
    assert result.columns["controller.events"].tolist() == [1, 2, 3, 4, 5, 6]
    assert result.columns["controller.enabled"].tolist() == [1, 1, 0, 1, 1, 1]
    assert result.columns["controller.y"][2] == 0.0
    assert result.columns["controller.t_sample"][3] == 3 * 0.1
    assert result.time[3] == 0.3


def test_events_may_take_several_updates(fmu: Get) -> None:
    system = feedback(fmu, period=0.02)
    system.components[1].parameters["updates"] = 3
    result = run(system, stop=0.1, interval=0.02)
    np.testing.assert_allclose(result.columns["plant.x"], (1.0 - 4.0 * 0.02) ** np.arange(6), rtol=1e-12)
    assert result.columns["controller.events"].tolist() == [1, 2, 3, 4, 5, 6]


def test_events_that_are_not_announced_are_found_at_the_next_point(fmu: Get) -> None:
    system = feedback(fmu, period=0.02)
    system.components[1].parameters["silent"] = True
    result = run(system, stop=0.1, interval=0.005)
    assert result.columns["controller.events"].tolist() == [1 + k // 4 for k in range(21)]
    np.testing.assert_allclose(result.columns["plant.x"][::4], (1.0 - 4.0 * 0.02) ** np.arange(6), rtol=1e-12)
    assert result.statistics["exchanges"] == 6


def test_two_controllers_with_their_own_periods(fmu: Get) -> None:
    system = System(
        [
            Component("plant", fmu("integrator"), {"x0": 1.0}),
            Component("slow", fmu("sampler"), {"T_compute": 0.05, "K": -1.0}),
            Component("fast", fmu("sampler"), {"T_compute": 0.01, "K": 2.0}),
        ],
        [
            Connection(("plant", "x"), ("slow", "u")),
            Connection(("slow", "y"), ("fast", "u")),
            Connection(("fast", "y"), ("plant", "u")),
        ],
    )
    result = run(system, stop=0.2, interval=0.05)
    np.testing.assert_allclose(result.columns["plant.x"], (1.0 - 2.0 * 0.05) ** np.arange(5), rtol=1e-12)
    assert result.columns["slow.count"].tolist() == [1, 2, 3, 4, 5]
    assert result.columns["fast.count"].tolist() == [1, 6, 11, 16, 21]


@pytest.mark.parametrize("first", ["a", "b"])
def test_of_two_controllers_in_a_row_the_second_samples_what_the_first_has_just_put_out(fmu: Get, first: str) -> None:
    names = ["a", "b"] if first == "a" else ["b", "a"]
    system = System(
        [Component(name, fmu("sampler"), {"T_compute": 0.1, "K": 3.0}) for name in names],
        [Connection(("a", "y"), ("b", "u"))],
        [Channel(("a", "u"), [0.0, 0.2, 0.2], [1.0, 1.0, 5.0])],
    )
    result = run(system, stop=0.4, interval=0.1)
    assert result.columns["a.y"].tolist() == [3.0, 3.0, 15.0, 15.0, 15.0]
    assert result.columns["b.y"].tolist() == [9.0, 9.0, 45.0, 45.0, 45.0]


def test_a_discrete_input_that_changes_is_an_event_but_no_sample(fmu: Get) -> None:
    system = feedback(fmu, period=0.02)
    system.channels = [Channel(("controller", "enable"), [0.0, 0.033], [1.0, 0.0])]
    result = run(system, stop=0.06)
    events = result.columns["controller.events"]
    assert [int(np.argmax(events == n)) for n in (1, 2, 3, 4, 5)] == [0, 20, 33, 40, 60]
    assert int(np.argmax(result.columns["controller.enabled"] == 0)) == 33
    assert int(np.argmax(result.columns["controller.y"] == 0.0)) == 40
    assert result.columns["controller.enable"].tolist() == [1] * 33 + [0] * 28


@pytest.mark.parametrize("version", [2, 3])
def test_a_channel_steps_at_its_exact_time(fmu: Get, version: int) -> None:
    channel = Channel(("plant", "u"), [0.0, 0.01234567, 0.01234567, 0.05], [2.0, 2.0, -1.0, 0.0])
    result = run(integrator(fmu, channel, version), stop=0.1)
    t = result.time
    x = 2.0 * np.minimum(t, 0.01234567) - np.clip(t - 0.01234567, 0.0, 0.05 - 0.01234567)
    np.testing.assert_allclose(result.columns["plant.x"], x, rtol=0, atol=1e-16)
    assert result.columns["plant.u"].tolist() == [2.0] * 13 + [-1.0] * 37 + [0.0] * 51
    assert result.statistics["exchanges"] == 3
    assert result.statistics["steps"] == {"plant": 101}


def test_a_step_at_zero_acts_after_initialisation_and_a_step_at_stop_shows_in_the_last_row(fmu: Get) -> None:
    channel = Channel(("plant", "u"), [0.0, 0.0, 0.1, 0.1], [5.0, 1.0, 1.0, 7.0])
    result = run(integrator(fmu, channel), stop=0.1, interval=0.05)
    assert result.columns["plant.y"].tolist() == [5.0, 1.0, 1.0]
    assert result.columns["plant.u"].tolist() == [1.0, 1.0, 7.0]
    np.testing.assert_allclose(result.columns["plant.x"], [0.0, 0.05, 0.1], rtol=1e-15)


def test_before_the_first_entry_the_start_value_holds(fmu: Get) -> None:
    result = run(integrator(fmu, Channel(("plant", "u"), [0.05], [1.0])), stop=0.1, interval=0.05)
    assert result.columns["plant.u"].tolist() == [0.0, 1.0, 1.0]
    np.testing.assert_allclose(result.columns["plant.x"], [0.0, 0.0, 0.05], rtol=1e-15)


def test_a_linear_channel_is_integrated_exactly_and_recorded_at_its_own_value(fmu: Get) -> None:
    channel = Channel(("plant", "u"), [0.0, 0.0473, 0.0473, 0.1], [0.0, 4.73, 1.0, 0.0], linear=True)
    result = run(integrator(fmu, channel), stop=0.12)
    t = result.time
    late = np.clip(t - 0.0473, 0.0, 0.0527)
    early = np.minimum(t, 0.0473)
    np.testing.assert_allclose(
        result.columns["plant.x"], 50.0 * early**2 + late - 0.5 * late**2 / 0.0527, rtol=0, atol=1e-15
    )
    u = np.where(t < 0.0473, 100.0 * t, 1.0 - late / 0.0527)
    np.testing.assert_allclose(result.columns["plant.u"], u, rtol=0, atol=1e-12)
    assert result.statistics["exchanges"] == 122


@pytest.mark.parametrize("version", [2, 3])
def test_a_sampled_component_sees_a_linear_channel_as_it_is_at_the_sample(fmu: Get, version: int) -> None:
    system = System(
        [Component("controller", fmu("sampler", version), {"T_compute": 0.02})],
        channels=[Channel(("controller", "u"), [0.0, 0.1], [1.0, 2.0], linear=True)],
    )
    result = run(system, stop=0.1, interval=0.02)
    np.testing.assert_allclose(result.columns["controller.y"], 1.0 + 10.0 * result.time, rtol=1e-15)


def test_stop_need_not_be_a_multiple_of_the_output_interval(fmu: Get) -> None:
    result = run(feedback(fmu, period=0.02), stop=0.0255, interval=0.01)
    assert result.time.tolist() == [0.0, 0.01, 0.02, 0.0255]
    assert run(feedback(fmu, period=0.02), stop=0.003).time.tolist() == [0.0, 0.001, 0.002, 0.003]
    assert run(feedback(fmu, period=0.02), stop=0.01, interval=1.0).time.tolist() == [0.0, 0.01]


def test_times_are_the_decimal_numbers_a_user_would_write(fmu: Get) -> None:
    result = run(feedback(fmu, period=0.02), stop=1.0)
    assert [repr(t) for t in result.time.tolist()] == [repr(float(f"{k / 1000:.3f}")) for k in range(1001)]


def test_an_unconnected_input_keeps_its_start_value(fmu: Get) -> None:
    result = run(System([Component("plant", fmu("integrator"))]), stop=0.1)
    assert set(result.columns["plant.x"]) == {0.0}
    assert result.statistics["exchanges"] == 1


def test_factor_and_offset_of_a_connection(fmu: Get) -> None:
    system = System(
        [Component("a", fmu("integrator"), {"x0": 3.0}), Component("b", fmu("integrator"))],
        [Connection(("a", "x"), ("b", "u"), factor=2.0, offset=-1.0)],
    )
    result = run(system, stop=0.1, interval=0.05)
    np.testing.assert_allclose(result.columns["b.x"], 5.0 * result.time, rtol=1e-14)


@pytest.mark.parametrize("version", [2, 3])
def test_continuous_components_exchange_at_every_output_point(fmu: Get, version: int) -> None:
    """x'' = -x by two integrators, stepped one after the other: the symplectic Euler method."""
    system = System(
        [Component("p", fmu("integrator", version), {"x0": 1.0}), Component("v", fmu("integrator", version))],
        [Connection(("p", "x"), ("v", "u"), factor=-1.0), Connection(("v", "x"), ("p", "u"))],
    )
    result = run(system, stop=1.0, interval=0.01)
    p, v = 1.0, 0.0
    for row in range(101):
        assert result.columns["p.x"][row] == pytest.approx(p, rel=1e-12)
        p = p + 0.01 * v
        v = v - 0.01 * p
    assert result.statistics["exchanges"] == 101


def test_what_feeds_an_input_through_is_stepped_before_what_it_drives(fmu: Get, undescribed_integrator: Fmu) -> None:
    """``y = u + offset`` of the first drives the second; given in the wrong order, it is stepped first all the same."""
    system = System(
        [Component("b", fmu("integrator", 2)), Component("a", undescribed_integrator)],
        [Connection(("b", "x"), ("a", "u")), Connection(("a", "y"), ("b", "u"), offset=1.0)],
    )
    result = run(system, stop=0.2, interval=0.1)
    # b's state at t goes through a over the same step: b_{k+1} = b_k + h (b_k + 1).
    np.testing.assert_allclose(result.columns["b.x"], [0.0, 0.1, 0.21], rtol=1e-14)


def test_the_same_system_gives_the_same_bytes(fmu: Get) -> None:
    one, two = (run(feedback(fmu, period=0.0073), stop=1.0) for _ in range(2))
    assert one.time.tobytes() == two.time.tobytes()
    assert {n: c.tobytes() for n, c in one.columns.items()} == {n: c.tobytes() for n, c in two.columns.items()}


def test_progress_is_reported_now_and_then_and_at_the_end(fmu: Get) -> None:
    seen: list[float] = []
    result = simulate(
        feedback(fmu, period=0.001), stop=5.0, output_interval=0.001, tolerance=1e-6, progress=seen.append
    )
    assert seen == sorted(seen)
    assert seen[-1] == 5.0
    assert len(seen) <= 3 + 20 * float(str(result.statistics["wall_s"]))
