"""What functions, algorithms and initial sections give, at t = 0.97 s, all pieces in two FMUs."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest

from cosim.fmu import export

pytest.importorskip("rumoca")

MODELS = Path(__file__).parents[1] / "models"
T = 0.97
A = np.array([[1.0], [T]])
C = A @ A.T


def elements(name: str, values: np.ndarray | list[float]) -> dict[str, float]:
    """The elements of an array by their Modelica names."""
    return {f"{name}[{','.join(str(i + 1) for i in index)}]": float(v) for index, v in np.ndenumerate(np.array(values))}


EXPECTED: dict[str, dict[str, float]] = {
    "algorithms": {"a": 1, "b": 6 * T, **elements("v", [T, 2 * T, 3 * T]), "n": 7, "late": 1, "up": 7},
    "functionChecks": {"dA": 2 * (1 + 2 * T) * 2, "y": 5},
    "functionLoops": {
        "a": 1 + 2 * T + 3 * T**2, **elements("B", np.array([[1, 2, 3], [4, 5, T]]).T),
        "c": 10 - 5 * (T - 0.5) / 0.5, **elements("d", [T, T**2, T**3]), **elements("e", [T, T**2]),
    },
    "functionOutputs": {
        "a": 2 * math.cos(T), "b": 2 * math.sin(T), "c": 2 * math.sin(T) + math.cos(T) * math.sin(T),
        **elements("d", [4, T**2]), "p": 9, "s": 81, "z": 16, "q": 11,
    },
    # q = p * conj(conj(p)) = p^2
    "functionRecords": {"a": T**2 - 1, "b": 2 * T, "c": -1},
    "functions": {"a": 1, "b": -4, "c": 1 + 2 * 2 * T + 1, "d": 2},
    # ticks at 0.1, 0.3, 0.5, 0.7, 0.9
    "functionTypes": {"a": -20, "b": 1, "c": T**3, "n": 5},
    "indices": {"a": 2, "b": 5, "c": 4 + 50 + 600, "d": 6 * T, "e": 6},
    # p = 3 k = 6, m = 4; d = 8/2, e = 2*10
    "initialAlgorithms": {"p": 6, "q": 12, "a": 16, "b": 4 + 20, "c": 6, "w": 2 - 0.5 * math.exp(-2 * T)},
    "initially": {"y": T, "n": 2, "m": 4},
    "jumps": {
        # 5 T - 2 = 2.85, 3 T = 2.91
        "a": 2, "b": 0.85, "c": 0.85, "d": 0, "e": 2, "f": 3, "h": 2 * (T - 0.5), "i": 3 * (0.5 - T),
        "j": T - 0.9,
        # div is -2, -1, 0, 1, 2 from 0, 0.1, 0.3, 0.7, 0.9 s on
        "g": -2 * 0.1 - 0.2 + 0.2 + 2 * (T - 0.9),
    },
    "enumerations": {"n": 2, "b": 1},
    # m v = 20 + 3 t
    "momentum": {
        "m": 10 - T / 2, "v": (20 + 3 * T) / (10 - T / 2), "a": 2 * (1 + T), "b": 6 * (1 + T),
        "c": (math.cos(1 + T) + math.sin(1 + T)) * math.exp(1 + T),
    },
    "oscillator": {"x": math.cos(2 * T)},
    "redeclared": {
        "a.s": 3 * T + T, "b.s": 6 * T + 70 * T, "c.s": 10 * T + 5 * T,
        "a.connection": 1, "b.connection": 2, "c.connection": 3,
    },
    "shapes": {
        **elements("c", C), **elements("d", [[1 + T**2]]), **elements("v", [1, T]), **elements("w", [2, 2 * T]),
        **elements("e", C @ [1, T]), **elements("m", [1 + T**2]), **elements("p", [[7, 10], [15, 22]]),
        **elements("s", [[3, T], [6, 2 * T]]), **elements("r", [[0, -T, 2], [T, 0, -1], [-2, 1, 0]]),
        **elements("q", [1, T]), **elements("u", [[1, T], [3, 4]]), **elements("z", [[1, 3, 4], [2, 5, T]]),
    },
}  # fmt: skip


S = 11 + 12 + 13 + 22 + 23
SECTIONS: dict[str, dict[str, float]] = {
    # x falls to 0.5 at 0.5 s, is set to 0.8, and falls to it again at 0.8 s, is set to 1.6
    "branches": {"n": 112, "w": 1.6, "y": 1.6 - (T - 0.8)},
    # ten ticks, the last at 0.9 s
    "buffer": {"k": 2, "last": 0.5, "total": 0.6 + 0.7 + 0.8 + 0.9, **elements("v", [0.8, 0.9, 0.6, 0.7])},
    "chain": {"y": 3 * (2 * T + 1) + 1, "z": 10 * T + 1 + 21},
    "partial_1": {"y": 3, "z": 6},
    "several": {
        "a": 2 * (1 + T) + 1 + 2 * (1 + T), "b": 2 * (1 + T) + 1, "c": 2 * math.cos(T),
        "d": 2 * math.sin(T) * math.sin(0.5), **elements("m", [[11, 12, 13], [-1, 22, 23]]), "s": S * T, "late": 1,
        "n": 1,
    },
    "shift": {**elements("a", [0.9, 0.8, 0.7, 0.6]), **elements("b", [0.9, 0.8, 0.7, 0.6]), "both": 0},
}  # fmt: skip


def last_row(model: str, expected: dict[str, dict[str, float]], folder: Path) -> Any:  # noqa: ANN401 - a record
    names = [f"{component}.{name}" for component, values in expected.items() for name in values]
    fmu = export(MODELS / f"{model}.mo", model, folder)
    return fmpy.simulate_fmu(str(fmu), stop_time=T, output_interval=T, relative_tolerance=1e-9, output=names)[-1]


@pytest.fixture(scope="module")
def last(tmp_path_factory: pytest.TempPathFactory) -> Any:  # noqa: ANN401 - a record of a structured array
    return last_row("Algorithmic", EXPECTED, tmp_path_factory.mktemp("algorithmic"))


@pytest.fixture(scope="module")
def last_of_sections(tmp_path_factory: pytest.TempPathFactory) -> Any:  # noqa: ANN401 - a record of a structured array
    return last_row("Sections", SECTIONS, tmp_path_factory.mktemp("sections"))


@pytest.mark.parametrize("component", sorted(EXPECTED))
def test_each_piece_that_computes_step_by_step_gives_what_it_must(last: Any, component: str) -> None:  # noqa: ANN401
    found = {name: float(last[f"{component}.{name}"]) for name in EXPECTED[component]}
    assert found == pytest.approx(EXPECTED[component], rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("component", sorted(SECTIONS))
def test_sections_that_the_front_end_refuses_give_what_they_must(
    last_of_sections: Any,  # noqa: ANN401
    component: str,
) -> None:
    found = {name: float(last_of_sections[f"{component}.{name}"]) for name in SECTIONS[component]}
    assert found == pytest.approx(SECTIONS[component], rel=1e-6, abs=1e-6)
