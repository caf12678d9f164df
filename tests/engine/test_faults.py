"""Faults on purpose against closed forms, by both loops, in FMI 2.0 and 3.0."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from zlib import crc32

import numpy as np
import pytest
from both_loops import simulate
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from test_equality import systems

from cosim.engine import (
    FAULT_KINDS,
    Channel,
    Component,
    Connection,
    Fault,
    FaultKind,
    Fmu,
    PartialResultError,
    Result,
    System,
)
from cosim.engine import simulate as simulate_once
from cosim.errors import InputError

Get = Callable[..., Fmu]
VERSIONS = [(3, 3), (2, 3), (3, 2), (2, 2)]
T = 0.01
"""Period of the sampler [s]."""
TARGET = ("controller", "u")
pytestmark = pytest.mark.filterwarnings("ignore:the steps in which components exchange are not adapted")
NEUTRAL: dict[FaultKind, float] = {"bias": 0.0, "scale": 1.0, "noise": 0.0, "drop": 0.0}


def sampled_ramp(fmu: Get, sampler: int = 3, plant: int = 3, slope: float = 1.0) -> System:
    """x(t) = slope t is sampled every ``T``: without a fault y holds slope k T."""
    return System(
        [
            Component("plant", fmu("integrator", plant)),
            Component("controller", fmu("sampler", sampler), {"T_compute": T}),
        ],
        [Connection(("plant", "x"), TARGET)],
        [Channel(("plant", "u"), [0.0], [slope])],
    )


def feedback(fmu: Get, sampler: int = 3, plant: int = 3) -> System:
    """der(x) = -4 x(k T), x(0) = 1."""
    return System(
        [
            Component("plant", fmu("integrator", plant), {"x0": 1.0}),
            Component("controller", fmu("sampler", sampler), {"T_compute": T, "K": -4.0}),
        ],
        [Connection(("plant", "x"), TARGET), Connection(("controller", "y"), ("plant", "u"))],
    )


def run(system: System, *faults: Fault, stop: float = 0.3, interval: float = T) -> Result:
    return simulate(replace(system, faults=list(faults)), stop=stop, output_interval=interval, tolerance=1e-6)


def draws(fault: Fault, count: int) -> NDArray[np.float64]:
    """Return the numbers that the documentation says the fault draws."""
    name = crc32(f"{'.'.join(fault.target)} {fault.kind}".encode())
    generator = np.random.Generator(np.random.Philox(np.random.SeedSequence([fault.seed, name, 0])))
    return generator.standard_normal(count) if fault.kind == "noise" else generator.random(count)


@pytest.mark.parametrize(("sampler", "plant"), VERSIONS)
@pytest.mark.parametrize(
    ("kind", "amount", "law"),
    [
        ("override", -0.75, lambda t: np.full_like(t, -0.75)),
        ("bias", 0.5, lambda t: t + 0.5),
        ("scale", -2.0, lambda t: -2.0 * t),
        ("freeze", 0.0, lambda t: np.full_like(t, 0.1)),
        ("delay", 0.03, lambda t: t - 0.03),
        ("delay", 0.0137, lambda t: t - 0.0137),
        ("drop", 1.0, lambda t: np.full_like(t, 0.09)),
        ("quantise", 0.025, lambda t: 0.025 * np.rint(t / 0.025)),
    ],
)
def test_each_kind_does_to_a_sampled_ramp_what_it_says(
    fmu: Get, sampler: int, plant: int, kind: FaultKind, amount: float, law: Callable[[NDArray[np.float64]], object]
) -> None:
    """From 0.1 s to 0.2 s; before and after it the samples are those of the ramp."""
    result = run(sampled_ramp(fmu, sampler, plant), Fault(TARGET, kind, amount, 0.1, 0.2))
    t = result.time
    expected = np.where((t > 0.0999) & (t < 0.1999), law(t), t)
    np.testing.assert_allclose(result.columns["controller.y"], expected, rtol=0, atol=1e-14)
    np.testing.assert_allclose(result.columns["controller.u"], expected, rtol=0, atol=1e-14)
    np.testing.assert_allclose(result.columns["plant.x"], t, rtol=0, atol=1e-14)


@pytest.mark.parametrize(("sampler", "plant"), VERSIONS)
def test_noise_is_the_documented_normal_numbers_held_for_a_sample(fmu: Get, sampler: int, plant: int) -> None:
    fault = Fault(TARGET, "noise", 0.2, 0.1, 0.2, seed=7)
    result = run(sampled_ramp(fmu, sampler, plant), fault)
    noise = np.zeros_like(result.time)
    noise[10:20] = 0.2 * draws(fault, 10)
    np.testing.assert_allclose(result.columns["controller.y"], result.time + noise, rtol=0, atol=1e-14)
    assert result.faults == (replace(fault, every=T),)


@pytest.mark.parametrize(("sampler", "plant"), VERSIONS)
def test_what_is_dropped_leaves_the_last_value_that_arrived(fmu: Get, sampler: int, plant: int) -> None:
    fault = Fault(TARGET, "drop", 0.4, 0.1, 0.2, seed=3)
    result = run(sampled_ramp(fmu, sampler, plant), fault)
    lost = draws(fault, 10) < 0.4
    assert 1 <= lost.sum() <= 9
    arrived = [k for k in range(30) if not (10 <= k < 20 and lost[k - 10])]
    last = [max(k for k in arrived if k <= row) for row in range(30)]
    np.testing.assert_allclose(result.columns["controller.y"][:30], T * np.array(last), rtol=0, atol=1e-14)


def test_noise_has_the_variance_that_it_says_and_no_correlation(fmu: Get) -> None:
    """Bounds of five standard errors for 20,000 numbers: sigma / sqrt(n), sigma^2 sqrt(2 / n), 1 / sqrt(n)."""
    n = 20_000
    system = System([Component("plant", fmu("integrator"))])
    faults = [Fault(("plant", "u"), "noise", 3.0, every=1e-3, seed=seed) for seed in (1, 2)]
    values = run(system, faults[0], stop=n * 1e-3, interval=1e-3).columns["plant.u"][:-1]
    others = run(system, faults[1], stop=n * 1e-3, interval=1e-3).columns["plant.u"][:-1]
    assert abs(values.mean()) < 5 * 3.0 / math.sqrt(n)
    assert abs(values.var() / 9.0 - 1.0) < 5 * math.sqrt(2 / n)
    assert abs(np.corrcoef(values[:-1], values[1:])[0, 1]) < 5 / math.sqrt(n)
    assert abs(np.corrcoef(values, others)[0, 1]) < 5 / math.sqrt(n)


@pytest.mark.parametrize(("sampler", "plant"), VERSIONS)
@pytest.mark.parametrize("kind", NEUTRAL)
def test_a_fault_that_does_nothing_changes_no_bit(fmu: Get, sampler: int, plant: int, kind: FaultKind) -> None:
    system = feedback(fmu, sampler, plant)
    reference = run(system, interval=0.003)
    for target in (TARGET, ("plant", "u")):
        result = run(system, Fault(target, kind, NEUTRAL[kind], 0.05, 0.15), interval=0.003)
        for name, column in reference.columns.items():
            assert column.tobytes() == result.columns[name].tobytes(), name


@pytest.mark.parametrize(("sampler", "plant"), VERSIONS)
def test_a_delay_of_n_samples_is_a_feedback_of_n_samples_ago(fmu: Get, sampler: int, plant: int) -> None:
    """x_{k+1} = x_k + T y_k. Late samples: y_k = -4 x_{k-3}, x_0 before 0 s. Late answers: y_k = 0 before the first."""
    system = feedback(fmu, sampler, plant)
    fault = Fault(TARGET, "delay", 3 * T)
    x, z = [1.0], [1.0]
    for k in range(30):
        x.append(x[k] - 4.0 * T * x[max(k - 3, 0)])
        z.append(z[k] - 4.0 * T * (z[k - 3] if k >= 3 else 0.0))
    np.testing.assert_allclose(run(system, fault).columns["plant.x"], x, rtol=1e-13)
    late_answers = run(system, replace(fault, target=("plant", "u")))
    np.testing.assert_allclose(late_answers.columns["plant.x"], z, rtol=1e-13)


@pytest.mark.parametrize("plant", [2, 3])
def test_a_delay_in_macro_steps(fmu: Get, plant: int) -> None:
    """As above, but with Jacobi's algorithm the answer acts one macro step later."""
    system = feedback(fmu, 2, plant)
    system.faults = [Fault(TARGET, "delay", 3 * T)]
    result = simulate(system, stop=0.3, output_interval=T, tolerance=1e-6, algorithm="jacobi", step=T)
    x, y = [1.0], 0.0
    for k in range(30):
        x.append(x[k] + T * y)
        y = -4.0 * x[max(k - 3, 0)]
    np.testing.assert_allclose(result.columns["plant.x"], x, rtol=1e-13)


