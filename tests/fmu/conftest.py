"""FMUs of the small models, built once in a run, and their simulation by an importer that is not ours."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest

from cosim.fmu import export

TESTS = Path(__file__).parents[1]
SMALL = TESTS / "models" / "Small"
LIBRARY = TESTS.parent / "modelica" / "WiperDrive"

Build = Callable[[str], Path]
Simulate = Callable[..., Any]


@pytest.fixture(scope="session")
def build(tmp_path_factory: pytest.TempPathFactory) -> Build:
    """The FMU of a small model, or of a model of WiperDrive by its full name."""
    pytest.importorskip("rumoca")
    folder = tmp_path_factory.mktemp("fmus")
    built: dict[str, Path] = {}

    def build(name: str) -> Path:
        if name not in built:
            built[name] = (
                export(LIBRARY, name, folder)
                if name.startswith("WiperDrive.")
                else export(SMALL / f"{name}.mo", f"Small.{name}", folder)
            )
        return built[name]

    return build


@pytest.fixture(scope="session")
def simulate(build: Build) -> Simulate:
    """Run the FMU of a model with fmpy; ``signals`` are (time, value) rows of an input, two at one time are a step."""

    def simulate(
        name: str,
        stop: float,
        *,
        step: float,
        tolerance: float = 1e-9,
        signals: tuple[str, list[tuple[float, float]]] | None = None,
        **start: float | bool,
    ) -> Any:  # noqa: ANN401 - a structured array
        table = None
        if signals is not None:
            variable, rows = signals
            table = np.array(rows, dtype=[("time", float), (variable, float)])
        return fmpy.simulate_fmu(
            str(build(name)),
            stop_time=stop,
            output_interval=step,
            relative_tolerance=tolerance,
            start_values=start,
            input=table,
        )

    return simulate
