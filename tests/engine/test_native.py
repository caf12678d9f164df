"""The native loop as a piece of machinery: where its library comes from, interruption, memory, sanitizers."""

from __future__ import annotations

import gc
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from coupled_systems import COUPLED, CoupledSystems

from cosim.engine import Algorithm, Component, Connection, Fmu, SimulationInterrupted, System, simulate
from cosim.engine.native import _compilation, _library
from cosim.errors import BuildError, InputError
from cosim.fmu.toolchain import host_name

Get = Callable[..., Fmu]


def feedback(fmu: Get, **parameters: float) -> System:
    return System(
        [Component("plant", fmu("integrator"), {"x0": 1.0}), Component("c", fmu("sampler"), {"K": -1.0, **parameters})],
        [Connection(("plant", "x"), ("c", "u")), Connection(("c", "y"), ("plant", "u"))],
    )


def loop_used(fmu: Get) -> object:
    result = simulate(feedback(fmu), stop=0.1, output_interval=0.02, tolerance=1e-6)
    np.testing.assert_allclose(result.columns["plant.x"], 0.98 ** np.arange(6), rtol=1e-12)
    return result.statistics["loop"]


@pytest.fixture
def empty_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A cache folder of the test's own, and nothing remembered."""
    monkeypatch.setattr(_library, "cache_folder", lambda: tmp_path / "cache")
    _library._load.cache_clear()
    yield tmp_path / "cache"
    _library._load.cache_clear()


def without_compiler() -> list[str]:
    raise BuildError("there is no C compiler")


@pytest.mark.parametrize(("choice", "loop"), [("auto", "native"), ("native", "native"), ("python", "python")])
def test_the_environment_chooses_the_loop(fmu: Get, monkeypatch: pytest.MonkeyPatch, choice: str, loop: str) -> None:
    monkeypatch.setenv("COSIM_ENGINE", choice)
    assert loop_used(fmu) == loop


