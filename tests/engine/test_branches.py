"""Branches from one state: each is what a run of its own would have been from there on, however many came before."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from both_loops import ending
from coupled_systems import CoupledSystems
from fmu_builder import edited
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from random_systems import systems
from saving_fmus import LOOPS, RUN, again, feedback, same, under

from cosim.engine import (
    Branches,
    Channel,
    Checkpoint,
    Component,
    Connection,
    Fault,
    Fmu,
    PartialResultError,
    Result,
    System,
    branches,
    simulate,
    warm_up,
)
from cosim.errors import CosimError, FmuError, InputError
from cosim.fmu import catalogue
from cosim.scenario import assemble, read

Get = Callable[..., Fmu]
SCENARIOS = Path(__file__).parents[2] / "scenarios"
TIMES = {"output_interval": 0.01, "tolerance": 1e-6}


@contextmanager
def loop(name: str) -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(os.environ, "COSIM_ENGINE", name)
        yield


def is_rest_of(branch: Result, whole: Result) -> None:
    """Assert that the rows after the first are the last ones of a run of the whole, in every bit; and the counts."""
    rows = len(branch.time) - 1
    assert rows > 0
    assert branch.time[1:].tobytes() == whole.time[-rows:].tobytes()
    for name, column in branch.columns.items():
        assert column[1:].tobytes() == whole.columns[name][-rows:].tobytes(), name
    for counted in ("exchanges", "steps", "events", "solver"):
        assert branch.statistics[counted] == whole.statistics[counted], counted


@pytest.mark.parametrize("name", ["linkage_disturbed", "rig_20ms"])
def test_the_wiper_drive(name: str) -> None:
    scenario = read(SCENARIOS / f"{name}.csv")
    system = assemble(scenario, catalogue.ensure)
    run = {"stop": 5.0, "output_interval": scenario.output_interval, "tolerance": scenario.tolerance}
    whole = simulate(system, checkpoint_at=[1.2345], **run)
    with branches(whole.checkpoints[0], system) as branch:
        assert branch.time == whole.checkpoints[0].time
        for _ in range(3):
            is_rest_of(branch(stop=5.0), whole)
            branch(stop=1.5, parameters={("plant", "motor.R"): 2.5})


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_systems_at_random(saving: Get, data: st.DataObject) -> None:
    """From any instant, by either loop, after a branch that ended elsewhere."""
    system = data.draw(systems(saving))
    stop = data.draw(st.floats(0.02, 0.1))
    interval = data.draw(st.sampled_from([0.001, 0.003, 0.01]) | st.floats(0.001, 0.1))
    at = data.draw(st.floats(0.0, 0.95 * stop))
    run = {"stop": stop, "output_interval": interval, "tolerance": 1e-6, "coupling_error": False}
    whole = ending(data.draw(st.sampled_from(LOOPS)), system, checkpoint_at=[at], **run)  # type: ignore[arg-type]
    if isinstance(whole, CosimError) or whole.checkpoints[0].time > 0.99 * stop:
        return
    with loop(data.draw(st.sampled_from(LOOPS))), branches(whole.checkpoints[0], system) as branch:
        branch(stop=data.draw(st.floats(branch.time + 1e-4, stop)))
        found = branch(stop=stop)
        is_rest_of(found, whole)
        assert found.time[0] == branch.time or math.isclose(found.time[0], branch.time, abs_tol=1e-9)


def test_a_fixed_step(saving: Get) -> None:
    run = {"algorithm": "jacobi", "step": 0.005, **RUN}
    for name in LOOPS:
        whole = under(name, feedback(saving), checkpoint_at=[0.032], **run)
        with loop(name), branches(whole.checkpoints[0], feedback(saving)) as branch:
            assert branch.time == 0.035
            is_rest_of(branch(stop=0.1), whole)
            with pytest.raises(InputError, match=r"stop is 0.052 s; it must be a multiple of the macro step, 0.005 s"):
                branch(stop=0.052)


def driven(saving: Get, *, linear: bool, times: list[float], values: list[float]) -> System:
    """Return an integrator and a sampler that looks at it, both driven by channels."""
    system = System(
        [Component("plant", saving("integrator")), Component("c", saving("sampler"), {"T_compute": 0.02})],
        [Connection(("plant", "x"), ("c", "u"))],
        [Channel(("c", "enable"), [0.0, 0.07], [1.0, 0.0]), Channel(("plant", "u"), times, values, linear)],
    )
    return system


@pytest.mark.parametrize("version", LOOPS)
@pytest.mark.parametrize("linear", [False, True])
def test_channels(saving: Get, version: str, linear: bool) -> None:
    """A branch with a channel is a run with the entries before and after; the other channels go on as they would."""
    before = ([0.0, 0.02, 0.04], [1.0, 3.0, 2.0])
    saved = under(
        version, driven(saving, linear=linear, times=before[0], values=before[1]), checkpoint_at=[0.04], **RUN
    )
    system = driven(saving, linear=linear, times=before[0], values=before[1])
    with loop(version), branches(saved.checkpoints[0], system) as branch:
        for entries in (([0.055, 0.08], [7.0, -1.0]), ([0.061], [0.5])):
            whole = driven(saving, linear=linear, times=before[0] + entries[0], values=before[1] + entries[1])
            found = branch(stop=0.1, channels=[Channel(("plant", "u"), *entries, linear)])
            is_rest_of(found, under(version, whole, **RUN))
        is_rest_of(branch(stop=0.1), saved)


@pytest.mark.parametrize("version", LOOPS)
def test_a_step_at_the_state_itself(saving: Get, version: str) -> None:
    """It acts from then on; the first row is that of before. x' = 5 from 0.04 s on."""
    system = System([Component("plant", saving("integrator"))], channels=[Channel(("plant", "u"), [0.0], [1.0])])
    with loop(version), warm_up(system, until=0.04, **TIMES) as branch:
        found = branch(stop=0.06, channels=[Channel(("plant", "u"), [0.04], [5.0])])
    assert found.columns["plant.u"].tolist() == [1.0, 5.0, 5.0]
    np.testing.assert_allclose(found.columns["plant.x"], [0.04, 0.09, 0.14], rtol=1e-13)
    system.channels[0].linear = True
    with loop(version), warm_up(system, until=0.04, **TIMES) as branch:
        found = branch(stop=0.06, channels=[Channel(("plant", "u"), [0.04, 0.06], [5.0, 7.0], linear=True)])
    np.testing.assert_allclose(found.columns["plant.u"], [1.0, 6.0, 7.0], rtol=1e-13)
    np.testing.assert_allclose(found.columns["plant.x"], [0.04, 0.04 + 0.055, 0.04 + 0.12], rtol=1e-13)


