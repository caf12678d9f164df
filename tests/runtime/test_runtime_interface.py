"""The FMI 3.0 shell: exported symbols, wrong use, saved states, compilers."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from ctypes import CDLL, byref, c_bool, c_double, c_size_t, c_uint32, c_void_p
from pathlib import Path

import pytest
from fmpy.fmi3 import FMU3Slave
from runtime_harness import HEADERS, HERE, TOKEN, FmiError, Sample, build, built, compiler, library_of

STRICT = ("-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Werror")
SAMPLES = sorted(path.stem for path in (HERE / "models").glob("*.c"))


def test_every_function_of_fmi_is_exported() -> None:
    declared = re.findall(r"^FMI3_Export\s+\w+\s+(fmi3\w+);", (HEADERS / "fmi3Functions.h").read_text(), re.MULTILINE)
    assert len(declared) == 75
    library = library_of("oscillator", built("oscillator"))
    dll = CDLL(str(library))
    assert [name for name in declared if not hasattr(dll, name)] == []


@pytest.mark.skipif(not shutil.which("nm") or sys.platform != "linux", reason="needs nm")
def test_nothing_else_is_exported() -> None:
    library = library_of("oscillator", built("oscillator"))
    symbols = subprocess.run(["nm", "-D", "--defined-only", library], capture_output=True, text=True, check=True).stdout
    names = [line.split()[-1] for line in symbols.splitlines() if " T " in line]
    assert len(names) == 75
    assert all(name.startswith("fmi3") for name in names)


@pytest.mark.skipif(not shutil.which("gcc"), reason="needs gcc")
@pytest.mark.parametrize("name", ["oscillator", "sampler", "algebraic"])
def test_gcc_has_no_complaints(name: str, tmp_path: Path) -> None:
    build(name, tmp_path, ["gcc"], "-O1", *STRICT)


@pytest.mark.slow
@pytest.mark.parametrize("target", ["x86_64-linux-gnu.2.17", "aarch64-linux-gnu.2.17", "x86_64-windows-gnu",
                                    "x86_64-macos", "aarch64-macos"])  # fmt: skip
def test_all_platforms_compile_without_complaints(target: str, tmp_path: Path) -> None:
    pytest.importorskip("ziglang")
    build("sampler", tmp_path, [*compiler(), "-target", target], "-O2", *STRICT)


SANITIZED = """
import sys
sys.path.insert(0, sys.argv[1])
from pathlib import Path
from runtime_harness import FmiError, Sample
name = sys.argv[2]
sample = Sample(name, folder=Path(sys.argv[3])).start(1e-6)
state = sample.save()
try:
    for k in range(20):
        sample.step(0.1)
    data = sample.serialize(state)
    other = sample.deserialize(data)
    sample.restore(other)
    sample.forget(other)
    sample.time = 0.0
    sample.step(1.0)
except FmiError as error:
    print(error)
