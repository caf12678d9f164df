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
    """Return the path of a test FMU by its name, FMI version and the lie that is compiled into it."""
    folder = tmp_path_factory.mktemp("fmus")
    built: dict[tuple[str, int, str], Path] = {}

    def path(name: str, fmi: int, lie: str = "") -> Path:
        key = name, fmi, lie
        if key not in built:
            place = folder / (lie or "honest")
            place.mkdir(exist_ok=True)
            built[key] = build(MODELS[name], fmi, place, defines=(f"LIE={lie}",) if lie else ())
        return built[key]

    return path
