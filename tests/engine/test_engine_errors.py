"""What a user reads when an FMU, a system or a run is wrong; every message in full."""

from __future__ import annotations

import re
import zipfile
from collections.abc import Callable
from pathlib import Path

import fmpy
import numpy as np
import pytest
from both_loops import simulate

from cosim.engine import (
    Channel,
    Component,
    Connection,
    Fmu,
    PartialResultError,
    SimulationInterrupted,
    System,
    explain_timing,
)
from cosim.errors import FmuError, InputError, SimulationError

Get = Callable[..., Fmu]


def refuse(
    system: System,
    kind: type[InputError] = InputError,
    stop: float = 0.1,
    output_interval: float = 0.01,
    tolerance: float = 1e-6,
) -> str:
    with pytest.raises(InputError) as caught:
        simulate(system, stop=stop, output_interval=output_interval, tolerance=tolerance)
    assert type(caught.value) is kind
    return str(caught.value)


def fail(system: System) -> PartialResultError:
    with pytest.raises(SimulationError) as caught:
        simulate(system, stop=0.1, output_interval=0.01, tolerance=1e-6)
    assert isinstance(caught.value, PartialResultError)
    assert not caught.value.result.complete
    assert caught.value.result.message == str(caught.value)
    return caught.value


def repack(source: Path, target: Path, edit: Callable[[str, bytes], tuple[str, bytes] | None]) -> Path:
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(target, "w") as new:
        for name in old.namelist():
            entry = edit(name, old.read(name))
            if entry is not None:
                new.writestr(*entry)
    return target


def replacing(old: str, new: str) -> Callable[[str, bytes], tuple[str, bytes]]:
    def edit(name: str, content: bytes) -> tuple[str, bytes]:
        return name, content.replace(old.encode(), new.encode()) if name == "modelDescription.xml" else content

    return edit


def read_error(path: Path) -> str:
    with pytest.raises(FmuError) as caught:
        Fmu.read(path)
    return str(caught.value).replace(str(path), "x.fmu")


def test_files_that_are_no_fmu(tmp_path: Path) -> None:
    path = tmp_path / "x.fmu"
    assert read_error(path) == "x.fmu: cannot be read: No such file or directory; give the path of an .fmu file"
    path.write_text("not a zip")
    assert read_error(path) == "x.fmu: is not an FMU: it is not a zip archive; export the model again"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("readme.txt", "")
    assert read_error(path) == "x.fmu: is not an FMU: it has no modelDescription.xml; export the model again"


def test_fmus_that_cannot_be_used_here(fmu_path: Callable[[str, int], Path], tmp_path: Path) -> None:
    good, path = fmu_path("integrator", 3), tmp_path / "x.fmu"
    repack(good, path, replacing("CoSimulation", "ScheduledExecution"))
    assert read_error(path) == ("x.fmu: has no Co-Simulation or Model Exchange interface; export it for Co-Simulation")
    repack(good, path, lambda name, content: (name.replace(fmpy.platform_tuple, "riscv64-linux"), content))
    library = f"binaries/{fmpy.platform_tuple}/integrator{fmpy.sharedLibraryExtension}"
    assert read_error(path) == (
        f"x.fmu: has no binary for this computer ({library}); it has riscv64-linux; export it for this platform"
    )
    repack(good, path, replacing('fmiVersion="3.0"', 'fmiVersion="4.0"'))
    assert read_error(path) == (
        "x.fmu: its modelDescription.xml cannot be read: Unsupported FMI version: 4.0; run `cosim check` for all that "
        "is wrong with it"
    )
    repack(good, path, lambda name, content: (name, b"\0" if name.startswith("binaries/") else content))
    with Fmu.read(path) as broken, pytest.raises(FmuError) as caught:
        simulate(System([Component("plant", broken)]), stop=1.0, output_interval=0.1, tolerance=1e-6)
    assert str(caught.value).startswith(f"{path}: its binary cannot be loaded: Failed to load shared library ")


def test_a_closed_fmu_is_refused(fmu_path: Callable[[str, int], Path]) -> None:
    path = fmu_path("integrator", 3)
    with Fmu.read(path) as closed:
        pass
    assert refuse(System([Component("plant", closed)]), FmuError) == f"{path}: is closed; read it again to use it"


