"""What may be changed where a run goes on from a checkpoint, and what is refused, by name."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from fmu_builder import build_first, edited
from saving_fmus import LOOPS, RUN, feedback, same, under

from cosim.engine import (
    Channel,
    Component,
    Connection,
    Fault,
    Fmu,
    PartialResultError,
    System,
    simulate,
)
from cosim.errors import InputError
from cosim.fmu import catalogue

Get = Callable[..., Fmu]


@pytest.mark.parametrize("version", [2, 3])
def test_a_tunable_parameter_acts_from_the_checkpoint_on(saving: Get, version: int) -> None:
    """x(k+1) = x(k) + h K x(k): the sample at the checkpoint has been taken, and stays."""
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
