"""An FMU that crashes, hangs or ends its process: what a user reads, what is kept, and that nothing else is touched."""

from __future__ import annotations

import gc
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from both_loops import compare
from fmu_builder import build_first

from cosim.engine import (
    Component,
    Connection,
    Fmu,
    Isolate,
    PartialResultError,
    Result,
    SimulationInterrupted,
    System,
    explain_timing,
    simulate,
)
from cosim.engine._execution import Job, execute, instantiated
from cosim.engine.fmu._calls import Site
from cosim.engine.loop._plan import lay_out
from cosim.engine.loop._record import Record
from cosim.errors import CosimError, FmuError, InputError, SimulationError
from cosim.fmu import catalogue, provenance
from cosim.worker import dismiss

Get = Callable[..., Fmu]
linux = pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")

_TOOL = "try it in another tool, and report it to whoever exported it"
_STATUS = "an FMU has to return a status instead: report it to whoever exported it"
_SEGMENTATION = "SIGSEGV (it used memory that it does not have, by a null pointer)"
_ABORT = "SIGABRT (it gave up by abort() or a failed assertion)"
_START, _STEP, _END = "during initialisation", "at t = 0.04 s", "after its last row, at t = 0.1 s"


def run(fmu: Fmu, crash: str, isolate: Isolate = "always", **limits: float) -> Result:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("CRASH", crash)
        system = System([Component("f", fmu)])
        return simulate(system, stop=0.1, output_interval=0.01, tolerance=1e-6, isolate=isolate, **limits)


def crash(fmu: Fmu, how: str, **limits: float) -> PartialResultError:
    with pytest.raises(PartialResultError) as caught:
        run(fmu, how, **limits)
    assert caught.value.exit_code == 3
    assert not caught.value.result.complete
    assert caught.value.result.message == str(caught.value)
    return caught.value


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize(
    ("how", "where", "message"),
    [
        ("loading segmentation", _START, f"crashed while loading its binary, with {_SEGMENTATION}"),
        ("Instantiate abort", _START, f"crashed in {{instantiate}}, with {_ABORT}"),
        ("EnterInitializationMode exit", _START, "ended its process in {fmi}EnterInitializationMode, with exit code 7"),
        ("ExitInitializationMode abort", _START, f"crashed in {{fmi}}ExitInitializationMode, with {_ABORT}"),
        ("{get} segmentation", _START, f"crashed in {{fmi}}{{get}}, with {_SEGMENTATION}"),
        ("DoStep segmentation", _STEP, f"crashed in {{fmi}}DoStep, with {_SEGMENTATION}"),
        ("DoStep abort", _STEP, f"crashed in {{fmi}}DoStep, with {_ABORT}"),
        ("DoStep exit", _STEP, "ended its process in {fmi}DoStep, with exit code 7"),
        ("DoStep success", _STEP, "ended its process in {fmi}DoStep, with exit code 0"),
        (
            "DoStep division",
            _STEP,
            "crashed in {fmi}DoStep, with SIGFPE (an arithmetic fault such as an integer division by 0)",
        ),
        (
            "DoStep instruction",
            _STEP,
            "crashed in {fmi}DoStep, with SIGILL (an instruction that this processor does not have)",
        ),
        (
            "DoStep recursion",
            _STEP,
            "crashed in {fmi}DoStep, with SIGSEGV (its stack has overflowed: its calls are nested too deeply)",
        ),
        ("Terminate abort", _END, f"crashed in {{fmi}}Terminate, with {_ABORT}"),
        ("FreeInstance exit", _END, "ended its process in {fmi}FreeInstance, with exit code 7"),
        ("unloading segmentation", _END, f"crashed while unloading its binary, with {_SEGMENTATION}"),
    ],
)
def test_a_crash_names_fmu_time_call_and_signal(fmu: Get, version: int, how: str, where: str, message: str) -> None:
    names = {
        "fmi": f"fmi{version}",
        "instantiate": "fmi2Instantiate" if version == 2 else "fmi3InstantiateCoSimulation",
        "get": "GetReal" if version == 2 else "GetFloat64",
    }
    error = crash(fmu("crash", version), how.format(**names))
    remedy = _STATUS if "exit code" in message else _TOOL
    assert str(error) == (
        f"the simulation failed {where}: f (crash): {message.format(**names)}; the FMU gave no reason; {remedy}"
    )
    rows = {_START: 0, _STEP: 5, _END: 11}[where]
    np.testing.assert_array_equal(error.result.time, np.arange(rows) / 100)
    np.testing.assert_allclose(error.result.columns["f.y"], error.result.time, rtol=1e-12)


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("how", ["DoStep spin", "loading hang", "FreeInstance spin"])
def test_a_call_that_does_not_come_back_is_given_up(fmu: Get, version: int, how: str) -> None:
    error = crash(fmu("crash", version), how, call_timeout=0.25)
    where, call, rows = {
        "DoStep": (_STEP, f"fmi{version}DoStep", 5),
        "loading": (_START, "loading its binary", 0),
        "FreeInstance": (_END, f"fmi{version}FreeInstance", 11),
    }[how.split(maxsplit=1)[0]]
    assert str(error) == (
        f"the simulation failed {where}: f (crash): has not come back from {call} within 0.25 s; the FMU gave no "
        "reason; if it is only slow, allow its calls more time with --call-timeout"
    )
    assert len(error.result.time) == rows


