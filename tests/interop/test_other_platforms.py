"""Binaries for other computers run: that for Windows under wine, that for Linux on ARM under qemu."""

from __future__ import annotations

import os
import subprocess
import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from cosim.engine import Channel, Component, Fmu, System, simulate
from cosim.engine.native._compilation import SOURCES, includes
from cosim.fmu import catalogue
from cosim.fmu.toolchain import PLATFORMS, compiler, fmi_headers

from .conftest import Need

INPUTS = {"duty": 0.7, "v_supply": 27.0}
OUTPUTS = ("phi_crank", "w_crank", "i_motor", "tau_crank", "phi_arm")
ARM_LIBRARIES = "/usr/aarch64-linux-gnu"


@dataclass(frozen=True)
class Emulator:
    """The command that runs a program of a platform, and what it needs on this machine."""

    command: tuple[str, ...]
    programs: tuple[str, ...]


EMULATORS = {
    "x86_64-linux": Emulator((), ()),
    "x86_64-windows": Emulator(("wine",), ("wine",)),
    "aarch64-linux": Emulator(("qemu-aarch64", "-L", ARM_LIBRARIES), ("qemu-aarch64",)),
}


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The rig plant with a binary for each of these platforms."""
    folder = tmp_path_factory.mktemp("platforms")
    return catalogue.build(["rig"], folder, platforms=",".join(EMULATORS))[0]


@pytest.fixture(scope="module")
def here(fmu: Path) -> NDArray[np.float64]:
    """Rows of the engine on this computer, every 0.1 s."""
    with Fmu.read(fmu) as opened:
        channels = [Channel(("plant", name), [0.0], [value]) for name, value in INPUTS.items()]
        system = System([Component("plant", opened)], channels=channels)
        result = simulate(system, stop=3.0, output_interval=1e-3, tolerance=1e-6)
    return np.array([result.columns[f"plant.{name}"][100:2001:100] for name in OUTPUTS]).T


@pytest.mark.parametrize("platform", EMULATORS)
def test_a_binary_gives_the_same_numbers(
    need: Need, fmu: Path, here: NDArray[np.float64], platform: str, tmp_path: Path
) -> None:
    need("ziglang", programs=EMULATORS[platform].programs)
    rows = drive(fmu, platform, tmp_path)
    assert rows.shape == here.shape
    # the same operations in the same order; what may differ in a last bit are sin, cos and exp of each C library, and
    # that makes no more than the tolerance told
    within = 0.0 if platform == "x86_64-linux" else 1e-6
    np.testing.assert_allclose(rows, here, rtol=within, atol=within)


@pytest.mark.parametrize("platform", ["x86_64-linux", "aarch64-linux"])
def test_the_solver_for_model_exchange_runs_where_there_is_no_cvode(
    need: Need, fmu: Path, here: NDArray[np.float64], platform: str, tmp_path: Path
) -> None:
    need("ziglang", programs=EMULATORS[platform].programs)
    rows = drive(fmu, platform, tmp_path, "exchange_driver.c")
    # another type of interface: the errors of either run are of the tolerance
    np.testing.assert_allclose(rows, here, rtol=2e-5, atol=2e-5)


def drive(fmu: Path, platform: str, folder: Path, driver: str = "driver.c") -> NDArray[np.float64]:
    """Compile a driver for a platform, and return what it prints for the FMU's binary."""
    target, emulator = PLATFORMS[platform], EMULATORS[platform]
    with zipfile.ZipFile(fmu) as archive:
        library = Path(archive.extract(f"binaries/{platform}/RigPlant{target.suffix}", folder))
    with Fmu.read(fmu) as opened:
        token = opened.slave().guid
        references = {name: str(opened.variables[name].value_reference) for name in (*INPUTS, *OUTPUTS)}
    program = folder / ("driver.exe" if target.suffix == ".dll" else "driver")
    source = str(Path(__file__).parent / driver)
    flags = ["-std=c11", "-O1", "-Wall", "-Wextra", f"-I{fmi_headers()}", f"-I{SOURCES}", *includes()]
    libraries = [] if target.suffix == ".dll" else ["-ldl", "-lm"]
    subprocess.run([*compiler(target), *flags, source, "-o", str(program), *libraries], check=True)
    given = [text for name, value in INPUTS.items() for text in (references[name], repr(value))]
    wanted = [references[name] for name in OUTPUTS]
    done = subprocess.run(
        [*emulator.command, str(program), f"./{library.name}", token, str(len(INPUTS)), *given, *wanted],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
        cwd=library.parent,
        env=os.environ | {"WINEDEBUG": "-all", "WINEPREFIX": str(folder / "wine")},
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return np.array([[float(text) for text in line.split()] for line in done.stdout.splitlines()])