@pytest.mark.parametrize("version", [2, 3])
def test_parameters(saving: Get, version: int) -> None:
    """x(k+1) = x(k) + h K x(k), K another one in each branch; it is what a resumed run with it gives."""
    saved = simulate(feedback(saving, version), checkpoint_at=[0.05], **RUN).checkpoints[0]
    for name in LOOPS:
        with loop(name), branches(saved, feedback(saving, version)) as branch:
            for gain in (-10.0, 3.0, -4.0):
                found = branch(stop=0.1, parameters={("c", "K"): gain})
                gains = [-4.0] * 6 + [gain] * 4  # the sample at 0.05 s has been taken
                rows = np.cumprod([1.0, *(1.0 + 0.01 * one for one in gains)])[5:]
                np.testing.assert_allclose(found.columns["plant.x"], rows, rtol=1e-13)
                if gain != -4.0:
                    is_rest_of(found, under(name, feedback(saving, version, K=gain), resume=saved, **RUN))
            assert branch(stop=0.1).columns["plant.x"][-1] == pytest.approx(0.96**10, rel=1e-13)
        with loop(name), branches(saved, feedback(saving, version, K=-10.0)) as branch:
            is_rest_of(branch(stop=0.1), under(name, feedback(saving, version, K=-10.0), resume=saved, **RUN))


def test_continuous_coupling(coupled: CoupledSystems) -> None:
    system = coupled.system("motor")
    run = {"stop": 0.4, "output_interval": 0.02, "tolerance": 1e-5}
    whole = simulate(system, checkpoint_at=[0.1234], coupling_error=False, **run)
    assert whole.checkpoints[0].setup.settings["algorithm"] == "adaptive"
    for name in LOOPS:
        with loop(name), branches(whole.checkpoints[0], system) as branch:
            for _ in range(2):
                is_rest_of(branch(stop=0.4), whole)
    with (
        pytest.raises(InputError, match="needs to know the end: give warm_up a stop"),
        warm_up(system, until=0.1, output_interval=0.02, tolerance=1e-5),
    ):
        pass


def test_faults_go_on(saving: Get) -> None:
    system = feedback(saving)
    system.faults = [Fault(("c", "u"), "noise", 0.2), Fault(("plant", "u"), "delay", 0.0123, 0.0, 0.08)]
    whole = simulate(system, checkpoint_at=[0.04], **RUN)
    with branches(whole.checkpoints[0], system) as branch:
        for _ in range(2):
            is_rest_of(branch(stop=0.1), whole)
    with (
        pytest.raises(InputError, match="need to know the end: give warm_up a stop"),
        warm_up(system, until=0.04, **TIMES),
    ):
        pass


@pytest.mark.parametrize("version", [2, 3])
def test_states_that_stay_in_memory(saving: Get, version: int, tmp_path: Path) -> None:
    claim = f'canSerializeFMU{"s" if version == 2 else "S"}tate="true"'
    system = feedback(saving, version)
    for number, component in enumerate(system.components):
        path = edited(component.fmu.path, tmp_path / f"{number}.fmu", lambda text: text.replace(claim, ""))
        component.fmu = Fmu.read(path)
    whole = simulate(system, **RUN)
    with warm_up(system, until=0.05, stop=0.1, **TIMES) as branch:
        is_rest_of(branch(stop=0.1), whole)
        with pytest.raises(FmuError, match="cannot write its state down"):
            branch.checkpoint()
    for component in system.components:
        component.fmu.close()