@linux
def test_an_fmu_that_takes_all_memory(fmu: Get) -> None:
    error = crash(fmu("crash"), "DoStep memory", memory_limit=3e8)
    assert str(error).startswith(
        f"the simulation failed at t = 0.04 s: f (crash): crashed in fmi3DoStep, with {_ABORT}"
    )
    assert str(error).endswith(
        " GB of memory; the FMU gave no reason; it may have 0.3 GB: give it more with --memory-limit, or let it take "
        "less"
    )
    assert len(error.result.time) == 5


def test_what_an_fmu_has_said_before_it_died(fmu: Get, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CRASH_SAYS", "1")
    assert "; the FMU says: this will not end well at 0.04 s; " in str(crash(fmu("crash"), "DoStep abort"))


def test_the_guilty_one_of_several_is_named(fmu: Get, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CRASH", "DoStep abort")
    system = feedback(fmu)
    system.components.insert(1, Component("third", fmu("crash")))
    with pytest.raises(PartialResultError) as caught:
        simulate(system, stop=0.1, output_interval=0.01, tolerance=1e-6, isolate="always")
    assert ": third (crash): crashed in fmi3DoStep, " in str(caught.value)
    monkeypatch.delenv("CRASH")
    whole = simulate(system, stop=0.1, output_interval=0.01, tolerance=1e-6)
    rows = len(caught.value.result.time)
    assert rows == 5
    for name, column in caught.value.result.columns.items():
        assert column.tobytes() == whole.columns[name][:rows].tobytes()


def test_the_python_loop_is_watched_too(fmu: Get, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COSIM_ENGINE", "python")
    error = crash(fmu("crash"), "DoStep segmentation")
    assert ": f (crash): crashed in fmi3DoStep, with SIGSEGV (it used memory that it does not have); " in str(error)
    assert error.result.statistics["loop"] == "python"
    assert len(error.result.time) == 5


def feedback(fmu: Get, version: int = 3, **parameters: float) -> System:
    controller = Component("c", fmu("sampler", version), {"K": -1.0, **parameters})
    return System(
        [Component("plant", fmu("integrator", version), {"x0": 1.0}), controller],
        [Connection(("plant", "x"), ("c", "u")), Connection(("c", "y"), ("plant", "u"))],
    )


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("loop", ["native", "python"])
@pytest.mark.parametrize("step", [None, 0.005])
def test_the_numbers_are_those_of_a_run_in_process(
    fmu: Get, monkeypatch: pytest.MonkeyPatch, version: int, loop: str, step: float | None
) -> None:
    monkeypatch.setenv("COSIM_ENGINE", loop)

    def result(isolate: Isolate) -> Result:
        return simulate(
            feedback(fmu, version),
            stop=0.5,
            output_interval=0.01,
            tolerance=1e-6,
            algorithm="gauss-seidel" if step is None else "jacobi",
            step=step,
            isolate=isolate,
        )

    isolated, here = result("always"), result("never")
    assert isolated.statistics["loop"] == loop
    compare(isolated, here)


@pytest.mark.parametrize("version", [2, 3])
def test_the_timing_is_explained_in_a_worker_too(fmu: Get, monkeypatch: pytest.MonkeyPatch, version: int) -> None:
    system = feedback(fmu, version)

    def text(isolate: Isolate) -> str:
        return explain_timing(system, stop=1.0, output_interval=0.01, isolate=isolate)

    assert text("always") == text("never")
    monkeypatch.setenv("CRASH", "DoStep abort")
    system.components.append(Component("third", fmu("crash", version)))
    with pytest.raises(SimulationError) as caught:
        text("always")
    assert str(caught.value) == (
        f"the simulation failed at t = 0.04 s: third (crash): crashed in fmi{version}DoStep, with {_ABORT}; "
        f"the FMU gave no reason; {_TOOL}"
    )


@pytest.mark.parametrize("version", [2, 3])
def test_model_exchange_runs_in_a_worker_as_it_does_here(fmu: Get, version: int) -> None:
    system = System(
        [Component("ball", fmu("ball", version), {"T": 0.07}), Component("relay", fmu("relay", version))],
        [Connection(("ball", "h"), ("relay", "u"))],
    )

    def result(isolate: Isolate) -> Result:
        return simulate(system, stop=0.6, output_interval=0.01, tolerance=1e-6, isolate=isolate)

    compare(result("always"), result("never"))


@pytest.mark.parametrize("version", [2, 3])
def test_each_call_of_the_solver_is_counted(fmu: Get, version: int) -> None:
    """Else one long step, in which a slow function is called again and again, would look like one call that hangs."""
    job = Job(System([Component("ball", fmu("ball", version))]), 1.0, 1.0, 1e-6)
    record = Record.empty(1.0, 1.0, lay_out(job.system).recorded, "native")
    with instantiated(job, [Site(record.at)]) as plan:
        ending = execute(job, plan, record, None)
    evaluations = ending.statistics["solver"]["ball"]["rhs_evaluations"]  # type: ignore[index]
    assert record.at.calls > 3 * evaluations


def test_fmi_1_runs_in_a_worker_as_it_does_here(tmp_path: Path) -> None:
    with Fmu.read(build_first(tmp_path)) as first:
        for parameters in ({"x0": -0.5}, {"t_wrong": 0.5, "name": "slave"}):
            system = System([Component("a", first, dict(parameters))])
            endings = []
            for isolate in ("always", "never"):
                try:
                    endings.append(simulate(system, stop=1.0, output_interval=0.1, tolerance=1e-6, isolate=isolate))
                except PartialResultError as error:
                    endings.append(error)
            compare(endings[0], endings[1])


def ending(system: System, isolate: Isolate) -> CosimError:
    with pytest.raises(CosimError) as caught:
        simulate(system, stop=0.1, output_interval=0.01, tolerance=1e-6, isolate=isolate)
    return caught.value


@pytest.mark.parametrize("version", [2, 3])
def test_ordinary_errors_arrive_unchanged(fmu: Get, version: int) -> None:
    faulty = fmu("faulty", version)
    for parameters in (
        {"fault": "error", "t_fault": 0.05},
        {"fault": "not_a_number", "t_fault": 0.05},
        {"fault": "fatal", "t_fault": 0.05},
        {"t_fault": -1.0},
        {"t_fault": -2.0},
        {"t_fault": "soon"},
    ):
        system = System([Component("f", faulty, dict(parameters))])
        compare(ending(system, "always"), ending(system, "never"))


def test_a_refused_system_and_a_closed_fmu(fmu: Get, fmu_path: Callable[[str, int], Path]) -> None:
    refused = System([Component("c", fmu("sampler")), Component("c", fmu("sampler"))])
    assert str(ending(refused, "always")) == str(ending(refused, "never"))
    with Fmu.read(fmu_path("integrator", 3)) as closed:
        pass
    error = ending(System([Component("c", closed)]), "always")
    assert type(error) is FmuError
    assert str(error) == f"{fmu_path('integrator', 3)}: is closed; read it again to use it"


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"isolate": "sometimes"}, "isolate is 'sometimes'; it can be auto, always, never"),
        ({"call_timeout": 0.0}, "call_timeout is 0 s; it must be above 0"),
        ({"memory_limit": 1.0}, "memory_limit is 1 bytes; at least 1e+08 are needed"),
    ],
)
def test_what_cannot_be_asked_for(fmu: Get, asked: dict[str, object], message: str) -> None:
    with pytest.raises(InputError) as caught:
        simulate(feedback(fmu), stop=0.1, output_interval=0.01, tolerance=1e-6, **asked)  # type: ignore[arg-type]
    assert str(caught.value) == message