@pytest.mark.parametrize("version", [2, 3])
def test_a_delayed_step_acts_on_a_continuous_component_at_its_own_instant(fmu: Get, version: int) -> None:
    """A channel steps at 0.1 s and 0.15 s; late by 0.0437 s the integral has its corners there, between the rows."""
    system = System(
        [Component("plant", fmu("integrator", version))],
        channels=[Channel(("plant", "u"), [0.0, 0.1, 0.15], [0.0, 2.0, -1.0])],
    )
    result = run(system, Fault(("plant", "u"), "delay", 0.0437), interval=0.02)
    late = result.time - 0.0437
    expected = 2.0 * np.clip(late - 0.1, 0.0, 0.05) - np.clip(late - 0.15, 0.0, None)
    np.testing.assert_allclose(result.columns["plant.x"], expected, rtol=0, atol=1e-15)


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("tau", [0.03, 0.0137])
def test_a_delayed_line_is_the_line_of_earlier(fmu: Get, version: int, tau: float) -> None:
    """u(t) = t up to 0.1 s, where it falls to 0; its integral is late by tau, the step in it too.

    A step that has the bend at 0 s inside errs once by at most h^2 / 8 there.
    """
    system = System(
        [Component("plant", fmu("integrator", version))],
        channels=[Channel(("plant", "u"), [0.0, 0.1, 0.1], [0.0, 0.1, 0.0], linear=True)],
    )
    result = run(system, Fault(("plant", "u"), "delay", tau), interval=0.01)
    late = np.clip(result.time - tau, 0.0, 0.1)
    bend = 0.0 if tau == 0.03 else 0.01**2 / 8.0
    np.testing.assert_allclose(result.columns["plant.x"], 0.5 * late**2, rtol=0, atol=1e-15 + bend)


