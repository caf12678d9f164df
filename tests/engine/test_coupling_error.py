"""The coupling error that a run reports, beside the true one, and what it says where there is none or none is known."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from both_loops import simulate as simulate_by_both
from coupled_systems import COUPLED, CoupledSystems, exact
from fmu_builder import INTEGRATOR, build, edited

from cosim.engine import (
    Channel,
    Component,
    Connection,
    Fmu,
    Result,
    SimulationInterrupted,
    System,
    explain_timing,
    simulate,
)
from cosim.errors import InputError

Get = Callable[..., Fmu]
HELD: list[dict[str, Any]] = [{"algorithm": "gauss-seidel"}, {"algorithm": "jacobi", "step": 0.005}]
STEPS = (0.1, 0.05, 0.025, 0.0125, 0.00625)
VARIABLE = 'canHandleVariableCommunicationStepSize="true"'


def entries(result: Result) -> list[dict[str, Any]]:
    found = result.statistics["coupling"]
    assert isinstance(found, list)
    return found


def only(result: Result) -> dict[str, Any]:
    (entry,) = entries(result)
    return entry


def one_way(first: Fmu, second: Fmu) -> System:
    """x' = 1, y' = x, from 0."""
    return System(
        [Component("a", first), Component("b", second)],
        [Connection(("a", "x"), ("b", "u"))],
        [Channel(("a", "u"), [0.0], [1.0])],
    )


def stepped(algorithm: str, **other: object) -> list[dict[str, Any]]:
    return [{"algorithm": algorithm, "step": step, "tolerance": 1e-9, **other} for step in STEPS]


ALGORITHMS = {
    "jacobi": stepped("jacobi"),
    "gauss-seidel": stepped("gauss-seidel"),
    **{f"extrapolated, order {order}": stepped("extrapolated", extrapolation=order) for order in (0, 1, 2)},
    **{f"iterated, order {order}": stepped("iterated", extrapolation=order) for order in (0, 2)},
    "adaptive": [{"algorithm": "adaptive", "tolerance": 10.0**-k} for k in range(2, 7)],
}


@pytest.mark.parametrize("algorithm", list(ALGORITHMS))
@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=[pytest.mark.slow] if n == "displacement" else []) for n in COUPLED]
)
def test_the_estimate_is_the_true_error_within_a_factor_of_three(
    coupled: CoupledSystems, name: str, algorithm: str
) -> None:
    for arguments in ALGORITHMS[algorithm]:
        result = simulate(coupled.system(name), stop=2.0, output_interval=0.1, **arguments)
        wanted = exact(name, result.time)
        for entry in entries(result):
            source = entry["source"]
            error = float(np.max(np.abs(result.columns[source] - wanted[source])))
            assert error / 3.0 < entry["error"] < 3.0 * error, (arguments, source)
            assert entry["relative"] == pytest.approx(entry["error"] / np.ptp(result.columns[source]), rel=1e-12)


@pytest.mark.parametrize("algorithm", ["gauss-seidel", "jacobi"])
def test_the_second_run_is_one_with_half_the_interval(coupled: CoupledSystems, algorithm: str) -> None:
    """So the estimate is twice what two runs, each made for itself, differ by."""
    results = []
    for step in (0.05, 0.025):
        arguments: dict[str, Any] = {"algorithm": algorithm} | ({"step": step} if algorithm == "jacobi" else {})
        system = coupled.system("oscillator", 2)
        results.append(simulate_by_both(system, stop=1.0, output_interval=step, tolerance=1e-8, **arguments))
    coarse, fine = results
    for entry in entries(coarse):
        difference = coarse.columns[entry["source"]] - fine.columns[entry["source"]][::2]
        assert entry["error"] == pytest.approx(2.0 * np.max(np.abs(difference)), rel=1e-9)
        assert (entry["order"], entry["note"]) == (1, "")


def test_what_nothing_acts_back_on_is_exact_and_its_target_is_not(fmu: Get) -> None:
    """y' = x = t with x as it is at the end of each step: y is too large by h t / 2."""
    system = one_way(fmu("integrator"), fmu("integrator"))
    entry = only(simulate(system, stop=1.0, output_interval=0.1, tolerance=1e-6, algorithm="gauss-seidel"))
    assert (entry["error"], entry["relative"]) == (pytest.approx(0.0, abs=1e-14), pytest.approx(0.0, abs=1e-14))
    worst = entry["target_outputs"]
    assert (worst["output"], worst["unit"], worst["error"]) == ("b.x", "m", pytest.approx(0.05, rel=1e-9))