def test_progress_is_told_and_ends_at_the_stop(fmu: Get) -> None:
    told: list[float] = []
    system = feedback(fmu, T_compute=0.0001)
    simulate(system, stop=50.0, output_interval=0.5, tolerance=1e-6, isolate="always", progress=told.append)
    assert told == sorted(told)
    assert told[-1] == 50.0


def test_what_an_fmu_prints_does_not_reach_stdout(fmu: Get, capfd: pytest.CaptureFixture[str]) -> None:
    run(fmu("crash"), "DoStep print")
    printed = capfd.readouterr()
    assert printed.out == ""
    assert printed.err == "printed by an FMU\n" * 6


def test_an_fmu_that_writes_into_all_channels_and_closes_them(fmu: Get) -> None:
    """Among them is the one to the memory in which its position is written down."""
    with pytest.raises(SimulationError) as caught:
        run(fmu("crash"), "DoStep channels")
    assert str(caught.value) == (
        f"the process of the simulation has ended, with {_ABORT}, and what it has written down makes no sense: an FMU "
        "must have written into memory that is not its own; report it to whoever exported it"
    )


@linux
def test_what_a_dead_fmu_has_started_ends_with_it(fmu: Get, capfd: pytest.CaptureFixture[str]) -> None:
    crash(fmu("crash"), "DoStep orphan")
    orphan = Path("/proc", capfd.readouterr().err.strip())
    deadline = time.perf_counter() + 2.0
    while orphan.exists() and time.perf_counter() < deadline:
        time.sleep(0.01)
    assert not orphan.exists()