def test_a_loop_that_there_is_not(fmu: Get, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COSIM_ENGINE", "fast")
    with pytest.raises(InputError) as caught:
        loop_used(fmu)
    assert str(caught.value) == "COSIM_ENGINE is 'fast'; it can be auto, native or python"


def test_the_library_is_compiled_once_and_found_again(
    fmu: Get, empty_cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert loop_used(fmu) == "native"
    assert [path.name for path in empty_cache.iterdir() if path.suffix != ".lock"] == [
        _compilation.file_name(host_name())
    ]
    _library._load.cache_clear()
    monkeypatch.setattr("cosim.fmu.toolchain.compiler", without_compiler)
    assert loop_used(fmu) == "native"


@pytest.mark.usefixtures("empty_cache")
def test_without_a_compiler_the_python_loop_runs(fmu: Get, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cosim.fmu.toolchain.compiler", without_compiler)
    assert loop_used(fmu) == "python"
    monkeypatch.setenv("COSIM_ENGINE", "native")
    with pytest.raises(BuildError, match="there is no C compiler"):
        loop_used(fmu)


def test_a_library_in_the_package_comes_first(
    fmu: Get, empty_cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = tmp_path / "native"
    shutil.copytree(_compilation.SOURCES, package)
    (package / "prebuilt").mkdir(exist_ok=True)
    monkeypatch.setattr(_compilation, "SOURCES", package)
    _library.compile_to(package / "prebuilt" / _compilation.file_name(host_name()))
    assert loop_used(fmu) == "native"
    assert not empty_cache.exists()


def test_a_library_with_other_tables_is_not_used(
    fmu: Get, empty_cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = tmp_path / "native"
    shutil.copytree(_compilation.SOURCES, package)
    header = package / "engine.h"
    header.write_text(header.read_text().replace("double period;", "double period, more;"))
    monkeypatch.setattr(_compilation, "SOURCES", package)
    monkeypatch.setenv("COSIM_ENGINE", "native")
    with pytest.raises(BuildError, match="its tables have the sizes"):
        loop_used(fmu)
    assert empty_cache.exists()


def test_the_c_compiles_without_warnings(tmp_path: Path) -> None:
    gcc = shutil.which("gcc")
    if gcc is None:
        pytest.skip("gcc is not installed")
    warnings = ["-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Wstrict-prototypes", "-Werror"]
    sources = map(str, _compilation.units())
    done = subprocess.run(
        [gcc, *_compilation.FLAGS, *_compilation.includes(), *warnings, "-o", str(tmp_path / "x.so"), *sources, "-lm"],
        check=False,
        capture_output=True,
        text=True,
    )
    assert done.stderr == ""
    assert done.returncode == 0


class ControlC:
    """Presses Ctrl-C 0.3 s after ``start``; ``sent`` is when that was."""

    def __init__(self) -> None:
        self.sent = 0.0
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._press)

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        self._ended.set()
        if self._thread.is_alive():
            self._thread.join()

    def _press(self) -> None:
        if not self._ended.wait(0.3):
            self.sent = time.perf_counter()
            os.kill(os.getpid(), signal.SIGINT)


@pytest.fixture
def control_c() -> Iterator[ControlC]:
    """A Ctrl-C that does not outlive the test."""
    pressing = ControlC()
    yield pressing
    pressing.stop()


@pytest.mark.parametrize("loop", ["native", "python"])
def test_control_c_ends_a_run_within_a_second(
    fmu: Get, monkeypatch: pytest.MonkeyPatch, control_c: ControlC, loop: str
) -> None:
    monkeypatch.setenv("COSIM_ENGINE", loop)
    system = feedback(fmu, T_compute=0.001)
    control_c.start()
    with pytest.raises(SimulationInterrupted) as caught:
        simulate(system, stop=1e5, output_interval=0.5, tolerance=1e-6)
    assert time.perf_counter() - control_c.sent < 1.0
    result = caught.value.result
    rows = len(result.time)
    assert rows > 2
    assert not result.complete
    assert str(caught.value) == result.message
    assert result.time.tolist() == [0.5 * k for k in range(rows)]
    np.testing.assert_allclose(result.columns["plant.x"], 0.999 ** (500.0 * np.arange(rows)), rtol=1e-9, atol=1e-300)
    assert result.columns["c.count"].tolist() == [500 * k + 1 for k in range(rows)]


@pytest.mark.parametrize(("algorithm", "step"), [("adaptive", None), ("extrapolated", 1e-6), ("iterated", 1e-6)])
def test_control_c_within_one_interval(
    coupled: CoupledSystems, control_c: ControlC, algorithm: Algorithm, step: float | None
) -> None:
    system = coupled.system("oscillator")
    asked = {"stop": 1e3, "output_interval": 500.0, "tolerance": 1e-9, "coupling_error": False}
    control_c.start()
    with pytest.raises(SimulationInterrupted) as caught:
        simulate(system, algorithm=algorithm, step=step, **asked)  # type: ignore[arg-type]
    assert time.perf_counter() - control_c.sent < 1.0
    assert caught.value.result.time.tolist() == [0.0]


def test_an_interval_in_many_pieces_gives_the_same(coupled: CoupledSystems) -> None:
    asked = {"stop": 2.0, "output_interval": 2.0, "tolerance": 1e-6, "coupling_error": False}
    whole = simulate(coupled.system("oscillator"), **asked)  # type: ignore[arg-type]
    pieces = simulate(coupled.system("oscillator"), progress=lambda t: None, **asked)  # type: ignore[arg-type]
    assert pieces.statistics["exchanges"] == whole.statistics["exchanges"]
    assert pieces.statistics["algorithm"] == whole.statistics["algorithm"]
    for name, column in pieces.columns.items():
        assert column.tobytes() == whole.columns[name].tobytes()


def test_control_c_is_not_lost_in_an_fmu_that_talks_all_the_time(fmu: Get, control_c: ControlC) -> None:
    system = System([Component("f", fmu("faulty"), {"fault": "talkative", "t_fault": 1e9})])
    control_c.start()
    with pytest.raises(SimulationInterrupted):
        simulate(system, stop=2e3, output_interval=1e-3, tolerance=1e-6)
    assert time.perf_counter() - control_c.sent < 1.0
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_runs_in_threads_do_not_disturb_each_other(fmu: Get) -> None:
    def final(gain: float) -> float:
        system = feedback(fmu, T_compute=0.001, K=gain)
        return float(simulate(system, stop=2.0, output_interval=0.01, tolerance=1e-6).columns["plant.x"][-1])

    gains = [-0.1 * k for k in range(1, 17)]
    with ThreadPoolExecutor(8) as pool:
        finals = list(pool.map(final, gains))
    np.testing.assert_allclose(finals, [(1.0 + 0.001 * gain) ** 2000 for gain in gains], rtol=1e-9)


@pytest.mark.slow
def test_ten_thousand_runs_leave_the_memory_flat(fmu: Get) -> None:
    statm = Path("/proc/self/statm")
    if not statm.exists():
        pytest.skip("the size of a process is read from /proc")
    sizes, seconds = [], []
    for _ in range(10):
        started = time.perf_counter()
        for _ in range(1000):
            simulate(feedback(fmu), stop=0.1, output_interval=0.02, tolerance=1e-6)
        seconds.append(time.perf_counter() - started)
        gc.collect()
        sizes.append(int(statm.read_text().split()[1]) * 4096)
    assert sizes[-1] - sizes[1] < 1e6
    assert min(seconds[-3:]) < 1.5 * min(seconds[:3])


@pytest.mark.slow
def test_the_suite_is_clean_under_sanitizers(tmp_path: Path) -> None:
    gcc = shutil.which("gcc")
    find = "-print-file-name=libasan.so"
    asan = gcc and subprocess.run([gcc, find], check=True, capture_output=True, text=True).stdout.strip()
    if not gcc or not asan or not Path(asan).exists():
        pytest.skip("gcc with its address sanitizer is not installed")
    library = tmp_path / "wiper-cosim" / "engine" / _compilation.file_name(host_name())
    library.parent.mkdir(parents=True)
    sources = map(str, _compilation.units())
    sanitize = ["-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=undefined"]
    subprocess.run(
        [gcc, *_compilation.FLAGS, *_compilation.includes(), *sanitize, "-o", str(library), *sources, "-lm"], check=True
    )
    environment = {
        **os.environ,
        "LD_PRELOAD": asan,
        "ASAN_OPTIONS": "detect_leaks=0:abort_on_error=1",
        "XDG_CACHE_HOME": str(tmp_path),
        "COSIM_TEST_FMUS": str(tmp_path),
    }
    coupled = CoupledSystems(tmp_path)  # the compiler of models does not run with these sanitizers
    for one in COUPLED.values():
        for model in (*one.parts.values(), one.twin):
            coupled.fmu(model, 2)
            coupled.fmu(model, 3)
    coupled.close()
    suite = [str(Path(__file__).parent / f"test_{name}.py") for name in ("engine_errors", "engine_instants", "jacobi")]
    suite += [
        str(Path(__file__).parent / f"test_{name}.py")
        for name in (
            *("types", "arrays", "texts", "binaries", "equality", "exchange", "exchange_solver", "faults"),
            *("power", "coupling_error"),
        )
    ]
    # processes of their own start without these sanitizers, and what builds FMUs does not run with them
    left_out = "not process_of_its_own and not our_own_plant"
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-x", "-n", "0", "-p", "no:cacheprovider", "-k", left_out, *suite],
        check=False,
        env=environment,
        capture_output=True,
        text=True,
        cwd=Path(__file__).parents[2],
    )
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    assert "Sanitizer" not in done.stderr
    assert "runtime error" not in done.stderr