@pytest.mark.parametrize("version", [2, 3])
def test_a_delay_between_continuous_components_is_of_second_order(fmu: Get, version: int) -> None:
    """der(x) = 1, der(z) = x(t - tau)^: the trapezoids of a line are exact, so z is to rounding."""
    system = System(
        [Component("one", fmu("integrator", version)), Component("two", fmu("integrator", version))],
        [Connection(("one", "x"), ("two", "u"))],
        [Channel(("one", "u"), [0.0], [1.0])],
    )
    result = run(system, Fault(("two", "u"), "delay", 0.1), stop=0.5)
    np.testing.assert_allclose(
        result.columns["two.x"], 0.5 * np.clip(result.time - 0.1, 0.0, None) ** 2, rtol=0, atol=1e-14
    )


def test_an_override_begins_and_ends_between_rows_and_instants(fmu: Get) -> None:
    """u = 1, but 5 from 0.0133 s to 0.0271 s: x = t + 4 (t2 - t1) from then on, to rounding."""
    system = System([Component("plant", fmu("integrator"))], channels=[Channel(("plant", "u"), [0.0], [1.0])])
    result = run(system, Fault(("plant", "u"), "override", 5.0, 0.0133, 0.0271), stop=0.1)
    t = result.time
    expected = t + 4.0 * (np.clip(t, 0.0133, 0.0271) - 0.0133)
    np.testing.assert_allclose(result.columns["plant.x"], expected, rtol=0, atol=1e-15)


