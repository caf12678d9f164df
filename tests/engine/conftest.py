"""The test FMUs, compiled once per test session."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from coupled_systems import CoupledSystems

from cosim.engine import Fmu

sys.path.insert(0, str(Path(__file__).parents[1] / "fmus"))
from fmu_builder import INTEGRATOR, MODELS, build, with_unknown_dependencies
from saving_fmus import SavingFmus


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


@pytest.fixture(scope="session")
def fmu(fmu_path: Callable[[str, int], Path]) -> Iterator[Callable[[str, int], Fmu]]:
    """Return a test FMU, read once, by its name and FMI version (3 unless told)."""
    opened: dict[tuple[str, int], Fmu] = {}

    def get(name: str, fmi: int = 3) -> Fmu:
        if (name, fmi) not in opened:
            opened[name, fmi] = Fmu.read(fmu_path(name, fmi))
        return opened[name, fmi]

    yield get
    for one in opened.values():
        one.close()


@pytest.fixture(scope="session")
def undescribed_integrator(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Fmu]:
    """The FMI 2.0 integrator without statements on what its outputs depend on."""
    path = build(with_unknown_dependencies(INTEGRATOR), 2, tmp_path_factory.mktemp("undescribed"))
    with Fmu.read(path) as opened:
        yield opened


@pytest.fixture(scope="session")
def coupled(tmp_path_factory: pytest.TempPathFactory) -> Iterator[CoupledSystems]:
    """Plants in two parts that drive each other; see ``coupled_systems``. A folder may have their FMUs already."""
    pytest.importorskip("rumoca")
    built = os.environ.get("COSIM_TEST_FMUS")
    systems = CoupledSystems(Path(built) if built else tmp_path_factory.mktemp("coupled"))
    yield systems
    systems.close()


@pytest.fixture(scope="session")
def saving(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Callable[[str, int], Fmu]]:
    """Return a test FMU that saves its state, read once, by its name and FMI version (3 unless told)."""
    fmus = SavingFmus(tmp_path_factory.mktemp("saving"))
    yield fmus
    fmus.close()
