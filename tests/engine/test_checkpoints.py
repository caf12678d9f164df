"""Checkpoints: a run that goes on from one equals one that was not interrupted, byte for byte, whatever was saved."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest
from both_loops import compare, ending
from coupled_systems import CoupledSystems
from fmu_builder import MODELS, build
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from random_systems import systems
from saving_fmus import LOOPS, RUN, again, feedback, same, under

from cosim.engine import (
    Algorithm,
    Checkpoint,
    Component,
    Connection,
    Fault,
    FaultKind,
    Fmu,
    PartialResultError,
    Result,
    SimulationInterrupted,
    System,
    simulate,
)
from cosim.errors import CosimError, FmuWarning
from cosim.fmu import catalogue
from cosim.report import write_csv
from cosim.scenario import assemble, read

Get = Callable[..., Fmu]
SCENARIOS = Path(__file__).parents[2] / "scenarios"


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_systems_at_random(saving: Get, tmp_path: Path, data: st.DataObject) -> None:
    system = data.draw(systems(saving))
    stop = data.draw(st.floats(0.01, 0.1))
    interval = data.draw(st.sampled_from([0.001, 0.003, 0.01]) | st.floats(0.001, 0.1))
    at = data.draw(st.lists(st.floats(0.0, stop), min_size=1, max_size=3))
    go(system, at, tmp_path, data.draw, stop=stop, output_interval=interval, tolerance=1e-6, coupling_error=False)


@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_systems_at_random_with_a_fixed_step(saving: Get, tmp_path: Path, data: st.DataObject) -> None:
    system = data.draw(systems(saving))
    step = data.draw(st.sampled_from([0.001, 0.0025, 0.0073]))
    every = data.draw(st.integers(1, 5))
    stop = data.draw(st.integers(5, 60)) * step
    at = data.draw(st.lists(st.floats(0.0, stop), min_size=1, max_size=3))
    arguments = {"output_interval": every * step, "tolerance": 1e-6, "algorithm": "jacobi", "step": step}
    go(system, at, tmp_path, data.draw, stop=stop, coupling_error=False, **arguments)


def go(system: System, at: list[float], folder: Path, draw: Callable[..., object], **arguments: object) -> None:
    """Compare runs with and without checkpoints, and from each to the end, by both loops."""
    first, second = draw(st.permutations(LOOPS))
    reference = ending(first, system, **arguments)
    saved = ending(second, system, checkpoint_at=at, **arguments)
    compare(saved, reference)  # saving has changed nothing
    if isinstance(reference, CosimError):  # an algebraic loop, or events without end
        assert isinstance(saved, PartialResultError)
        saved = saved.result
    else:
        assert isinstance(saved, Result)
        assert len(saved.checkpoints) == len(set(at))
    for checkpoint in saved.checkpoints:
        resumed = ending(draw(st.sampled_from(LOOPS)), system, resume=again(checkpoint, folder), **arguments)
        if isinstance(resumed, Result) and isinstance(reference, Result):
            same(resumed, reference)
        else:
            assert str(resumed) == str(reference)


FAULTS: dict[FaultKind, float] = {
    "override": 0.3,
    "bias": 0.1,
    "scale": 0.5,
    "freeze": 0.0,
    "delay": 0.0123,
    "drop": 0.5,
    "quantise": 0.25,
    "noise": 0.2,
}


@pytest.mark.parametrize("target", [("plant", "u"), ("c", "u")])
@pytest.mark.parametrize("kind", FAULTS)
def test_faults(saving: Get, tmp_path: Path, kind: FaultKind, target: tuple[str, str]) -> None:
    """Before, at the beginning of, within and after the time of a fault, the delay's long history included."""
    system = feedback(saving)
    system.faults = [Fault(target, kind, FAULTS[kind], start=0.0234, stop=0.0712)]
    run = RUN | {"stop": 0.2}
    for loop, other in (LOOPS, LOOPS[::-1]):
        reference = under(loop, system, **run)
        saved = under(other, system, checkpoint_at=[0.01, 0.0234, 0.03, 0.052, 0.0712, 0.1], **run)
        same(saved, reference)
        for checkpoint in saved.checkpoints:
            same(under(loop, system, resume=again(checkpoint, tmp_path), **run), reference)