def test_a_sampled_loop_has_none_and_runs_once(fmu: Get) -> None:
    system = System(
        [Component("plant", fmu("integrator"), {"x0": 1.0}), Component("c", fmu("sampler"), {"K": -1.0})],
        [Connection(("plant", "x"), ("c", "u")), Connection(("c", "y"), ("plant", "u"))],
    )
    result = simulate_by_both(system, stop=0.1, output_interval=0.01, tolerance=1e-6)
    assert "second_wall_s" not in result.statistics
    for entry, ends in zip(entries(result), (("plant.x", "c.u"), ("c.y", "plant.u")), strict=True):
        assert (entry["source"], entry["target"]) == ends
        assert (entry["delay_s"], entry["error"], entry["order"]) == (0.0, None, None)
        assert entry["note"] == "none: sampled"
    late = simulate(system, stop=0.1, output_interval=0.02, tolerance=1e-6, algorithm="jacobi", step=0.02)
    assert [entry["delay_s"] for entry in entries(late)] == [0.0, 0.02]
    assert all(entry["error"] > 0.0 for entry in entries(late))


def test_it_costs_nothing_that_was_not_asked_for(coupled: CoupledSystems) -> None:
    system = coupled.system("motor")
    result = simulate(system, stop=0.1, output_interval=0.01, tolerance=1e-6, coupling_error=False)
    assert "second_wall_s" not in result.statistics
    assert {entry["note"] for entry in entries(result)} == {"not estimated: not asked for"}
    asked = simulate(system, stop=0.1, output_interval=0.01, tolerance=1e-6)
    assert asked.statistics["steps"] == result.statistics["steps"]
    for name, column in result.columns.items():
        assert column.tobytes() == asked.columns[name].tobytes()


@pytest.mark.filterwarnings("ignore::cosim.errors.FmuWarning")
@pytest.mark.parametrize("version", [2, 3])
def test_a_component_with_steps_of_its_own_leaves_its_neighbours_without(
    fmu: Get, version: int, tmp_path: Path
) -> None:
    def edit(text: str) -> str:
        text = text.replace(VARIABLE, ' fixedInternalStepSize="0.1" ' if version == 3 else " ")
        return text.replace("<ModelVariables>", '<DefaultExperiment stepSize="0.1"/><ModelVariables>')

    path = edited(build(INTEGRATOR, version, tmp_path), tmp_path / "fixed.fmu", edit if version == 2 else _only_fixed)
    with Fmu.read(path) as fixed:
        system = one_way(fmu("integrator"), fixed)
        system.components += [Component(name, fmu("integrator")) for name in ("c", "d", "e")]
        system.connections += [Connection((s, "x"), (t, "u")) for s, t in (("a", "c"), ("d", "e"))]
        runs = [
            simulate(system, stop=1.0, output_interval=0.1, tolerance=1e-6, **arguments)
            for arguments in ({}, {"algorithm": "jacobi", "step": 0.1})
        ]
    why = "not estimated: b takes steps of 0.1 s only, and cannot take shorter ones"
    assert [entry["note"] for entry in entries(runs[0])] == [why, why, ""]
    assert [entry["note"] for entry in entries(runs[1])] == [why] * 3
    assert "second_wall_s" not in runs[1].statistics


def _only_fixed(text: str) -> str:
    return text.replace(VARIABLE, ' fixedInternalStepSize="0.1" ')


def test_other_reasons_for_none(fmu: Get) -> None:
    boolean = System(
        [Component("a", fmu("integrator")), Component("b", fmu("integrator"))],
        [Connection(("a", "positive"), ("b", "u"))],
    )
    entry = only(simulate(boolean, stop=0.1, output_interval=0.01, tolerance=1e-6))
    assert entry["note"] == "not estimated: the signal is no Real"
    follower = System(
        [Component("a", fmu("integrator")), Component("f", fmu("foreign", 2))],
        [Connection(("a", "x"), ("f", "u"))],
    )
    result = simulate(follower, stop=0.1, output_interval=0.01, tolerance=1e-6, algorithm="jacobi", step=0.01)
    assert only(result)["note"] == "not estimated: f samples at each of its steps, and would sample more often"


