"""Hand-made runs of the voltage profile: states from given instants on, and closings of the park contact."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest

from cosim.assessment import Trace

Run = Callable[..., Trace]

CYCLE = ((0.0, "Soft_start"), (0.1, "RUN"), (0.9, "turn_point_dec"), (1.0, "turn_point_acc"), (1.1, "RUN"))
"""Figure 3.12 but for the end of the revolution, from its beginning on [s]."""


def make(states: Sequence[tuple[float, str]], parks: Sequence[float], stop: float, **more: Any) -> Trace:  # noqa: ANN401
    """A run with rows each ms; the contact closes at each of ``parks`` [s] for 12 ms."""
    time = np.arange(round(stop * 1000) + 1) * 1e-3
    entries = np.round(np.array([at for at, _ in states]) * 1000)
    index = np.searchsorted(entries, np.arange(len(time)), side="right") - 1
    since = np.array([time - at for at in parks])
    on = ((since > -1e-9) & (since < 0.012 - 1e-9)).any(axis=0)
    columns = {"controller.state": np.array([name for _, name in states])[index], "plant.park": on.astype(int)}
    return Trace("made", time, columns | more)


def cycles(ends: Sequence[Sequence[tuple[float, str]]], length: float = 2.0) -> list[tuple[float, str]]:
    """Revolutions of ``length`` [s] one after another, each with an end of its own, relative to its beginning."""
    return [(k * length + at, state) for k, end in enumerate(ends) for at, state in (*CYCLE, *end)]


@pytest.fixture
def run() -> Run:
    return make