def test_numbers_that_make_no_run(fmu: Get) -> None:
    system = System([Component("plant", fmu("integrator"))])
    assert refuse(system, stop=0.0) == "stop is 0 s; it must be above 0"
    assert refuse(system, output_interval=-1.0) == "output_interval is -1 s; it must be above 0"
    assert refuse(system, tolerance=float("nan")) == "tolerance is nan; it must be above 0"
    assert refuse(system, tolerance=1e-13) == (
        "tolerance is 1e-13; below 1e-12 rounding errors count for more than those of the method; write 1e-12 or more"
    )
    assert refuse(system, output_interval=1e-9) == "output_interval is 1e-09 s; it must be at least 1e-08 s"


def test_systems_that_do_not_fit_together(fmu: Get) -> None:
    plant, controller = Component("plant", fmu("integrator")), Component("controller", fmu("sampler"))
    both = [plant, controller]

    def connect(*ends: tuple[str, str, str, str], **factors: float) -> System:
        return System(both, [Connection((a, b), (c, d), **factors) for a, b, c, d in ends])

    assert refuse(System([])) == "the system has no components; give it at least one FMU"
    assert refuse(System([plant, plant])) == 'two components have the name "plant"; give each a name of its own'
    assert refuse(connect(("plan", "x", "controller", "u"))) == (
        'plan.x: there is no component "plan"; there are plant, controller; did you mean plant?'
    )
    assert refuse(connect(("plant", "posit", "controller", "u")), FmuError) == (
        "plant.posit: integrator has no output posit; its outputs are x, y, positive; did you mean positive?"
    )
    assert refuse(connect(("plant", "u", "controller", "u")), FmuError) == (
        "plant.u: is of causality input; an output is needed here"
    )
    assert refuse(connect(("plant", "x", "controller", "u"), ("plant", "y", "controller", "u"))) == (
        "controller.u: is driven twice; keep one of its connections and channels"
    )
    assert refuse(connect(("plant", "x", "controller", "enable"))) == (
        "plant.x -> controller.enable: a Real cannot drive a Boolean; it takes Boolean"
    )
    assert refuse(connect(("plant", "positive", "controller", "enable"), factor=2.0)) == (
        "plant.positive -> controller.enable: factor and offset need a Real target, but it is a Boolean; leave them out"
    )
    assert refuse(connect(("plant", "x", "controller", "u"), offset=float("inf"))) == (
        "plant.x -> controller.u: factor 1.0 and offset inf must be finite"
    )


def test_channels_that_are_no_table(fmu: Get) -> None:
    def channel(times: list[float], values: list[float], name: str = "u", linear: bool = False) -> str:
        system = System([Component("c", fmu("sampler"))], channels=[Channel(("c", name), times, values, linear)])
        return refuse(system)

    assert channel([0.0, 1.0], [1.0]) == (
        "channel c.u: it has 2 times and 1 values; as many of both are needed, at least one"
    )
    assert channel([0.0], [float("nan")]) == "channel c.u: every time and value must be finite"
    assert channel([-1.0], [0.0]) == "channel c.u: its first time is -1 s; a simulation starts at 0 s"
    assert channel([0.0, 2.0, 1.0], [0.0, 0.0, 0.0]) == (
        "channel c.u: time goes back from 2 s to 1 s; sort the entries"
    )
    assert channel([1.0, 1.0, 1.0], [0.0, 1.0, 2.0]) == "channel c.u: three entries at 1 s; a step has two"
    assert channel([0.0], [1.0], "enable", linear=True) == (
        "channel c.enable: a Boolean cannot be interpolated; let it hold"
    )
    assert channel([0.0], [0.5], "enable") == "channel c.enable: a Boolean takes whole numbers only"
    assert channel([0.0], [2.0], "enable") == "channel c.enable: a Boolean takes 0 and 1 only"


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize(
    ("model", "parameters", "message"),
    [
        ("integrator", {"x_0": 1.0}, "c.x_0: integrator has no parameter x_0; did you mean x0?"),
        ("integrator", {"u": 1.0}, "c.u: is an input; drive it by a channel or a connection"),
        ("integrator", {"x": 1.0}, "c.x: is an output; it cannot be set"),
        ("integrator", {"longest": 1.0}, "c.longest: is no parameter; it cannot be set"),
        ("integrator", {"x0": "one"}, "c.x0: 'one' does not fit; it takes a number"),
        (
            "faulty",
            {"fault": "melt"},
            "c.fault: 'melt' does not fit; it takes one of none, not_a_number, error, discard, terminate, "
            "silent_error, fatal, early, talkative",
        ),
        (
            "faulty",
            {"fault": 1.5},
            "c.fault: 1.5 does not fit; it takes one of none, not_a_number, error, discard, "
            "terminate, silent_error, fatal, early, talkative",
        ),
    ],
)
def test_parameters_that_cannot_be_set(
    fmu: Get, version: int, model: str, parameters: dict[str, float | int | bool | str], message: str
) -> None:
    assert refuse(System([Component("c", fmu(model, version), parameters)]), FmuError) == message


