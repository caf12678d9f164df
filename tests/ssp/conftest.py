"""System structures written by hand around the test FMUs, and a way to run them."""

from __future__ import annotations

import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from cosim.engine import Result, System, simulate
from cosim.errors import InputError
from cosim.scenario import assemble, read

sys.path.insert(0, str(Path(__file__).parents[1] / "fmus"))
from fmu_builder import MODELS, build


@pytest.fixture(scope="session")
def fmu_path(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, int], Path]:
    """Return the path of a test FMU by its name and FMI version."""
    folder = tmp_path_factory.mktemp("fmus")
    built: dict[tuple[str, int], Path] = {}

    def path(name: str, fmi: int) -> Path:
        if (name, fmi) not in built:
            built[name, fmi] = build(MODELS[name], fmi, folder)
        return built[name, fmi]

    return path


Pack = Callable[..., Path]


@pytest.fixture
def pack(tmp_path: Path, fmu_path: Callable[[str, int], Path]) -> Pack:
    """Write x.ssp with a structure, the FMUs it names and other files; return its path."""

    def run(structure: str, files: dict[str, str | bytes] | None = None, fmi: int = 3) -> Path:
        path = tmp_path / "x.ssp"
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("SystemStructure.ssd", structure)
            for name in MODELS:
                everything = structure + "".join(str(content) for content in (files or {}).values())
                if f"resources/{name}.fmu" in everything:
                    archive.write(fmu_path(name, fmi), f"resources/{name}.fmu")
            for name, content in (files or {}).items():
                archive.writestr(name, content)
        return path

    return run


Assemble = Callable[..., System]


@pytest.fixture
def assembled(pack: Pack, tmp_path: Path) -> Assemble:
    """Return the system of a scenario that runs a structure."""

    def run(
        structure: str,
        files: dict[str, str | bytes] | None = None,
        *,
        keys: str = "",
        table: str = "time [s]\n",
        fmi: int = 3,
        system: str = "x.ssp",
    ) -> System:
        pack(structure, files, fmi)
        (tmp_path / "x.csv").write_text(f"# system: {system}\n# stop: 1 s\n{keys}{table}")
        return assemble(read(tmp_path / "x.csv"), _no_builtin)

    return run


@pytest.fixture
def run(assembled: Assemble) -> Callable[..., Result]:
    """Simulate a structure for 1 s; results every 0.1 s."""

    def simulated(*arguments: object, **options: object) -> Result:
        system = assembled(*arguments, **options)
        return simulate(system, stop=1.0, output_interval=0.1, tolerance=1e-6)

    return simulated


@pytest.fixture
def refusal(assembled: Assemble, tmp_path: Path) -> Callable[..., str]:
    """Return the message with which a structure is refused, without the folder."""

    def refused(*arguments: object, **options: object) -> str:
        with pytest.raises(InputError) as error:
            assembled(*arguments, **options)
        return str(error.value).replace(f"{tmp_path}/", "")

    return refused


def _no_builtin(name: str) -> Path:
    raise InputError(f"no built-in '{name}'")
