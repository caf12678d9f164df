"""FMUs with limits, and FMUs that lack something: a run without it, or a message that says what to do."""

from __future__ import annotations

import subprocess
import threading
import zipfile
from collections.abc import Callable
from pathlib import Path

import fmpy
import pytest
from fmu_builder import FMI_HEADERS, HERE, INTEGRATOR, build, edited

from cosim.engine import Component, Fmu, System, simulate
from cosim.errors import FmuError, FmuWarning
from cosim.fmu import catalogue

ARGUMENTS = {"stop": 0.2, "output_interval": 0.1, "tolerance": 1e-6}
versions = pytest.mark.parametrize("version", [2, 3])


def claiming(claim: str) -> Callable[[str], str]:
    return lambda text: text.replace("<CoSimulation ", f'<CoSimulation {claim}="true" ')


@pytest.fixture
def once(tmp_path: Path, version: int) -> Path:
    """The integrator, which claims that it can be instantiated only once."""
    path = build(INTEGRATOR, version, tmp_path)
    return edited(path, tmp_path / "once.fmu", claiming("canBeInstantiatedOnlyOncePerProcess"))


@versions
def test_twice_in_a_system_is_refused_also_when_it_was_read_twice(once: Path) -> None:
    with Fmu.read(once) as one, Fmu.read(once) as other:
        for second in (one, other):
            with pytest.raises(FmuError) as caught:
                simulate(System([Component("left", one), Component("right", second)]), **ARGUMENTS)
            assert str(caught.value) == (
                f"{once}: can be used only once in a system, but it is left, right; keep one of them"
            )


@versions
def test_it_can_be_used_again_when_a_run_has_ended(once: Path) -> None:
    with Fmu.read(once) as fmu:
        for _ in range(3):
            assert simulate(System([Component("p", fmu)]), **ARGUMENTS).complete


@versions
def test_two_runs_at_a_time_are_refused(once: Path) -> None:
    started, ended = threading.Event(), threading.Event()

    def wait(_: float) -> None:
        started.set()
        ended.wait(30.0)

    with Fmu.read(once) as fmu:
        first = threading.Thread(
            target=lambda: simulate(System([Component("first", fmu)]), progress=wait, **ARGUMENTS), daemon=True
        )
        first.start()
        assert started.wait(30.0)
        with pytest.raises(FmuError, match=r"p \(integrator\) can be used only once .* uses it as first; let that end"):
            simulate(System([Component("p", fmu)]), **ARGUMENTS)
        ended.set()
        first.join()
        assert simulate(System([Component("p", fmu)]), **ARGUMENTS).complete


def test_a_missing_tool_is_named() -> None:
    """It refuses to be instantiated, here since the token is another one."""
    with Fmu.read(catalogue.ensure("speed_control")) as refusing:
        refusing.capabilities["needsExecutionTool"] = True
        refusing._token = "another"
        with pytest.raises(FmuError, match=r"cannot be instantiated.*it needs written by hand on this computer: check"):
            simulate(System([Component("c", refusing)]), **ARGUMENTS)


@versions
def test_functions_that_no_run_needs_may_be_missing(tmp_path: Path, version: int) -> None:
    path = stripped(tmp_path, version, "stubs.c")
    with Fmu.read(path) as fmu:
        system = System([Component("p", fmu)])
        with pytest.warns(FmuWarning, match=rf"its binary lacks .*fmi{version}GetDirectionalDerivative.*no run here"):
            result = simulate(system, **ARGUMENTS)
    assert result.complete


@versions
def test_functions_that_a_run_needs_are_named(tmp_path: Path, version: int) -> None:
    path = stripped(tmp_path, version, "integrator.c")
    with Fmu.read(path) as fmu, pytest.raises(FmuError) as caught:
        simulate(System([Component("p", fmu)]), **ARGUMENTS)
    assert str(caught.value).startswith(f"{path}: its binary lacks the function fmi{version}")
    assert str(caught.value).endswith(", without which it cannot be used; report it to whoever exported it")


def stripped(folder: Path, version: int, source: str) -> Path:
    """Return the integrator without the functions of one of its C files."""
    path = build(INTEGRATOR, version, folder)
    left = {"integrator.c": "stubs.c", "stubs.c": "integrator.c"}[source]
    library = folder / f"less{fmpy.sharedLibraryExtension}"
    flags = ["-shared", "-fPIC", "-w", f"-DFMI={version}", f"-I{FMI_HEADERS}", f"-I{HERE}"]
    subprocess.run(["cc", *flags, str(HERE / left), "-o", str(library), "-lm"], check=True)
    less = folder / "less.fmu"
    with zipfile.ZipFile(path) as old, zipfile.ZipFile(less, "w") as new:
        for name in old.namelist():
            new.writestr(name, library.read_bytes() if name.startswith("binaries/") else old.read(name))
    return less


def test_sources_are_mentioned_where_a_binary_is_missing(tmp_path: Path) -> None:
    path = build(INTEGRATOR, 3, tmp_path)
    bare = tmp_path / "bare.fmu"
    with zipfile.ZipFile(path) as old, zipfile.ZipFile(bare, "w") as new:
        new.writestr("modelDescription.xml", old.read("modelDescription.xml"))
        new.writestr("binaries/x86_64-none/integrator.so", b"")
        new.writestr("sources/integrator.c", b"")
    with pytest.raises(FmuError) as caught:
        Fmu.read(bare)
    library = f"binaries/{fmpy.platform_tuple}/integrator{fmpy.sharedLibraryExtension}"
    assert str(caught.value) == (
        f"{bare}: has no binary for this computer ({library}); it has x86_64-none; it has C sources: "
        f"`fmpy compile {bare}` adds a binary that a C compiler here makes of them"
    )
