"""Test FMUs that save their states, and runs with one loop, for tests of checkpoints and branches."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TypedDict

from both_loops import compare, ending
from fmu_builder import MODELS, build

from cosim.engine import Checkpoint, Component, Connection, Fmu, Result, System
from cosim.errors import CosimError

Get = Callable[..., Fmu]
LOOPS = ("native", "python")


class Run(TypedDict):
    stop: float
    output_interval: float
    tolerance: float
    coupling_error: bool


RUN: Run = {"stop": 0.1, "output_interval": 0.01, "tolerance": 1e-6, "coupling_error": False}


class SavingFmus:
    """Test FMUs that save their state, by name and FMI version (3 unless told)."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._opened: dict[tuple[str, int], Fmu] = {}

    def __call__(self, name: str, fmi: int = 3) -> Fmu:
        if (name, fmi) not in self._opened:
            self._opened[name, fmi] = Fmu.read(build(MODELS[name], fmi, self._folder, saves=True))
        return self._opened[name, fmi]

    def close(self) -> None:
        for one in self._opened.values():
            one.close()


def under(loop: str, system: System, **arguments: object) -> Result:
    """Simulate with one loop; raise what it ends with."""
    found = ending(loop, system, **arguments)  # type: ignore[arg-type]
    if isinstance(found, CosimError):
        raise found
    return found


def again(checkpoint: Checkpoint, folder: Path) -> Checkpoint:
    """Send a checkpoint through a file."""
    return Checkpoint.load(checkpoint.save(folder / "x.cosim"))


def same(result: Result, reference: Result) -> None:
    """Assert that two results are equal but for wall time, loop, and what tells that one was resumed."""
    result.statistics.pop("resumed_at_s", None)
    compare(result, reference)


def feedback(get: Get, version: int = 3, **parameters: float) -> System:
    """Return an integrator and a sampler in a loop: x' = u, u = K x(t_k)."""
    return System(
        [
            Component("plant", get("integrator", version), {"x0": 1.0}),
            Component("c", get("sampler", version), {"K": -4.0, "T_compute": 0.01, **parameters}),
        ],
        [Connection(("plant", "x"), ("c", "u")), Connection(("c", "y"), ("plant", "u"))],
    )