def test_an_input_that_nothing_drives_has_its_start_value_as_its_signal(fmu: Get) -> None:
    system = System([Component("controller", fmu("sampler"), {"T_compute": T})])
    result = run(system, Fault(TARGET, "bias", 2.0, 0.1), stop=0.2)
    assert result.columns["controller.y"].tolist() == [0.0] * 10 + [2.0] * 11
    assert result.units["controller.u"] == "m"


def test_faults_of_one_input_act_in_their_order(fmu: Get) -> None:
    bias, scale = Fault(TARGET, "bias", 1.0), Fault(TARGET, "scale", 3.0)
    for faults, offset in (((bias, scale), 3.0), ((scale, bias), 1.0)):
        result = run(sampled_ramp(fmu), *faults)
        np.testing.assert_allclose(result.columns["controller.y"], 3.0 * result.time + offset, atol=1e-14)
    late_noise = Fault(TARGET, "noise", 0.2, seed=7), Fault(TARGET, "delay", 0.05)
    result = run(sampled_ramp(fmu), *late_noise)
    noise = 0.2 * draws(late_noise[0], 31)
    expected = np.concatenate([np.full(5, noise[0]), result.time[:26] + noise[:26]])
    expected[:5] = 0.0  # before 0 s there is initialisation, which has the first number, too
    np.testing.assert_allclose(result.columns["controller.y"][5:], expected[5:], atol=1e-14)
    np.testing.assert_allclose(result.columns["controller.y"][:5], noise[0], atol=1e-14)


def test_units_of_a_connection_come_before_its_faults(fmu: Get) -> None:
    system = sampled_ramp(fmu)
    system.connections[0] = Connection(("plant", "x"), TARGET, factor=1000.0, offset=5.0)
    result = run(system, Fault(TARGET, "scale", 2.0))
    np.testing.assert_allclose(result.columns["controller.y"], 2.0 * (1000.0 * result.time + 5.0), rtol=1e-14)


def test_a_stuck_switch_is_an_event_for_a_component_with_event_mode(fmu: Get) -> None:
    """Its input is a discrete source, so that it sees the change at once, between its samples."""
    system = System([Component("controller", fmu("sampler"), {"T_compute": T})])
    system.channels.append(Channel(("controller", "enable"), [0.0], [1.0]))
    result = run(system, Fault(("controller", "enable"), "override", 0.0, 0.015, 0.035), stop=0.05, interval=0.001)
    off = (result.time > 0.0149) & (result.time < 0.0349)
    assert result.columns["controller.enabled"].tolist() == (~off).astype(int).tolist()
    assert result.columns["controller.enable"].dtype == np.int64
    assert result.statistics["events"] == {"controller": 6 + 2}


@pytest.mark.parametrize("version", [2, 3])
def test_a_boolean_comes_late_whole(fmu: Get, version: int) -> None:
    """What a continuous component switches is switched late, at the communication point that has seen it; no half."""
    system = System(
        [Component("plant", fmu("integrator", version), {"x0": -0.1}), Component("mirror", fmu("mirror", version))],
        [Connection(("plant", "positive"), ("mirror", "u_Float64"))],
        [Channel(("plant", "u"), [0.0], [1.0])],
    )
    result = run(system, Fault(("mirror", "u_Float64"), "delay", 0.015), interval=0.01)
    seen = result.columns["mirror.u_Float64"]
    assert set(seen.tolist()) == {0.0, 1.0}
    late = np.interp(result.time - 0.015, result.time, result.columns["plant.positive"])
    assert seen.tolist() == np.floor(late + 1e-9).tolist()


@pytest.mark.parametrize("version", [2, 3])
def test_whole_numbers_and_enumerations(fmu: Get, version: int) -> None:
    """The mirror's outputs are its inputs as they were in the last step."""
    system = System([Component("mirror", fmu("mirror", version))])
    system.channels = [Channel(("mirror", "u_Int16"), [0.0, 0.05, 0.15], [0.0, 7.0, -3.0])]
    result = run(
        system,
        Fault(("mirror", "u_Enumeration"), "override", 3.0, 0.1, 0.2),
        Fault(("mirror", "u_Int16"), "delay", 0.02),
        Fault(("mirror", "u_Int16"), "freeze", start=0.1, stop=0.2),
        Fault(("mirror", "u_UInt64"), "override", 2.0**30, 0.1),
    )
    row = np.arange(31)
    columns = result.columns
    assert columns["mirror.u_Enumeration"].tolist() == np.where((row >= 10) & (row < 20), 3, 1).tolist()
    late = np.where(row < 7, 0, np.where(row < 17, 7, -3))
    assert columns["mirror.u_Int16"].tolist() == np.where((row >= 10) & (row < 20), 7, late).tolist()
    assert columns["mirror.y_Int16"][1:].tolist() == columns["mirror.u_Int16"][:-1].tolist()
    assert columns["mirror.u_UInt64"].dtype == np.int64
    assert columns["mirror.y_UInt64"][-1] == 2**30