def test_a_parameter_outside_its_range(fmu_path: Callable[[str, int], Path], tmp_path: Path) -> None:
    edit = replacing('name="T_compute"', 'name="T_compute" min="0.001" max="10"')
    with Fmu.read(repack(fmu_path("sampler", 3), tmp_path / "x.fmu", edit)) as bounded:
        for value, message in ((0.0, "0 s is below its minimum 0.001 s"), (11.0, "11 s is above its maximum 10 s")):
            system = System([Component("c", bounded, {"T_compute": value})])
            assert refuse(system, FmuError) == f"c.T_compute = {message}"


def test_clocks_are_refused_by_name(fmu_path: Callable[[str, int], Path], tmp_path: Path) -> None:
    clock = '<Clock name="b" valueReference="40" causality="input" intervalVariability="triggered"/>'
    edit = replacing("</ModelVariables>", f"{clock}</ModelVariables>")
    with Fmu.read(repack(fmu_path("sampler", 3), tmp_path / "x.fmu", edit)) as odd:
        assert odd.left_out == {"b": "a Clock"}
        system = System([Component("c", odd)], channels=[Channel(("c", "b"), [0.0], [1.0])])
        assert refuse(system, FmuError) == "c.b: is a Clock; it cannot be exchanged"
        assert refuse(System([Component("c", odd, {"b": 1.0})]), FmuError) == "c.b: is a Clock; it cannot be set"


def test_a_sample_period_of_nothing(fmu: Get) -> None:
    assert refuse(System([Component("c", fmu("sampler", 2), {"T_compute": 0.0})]), FmuError) == (
        "c.T_compute: is 0.0; a sample period must be above 2e-09 s"
    )


def test_parameters_arrive_in_their_own_type(fmu: Get) -> None:
    system = System(
        [
            Component("p", fmu("integrator"), {"x0": 3, "offset": 0.5}),
            Component("f", fmu("faulty"), {"fault": "none", "t_fault": 1}),
        ]
    )
    result = simulate(system, stop=0.1, output_interval=0.05, tolerance=1e-6)
    assert result.columns["p.x"].tolist() == [3.0, 3.0, 3.0]
    assert result.columns["p.y"].tolist() == [0.5, 0.5, 0.5]


_CHECK = "check its parameters and its inputs at that time, or try another tolerance"
_END = "set stop before that time, or change what makes it end"


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize(
    ("fault", "at", "message"),
    [
        ("not_a_number", "0.05", f"its output y is not a number (NaN); the FMU gave no reason; {_CHECK}"),
        (
            "error",
            "0.04",
            f"fmi{{0}}DoStep returned Error; the FMU says: the solver has lost the solution at 0.04 s; {_CHECK}",
        ),
        ("silent_error", "0.04", f"fmi{{0}}DoStep returned Error; the FMU gave no reason; {_CHECK}"),
        (
            "discard",
            "0.04",
            "fmi{0}DoStep returned Discard; the FMU says: the step is too long at 0.04 s; it could not finish this "
            "step: try a smaller output interval or a looser tolerance",
        ),
        ("terminate", "0.04", f"asked to end the simulation; the FMU gave no reason; {_END}"),
        ("fatal", "0.04", f"fmi{{0}}DoStep returned Fatal; the FMU says: memory is exhausted at 0.04 s; {_CHECK}"),
    ],
)
def test_a_failing_fmu_leaves_the_rows_before_the_failure(
    fmu: Get, version: int, fault: str, at: str, message: str
) -> None:
    parameters: dict[str, float | int | bool | str] = {"fault": fault, "t_fault": 0.05}
    error = fail(
        System([Component("p", fmu("integrator"), {"x0": 1.0}), Component("f", fmu("faulty", version), parameters)])
    )
    assert str(error) == f"the simulation failed at t = {at} s: f (faulty): {message.format(version)}"
    assert error.exit_code == 3
    assert error.result.time.tolist() == [0.0, 0.01, 0.02, 0.03, 0.04]
    np.testing.assert_allclose(error.result.columns["f.y"], error.result.time, rtol=1e-12)
    assert set(error.result.columns["p.x"]) == {1.0}
    # The integrator, given first, has been stepped up to the end of the failed step.
    assert error.result.statistics["solver"] == {"p": {"steps": 5}}


