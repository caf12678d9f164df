"""FMUs for the check: the test FMUs, and copies of them with something wrong."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "fmus"))
from fmu_builder import MODELS, build


@pytest.fixture(scope="session")
def fmu_path(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Path]:
    """Return the path of a test FMU by its name and FMI version."""
    folder = tmp_path_factory.mktemp("fmus")
    built: dict[tuple[str, int], Path] = {}

    def path(name: str, fmi: int) -> Path:
        if (name, fmi) not in built:
            built[name, fmi] = build(MODELS[name], fmi, folder, defines=(name.upper(),))
        return built[name, fmi]

    return path
