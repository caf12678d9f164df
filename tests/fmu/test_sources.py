"""Sources in the FMU: a plain C compiler makes a binary of them that gives the same numbers to the last bit."""

from __future__ import annotations

import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import pytest
from fmpy.validation import validate_fmu

from cosim.fmu import compile_model, export
from cosim.fmu.exporter import pack
from cosim.fmu.versions import FmiVersion

pytest.importorskip("rumoca")

SMALL = Path(__file__).parents[1] / "models" / "Small"
FLAGS = ["-std=c11", "-shared", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]


def plain_compiler() -> str:
    found = shutil.which("gcc") or shutil.which("cc")
    if found is None:
        pytest.skip("there is no C compiler but ours")
    return found


def rebuilt(path: Path, folder: Path) -> Path:
    """The FMU, its binary made anew as its own description says."""
    unzipped = Path(fmpy.extract(str(path), str(folder / "unzipped")))
    read = fmpy.read_model_description(str(path))
    (configuration,) = read.buildConfigurations
    (sources,) = configuration.sourceFileSets
    options = sources.compilerOptions.split() if sources.compilerOptions else ["-O2", "-fPIC"]
    (binary,) = (p for p in unzipped.glob("binaries/*/*") if p.suffix in (".so", ".dylib", ".dll"))
    before = binary.read_bytes()
    command = [plain_compiler(), *FLAGS, *options, "-I.", *sources.sourceFiles, "-o", str(binary)]
    command += [] if sys.platform == "win32" else ["-lm"]
    done = subprocess.run(command, cwd=unzipped / "sources", capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert binary.read_bytes() != before
    return unzipped


@pytest.mark.parametrize(
    ("name", "fmi", "fixed_step"),
    [("Rectifier", "3.0", None), pytest.param("FourBar", "2.0", 1e-3, marks=pytest.mark.slow)],
)
def test_a_plain_compiler_builds_a_binary_that_gives_the_same_bytes(
    tmp_path: Path, name: str, fmi: FmiVersion, fixed_step: float | None
) -> None:
    path = export(SMALL / f"{name}.mo", f"Small.{name}", tmp_path, fmi=fmi, fixed_step=fixed_step)
    assert validate_fmu(str(path)) == []
    again = rebuilt(path, tmp_path)
    results = [fmpy.simulate_fmu(str(fmu), stop_time=0.3, output_interval=1e-3) for fmu in (path, again)]
    assert len(results[0]) == 301
    assert results[0].tobytes() == results[1].tobytes()


def test_sources_can_be_left_out(tmp_path: Path) -> None:
    dae = compile_model(SMALL / "PendulumXY.mo", "Small.PendulumXY")
    versions: tuple[FmiVersion, ...] = ("2.0", "3.0")
    for fmi in versions:
        path = pack(dae, tmp_path, fmi=fmi, with_sources=False)
        with zipfile.ZipFile(path) as archive:
            assert not [name for name in archive.namelist() if name.startswith("sources/")]
        read = fmpy.read_model_description(str(path))
        assert not read.buildConfigurations
        assert validate_fmu(str(path)) == []