def test_an_fmu_that_returns_early_although_it_must_not(fmu: Get) -> None:
    error = fail(System([Component("f", fmu("faulty"), {"fault": "early", "t_fault": 0.05})]))
    assert str(error) == (
        "the simulation failed at t = 0.04 s: f (faulty): returned early from a step, which it was not allowed to; the "
        "FMU gave no reason; try a smaller output interval, or report it to whoever exported the FMU"
    )


@pytest.mark.parametrize("version", [2, 3])
def test_parameters_that_an_fmu_refuses_are_wrong_input(fmu: Get, version: int) -> None:
    system = System([Component("f", fmu("faulty", version), {"t_fault": -1.0})])
    message = "f (faulty) refuses its parameters or inputs: t_fault is negative at 0 s; change them"
    assert refuse(system) == message
    with pytest.raises(InputError) as caught:
        explain_timing(system, stop=0.1, output_interval=0.01, tolerance=1e-6)
    assert str(caught.value) == message


@pytest.mark.parametrize("version", [2, 3])
def test_another_failure_of_the_initialisation_is_one_of_the_simulation(fmu: Get, version: int) -> None:
    error = fail(System([Component("f", fmu("faulty", version), {"t_fault": -2.0})]))
    assert str(error) == (
        f"the simulation failed during initialisation: f (faulty): fmi{version}ExitInitializationMode returned Error; "
        f"the FMU says: it is too early at 0 s; {_CHECK}"
    )


def test_nan_is_blamed_on_its_origin(fmu: Get) -> None:
    system = System(
        [
            Component("controller", fmu("sampler"), {"T_compute": 0.01}),
            Component("f", fmu("faulty"), {"fault": "not_a_number", "t_fault": 0.05}),
        ],
        [Connection(("f", "y"), ("controller", "u"))],
    )
    assert str(fail(system)).startswith("the simulation failed at t = 0.05 s: f (faulty): its output y is not a number")


def test_an_fmu_that_nobody_reads_or_writes_fails_with_its_reason(
    fmu_path: Callable[[str, int], Path], tmp_path: Path
) -> None:
    def edit(name: str, content: bytes) -> tuple[str, bytes]:
        if name == "modelDescription.xml":
            content = content.replace(b'causality="output"', b'causality="local"')
            content = re.sub(rb"<Output [^>]*/>", b"", content)
        return name, content

    path = repack(fmu_path("faulty", 3), tmp_path / "x.fmu", edit)
    with Fmu.read(path) as closed:
        error = fail(System([Component("f", closed, {"fault": "error", "t_fault": 0.05})]))
    assert "fmi3DoStep returned Error; the FMU says: the solver has lost the solution at" in str(error)


def test_an_fmu_that_takes_one_step_length_only(fmu_path: Callable[[str, int], Path], tmp_path: Path) -> None:
    edit = replacing('canHandleVariableCommunicationStepSize="true"', "")
    path = repack(fmu_path("faulty", 3), tmp_path / "x.fmu", edit)
    with Fmu.read(path) as fixed:
        error = fail(System([Component("f", fixed, {"fault": "silent_error", "t_fault": 0.05})]))
    assert str(error) == (
        "the simulation failed at t = 0.04 s: f (faulty): fmi3DoStep returned Error; the FMU gave no reason; "
        "it takes steps of one length only and does not say which, so it was given the output interval: "
        "set output_interval to the length that it takes"
    )