def test_an_fmu_that_stops_its_process(fmu: Get) -> None:
    error = crash(fmu("crash"), "DoStep stop", call_timeout=0.25)
    assert "has not come back from fmi3DoStep within 0.25 s" in str(error)


def interrupt_soon() -> tuple[threading.Timer, list[float]]:
    sent: list[float] = []

    def press() -> None:
        sent.append(time.perf_counter())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.4, press)
    timer.start()
    return timer, sent


@pytest.mark.parametrize("loop", ["native", "python"])
def test_control_c_ends_an_isolated_run_within_a_second(fmu: Get, monkeypatch: pytest.MonkeyPatch, loop: str) -> None:
    run(fmu("crash"), "")
    monkeypatch.setenv("COSIM_ENGINE", loop)
    _, sent = interrupt_soon()
    with pytest.raises(SimulationInterrupted) as caught:
        simulate(feedback(fmu, T_compute=0.001), stop=1e5, output_interval=0.5, tolerance=1e-6, isolate="always")
    assert time.perf_counter() - sent[0] < 1.0
    result = caught.value.result
    rows = np.arange(len(result.time))
    assert not result.complete
    assert str(caught.value) == result.message
    assert len(rows) > 1
    assert result.time.tolist() == [0.5 * k for k in rows]
    np.testing.assert_allclose(result.columns["plant.x"], 0.999 ** (500.0 * rows), rtol=1e-9, atol=1e-300)
    assert result.statistics["steps"]


def test_control_c_ends_a_run_whose_fmu_hangs(fmu: Get) -> None:
    run(fmu("crash"), "")
    _, sent = interrupt_soon()
    with pytest.raises(SimulationInterrupted) as caught:
        run(fmu("crash"), "DoStep spin")
    assert time.perf_counter() - sent[0] < 1.0
    assert str(caught.value) == "the simulation was interrupted at t = 0.04 s"
    np.testing.assert_allclose(caught.value.result.columns["f.y"], np.arange(5) / 100, rtol=1e-12)


def descendants(root: int) -> list[int]:
    """Return the processes that this one has started, directly or not, zombies included."""
    parents = {}
    for entry in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = entry.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        parents[int(entry.parent.name)] = int(fields[1])
    found = [root]
    for process in found:
        found += [child for child, parent in parents.items() if parent == process]
    return found[1:]


def leftovers() -> dict[str, object]:
    """Return what a run could leave: open files, processes, shared memory, threads."""
    gc.collect()
    descriptors = Path("/proc/self/fd")
    return {
        "descriptors": len(list(descriptors.iterdir())),
        "maps": sum("wiper-cosim" in line for line in Path("/proc/self/maps").read_text().splitlines()),
        "processes": descendants(os.getpid()),
        "shm": {path.name for path in Path("/dev/shm").iterdir()},
        "threads": threading.active_count(),
    }


def run_of_every_kind(fmu: Get, count: int) -> list[Result]:
    endings = ["", "DoStep segmentation", "DoStep exit", "loading abort", "FreeInstance abort"]
    results = []
    for number in range(count):
        how = endings[number % len(endings)]
        results.append(crash(fmu("crash"), how).result if how else run(fmu("crash"), how))
    return results


