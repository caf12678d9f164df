"""Tests with other tools. A missing tool skips its tests, but where COSIM_INTEROP is "required" it fails them."""

from __future__ import annotations

import importlib.util
import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

Need = Callable[..., None]

HERE = Path(__file__).parent


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """All tests of this folder are of the interop kind."""
    for item in items:
        if HERE in item.path.parents:
            item.add_marker(pytest.mark.interop)


@pytest.fixture(scope="session")
def need() -> Need:
    """Return a function that takes Python modules and programs, and ends the test if one is missing."""

    def need(*modules: str, programs: tuple[str, ...] = ()) -> None:
        missing = [name for name in modules if importlib.util.find_spec(name) is None]
        missing += [name for name in programs if shutil.which(name) is None]
        if missing and os.environ.get("COSIM_INTEROP") == "required":
            pytest.fail(f"{', '.join(missing)} must be installed where COSIM_INTEROP is required")
        if missing:
            pytest.skip(f"needs {', '.join(missing)}; see .ci/run")

    return need
