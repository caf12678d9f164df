"""The project's own FMUs, built once, and runs of them that several tests look at."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmpy import simulate_fmu

from cosim.fmu import catalogue, export

MODELICA = Path(__file__).parents[2] / "modelica" / "WiperDrive"

Run = dict[str, np.ndarray[Any, np.dtype[np.float64]]]
Simulate = Callable[..., Run]


@pytest.fixture(scope="session")
def simulate() -> Simulate:
    """Simulate one FMU of the catalogue alone with fmpy, which shares nothing with this project's engine."""

    @cache
    def run(
        name: str, outputs: tuple[str, ...], stop: float, step: float, tolerance: float, start: tuple[Any, ...] = ()
    ) -> Run:
        result = simulate_fmu(
            str(catalogue.ensure(name)),
            stop_time=stop,
            output_interval=step,
            relative_tolerance=tolerance,
            start_values=dict(start),
            output=list(outputs),
        )
        return {key: np.asarray(result[key], dtype=float) for key in ("time", *outputs)}

    return run


@pytest.fixture(scope="session")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """Export a class of the library that is not in the catalogue."""
    out = tmp_path_factory.mktemp("exported")
    return cache(lambda model: export(MODELICA, f"WiperDrive.{model}", out))