@linux
@pytest.mark.parametrize("count", [10, pytest.param(200, marks=pytest.mark.slow)])
def test_runs_and_crashes_leave_nothing_behind(
    fmu: Get, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, count: int
) -> None:
    run(fmu("crash"), "")
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setenv("TMPDIR", str(folder))
    monkeypatch.setattr("tempfile.tempdir", None)
    before = leftovers()
    assert len(before["processes"]) == 1  # type: ignore[arg-type]
    results = run_of_every_kind(fmu, count)
    deadline = time.perf_counter() + 2.0
    while leftovers() != before and time.perf_counter() < deadline:
        time.sleep(0.01)
    assert leftovers() == before
    assert list(folder.iterdir()) == []
    assert len(results) == count  # they are still there, and take no files
    dismiss()
    assert descendants(os.getpid()) == []


HANGING = """
import sys
from cosim.engine import Component, Fmu, System, simulate
system = System([Component("f", Fmu.read(sys.argv[1]))])
simulate(system, stop=0.1, output_interval=0.01, tolerance=1e-6, isolate="always")
"""


@linux
def test_a_worker_does_not_outlive_the_process_that_wanted_it(fmu_path: Callable[[str, int], Path]) -> None:
    script = [sys.executable, "-c", HANGING, str(fmu_path("crash", 3))]
    with subprocess.Popen(script, env=os.environ | {"CRASH": "DoStep spin"}) as process:
        deadline = time.perf_counter() + 20.0
        while len(started := descendants(process.pid)) < 2 and time.perf_counter() < deadline:
            time.sleep(0.02)
        assert len(started) == 2  # nursery and worker
        process.kill()
    deadline = time.perf_counter() + 5.0
    while any(Path(f"/proc/{pid}").exists() for pid in started) and time.perf_counter() < deadline:
        time.sleep(0.02)
    assert [pid for pid in started if Path(f"/proc/{pid}").exists()] == []


def test_workers_of_several_threads_do_not_disturb_each_other(fmu: Get) -> None:
    def final(gain: float) -> float:
        system = feedback(fmu, T_compute=0.001, K=gain)
        result = simulate(system, stop=1.0, output_interval=0.01, tolerance=1e-6, isolate="always")
        return float(result.columns["plant.x"][-1])

    gains = [-0.1 * k for k in range(1, 17)]
    with ThreadPoolExecutor(8) as pool:
        finals = list(pool.map(final, gains))
    np.testing.assert_allclose(finals, [(1.0 + 0.001 * gain) ** 1000 for gain in gains], rtol=1e-9)


def test_without_an_interpreter_there_is_no_worker(fmu: Get, monkeypatch: pytest.MonkeyPatch) -> None:
    dismiss()
    monkeypatch.setattr(sys, "executable", "")
    with pytest.raises(InputError) as caught:
        run(fmu("crash"), "")
    assert str(caught.value) == (
        'there is no Python program to run a worker with; set isolate="never" (--isolate never)'
    )


def test_a_new_nursery_takes_the_place_of_one_that_died(fmu: Get) -> None:
    from cosim.worker import _nursery

    run(fmu("crash"), "")
    _nursery._nursery[0]._process.kill()
    _nursery._nursery[0]._process.wait()
    assert run(fmu("crash"), "").complete


def test_where_there_is_no_fork_the_worker_is_a_new_process(fmu: Get, monkeypatch: pytest.MonkeyPatch) -> None:
    from cosim.worker import _posix, _spawned

    monkeypatch.setattr(_posix, "transport", _spawned.transport)
    compare(run(fmu("crash"), ""), run(fmu("crash"), "", "never"))
    assert ": f (crash): crashed in fmi3DoStep, with SIGABRT" in str(crash(fmu("crash"), "DoStep abort"))
    assert "has not come back from fmi3DoStep within 0.25 s" in str(
        crash(fmu("crash"), "DoStep spin", call_timeout=0.25)
    )


def test_auto_isolates_what_was_not_built_here(
    fmu: Get, fmu_path: Callable[[str, int], Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(provenance, "_folder", lambda: tmp_path / "built")
    path = fmu_path("crash", 3)
    assert ": crashed in fmi3DoStep, " in str(crash(fmu("crash"), "DoStep abort", isolate="auto"))  # type: ignore[arg-type]
    assert not catalogue.is_own(path, fmu("crash").sha256)
    provenance.remember(path)
    assert catalogue.is_own(path, fmu("crash").sha256)
    changed = tmp_path / "changed.fmu"
    changed.write_bytes(path.read_bytes() + b"\0")
    with Fmu.read(changed) as other:
        assert not catalogue.is_own(changed, other.sha256)
