"""The library through the front end alone: flattened and simulated without our own compiler."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

LIBRARY = Path(__file__).parents[2] / "modelica" / "WiperDrive"

Columns = dict[str, np.ndarray]
Simulate = Callable[..., Columns]


@pytest.fixture(scope="session")
def library() -> Path:
    return LIBRARY


@pytest.fixture(scope="session")
def load() -> Callable[[str], Any]:
    """A model of the library by its name inside WiperDrive, loaded once."""
    rumoca = pytest.importorskip("rumoca")
    loaded: dict[str, Any] = {}

    def load(name: str) -> Any:  # noqa: ANN401 - a model of an untyped package
        if name not in loaded:
            session = rumoca.Session(roots=[str(LIBRARY)])
            loaded[name] = session.load(str(LIBRARY / "package.mo"), model=f"WiperDrive.{name}")
        return loaded[name]

    return load


@pytest.fixture(scope="session")
def simulate() -> Simulate:
    """Simulate one component, whose inputs and parameters the modifier binds; columns by name inside the component."""
    rumoca = pytest.importorskip("rumoca")

    def simulate(name: str, stop: float, *, step: float, modifier: str = "", tolerance: float = 1e-8) -> Columns:
        # a variable with a derivative, because the solver wants at least one state
        text = f"""
            model Wrapper "Wrapper"
              WiperDrive.{name} x({modifier}) "Component";
              Real level(start=0, fixed=true) "State";
            equation
              der(level) = 0;
            end Wrapper;"""
        model = rumoca.Session(roots=[str(LIBRARY)]).loads(text, model="Wrapper", filename="Wrapper.mo")
        config = rumoca.SimConfig(solver="bdf", rtol=tolerance, atol=tolerance)
        result = model.simulate(stop, dt=step, config=config)
        columns = {n.removeprefix("x."): np.asarray(result[n], dtype=float) for n in result.names}
        return columns | {"time": np.asarray(result.time, dtype=float)}

    return simulate