def test_a_warm_up_gives_a_checkpoint(tmp_path: Path) -> None:
    """What the FMUs were told of the end is in their states: a run of the same stop goes on to the same bytes."""
    scenario = read(SCENARIOS / "linkage_20ms.csv")
    system = assemble(scenario, catalogue.ensure)
    times = {"output_interval": 1e-3, "tolerance": 1e-6}
    whole = simulate(system, stop=4.0, **times)
    with warm_up(system, until=1.5, stop=4.0, **times) as branch:
        is_rest_of(branch(stop=4.0), whole)
        checkpoint = again(branch.checkpoint(), tmp_path)
        is_rest_of(branch(stop=4.0), whole)
    same(simulate(system, stop=4.0, resume=checkpoint, **times), whole)
    with warm_up(system, until=1.5, **times) as branch:
        assert branch.horizon == branch.checkpoint().horizon == math.inf
        assert Checkpoint.load(branch.checkpoint().save(tmp_path / "y.cosim")).horizon == math.inf
        assert branch(stop=9.0).time[-1] == 9.0


def test_a_branch_that_fails_leaves_the_others(saving: Get) -> None:
    system = System([Component("f", saving("faulty"), {"fault": "error", "t_fault": 0.06})])
    for name in LOOPS:
        with loop(name), warm_up(system, until=0.03, **TIMES) as branch:
            for _ in range(2):
                with pytest.raises(PartialResultError) as caught:
                    branch(stop=0.1)
                assert caught.value.result.time.tolist() == [0.03, 0.04, 0.05]
                assert len(branch(stop=0.05).time) == 3
    system = System([Component("f", saving("faulty"), {"fault": "fatal", "t_fault": 0.06})])
    with warm_up(system, until=0.03, **TIMES) as branch:
        with pytest.raises(PartialResultError, match="returned Fatal"):
            branch(stop=0.1)
        with pytest.raises(PartialResultError, match="has declared itself broken in an earlier branch"):
            branch(stop=0.05)


def test_what_is_refused(saving: Get, fmu: Get) -> None:
    system = feedback(saving)
    system.channels = [Channel(("c", "enable"), [0.0], [1.0])]
    saved = simulate(system, checkpoint_at=[0.05], **RUN).checkpoints[0]

    def refused(**arguments: Any) -> str:  # noqa: ANN401
        with branches(saved, system) as branch, pytest.raises(InputError) as caught:
            branch(**{"stop": 0.1, **arguments})
        return str(caught.value)

    assert refused(stop=0.05) == "stop is 0.05 s; the branches begin at 0.05 s, so give a later one"
    assert refused(stop=0.2).startswith("stop is 0.2 s, but the FMUs were told that the simulation ends at 0.1 s; ")
    assert refused(parameters={("d", "K"): 1.0}) == "d.K: there is no component d; there are plant, c"
    assert refused(parameters={("c", "k"): 1.0}) == "c.k: sampler has no parameter k"
    assert refused(parameters={("c", "T_compute"): 1.0}) == (
        "c.T_compute: is fixed; it cannot change while a simulation runs"
    )
    assert refused(channels=[Channel(("plant", "u"), [0.06], [1.0])]) == (
        "channel plant.u: no channel has driven it up to 0.05 s; there are c.enable; give the whole system one, with "
        "its start value"
    )
    assert refused(channels=[Channel(("c", "enable"), [0.06], [1.0], linear=True)]) == (
        "channel c.enable: up to 0.05 s it was held; it has to remain so"
    )
    assert refused(channels=[Channel(("c", "enable"), [0.04], [1.0])]) == (
        "channel c.enable: its first entry is at 0.04 s; the branches begin at 0.05 s"
    )
    assert refused(channels=[Channel(("c", "enable"), [0.06], [0.5])]) == (
        "channel c.enable: a Boolean takes whole numbers only"
    )
    with pytest.raises(InputError, match="cannot go on from the checkpoint"), branches(saved, feedback(saving)):
        pass
    with pytest.raises(FmuError, match="cannot save its state"), warm_up(feedback(fmu), until=0.05, **TIMES):
        pass
    for until in (0.0, 0.1, math.nan):
        with (
            pytest.raises(InputError, match=r"until is .* s; it must be above 0 and before the stop, 0.1 s"),
            warm_up(system, until=until, stop=0.1, **TIMES),
        ):
            pass


def test_after_the_end(saving: Get) -> None:
    with warm_up(feedback(saving), until=0.05, **TIMES) as branch:
        assert isinstance(branch, Branches)
    with pytest.raises(InputError, match="there are no branches any more"):
        branch(stop=0.1)
