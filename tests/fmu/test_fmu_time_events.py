"""Relations of time alone change at instants that are known beforehand: hit, not searched for."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.fmi3 import FMU3Slave

from cosim.fmu import compile_model, export

MODELS = Path(__file__).parents[1] / "models" / "TimeEvents.mo"
COUNTERS = ("solver.state_events", "solver.time_events")

Simulate = Callable[..., Any]


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    folder = tmp_path_factory.mktemp("time_events")
    return cache(lambda name: export(MODELS, f"TimeEvents.{name}", folder))


@pytest.fixture(scope="module")
def simulate(exported: Callable[[str], Path]) -> Simulate:
    def simulate(name: str, stop: float, step: float, outputs: tuple[str, ...], **start: float) -> Any:  # noqa: ANN401
        return fmpy.simulate_fmu(
            str(exported(name)), stop_time=stop, output_interval=step, relative_tolerance=1e-9, start_values=start,
            output=[*outputs, *COUNTERS],
        )  # fmt: skip

    return simulate


@pytest.mark.parametrize("duty", [0.0, 0.05, 0.3, 0.5, 0.95, 1.0])
def test_pulses_on_a_coil_follow_their_exponentials(simulate: Simulate, duty: float) -> None:
    """One exponential in each part of each period, from switching instant to switching instant."""
    result = simulate("Pulses", 0.05, 1e-4, ("i",), duty=duty)
    T, L, R, U = 1e-3, 3.75e-3, 1.91, 28.0
    rate, end = R / L, U / R
    current, expected = 0.0, []
    for k in range(500):
        in_period = (k % 10) * 1e-4
        if k % 10 == 0 and k:
            current = end + (current - end) * np.exp(-rate * duty * T)
            current *= np.exp(-rate * (1.0 - duty) * T)
        risen = end + (current - end) * np.exp(-rate * min(in_period, duty * T))
        expected.append(risen * np.exp(-rate * max(in_period - duty * T, 0.0)))
    np.testing.assert_allclose(result["i"][:500], expected, atol=2e-8)
    # each period has its tick, and the end of a pulse that ends inside it; nothing had to be searched for
    assert result["solver.state_events"][-1] == 0
    inside = 0.0 < duty < 1.0
    assert result["solver.time_events"][-1] in ((100, 101) if inside else (50, 51))


@pytest.mark.parametrize("enabled", [True, False])
def test_registers_take_what_was_there_before_the_tick(simulate: Simulate, enabled: bool) -> None:
    """Whatever order the groups of assignments come in, and although each overwrites what others read."""
    outputs = [f"{name}[{k}]" for name in ("up", "down", "copy") for k in range(1, 41)]
    result = simulate("Registers", 6.05, 0.05, (*outputs, "a", "b", "total"), enabled=enabled)
    a, b, total, up, down, copy = 3.0, 5.0, 0.0, np.zeros(40), np.zeros(40), np.zeros(40)
    for tick in range(61):
        before = (a, b, up.copy(), down.copy(), copy.copy())
        a, b = before[1], before[0]
        if enabled:
            up = np.concatenate((before[2][1:], [1.0]))
            down = np.concatenate((before[3][1:] + before[2][:-1], [1.0 + before[0]]))
        if tick % 2 == 0:
            copy, total = before[2] - before[4] + before[0], before[2][0] + 2 * before[2][-1]
        row = result[2 * tick + 1]  # between two ticks
        assert (row["a"], row["b"], row["total"]) == (a, b, total)
        for name, expected in (("up", up), ("down", down), ("copy", copy)):
            assert [row[f"{name}[{k}]"] for k in range(1, 41)] == expected.tolist(), (name, tick)


@pytest.mark.parametrize("u", [True, False])
def test_what_a_tick_decides_is_handed_on_at_once(simulate: Simulate, u: bool) -> None:
    """In a model that one pass over its equations settles, and in one that needs more."""
    names = ("on", "off", "both", "same", "n")
    once, more = (
        simulate("Handed", 2.05, 0.05, names, u=u),
        simulate("Beats", 2.05, 0.05, (*names, "beat", "settled"), u=u),
    )
    n = 0
    for tick in range(20):
        on = tick % 2 == 0
        n += not on and u
        for result in (once, more):
            row = result[2 * tick + 1]  # between two ticks
            assert tuple(row[name] for name in names) == (on, not on, not on and u, not on and u, n)
        assert (row["beat"], row["settled"]) == (False, not on)


def test_an_instant_fixes_the_next(simulate: Simulate) -> None:
    result = simulate("Instants", 10.0, 0.01, ("seen", "n"))
    n = np.arange(0, 20)
    instants = 0.5 + 0.125 * n * (n + 1) / 2  # all exact in binary
    counts = np.searchsorted(instants, result["time"] + 1e-9, side="right")
    assert np.array_equal(result["n"], counts)
    after = result["n"] > 0
    assert np.array_equal(result["seen"][after], instants[result["n"][after] - 1])
    assert result["solver.state_events"][-1] == 0


def test_a_state_event_can_fix_a_time_event_within_the_same_step(simulate: Simulate) -> None:
    result = simulate("Alarm", 3.0, 1.0, ("y", "alarm"))
    assert result["y"][-1] == pytest.approx(3.0 - np.log(2.0) - 1e-3, abs=1e-8)
    assert (result["solver.state_events"][-1], result["solver.time_events"][-1]) == (1, 1)


def test_a_relation_and_a_clock_of_one_instant_change_together(simulate: Simulate) -> None:
    """3*0.1 is not the third tick's 0.30000000000000004 in every way of writing it; a nanosecond apart is one."""
    result = simulate("Two", 1.05, 0.05, ("early", "late"))
    assert (result["early"][-1], result["late"][-1]) == (3, 8)


def test_an_importer_with_event_mode_is_told_the_instants_beforehand(exported: Callable[[str], Path]) -> None:
    path = str(exported("Instants"))
    description = fmpy.read_model_description(path)
    references = {variable.name: variable.valueReference for variable in description.modelVariables}
    fmu = FMU3Slave(
        guid=description.guid,
        modelIdentifier=description.coSimulation.modelIdentifier,
        unzipDirectory=fmpy.extract(path),
        instanceName="instants",
    )
    fmu.instantiate(eventModeUsed=True, earlyReturnAllowed=True)
    fmu.enterInitializationMode(startTime=0.0)
    fmu.exitInitializationMode()
    time, instants = 0.0, []
    for _ in range(6):
        *_, defined, next_time = fmu.updateDiscreteStates()
        assert defined
        instants.append(next_time)
        fmu.enterStepMode()
        needed, _, early, _ = fmu.doStep(time, next_time - time)
        assert (needed, early) == (True, False)
        time = next_time
        fmu.enterEventMode()
    assert instants == [0.5, 0.625, 0.875, 1.25, 1.75, 2.375]
    assert fmu.getFloat64([references["seen"]])[0] == 1.75  # the event at 2.375 s has not been computed yet
    fmu.updateDiscreteStates()
    assert fmu.getFloat64([references["seen"]])[0] == 2.375
    fmu.terminate()
    fmu.freeInstance()


def test_only_relations_of_time_and_what_holds_between_events_are_known_beforehand() -> None:
    slopes = {r.text: r.slope for r in compile_model(MODELS, "TimeEvents.Alarm").relations}
    assert slopes == {"x > 0.5": 0.0, "time >= t_alarm": 1.0}
    assert {r.slope for r in compile_model(MODELS, "TimeEvents.Pulses").relations} == {-1.0}
