"""A wheel as it is released brings the native loop for all platforms, so that whoever installs it needs no compiler."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import venv
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from cosim.engine.native import _compilation
from cosim.fmu.toolchain import PLATFORMS

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
RUN = """
import importlib.util, sys
from cosim.engine import Component, Fmu, System, simulate
assert importlib.util.find_spec("ziglang") is None
with Fmu.read(sys.argv[1]) as fmu:
    result = simulate(System([Component("f", fmu, {"x0": 2.0})]), stop=1.0, output_interval=0.5, tolerance=1e-6)
print(result.statistics["loop"], result.columns["f.x"].tolist())
"""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the wheel as CONTRIBUTING.md says; pip needs its index for the build's own packages."""
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", str(folder), str(ROOT)]
    subprocess.run(command, check=True, env={**os.environ, "HATCH_BUILD_HOOKS_ENABLE": "true"})
    return next(folder.glob("*.whl"))


def test_it_has_the_library_of_each_platform_and_no_others(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        names = {name.rpartition("/")[2] for name in archive.namelist() if "/prebuilt/" in name}
    assert names == {_compilation.file_name(platform) for platform in PLATFORMS}
    assert wheel.name.endswith("-py3-none-any.whl")


def test_the_native_loop_runs_without_a_compiler(
    wheel: Path, tmp_path: Path, fmu_path: Callable[[str, int], Path]
) -> None:
    venv.create(tmp_path / "venv", with_pip=True)
    python = tmp_path / "venv" / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    subprocess.run([python, "-m", "pip", "install", "--quiet", str(wheel)], check=True)
    environment = {key: value for key, value in os.environ.items() if key not in ("PATH", "PYTHONPATH", "COSIM_ENGINE")}
    environment |= {"XDG_CACHE_HOME": str(tmp_path / "cache"), "PATH": str(python.parent)}
    done = subprocess.run(
        [python, "-c", RUN, str(fmu_path("integrator", 3))],
        check=True,
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env=environment,
    )
    assert done.stdout.strip() == "native [2.0, 2.0, 2.0]"
    assert not (tmp_path / "cache").exists()


def test_the_bytes_do_not_depend_on_where_they_are_built(tmp_path: Path) -> None:
    code = "import sys; from pathlib import Path; import hatch_build; hatch_build.compile_all(Path(sys.argv[1]))"
    copy = tmp_path / "copy"
    shutil.copytree(ROOT / "src", copy / "src")
    shutil.copy(ROOT / "hatch_build.py", copy)
    built: list[dict[str, bytes]] = []
    for root in (ROOT, copy):
        folder = tmp_path / f"from_{root.name}"
        folder.mkdir()
        subprocess.run([sys.executable, "-c", code, str(folder)], check=True, cwd=root)
        built.append({path.name: path.read_bytes() for path in folder.rglob("engine-*")})
    assert len(built[0]) == len(PLATFORMS)
    assert built[0] == built[1]