@pytest.mark.parametrize(("name", "version"), [("linkage_20ms", "3.0"), ("rig_20ms", "2.0")])
def test_the_wiper_drive(name: str, version: str, tmp_path: Path) -> None:
    bytes_agree(name, version, "native", count=4, stop=5.0, folder=tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("loop", LOOPS)
@pytest.mark.parametrize("version", ["3.0", "2.0"])
@pytest.mark.parametrize("name", ["linkage_20ms", "linkage_disturbed", "rig_20ms"])
def test_the_wiper_drive_at_twenty_instants(name: str, version: str, loop: str, tmp_path: Path) -> None:
    bytes_agree(name, version, loop, count=20, stop=25.0, folder=tmp_path)


def bytes_agree(name: str, version: str, loop: str, *, count: int, stop: float, folder: Path) -> None:
    """Compare results.csv of an uninterrupted run with that of runs resumed at random instants, from files."""
    scenario = read(SCENARIOS / f"{name}.csv")
    system = assemble(scenario, partial(catalogue.ensure, fmi=version))
    assert {component.fmu.fmi_version for component in system.components} == {version}
    chance = random.Random(f"{name} {version} {loop}")
    at = sorted(chance.uniform(0.0, stop) for _ in range(count))
    arguments = {"stop": stop, "output_interval": scenario.output_interval, "tolerance": scenario.tolerance}
    reference = under(loop, system, **arguments)
    saved = under(loop, system, checkpoint_at=at, checkpoint_to=folder, **arguments)
    for number, result in enumerate((reference, saved)):
        write_csv(result, folder / f"{number}.csv")
    expected = (folder / "0.csv").read_bytes()
    assert (folder / "1.csv").read_bytes() == expected
    assert len(saved.checkpoints) == count
    for time in at:
        checkpoint = Checkpoint.load(folder / f"checkpoint_{time:.9g}s.cosim")
        assert time <= checkpoint.time <= time + 1.1e-3
        resumed = under(loop, system, resume=checkpoint, **arguments)
        write_csv(resumed, folder / "resumed.csv")
        assert (folder / "resumed.csv").read_bytes() == expected
        same(resumed, reference)


@pytest.mark.parametrize("algorithm", ["extrapolated", "iterated", "adaptive"])
@pytest.mark.parametrize("name", ["displacement", "motor"])
def test_continuous_coupling(coupled: CoupledSystems, name: str, algorithm: Algorithm, tmp_path: Path) -> None:
    """What is known of the connected signals, and the next macro step, are saved; the end is the one first told."""
    system = coupled.system(name)
    run = {"stop": 0.4, "output_interval": 0.02, "tolerance": 1e-5, "algorithm": algorithm, "coupling_error": False}
    chance = random.Random(f"{name} {algorithm}")
    for loop, other in (LOOPS, LOOPS[::-1]):
        reference = under(loop, system, **run)
        saved = under(other, system, checkpoint_at=[chance.uniform(0.0, 0.4) for _ in range(3)], **run)
        same(saved, reference)
        for checkpoint in saved.checkpoints:
            same(under(loop, system, resume=again(checkpoint, tmp_path), **run), reference)
        checkpoint = saved.checkpoints[0]
        shorter = under(loop, system, resume=checkpoint, **run | {"stop": checkpoint.time + 0.05})
        rows = len(shorter.time) - 1
        for column in shorter.columns:
            assert shorter.columns[column][:rows].tobytes() == reference.columns[column][:rows].tobytes()


@pytest.mark.parametrize("version", ["3.0", "2.0"])
def test_model_exchange(version: str, tmp_path: Path) -> None:
    """The solver beside the FMU goes on as if nothing had happened, within its own step, too."""
    scenario = read(SCENARIOS / "linkage_20ms.csv")
    system = assemble(scenario, partial(catalogue.ensure, fmi=version))
    for component in system.components:
        component.fmu.close()
        component.fmu = Fmu.read(component.fmu.path, interface="ModelExchange")
    run = {"stop": 2.0, "output_interval": 1e-3, "tolerance": 1e-6}
    reference = simulate(system, **run)
    saved = simulate(system, checkpoint_at=[0.3217, 0.9, 1.4444], **run)
    same(saved, reference)
    for checkpoint in saved.checkpoints:
        same(simulate(system, resume=again(checkpoint, tmp_path), **run), reference)


@pytest.mark.parametrize("version", [2, 3])
def test_steps_of_one_length(saving: Get, version: int, tmp_path: Path) -> None:
    """Within a step that has begun: its inputs are set, and it ends later."""
    with Fmu.read(build(MODELS["integrator"], version, tmp_path, variable_steps=False, saves=True)) as slow:
        system = feedback(saving, version, T_compute=0.007)
        system.components.append(Component("slow", slow))
        system.connections.append(Connection(("plant", "x"), ("slow", "u")))
        with pytest.warns(FmuWarning, match="takes steps of one length only"):
            for loop, other in (LOOPS, LOOPS[::-1]):
                reference = under(loop, system, **RUN)
                saved = under(other, system, checkpoint_at=[0.001, 0.013, 0.04, 0.0771], **RUN)
                for checkpoint in saved.checkpoints:
                    same(under(loop, system, resume=again(checkpoint, tmp_path), **RUN), reference)


@pytest.mark.parametrize("name", ["label", "words", "parcel"])
def test_texts_and_binaries(saving: Get, name: str, tmp_path: Path) -> None:
    version = 2 if name == "label" else 3
    wires = [("y", "u")] if name == "label" else [("y[1]", "u[1]"), ("y[2]", "u[2]")]
    system = System(
        [Component(f"c{i}", saving(name, version)) for i in range(2)],
        [Connection(("c0", source), ("c1", target)) for source, target in wires],
    )
    for loop in LOOPS:
        reference = under(loop, system, **RUN)
        saved = under(loop, system, checkpoint_at=[0.0, 0.033, 0.05, 0.1], **RUN)
        for checkpoint in saved.checkpoints:
            for other in LOOPS:
                result = under(other, system, resume=again(checkpoint, tmp_path), **RUN)
                assert {k: v.tobytes() for k, v in result.columns.items()} == {
                    k: v.tobytes() for k, v in reference.columns.items()
                }


def test_in_a_process_of_its_own(saving: Get, tmp_path: Path) -> None:
    system = feedback(saving)
    reference = simulate(system, **RUN)
    saved = simulate(system, checkpoint_at=[0.02, 0.05], isolate="always", **RUN)
    assert [checkpoint.time for checkpoint in saved.checkpoints] == [0.02, 0.05]
    for isolate in ("always", "never"):
        same(simulate(system, resume=saved.checkpoints[1], isolate=isolate, **RUN), reference)


def test_what_was_written_before_a_crash_is_of_use(fmu: Get, saving: Get, tmp_path: Path) -> None:
    """The worker dies; what it has written before is complete."""
    system = feedback(saving)
    broken = System([*system.components, Component("f", saving("faulty"), {"fault": "error", "t_fault": 0.06})])
    broken.connections = system.connections
    for isolate in ("never", "always"):
        folder = tmp_path / isolate
        with pytest.raises(PartialResultError) as caught:
            simulate(broken, checkpoint_at=[0.03, 0.09], checkpoint_to=folder, isolate=isolate, **RUN)
        assert [checkpoint.time for checkpoint in caught.value.result.checkpoints] == [0.03]
        assert [path.name for path in folder.iterdir()] == ["checkpoint_0.03s.cosim"]
        with pytest.raises(PartialResultError) as repeated:
            simulate(broken, resume=Checkpoint.load(folder / "checkpoint_0.03s.cosim"), **RUN)
        assert str(repeated.value) == str(caught.value)
        same(repeated.value.result, caught.value.result)


def test_a_process_that_dies_leaves_its_checkpoints(saving: Get, tmp_path: Path) -> None:
    """Also of an earlier run none of the same name remains."""
    system = System([Component("f", saving("crash"))])
    for at in (0.03, 0.09):
        simulate(system, checkpoint_at=[0.0], **RUN).checkpoints[0].save(tmp_path / Checkpoint.file_name(at))
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("CRASH", "DoStep segmentation")
        with pytest.raises(PartialResultError, match=r"at t = 0.04 s: f \(crash\): crashed in fmi3DoStep") as caught:
            simulate(system, checkpoint_at=[0.03, 0.09], checkpoint_to=tmp_path, isolate="always", **RUN)
    assert [checkpoint.time for checkpoint in caught.value.result.checkpoints] == [0.03]
    assert [path.name for path in tmp_path.iterdir()] == ["checkpoint_0.03s.cosim"]
    same(simulate(system, resume=caught.value.result.checkpoints[0], **RUN), simulate(system, **RUN))


@pytest.mark.parametrize(("version", "name"), [(2, "fmi2SerializeFMUstate"), (3, "fmi3SerializeFMUState")])
def test_a_process_that_dies_of_a_checkpoint(saving: Get, version: int, name: str, tmp_path: Path) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("CRASH", "Serialize segmentation")
        with pytest.raises(PartialResultError) as caught:
            system = System([Component("f", saving("crash", version))])
            simulate(system, checkpoint_at=[0.03], checkpoint_to=tmp_path, isolate="always", **RUN)
    assert f"the simulation failed at t = 0.03 s: f (crash): crashed in {name}, with SIGSEGV" in str(caught.value)
    assert len(caught.value.result.time) == 4
    assert caught.value.result.checkpoints == ()


@pytest.mark.parametrize("loop", LOOPS)
def test_an_interruption_keeps_them(saving: Get, loop: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(_: float) -> None:
        raise KeyboardInterrupt

    monkeypatch.setenv("COSIM_ENGINE", loop)
    system = feedback(saving)
    run = RUN | {"stop": 100.0}
    with pytest.raises(SimulationInterrupted) as caught:
        simulate(system, checkpoint_at=[0.0], progress=interrupt, **run)
    (checkpoint,) = caught.value.result.checkpoints
    assert checkpoint.time == 0.0
    same(simulate(system, resume=checkpoint, **run), simulate(system, **run))


def test_infinite_numbers(saving: Get, tmp_path: Path) -> None:
    system = System([Component("plant", saving("integrator"), {"offset": math.inf})])
    saved = simulate(system, checkpoint_at=[0.05], **RUN)
    assert saved.columns["plant.y"][0] == math.inf
    same(simulate(system, resume=again(saved.checkpoints[0], tmp_path), **RUN), saved)
