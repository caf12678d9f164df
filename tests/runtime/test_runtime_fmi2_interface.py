"""The FMI 2.0 shell: exported symbols, wrong use, damaged states, compilers."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from ctypes import CDLL, byref, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
from pathlib import Path

import pytest
from fmi2_harness import CO_SIMULATION, DISCARD, Sample2
from runtime_harness import HEADERS, HERE, TOKEN, FmiError, build, built, compiler, library_of

STRICT = ("-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Werror")
SAMPLES = sorted(path.stem for path in (HERE / "models").glob("*.c"))


def test_every_function_of_fmi_is_exported() -> None:
    text = (HEADERS / "fmi2Functions.h").read_text()
    declared = re.findall(r"^\s*FMI2_Export\s+\w+\s+(fmi2\w+);", text, re.MULTILINE)
    assert len(declared) == 44
    dll = CDLL(str(library_of("oscillator", built("oscillator", 2), 2)))
    assert [name for name in declared if not hasattr(dll, name)] == []


@pytest.mark.skipif(not shutil.which("nm") or sys.platform != "linux", reason="needs nm")
def test_nothing_else_is_exported() -> None:
    library = library_of("oscillator", built("oscillator", 2), 2)
    symbols = subprocess.run(["nm", "-D", "--defined-only", library], capture_output=True, text=True, check=True).stdout
    names = [line.split()[-1] for line in symbols.splitlines() if " T " in line]
    assert len(names) == 44
    assert all(name.startswith("fmi2") for name in names)


@pytest.mark.skipif(not shutil.which("gcc"), reason="needs gcc")
@pytest.mark.parametrize("name", ["oscillator", "sampler", "algebraic"])
def test_gcc_has_no_complaints(name: str, tmp_path: Path) -> None:
    build(name, tmp_path, ["gcc"], "-O1", *STRICT, fmi=2)


@pytest.mark.slow
@pytest.mark.parametrize("target", ["x86_64-linux-gnu.2.17", "aarch64-linux-gnu.2.17", "x86_64-windows-gnu",
                                    "x86_64-macos", "aarch64-macos"])  # fmt: skip
def test_all_platforms_compile_without_complaints(target: str, tmp_path: Path) -> None:
    pytest.importorskip("ziglang")
    build("sampler", tmp_path, [*compiler(), "-target", target], "-O2", *STRICT, fmi=2)


SANITIZED = """
import sys
sys.path.insert(0, sys.argv[1])
from pathlib import Path
from fmi2_harness import Sample2
from runtime_harness import FmiError
name = sys.argv[2]
sample = Sample2(name, folder=Path(sys.argv[3]), logging=True).start(1e-6)
state = sample.save()
try:
    for k in range(20):
        try:
            sample.set(1, 0.1 * k)
        except FmiError as error:
            print(error)
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
    flags = ("-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=undefined")
    build(name, tmp_path, ["gcc"], *flags, fmi=2)
    runtime = subprocess.run(["gcc", "-print-file-name=libasan.so"], capture_output=True, text=True, check=True)
    environment = {"LD_PRELOAD": runtime.stdout.strip(), "ASAN_OPTIONS": "detect_leaks=0"}
    command = [sys.executable, "-c", SANITIZED, str(HERE), name, str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stderr


def test_what_cannot_be_instantiated() -> None:
    with pytest.raises(FmiError, match="the instantiation token is not that of this FMU"):
        Sample2("oscillator", guid="{other}")
    with pytest.raises(FmiError, match="fmi2Instantiate: the instance needs a name"):
        Sample2("oscillator", called="")
    with pytest.raises(FmiError, match="oscillator: there is no type of interface with the number 2"):
        Sample2("oscillator", kind=2)
    sample = Sample2("oscillator")
    callbacks = byref(sample.callbacks)
    assert sample.dll.fmi2Instantiate(None, CO_SIMULATION, TOKEN.encode(), None, callbacks, 0, 0) is None
    assert sample.dll.fmi2Instantiate(b"a", CO_SIMULATION, None, None, callbacks, 0, 0) is None
    assert sample.dll.fmi2Instantiate(b"a", CO_SIMULATION, TOKEN.encode(), None, None, 0, 0) is None
    sample.callbacks.logger = type(sample.callbacks.logger)()
    assert sample.dll.fmi2Instantiate(b"a", CO_SIMULATION, b"{other}", None, callbacks, 0, 0) is None


def test_version_and_types() -> None:
    dll = Sample2("oscillator").dll
    dll.fmi2GetVersion.restype = dll.fmi2GetTypesPlatform.restype = c_char_p
    assert (dll.fmi2GetVersion(), dll.fmi2GetTypesPlatform()) == (b"2.0", b"default")


STEP = (c_double(0.0), c_double(0.1), 1)


def test_calls_out_of_order_are_refused_and_leave_no_trace() -> None:
    sample = Sample2("oscillator")
    for function, arguments in (
        ("fmi2EnterInitializationMode", ()), ("fmi2ExitInitializationMode", ()), ("fmi2Terminate", ()),
        ("fmi2DoStep", STEP),
    ):  # fmt: skip
        with pytest.raises(FmiError, match=f"{function} is not allowed before fmi2SetupExperiment"):
            sample.call(function, *arguments)
    sample.set_up(1e-3).set_up(1e-6, stop=1.0)
    with pytest.raises(FmiError, match="fmi2DoStep is not allowed before Initialization Mode"):
        sample.call("fmi2DoStep", *STEP)
    sample.enter()
    for function, arguments in (("fmi2DoStep", STEP), ("fmi2EnterInitializationMode", ()), ("fmi2Terminate", ())):
        with pytest.raises(FmiError, match=f"{function} is not allowed in Initialization Mode"):
            sample.call(function, *arguments)
    with pytest.raises(FmiError, match="fmi2SetupExperiment is not allowed in Initialization Mode"):
        sample.set_up()
    sample.exit()
    with pytest.raises(FmiError, match="fmi2ExitInitializationMode is not allowed after the end of Initialization"):
        sample.exit()
    sample.step(0.1)
    sample.call("fmi2Terminate")
    with pytest.raises(FmiError, match="fmi2SetReal is not allowed after fmi2Terminate"):
        sample.set(4, 1.0)
    with pytest.raises(FmiError, match="fmi2DoStep is not allowed after fmi2Terminate"):
        sample.step(0.1)
    assert sample.get(4) == 0.0


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
        Sample2("oscillator").set_up(tolerance, start, stop)


def test_bad_steps_are_refused_and_leave_no_trace() -> None:
    sample = Sample2("oscillator").set_up(stop=1.0).enter().exit()
    sample.step(0.5)
    for time, h, message in [
        (0.4, 0.1, "communication point 0.4.* is not the instance's time 0.5 s"),
        (float("nan"), 0.1, "communication point nan"),
        (0.5, -0.1, "step size -0.1 s is not a positive number"),
        (0.5, 0.0, "step size 0 s is not a positive number"),
        (0.5, float("inf"), "step size inf s is not"),
        (0.5, 0.6, "goes beyond the stop time 1 s"),
    ]:
        with pytest.raises(FmiError, match=f"fmi2DoStep: .*{message}"):
            sample.call("fmi2DoStep", c_double(time), c_double(h), 1)
    sample.step_to(1.0)


def test_reading_and_setting_the_wrong_things() -> None:
    sample = Sample2("sampler")
    with pytest.raises(FmiError, match="value reference 6 has no value before Initialization Mode"):
        sample.get(6)
    assert sample.get(8) == 0.1
    sample.set_up()
    with pytest.raises(FmiError, match="value reference 6 has no value before Initialization Mode"):
        sample.get(6)
    sample.enter().exit()
    wrong: list[tuple[Callable[[], object], str]] = [
        (lambda: sample.get(99), "fmi2GetReal: there is no variable with value reference 99"),
        (lambda: sample.get(2), "fmi2GetReal: the variable with value reference 2 is a Integer"),
        (lambda: sample.get(3, kind="Integer"), "fmi2GetInteger: the variable with value reference 3 is a Real"),
        (lambda: sample.get(4, kind="Integer"), "value reference 4 is a Boolean"),
        (lambda: sample.set(1, 1, kind="Boolean"), "fmi2SetBoolean: the variable with value reference 1 is a Real"),
        (lambda: sample.set(12, 1, kind="Integer"), "value reference 12 cannot be set"),
        (lambda: sample.set(6, 1.0), "value reference 6 cannot be set"),
        (lambda: sample.set(8, 1.0), "value reference 8 can be set before the end of Initialization Mode only"),
        (lambda: sample.set(1, float("nan")), "value reference 1 is set to nan, which is not a usable number"),
        (lambda: sample.set(1, float("inf")), "value reference 1 is set to inf, which is not a usable number"),
        (lambda: sample.set(99, 1.0), "there is no variable with value reference 99"),
    ]
    for call, message in wrong:
        with pytest.raises(FmiError, match=message):
            call()
        assert sample.log[0][:2] == (3, "logStatusError")
    assert sample.get(1, 8) == [0.0, 0.1]


def test_null_arrays_and_strings() -> None:
    sample = Sample2("oscillator").start()
    references, values = (c_uint * 2)(1, 2), (c_double * 2)()
    with pytest.raises(FmiError, match="fmi2GetReal: an array is null"):
        sample.call("fmi2GetReal", references, c_size_t(2), None)
    with pytest.raises(FmiError, match="fmi2SetReal: an array is null"):
        sample.call("fmi2SetReal", None, c_size_t(2), values)
    for function in ("fmi2GetReal", "fmi2SetInteger", "fmi2GetBoolean", "fmi2GetString", "fmi2SetString"):
        sample.call(function, None, c_size_t(0), None)
    for function in ("fmi2GetString", "fmi2SetString"):
        with pytest.raises(FmiError, match=f"{function}: the model has no variables of this type"):
            sample.call(function, references, c_size_t(1), values)


def test_refused_set_changes_nothing() -> None:
    sample = Sample2("oscillator").start()
    references, values = (c_uint * 2)(4, 8), (c_double * 2)(5.0, 1.0)
    with pytest.raises(FmiError):
        sample.call("fmi2SetReal", references, c_size_t(2), values)
    assert sample.get(4) == 0.0


def test_null_instances_and_unsupported_functions_are_errors() -> None:
    sample = Sample2("oscillator").start()
    dll = sample.dll
    assert dll.fmi2DoStep(None, *STEP) == 3
    assert dll.fmi2GetReal(None, None, c_size_t(0), None) == 3
    assert dll.fmi2CancelStep(None) == 3
    assert dll.fmi2GetStatus(None, 0, None) == 3
    dll.fmi2FreeInstance(None)
    with pytest.raises(FmiError, match="fmi2CancelStep is not supported by this FMU"):
        sample.call("fmi2CancelStep")
    for function in ("fmi2EnterEventMode", "fmi2EnterContinuousTimeMode"):
        with pytest.raises(FmiError, match=f"{function} does not exist in Co-Simulation"):
            sample.call(function)
    reference, order, value = (c_uint * 1)(4), (c_int * 1)(1), (c_double * 1)(0.0)
    for function in ("fmi2SetRealInputDerivatives", "fmi2GetRealOutputDerivatives"):
        sample.call(function, None, c_size_t(0), None, None)
        with pytest.raises(FmiError, match=f"{function} is not supported by this FMU"):
            sample.call(function, reference, c_size_t(1), order, value)


def test_status_that_is_not_there_is_discarded() -> None:
    sample = Sample2("oscillator").start()
    sample.step(0.25)
    assert (sample.last_time(), sample.terminated()) == (0.25, False)
    value = c_double()
    for function in ("fmi2GetStatus", "fmi2GetRealStatus", "fmi2GetIntegerStatus", "fmi2GetStringStatus"):
        with pytest.raises(FmiError, match=f"{function} does not tell fmi2PendingStatus"):
            sample.call(function, 1, byref(value))
        assert sample.status == DISCARD
    with pytest.raises(FmiError, match="does not tell a status that FMI does not know"):
        sample.call("fmi2GetBooleanStatus", 77, byref(value))
    with pytest.raises(FmiError, match="fmi2GetRealStatus: value is null"):
        sample.call("fmi2GetRealStatus", 2, None)


def test_foreign_and_damaged_states_are_refused() -> None:
    sample = Sample2("sampler").start()
    data = bytearray(sample.serialize(sample.save()))
    with pytest.raises(FmiError, match="fmi2DeSerializeFMUstate: this is not a state of this build of sampler"):
        sample.deserialize(bytes(data[:-1]))
    with pytest.raises(FmiError, match="not a state of this build of sampler"):
        sample.deserialize(b"x" * len(data))
    data[-20] ^= 1
    with pytest.raises(FmiError, match="the state is damaged"):
        sample.deserialize(bytes(data))
    with pytest.raises(FmiError, match="fmi2SetFMUstate: FMUState is null"):
        sample.restore(c_void_p())


def test_reset_is_as_good_as_new() -> None:
    sample = Sample2("oscillator").start(1e-6, v5=5.0)
    sample.set(4, 1.0)
    sample.step(1.0)
    sample.set(4, 3.0)
    sample.call("fmi2Reset")
    assert sample.get(4, 5) == [0.0, 2.0]
    with pytest.raises(FmiError, match="not allowed before fmi2SetupExperiment"):
        sample.enter()
    sample.start(1e-6).step(1.0)
    fresh = Sample2("oscillator").start(1e-6)
    fresh.step(1.0)
    assert sample.get(1, 2) == fresh.get(1, 2)