sample.forget(state)
sample.free()
"""


@pytest.mark.slow
@pytest.mark.skipif(not shutil.which("gcc") or sys.platform != "linux", reason="needs gcc's sanitizers")
@pytest.mark.parametrize("name", SAMPLES)
def test_sanitizers_find_nothing(name: str, tmp_path: Path) -> None:
    build(name, tmp_path, ["gcc"], "-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=undefined")
    runtime = subprocess.run(["gcc", "-print-file-name=libasan.so"], capture_output=True, text=True, check=True)
    environment = {"LD_PRELOAD": runtime.stdout.strip(), "ASAN_OPTIONS": "detect_leaks=0"}
    command = [sys.executable, "-c", SANITIZED, str(HERE), name, str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stderr


def test_fmpy_can_drive_it() -> None:
    slave = FMU3Slave(
        guid=TOKEN, unzipDirectory=str(built("oscillator")), modelIdentifier="oscillator", instanceName="o"
    )
    slave.instantiate()
    slave.enterInitializationMode(startTime=0.0)
    slave.exitInitializationMode()
    assert slave.doStep(currentCommunicationPoint=0.0, communicationStepSize=0.5) == (False, False, False, 0.5)
    assert slave.getFloat64([0]) == [0.5]
    slave.terminate()
    slave.freeInstance()


def test_wrong_token_and_missing_name_are_refused() -> None:
    with pytest.raises(FmiError, match="the instantiation token is not that of this FMU"):
        Sample("oscillator", token="{other}")
    dll = Sample("oscillator").dll
    dll.fmi3InstantiateCoSimulation.restype = c_void_p
    nothing = [c_bool(False)] * 4 + [None, c_size_t(0), None, None, None]
    assert dll.fmi3InstantiateCoSimulation(None, TOKEN.encode(), None, *nothing) is None
    assert dll.fmi3InstantiateCoSimulation(b"a", None, None, *nothing) is None


def test_other_kinds_of_fmu_are_refused() -> None:
    dll = Sample("oscillator").dll
    function = dll.fmi3InstantiateScheduledExecution
    function.restype = c_void_p
    assert function(b"a", TOKEN.encode(), None, c_bool(False), c_bool(False), *[None] * 5) is None


@pytest.mark.parametrize(
    ("function", "arguments"),
    [
        ("fmi3ExitInitializationMode", ()),
        ("fmi3EnterEventMode", ()),
        ("fmi3EnterStepMode", ()),
        ("fmi3Terminate", ()),
        ("fmi3UpdateDiscreteStates", [None] * 6),
        ("fmi3DoStep", (c_double(0.0), c_double(0.1), c_bool(True), None, None, None, None)),
    ],
)
def test_calls_before_initialization_are_refused(function: str, arguments: tuple[object, ...]) -> None:
    sample = Sample("oscillator")
    with pytest.raises(FmiError, match=f"{function} is not allowed before Initialization Mode"):
        sample.call(function, *arguments)
    sample.start().step(0.1)


def test_event_mode_needs_to_be_asked_for() -> None:
    with pytest.raises(FmiError, match="made without eventModeUsed"):
        Sample("sampler").start().call("fmi3EnterEventMode")


def test_calls_in_the_wrong_mode_are_refused() -> None:
    sample = Sample("sampler", events=True).start()
    with pytest.raises(FmiError, match="fmi3DoStep is not allowed in Event Mode"):
        sample.step(0.1)
    sample.call("fmi3EnterStepMode")
    with pytest.raises(FmiError, match="fmi3UpdateDiscreteStates is not allowed in Step Mode"):
        sample.update()
    with pytest.raises(FmiError, match="fmi3EnterInitializationMode is not allowed in Step Mode"):
        sample.enter()
    sample.call("fmi3Terminate")
    with pytest.raises(FmiError, match="fmi3SetFloat64 is not allowed after fmi3Terminate"):
        sample.set(1, 1.0)
    assert sample.get(1) == 0.0


@pytest.mark.parametrize(
    ("start", "tolerance", "stop", "message"),
    [
        (float("nan"), None, None, "start time nan is not a finite number"),
        (0.0, -1.0, None, "tolerance -1 is not between 0 and 1"),
        (0.0, float("nan"), None, "tolerance nan is not between 0 and 1"),
        (1.0, None, 0.5, "stop time 0.5 s is before the start time 1 s"),
    ],
)
def test_bad_experiment_is_refused(start: float, tolerance: float | None, stop: float | None, message: str) -> None:
    with pytest.raises(FmiError, match=message):
        Sample("oscillator").enter(tolerance, start, stop)


def test_a_tolerance_below_rounding_is_raised_with_a_warning() -> None:
    sample = Sample("oscillator").enter(1e-14)
    assert sample.log == ["The tolerance 1e-14 is below what double precision allows; 1e-12 is taken instead."]
    exact = Sample("oscillator").enter(1e-12)
    assert exact.log == []
    assert sample.exit().step(1.0) == exact.exit().step(1.0)
    assert sample.get(1, 2) == exact.get(1, 2)


def test_bad_steps_are_refused_and_leave_no_trace() -> None:
    sample = Sample("oscillator").enter(stop=1.0).exit()
    sample.step(0.5)
    for time, h, message in [
        (0.4, 0.1, "communication point 0.4.* is not the instance's time 0.5 s"),
        (float("nan"), 0.1, "communication point nan"),
        (0.5, -0.1, "step size -0.1 s is not a positive number"),
        (0.5, 0.0, "step size 0 s is not a positive number"),
        (0.5, float("inf"), "step size inf s is not"),
        (0.5, 0.6, "goes beyond the stop time 1 s"),
    ]:
        out = [byref(c_bool()), byref(c_bool()), byref(c_bool()), byref(c_double())]
        with pytest.raises(FmiError, match=message):
            sample.call("fmi3DoStep", c_double(time), c_double(h), c_bool(True), *out)
        with pytest.raises(FmiError, match="an output argument is null"):
            sample.call("fmi3DoStep", c_double(0.5), c_double(0.1), c_bool(True), *out[:3], None)
    sample.step_to(1.0)


def test_reading_and_setting_the_wrong_things() -> None:
    sample = Sample("sampler")
    with pytest.raises(FmiError, match="value reference 6 has no value before Initialization Mode"):
        sample.get(6)
    assert sample.get(8) == 0.1
    sample.start()
    wrong: list[tuple[Callable[[], object], str]] = [
        (lambda: sample.get(99), "fmi3GetFloat64: there is no variable with value reference 99"),
        (lambda: sample.get(2), "fmi3GetFloat64: the variable with value reference 2 is a Int32"),
        (lambda: sample.get(3, kind="Int64"), "fmi3GetInt64: the variable with value reference 3 is a Float64"),
        (lambda: sample.get(3, kind="UInt64"), "value reference 3 is a Float64"),
        (lambda: sample.set(1, 1, kind="Boolean"), "fmi3SetBoolean: the variable with value reference 1 is a Float64"),
        (lambda: sample.set(6, 1.0), "value reference 6 cannot be set"),
        (lambda: sample.set(8, 1.0), "value reference 8 can be set before the end of Initialization Mode only"),
        (lambda: sample.set(1, float("nan")), "value reference 1 is set to nan, which is not a usable number"),
        (lambda: sample.set(1, float("inf")), "value reference 1 is set to inf, which is not a usable number"),
        (lambda: sample.set(99, 1.0), "there is no variable with value reference 99"),
    ]
    for call, message in wrong:
        with pytest.raises(FmiError, match=message):
            call()
    assert sample.get(1, 8) == [0.0, 0.1]


def test_counts_and_null_arrays_are_checked() -> None:
    sample = Sample("oscillator").start()
    references, values = (c_uint32 * 2)(1, 2), (c_double * 2)()
    with pytest.raises(FmiError, match="1 values for 2 variables"):
        sample.call("fmi3GetFloat64", references, c_size_t(2), values, c_size_t(1))
    with pytest.raises(FmiError, match="an array is null"):
        sample.call("fmi3GetFloat64", references, c_size_t(2), None, c_size_t(2))
    sample.call("fmi3GetFloat64", None, c_size_t(0), None, c_size_t(0))
    for kind in ("Float32", "Int8", "UInt8", "Int16", "UInt16", "UInt32", "String"):
        for access in ("Get", "Set"):
            sample.call(f"fmi3{access}{kind}", None, c_size_t(0), None, c_size_t(0))
            with pytest.raises(FmiError, match="the model has no variables of this type"):
                sample.call(f"fmi3{access}{kind}", references, c_size_t(2), values, c_size_t(2))


def test_refused_set_changes_nothing() -> None:
    sample = Sample("oscillator").start()
    references, values = (c_uint32 * 2)(4, 8), (c_double * 2)(5.0, 1.0)
    with pytest.raises(FmiError):
        sample.call("fmi3SetFloat64", references, c_size_t(2), values, c_size_t(2))
    assert sample.get(4) == 0.0


def test_null_instances_and_unsupported_functions_are_errors() -> None:
    sample = Sample("oscillator").start()
    assert sample.dll.fmi3DoStep(None, c_double(0.0), c_double(1.0), c_bool(True), None, None, None, None) == 3
    assert sample.dll.fmi3SetTime(None, c_double(0.0)) == 3
    assert sample.dll.fmi3GetFloat64(None, None, c_size_t(0), None, c_size_t(0)) == 3
    sample.dll.fmi3FreeInstance(None)
    with pytest.raises(FmiError, match="fmi3EnterContinuousTimeMode does not exist in Co-Simulation"):
        sample.call("fmi3EnterContinuousTimeMode")
    for function in ("fmi3EvaluateDiscreteStates", "fmi3EnterConfigurationMode"):
        with pytest.raises(FmiError, match=f"{function} is not supported by this FMU"):
            sample.call(function)


def test_outputs_follow_inputs_at_once_and_discrete_variables_do_not() -> None:
    sample = Sample("sampler").start()
    sample.step(0.05)
    assert sample.get(7) == sample.get(6)
    sample.set(1, 2.5)
    assert sample.get(7) == sample.get(6) + 2.5
    assert sample.get(3) == 0.0


def test_values_follow_inputs_in_initialization_mode() -> None:
    sample = Sample("algebraic").enter()
    sample.set(4, 8.0)
    z = sample.get(2)
    assert z**3 + z - 10.1 == pytest.approx(0.0, abs=1e-12)
    sample.set(4, -2.0)
    assert sample.get(2) == pytest.approx(0.0, abs=1e-12)
    sample.exit()


def wave(k: int) -> float:
    return 0.1 * k * k - k


def trace(sample: Sample, steps: int) -> list[object]:
    result: list[object] = []
    for k in range(steps):
        sample.set(1, float(k % 3))
        sample.step_to((30 + k + 1) * 0.07)
        result.append((sample.get(2, kind="Int32"), sample.get(3, 6, 7), sample.counters(12)))
    return result


def test_restored_state_continues_bit_by_bit() -> None:
    sample = Sample("sampler").start(v8=0.1)
    for k in range(30):
        sample.set(1, wave(k))
        sample.step_to((k + 1) * 0.07)
    time, state = sample.time, sample.save()
    data = sample.serialize(state)
    first = trace(sample, 20)
    sample.restore(state)
    sample.time = time
    assert trace(sample, 20) == first
    other = Sample("sampler")
    copy = other.deserialize(data)
    other.restore(copy)
    other.time = time
    assert trace(other, 20) == first
    for owner, saved in ((sample, state), (other, copy)):
        owner.forget(saved)
        assert not saved.value


def test_repeated_step_after_restore_is_identical_with_events_inside() -> None:
    ball = Sample("bouncing_ball").start(1e-6)
    ball.step(0.3)
    state = ball.save()
    results = []
    for _ in range(3):
        ball.restore(state)
        ball.time = 0.3
        ball.step(1.7)
        results.append((ball.get(1, 2), ball.counters(6)))
    assert results[0] == results[1] == results[2]


def test_foreign_and_damaged_states_are_refused() -> None:
    sample = Sample("sampler").start()
    data = bytearray(sample.serialize(sample.save()))
    with pytest.raises(FmiError, match="not a state of this build of sampler"):
        sample.deserialize(bytes(data[:-1]))
    with pytest.raises(FmiError, match="not a state of this build of sampler"):
        sample.deserialize(b"x" * len(data))
    data[-20] ^= 1
    with pytest.raises(FmiError, match="the state is damaged"):
        sample.deserialize(bytes(data))
    with pytest.raises(FmiError, match="FMUState is null"):
        sample.restore(c_void_p())


def test_reset_is_as_good_as_new() -> None:
    sample = Sample("oscillator").start(1e-6, v5=5.0)
    sample.set(4, 1.0)
    sample.step(1.0)
    sample.call("fmi3Reset")
    assert sample.get(4, 5) == [0.0, 2.0]
    sample.start(1e-6).step(1.0)
    fresh = Sample("oscillator").start(1e-6)
    fresh.step(1.0)
    assert sample.get(1, 2) == fresh.get(1, 2)