def test_a_value_that_an_integer_cannot_take_is_told(fmu: Get) -> None:
    system = System([Component("mirror", fmu("mirror"))])
    with pytest.raises(PartialResultError, match="cannot take 300: its input is an integer of 8 bits"):
        run(system, Fault(("mirror", "u_Int8"), "override", 300.0, 0.1))


def test_one_element_of_an_array(fmu: Get) -> None:
    """The others keep their start values, 0.5 and 2.5."""
    system = System([Component("vector", fmu("vector"))])
    result = run(system, Fault(("vector", "u[2]"), "scale", 10.0, 0.1))
    row = np.arange(31)
    assert result.columns["vector.u[2]"].tolist() == np.where(row < 10, 1.5, 15.0).tolist()
    assert result.columns["vector.y[2]"][-1] == 15.0
    assert (result.columns["vector.y[1]"][-1], result.columns["vector.y[3]"][-1]) == (0.5, 2.5)


def test_a_process_of_its_own_gives_the_same_bits(fmu: Get) -> None:
    faults = [Fault(TARGET, "noise", 0.2), Fault(TARGET, "delay", 0.0137), Fault(("plant", "u"), "drop", 0.3, 0.05)]
    system = replace(feedback(fmu), faults=faults)
    here, there = (
        simulate_once(system, stop=0.3, output_interval=T, tolerance=1e-6, isolate=isolate)
        for isolate in ("never", "always")
    )
    for name, column in here.columns.items():
        assert column.tobytes() == there.columns[name].tobytes(), name
    assert here.faults == there.faults


def test_a_long_delay_over_many_steps_needs_more_memory_while_it_runs(fmu: Get) -> None:
    """3,000 points, all within the delay, which no memory made beforehand had."""
    system = sampled_ramp(fmu)
    system.channels = [Channel(("plant", "u"), [0.0, 3.0], [0.0, 3.0], linear=True)]
    result = run(system, Fault(TARGET, "delay", 2.5), stop=3.0, interval=0.001)
    late = np.clip(T * np.floor(result.time / T + 1e-6) - 2.5, 0.0, None)
    np.testing.assert_allclose(result.columns["controller.y"], 0.5 * late**2, atol=1e-9)


