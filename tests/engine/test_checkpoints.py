"""Checkpoints: a run that goes on from one equals one that was not interrupted, byte for byte, whatever was saved."""

from __future__ import annotations

import json
import math
import os
import random
import zipfile
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from both_loops import compare, ending
from coupled_systems import CoupledSystems
from fmu_builder import MODELS, build, build_first, edited
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from random_systems import systems
from saving_fmus import LOOPS, RUN, again, feedback, same, under

from cosim.engine import (
    Algorithm,
    Channel,
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
from cosim.errors import CosimError, FmuError, FmuWarning, InputError
from cosim.fmu import catalogue
from cosim.report import write_csv
from cosim.scenario import assemble, read

Get = Callable[..., Fmu]
SCENARIOS = Path(__file__).parents[2] / "scenarios"


# to the same bytes


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


@pytest.mark.parametrize("version", ["3.0", "2.0"])
@pytest.mark.parametrize("name", ["linkage_20ms", "linkage_disturbed", "rig_20ms"])
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


# what may be changed


@pytest.mark.parametrize("version", [2, 3])
def test_a_tunable_parameter_acts_from_the_checkpoint_on(saving: Get, version: int) -> None:
    """x(k+1) = x(k) + h K x(k): the sample at the checkpoint has been taken, unless an event takes it again."""
    saved = simulate(feedback(saving, version), checkpoint_at=[0.05], **RUN).checkpoints[0]
    for loop in LOOPS:
        result = under(loop, feedback(saving, version, K=-10.0), resume=saved, **RUN)
        gains = [-4.0] * 6 + [-10.0] * 4
        rows = np.cumprod([1.0, *(1.0 + 0.01 * gain for gain in gains)])
        np.testing.assert_allclose(result.columns["plant.x"], rows, rtol=1e-13)
        events = 12 if version == 3 else 0
        assert result.statistics["events"] == ({"c": events} if version == 3 else {})


def test_channels_may_change_after_the_checkpoint(saving: Get) -> None:
    def system(after: float) -> System:
        channel = Channel(("plant", "u"), [0.0, 0.02, 0.06], [1.0, 2.0, after])
        return System([Component("plant", saving("integrator"))], channels=[channel])

    saved = simulate(system(0.0), checkpoint_at=[0.04], **RUN).checkpoints[0]
    for loop in LOOPS:
        same(under(loop, system(7.0), resume=saved, **RUN), simulate(system(7.0), **RUN))
    same(simulate(system(7.0), resume=saved, **RUN | {"stop": 0.08}), simulate(system(7.0), **RUN | {"stop": 0.08}))


def test_the_past_of_a_line_reaches_to_its_next_corner(saving: Get) -> None:
    def system(next_: float, last: float) -> System:
        channel = Channel(("plant", "u"), [0.0, 0.06, 0.1], [1.0, next_, last], linear=True)
        return System([Component("plant", saving("integrator"))], channels=[channel])

    saved = simulate(system(2.0, 3.0), checkpoint_at=[0.04], **RUN).checkpoints[0]
    same(simulate(system(2.0, 9.0), resume=saved, **RUN), simulate(system(2.0, 9.0), **RUN))
    assert "another past: 5 at 0.06 s, in the checkpoint 2 at 0.06 s" in refused(system(5.0, 3.0), resume=saved)


# what is refused


def refused(system: System, **arguments: object) -> str:
    with pytest.raises(InputError) as caught:
        simulate(system, **RUN | arguments)  # type: ignore[arg-type]
    return str(caught.value)


def test_what_differs_is_told(saving: Get, fmu: Get) -> None:
    saved = simulate(feedback(saving), checkpoint_at=[0.05], **RUN).checkpoints[0]
    begin = "cannot go on from the checkpoint at 0.05 s"
    told = "; use what it was made with, or make a new one"
    assert refused(feedback(saving), resume=saved, tolerance=1e-5) == (
        f"{begin}: tolerance is 1e-05, in the checkpoint 1e-06{told}"
    )
    assert refused(feedback(saving), resume=saved, algorithm="jacobi", step=0.01) == (
        f"{begin}: algorithm is jacobi, in the checkpoint gauss-seidel; step is 0.01, in the checkpoint not given; "
        f"c is used as CoSimulation, continuous, in the checkpoint as CoSimulation, event{told}"
    )
    other = feedback(saving)
    other.components[0] = Component("plant", saving("integrator", 2), {"x0": 1.0})
    assert f"{begin}: plant has another FMU: integrator (FMI 2.0, SHA-256 " in refused(other, resume=saved)
    other = feedback(saving)
    other.components[1].name = "d"
    other.connections = []
    assert f"{begin}: the components are plant, d, in the checkpoint plant, c" in refused(other, resume=saved)
    other = feedback(saving)
    other.connections[0] = Connection(("plant", "x"), ("c", "u"), factor=2.0)
    assert refused(other, resume=saved).startswith(
        f"{begin}: the connection plant.x -> c.u (factor 2, offset 0) is not in the checkpoint; the checkpoint has a "
        "connection plant.x -> c.u;"
    )
    other = feedback(saving)
    other.channels = [Channel(("c", "enable"), [0.0], [1.0])]
    assert "the channels are c.enable, in the checkpoint none (an input that is to be driven" in refused(
        other, resume=saved
    )
    other = feedback(saving)
    other.faults = [Fault(("c", "u"), "bias", 0.5, start=0.07)]
    message = refused(other, resume=saved)
    assert f"{begin}: the faults are c.u bias 0.5 from 0.07 s, in the checkpoint none" in message
    assert refused(feedback(saving, T_compute=0.02), resume=saved) == (
        "c.T_compute: is 0.02, in the checkpoint 0.01; it is fixed, so it cannot change while a simulation runs; "
        "tunable are c.K"
    )
    assert refused(feedback(saving), resume=saved, stop=0.2).startswith(
        f"{begin} to 0.2 s: the FMUs were told that the simulation ends at 0.1 s; stop there or earlier"
    )
    assert refused(feedback(saving), resume=saved, stop=0.04) == f"{begin} to 0.04 s; give a later stop"
    assert (
        len(simulate(feedback(saving), resume=saved, **RUN | {"stop": 0.05}).time) == 6
    )  # there is nothing left to do


def test_what_it_shows_of_itself(saving: Get) -> None:
    (saved,) = simulate(feedback(saving), checkpoint_at=[0.05], **RUN).checkpoints
    assert repr(saved) == "<checkpoint of plant, c at 0.05 s, with 6 rows>"


def test_times_of_checkpoints(saving: Get) -> None:
    system = feedback(saving)
    for time in (-1.0, 0.2, math.nan):
        assert refused(system, checkpoint_at=[time]) == f"a checkpoint at {time:g} s: the run goes from 0 to 0.1 s only"
    saved = simulate(system, checkpoint_at=[0.05], **RUN).checkpoints[0]
    assert refused(system, checkpoint_at=[0.05], resume=saved) == (
        "a checkpoint at 0.05 s: the run goes on from 0.05 s; give a later time"
    )


@pytest.mark.parametrize("version", [2, 3])
def test_an_fmu_that_cannot_save_its_state_is_refused(saving: Get, fmu: Get, version: int, tmp_path: Path) -> None:
    claim = "FMUstate" if version == 2 else "FMUState"
    system = feedback(lambda name, version: (fmu if name == "sampler" else saving)(name, version), version)
    assert refused(system, checkpoint_at=[0.05]).endswith(
        "no checkpoint can be made: c (sampler) cannot save its state (its description does not claim "
        f"canGetAndSet{claim}); run the system without checkpoints, from 0 on"
    )
    path = edited(
        saving("sampler", version).path,
        tmp_path / "x.fmu",
        lambda text: text.replace(f'canSerialize{claim}="true"', ""),
    )
    with Fmu.read(path) as in_memory_only:
        system.components[1].fmu = in_memory_only
        assert refused(system, checkpoint_at=[0.05]).endswith(
            "no checkpoint can be made: c (sampler) cannot write its state down (its description does not claim "
            f"canSerialize{claim}); it can keep it in memory: cosim.engine.warm_up lets many runs branch from one state"
        )


def test_an_fmu_of_fmi_1_is_refused(tmp_path: Path) -> None:
    with Fmu.read(build_first(tmp_path)) as first:
        message = refused(System([Component("first", first)]), checkpoint_at=[0.05])
    assert "first (first) is of FMI 1.0, which cannot save states" in message


def test_without_the_native_library_model_exchange_is_refused(saving: Get, monkeypatch: pytest.MonkeyPatch) -> None:
    plant = Fmu.read(catalogue.ensure("LinkagePlant"), interface="ModelExchange")
    monkeypatch.setenv("COSIM_ENGINE", "python")
    with plant:
        message = refused(System([Component("plant", plant)]), checkpoint_at=[0.05])
    assert "plant (LinkagePlant) is for Model Exchange, and without the native library its solver (CVode)" in message


def test_a_folder_that_cannot_be_written_ends_the_run(saving: Get, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(PartialResultError) as caught:
        simulate(feedback(saving), checkpoint_at=[0.05], checkpoint_to=tmp_path / "file", **RUN)
    assert "checkpoint_0.05s.cosim: the checkpoint cannot be written: " in str(caught.value)
    assert len(caught.value.result.time) == 6


# files


@pytest.fixture(scope="module")
def some(saving: Get, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A file of a run with a channel and events, at 0.05 s."""
    folder = tmp_path_factory.mktemp("some")
    return simulate(eventful(saving), checkpoint_at=[0.05], **RUN).checkpoints[0].save(folder / "some.cosim")


def eventful(saving: Get) -> System:
    system = feedback(saving)
    system.channels = [Channel(("c", "enable"), [0.0, 0.045, 0.07], [1.0, 0.0, 1.0])]
    return system


def test_no_file_and_other_files(tmp_path: Path) -> None:
    def of(content: bytes | None) -> str:
        path = tmp_path / "x.cosim"
        path.unlink(missing_ok=True)
        if content is not None:
            path.write_bytes(content)
        with pytest.raises(InputError) as caught:
            Checkpoint.load(path)
        return str(caught.value).removeprefix(f"{path}: ")

    assert of(None) == "the checkpoint cannot be read: No such file or directory; give the path of a .cosim file"
    told = "; write it again with --checkpoint, or Checkpoint.save"
    assert of(b"") == of(b"time,x\n0,1\n") == f"is not a checkpoint{told}"
    assert of(b"PK\3\4") == f"is cut off or damaged{told}"
    with zipfile.ZipFile(tmp_path / "other.zip", "w") as archive:
        archive.writestr("modelDescription.xml", "<fmi/>")
    assert of((tmp_path / "other.zip").read_bytes()).startswith("is not a checkpoint: it has no checkpoint.json")


def repacked(some: Path, path: Path, edit: Callable[[dict[str, bytes]], None], kind: int = zipfile.ZIP_STORED) -> Path:
    with zipfile.ZipFile(some) as old:
        contents = {name: old.read(name) for name in old.namelist()}
    edit(contents)
    with zipfile.ZipFile(path, "w", kind) as new:
        for name, content in contents.items():
            new.writestr(name, content)
    return path


def with_document(**changes: object) -> Callable[[dict[str, bytes]], None]:
    def edit(contents: dict[str, bytes]) -> None:
        document = json.loads(contents["checkpoint.json"]) | changes
        contents["checkpoint.json"] = json.dumps(document).encode()

    return edit


def test_what_does_not_agree_within_a_file(some: Path, tmp_path: Path, saving: Get) -> None:
    def of(edit: Callable[[dict[str, bytes]], None], kind: int = zipfile.ZIP_STORED) -> str:
        path = repacked(some, tmp_path / "x.cosim", edit, kind)
        with pytest.raises(InputError) as caught:
            simulate(eventful(saving), resume=Checkpoint.load(path), **RUN)
        return str(caught.value)

    def cut(contents: dict[str, bytes]) -> None:
        contents["values"] = contents["values"][:-8]

    assert "is damaged: what is in it is not what checkpoint.json says: values" in of(cut)
    assert "its directory is not as cosim writes it" in of(lambda _: None, zipfile.ZIP_DEFLATED)
    assert "says: extra" in of(lambda contents: contents.update(extra=b""))
    assert "is a checkpoint of format 2, and this version of cosim reads 1" in of(with_document(version=2, new=1))
    assert "is damaged: checkpoint.json: rows: Input should be a valid integer" in of(with_document(rows="many"))
    assert "is damaged: checkpoint.json: time: " in of(with_document(time=math.nan))
    assert "what is in it is not what checkpoint.json says: rows" in of(with_document(rows=10**15))
    assert "does not fit this system: it is damaged" in of(with_document(time=0.0499))
    assert "cannot go on from the checkpoint" in of(with_document(settings={}))

    def garbled(contents: dict[str, bytes]) -> None:
        contents["states/0"] = contents["states/0"][:8]
        with_document(
            components=[c | {"state_size": 8} for c in _components(contents)[:1]] + _components(contents)[1:]
        )(contents)

    assert "plant (integrator) refuses its state in the checkpoint: fmi3DeserializeFMUState returned Error" in of(
        garbled
    )


@pytest.mark.parametrize("version", ["3.0", "2.0"])
def test_our_own_fmus_find_damage_in_their_states(version: str, tmp_path: Path) -> None:
    with Fmu.read(catalogue.ensure("VoltageProfile", fmi=version)) as controller:
        system = System([Component("controller", controller)])
        path = simulate(system, checkpoint_at=[0.05], **RUN).checkpoints[0].save(tmp_path / "x.cosim")

        def turn(contents: dict[str, bytes]) -> None:
            state = bytearray(contents["states/0"])
            state[len(state) // 2] ^= 1
            contents["states/0"] = bytes(state)

        with pytest.raises(FmuError) as caught:
            simulate(system, resume=Checkpoint.load(repacked(path, tmp_path / "y.cosim", turn)), **RUN)
    assert "controller (VoltageProfile) refuses its state in the checkpoint: " in str(caught.value)
    assert "the state is damaged (its checksum is wrong)" in str(caught.value)


def _components(contents: dict[str, bytes]) -> list[dict[str, object]]:
    found: list[dict[str, object]] = json.loads(contents["checkpoint.json"])["components"]
    return found


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_damaged_files_are_refused(some: Path, tmp_path: Path, data: st.DataObject) -> None:
    """One changed byte, or the loss of a part, is noticed by the archive's checksums, or changes nothing."""
    content = bytearray(some.read_bytes())
    if data.draw(st.booleans()):
        content[data.draw(st.integers(0, len(content) - 1))] ^= data.draw(st.integers(1, 255))
    else:
        first = data.draw(st.integers(0, len(content)))
        del content[first : first + data.draw(st.integers(1, len(content)))]
    (tmp_path / "x.cosim").write_bytes(content)
    try:
        found = Checkpoint.load(tmp_path / "x.cosim")
    except InputError:
        return
    expected = Checkpoint.load(some)
    assert (found.setup, found.snapshot, found.states) == (expected.setup, expected.snapshot, expected.states)
    assert found.rows.tobytes() == expected.rows.tobytes()


NUMBERS = st.none() | st.booleans() | st.integers(-(2**70), 2**70) | st.floats() | st.text(max_size=5) | st.just([])


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_forged_documents_end_with_a_message_or_run(
    some: Path, saving: Get, tmp_path: Path, data: st.DataObject
) -> None:
    """Whatever the document says in the place of one of its values: no crash, no traceback, an end."""

    def edit(contents: dict[str, bytes]) -> None:
        document = json.loads(contents["checkpoint.json"])
        place: object = document
        while isinstance(place, dict | list) and place:
            keys = list(place) if isinstance(place, dict) else range(len(place))
            key = data.draw(st.sampled_from(keys))
            inner = place[key]  # type: ignore[index]
            if not isinstance(inner, dict | list) or not inner or data.draw(st.booleans()):
                place[key] = data.draw(NUMBERS)  # type: ignore[index]
                break
            place = inner
        contents["checkpoint.json"] = json.dumps(document).encode()

    path = repacked(some, tmp_path / "x.cosim", edit)
    try:
        checkpoint = Checkpoint.load(path)
        simulate(eventful(saving), resume=checkpoint, **RUN)
    except CosimError:
        pass


def test_saving_replaces_the_file_at_once(some: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    checkpoint = Checkpoint.load(some)
    path = checkpoint.save(tmp_path / "x.cosim")
    before = path.read_bytes()

    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(InputError, match="No space left on device; give another place"):
        checkpoint.save(path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]