def test_a_second_run_that_fails_is_no_failure(fmu: Get, monkeypatch: pytest.MonkeyPatch) -> None:
    """A component that fails from 0.05 s on, the first time that it is asked for less than a whole step."""
    from cosim.engine.signals._participant import Participant

    whole = Participant.step

    def step(self: Participant, t: float, h: float) -> None:
        whole(self, t, float("nan") if h < 0.009 and t > 0.049 and self.instance.name == "f" else h)

    monkeypatch.setattr(Participant, "step", step)
    monkeypatch.setitem(os.environ, "COSIM_ENGINE", "python")
    system = one_way(fmu("integrator"), fmu("integrator"))
    system.components.append(Component("f", fmu("integrator")))
    result = simulate(system, stop=0.1, output_interval=0.01, tolerance=1e-6, algorithm="gauss-seidel")
    assert result.complete
    note = only(result)["note"]
    assert note.startswith(
        "not estimated: with shorter intervals, the simulation failed at t = 0.06 s: f (integrator): "
    )
    assert only(result)["error"] is None


@pytest.mark.parametrize("error", [InputError("there is not enough memory"), KeyboardInterrupt()])
def test_a_second_run_that_does_not_start_is_no_failure(
    fmu: Get, monkeypatch: pytest.MonkeyPatch, error: BaseException
) -> None:
    from cosim.engine import _simulate

    first = _simulate._run_here

    def run_once(*arguments: Any) -> Any:  # noqa: ANN401
        monkeypatch.setattr(_simulate, "_run_here", refuse)
        return first(*arguments)

    def refuse(*_: object) -> None:
        raise error

    monkeypatch.setattr(_simulate, "_run_here", run_once)
    system = one_way(fmu("integrator"), fmu("integrator"))
    arguments: dict[str, Any] = {"stop": 1.0, "output_interval": 0.1, "tolerance": 1e-6, "algorithm": "gauss-seidel"}
    if isinstance(error, InputError):
        result = simulate(system, **arguments)
        assert only(result)["note"] == "not estimated: the second run cannot be made: there is not enough memory"
    else:
        with pytest.raises(SimulationInterrupted) as caught:
            simulate(system, **arguments)
        result = caught.value.result
        assert only(result)["note"] == "not estimated: interrupted"
    assert result.complete
    assert len(result.time) == 11


def test_an_interruption_of_the_second_run_keeps_the_first(fmu: Get) -> None:
    seen: list[float] = []

    def progress(t: float) -> None:
        if seen and t < seen[-1]:
            raise KeyboardInterrupt
        seen.append(t)

    system = one_way(fmu("integrator"), fmu("integrator"))
    with pytest.raises(SimulationInterrupted) as caught:
        simulate(
            system,
            stop=1.0,
            output_interval=1e-4,
            tolerance=1e-6,
            progress=progress,
            algorithm="gauss-seidel",
        )
    assert str(caught.value) == "interrupted while the coupling error was estimated, after the run itself"
    assert caught.value.result.complete
    assert caught.value.result.time[-1] == 1.0


def test_delays_are_those_that_an_onlooker_sees(fmu: Get, coupled: CoupledSystems) -> None:
    """The longest delay by rule, and by the trace of a run."""
    plant = Component("plant", fmu("integrator"), {"x0": 1.0})
    sampled = [
        Component(name, fmu("sampler", version), {"T_compute": period, "K": -0.5})
        for name, version, period in (("fast", 2, 0.01), ("slow", 2, 0.03), ("odd", 2, 0.025), ("event", 3, 0.02))
    ]
    chains = (("plant.x", "fast"), ("fast.y", "slow"), ("slow.y", "odd"), ("fast.y", "event"))
    back = [Connection(("event", "y"), ("plant", "u"))]
    chain = System([plant, *sampled], [Connection(_end(s), (t, "u")) for s, t in chains] + back)
    ring = System(
        [plant, *sampled[:2]], [Connection(("fast", "y"), ("slow", "u")), Connection(("slow", "y"), ("fast", "u"))]
    )
    for system in (chain, ring, coupled.system("oscillator"), coupled.system("motor"), coupled.system("displacement")):
        for arguments in HELD:
            result = simulate(system, stop=1.5, output_interval=0.005, tolerance=1e-6, **arguments)
            text = explain_timing(system, stop=1.5, output_interval=0.005, **arguments)
            seen = [
                [float(d) for d in re.findall(r"(\S+) s\b", line)] for line in re.findall(r"    delay ([^;]+);", text)
            ]
            wanted = [max(delays, key=abs) for delays in seen]
            assert [entry["delay_s"] for entry in entries(result)] == pytest.approx(wanted, abs=1e-9), text


def test_a_signal_that_is_continued_into_the_step_has_no_delay(coupled: CoupledSystems) -> None:
    result = simulate(coupled.system("oscillator"), stop=0.1, output_interval=0.01, tolerance=1e-4)
    assert [entry["delay_s"] for entry in entries(result)] == [0.0, 0.0, 0.0]


def _end(dotted: str) -> tuple[str, str]:
    component, _, variable = dotted.partition(".")
    return component, variable