def test_an_algebraic_loop_without_a_solution(fmu: Get) -> None:
    system = System(
        [Component("a", fmu("integrator"), {"offset": 1.0}), Component("b", fmu("integrator"))],
        [Connection(("a", "y"), ("b", "u")), Connection(("b", "y"), ("a", "u"))],
    )
    error = fail(system)
    assert str(error) == (
        "the simulation failed during initialisation: the algebraic loop a.y -> b.u -> b.y -> a.u has no solution, or "
        "none close by: around it a change comes back unchanged (a gain of 1); closest: a.y = 0 m/s comes back as "
        "1 m/s (residual 1 m/s), with b.u = 0 m/s, b.y = 0 m/s, a.u = 0 m/s; change a gain or an offset in it, or "
        "break it: by a state, a sample or a delay in one of its components"
    )
    assert error.result.time.tolist() == []
    assert error.result.columns["a.y"].shape == (0,)


def test_events_that_set_each_other_off_without_end(fmu: Get) -> None:
    """Either controller reports a new event count to the other, which is an event for it."""
    system = System(
        [Component("a", fmu("sampler")), Component("b", fmu("sampler"))],
        [Connection(("a", "events"), ("b", "u")), Connection(("b", "events"), ("a", "u"))],
    )
    error = fail(system)
    assert str(error) == (
        "the simulation failed at t = 0 s: a (sampler): the events of a, b set each other off without end; the FMU "
        "gave no reason; give one of them a sample period or a delay"
    )


def test_a_sample_period_of_nothing_in_event_mode(fmu: Get) -> None:
    error = fail(System([Component("c", fmu("sampler"), {"T_compute": 0.0})]))
    assert str(error) == (
        "the simulation failed at t = 0 s: c (sampler): announces its next event at 0 s, which is not after the "
        "present one; the FMU gave no reason; check its sample period"
    )


def test_an_event_that_never_settles(fmu: Get) -> None:
    error = fail(System([Component("c", fmu("sampler"), {"updates": 1000})]))
    assert str(error) == (
        "the simulation failed at t = 0 s: c (sampler): still needs to update its discrete states after 100 updates; "
        "the FMU gave no reason; break the cycle of events inside it"
    )


def test_a_parameter_beyond_the_range_of_its_type(fmu: Get) -> None:
    system = System([Component("c", fmu("sampler"), {"updates": 2**31})])
    assert refuse(system, FmuError) == "c.updates: 2147483648 does not fit; it is an Int32"


def test_more_rows_than_memory_are_refused(fmu: Get) -> None:
    system = System([Component("c", fmu("integrator"))])
    assert refuse(system, stop=1e10, output_interval=1e-4) == (
        "the result would have 1e+14 rows of 4 columns, which take 3.2e+06 GB of memory, more than there is; "
        "set a longer output_interval or an earlier stop"
    )
    assert "inf rows" in refuse(system, stop=1e308, output_interval=1e-4)


def test_memory_that_is_not_to_be_had_is_refused_alike(fmu: Get, monkeypatch: pytest.MonkeyPatch) -> None:
    def none_left(*_: object, **__: object) -> None:
        raise MemoryError

    monkeypatch.setattr("cosim.engine.loop._record.np.empty", none_left)
    assert refuse(System([Component("c", fmu("integrator"))])).startswith(
        "the result would have 11 rows of 4 columns, which take 3.52e-07 GB of memory, more than there is; "
    )


def test_an_interrupted_run_keeps_its_rows(fmu: Get) -> None:
    def stop_there(t: float) -> None:
        if t > 0.0:
            raise KeyboardInterrupt

    system = System([Component("plant", fmu("integrator"), {"x0": 1.0})])
    with pytest.raises(KeyboardInterrupt) as caught:
        simulate(system, stop=0.1, output_interval=0.01, tolerance=1e-6, progress=stop_there)
    assert isinstance(caught.value, SimulationInterrupted)
    assert str(caught.value) == "the simulation was interrupted at t = 0.01 s"
    assert caught.value.result.time.tolist() == [0.0]
    assert caught.value.result.message == str(caught.value)
    assert not caught.value.result.complete