@st.composite
def faults_of(draw: st.DrawFn, system: System) -> list[Fault]:
    """Up to four faults of any kind on any input ``u``."""
    kinds = draw(st.lists(st.sampled_from(FAULT_KINDS), min_size=1, max_size=4))
    faults = []
    for kind in kinds:
        amounts = {
            "delay": st.sampled_from([0.001, 0.0105, 0.03]) | st.floats(1e-6, 0.2),
            "drop": st.floats(0.0, 1.0),
            "quantise": st.floats(1e-3, 1.0),
            "noise": st.floats(0.0, 1.0),
        }
        start = draw(st.sampled_from([0.0, 0.01, 0.02]) | st.floats(0.0, 0.1))
        length = draw(st.sampled_from([0.01, math.inf]) | st.floats(1e-6, 0.1))
        every = draw(st.none() | st.sampled_from([0.001, 0.0073])) if kind in ("drop", "noise") else None
        target = (draw(st.sampled_from(system.components)).name, "u")
        amount = draw(amounts.get(kind, st.floats(-3.0, 3.0)))
        faults.append(Fault(target, kind, amount, start, start + length, every, draw(st.integers(0, 5))))
    return faults


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_systems_at_random_with_faults_at_random(fmu: Get, data: st.DataObject) -> None:
    """Both loops agree in every bit, or fail with one message."""
    system = data.draw(systems(fmu))
    system.faults = data.draw(faults_of(system))
    interval = data.draw(st.sampled_from([0.001, 0.003, 0.01]) | st.floats(0.001, 0.1))
    with suppress(PartialResultError):
        simulate(system, stop=data.draw(st.floats(0.1, 0.15)), output_interval=interval, tolerance=1e-6)
    step = data.draw(st.sampled_from([0.001, 0.0025, 0.0073]))
    with suppress(PartialResultError):
        simulate(system, stop=20 * step, output_interval=2 * step, tolerance=1e-6, algorithm="jacobi", step=step)


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        (Fault(("plant", "y"), "bias", 1.0), "plant.y: is of causality output; an input is needed here"),
        (Fault(("controller", "v"), "bias", 1.0), "controller.v: sampler has no input v; its inputs are u, enable"),
        (
            Fault(TARGET, "wobble", 1.0),  # type: ignore[arg-type]
            "fault controller.u wobble: there is no such kind; there are override, bias, scale, freeze, delay, drop, "
            "quantise, noise",
        ),
        (
            Fault(("controller", "enable"), "bias", 1.0),
            "fault controller.enable bias: needs a Real, but it is a Boolean; it takes override, freeze, delay, drop",
        ),
        (
            Fault(("controller", "enable"), "override", 2.0),
            "fault controller.enable override: a Boolean takes 0 and 1 only, not 2",
        ),
        (Fault(TARGET, "bias", math.nan), "fault controller.u bias: its amount is nan; it must be finite"),
        (Fault(TARGET, "bias", 1.0, -1.0), "fault controller.u bias: it begins at -1 s; a simulation starts at 0 s"),
        (
            Fault(TARGET, "bias", 1.0, 2.0, 1.0),
            "fault controller.u bias: it ends at 1 s; it must end after its begin at 2 s",
        ),
        (Fault(TARGET, "delay", 0.0), "fault controller.u delay: the delay is 0 s; it must be above 2e-09 s"),
        (Fault(TARGET, "drop", 1.5), "fault controller.u drop: the probability is 1.5; it must be from 0 to 1"),
        (Fault(TARGET, "quantise"), "fault controller.u quantise: the step is 0; it must be above 0"),
        (
            Fault(TARGET, "noise", -1.0),
            "fault controller.u noise: the standard deviation is -1; it must not be below 0",
        ),
        (
            Fault(TARGET, "noise", 1.0, every=0.0),
            "fault controller.u noise: its period is 0 s; it must be above 2e-09 s",
        ),
        (
            Fault(TARGET, "noise", 1.0, seed=-1),
            "fault controller.u noise: the seed is -1; it must be a whole number from 0 on",
        ),
        (Fault(TARGET, "bias", 1.0, every=0.1), "fault controller.u bias: has a period; only drop and noise take one"),
        (
            Fault(TARGET, "noise", 1.0, every=1e-8),
            "fault controller.u noise: with a period of 1e-08 s it draws more than 10,000,000 random numbers; give it "
            "a longer one or less time",
        ),
    ],
)
def test_faults_that_cannot_be(fmu: Get, fault: Fault, message: str) -> None:
    with pytest.raises(InputError) as caught:
        run(sampled_ramp(fmu), fault)
    assert str(caught.value) == message


@pytest.mark.parametrize("version", [2, 3])
def test_what_a_fault_makes_of_infinity_is_told(fmu: Get, version: int) -> None:
    system = sampled_ramp(fmu, version, version)
    system.components[0].parameters["x0"] = math.inf
    with pytest.raises(PartialResultError) as caught:
        run(system, Fault(TARGET, "scale", 0.0, 0.1))
    assert "at t = 0.1 s: controller (sampler): its input u, as its faults make it, is not a number" in str(
        caught.value
    )


def test_a_text_has_no_faults(fmu: Get) -> None:
    system = System([Component("label", fmu("label"))])
    with pytest.raises(InputError, match=r"fault label.u freeze: is a String; a fault changes numbers only"):
        run(system, Fault(("label", "u"), "freeze"))
