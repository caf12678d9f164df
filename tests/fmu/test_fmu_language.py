"""What each piece of the language gives, at t = 0.97 s, all pieces in one FMU."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest

from cosim.fmu import export

pytest.importorskip("rumoca")

LANGUAGE = Path(__file__).parents[1] / "models" / "Language.mo"
T = 0.97
E = math.exp(-T)
LOOP = np.linalg.solve(
    [[2, 1, 0, 0, 0], [1, 3, 1, 0, 0], [0, 1, 4, 1, 0], [0, 0, 1, 5, 1], [0, 0, 0, 1, 6]], [T, 1, 2, 3, 4]
)
ROOT = next(r.real for r in np.roots([1, 0, 1, -2 * T - 2]) if abs(r.imag) < 1e-9)
EXPECTED: dict[str, dict[str, float]] = {
    "absolute": {"x": E},
    "alg2": {"x": ROOT},
    # each of the ticks at 0.1, 0.3, ... doubles what was there and adds twice the time
    "algWhen": {"s": 16.6, "last": 9.2},
    "arrComp": {"s": 36},
    "assigned": {"n": 11, "f": 0},
    "boolEq": {"c": 1},
    "conditional": {"z": 5 * T},
    "connected": {"z": 6 * T},
    "crossed": {"c[3]": 1, "n": 0},
    # ticks at 0, 0.3, 0.6 and 0.9
    "delayed": {"a": 0, "b": 1},
    "derWhen": {"v": 0.5, "b": 1},
    "discReal": {"d": 1},
    # false at t = 0, where the sine is zero, and true right after it
    "edgeChange": {"up": 4, "ch": 7},
    "elsewhen_1": {"k": 211},
    "ends": {"s": 5, "t": 5},
    "functions": {
        "a": 8, "b": -4, "c": 2e-3, "d": 2, "e": 0.25, "g": math.e + 2, "h": math.pi / 4 + math.pi / 2,
    },
    "homotopy_1": {"y": T, "z": (T - 0.5) ** 2},
    "ident": {"y": 7},
    "ifEq": {"y": T, "z": 1},
    "initialWhen": {"k": 1, "q": 4},
    "innerOuter": {"z": 3 * T},
    "intPar": {"a": 3, "b": 2, "c": -1, "d": -3, "e": 2, "f": 3, "g": 1, "h": 1, "i": 3.5, "y": 4},
    "linLoop": dict(zip("abcde", LOOP, strict=True)),
    "mat": {
        "d": 5, "s": 19, "t[1]": 5, "t[2]": 11, "u[1]": 7, "u[2]": 10, "w": 5, "c[1]": 3, "c[2]": 6, "m[1]": 9,
        "m[2]": 12, "m[3]": 15, "n": 3, "o[1]": 5, "o[2]": 12,
    },
    "matState": {"P[1,1]": 1 + 3 * T, "P[1,2]": 2 + 4 * T, "P[2,1]": 3, "P[2,2]": 4},
    "minMax": {"y": T, "z": 5},
    "negAlias": {"x": E, "y": -E},
    "nestedIfWhen": {"n": 433},
    "noEvt": {"x": T},
    "nonlinPair": {"x": (math.sqrt(6 + T) + math.sqrt(2 + T)) / 2, "y": (math.sqrt(6 + T) - math.sqrt(2 + T)) / 2},
    "paramEq": {"y": 18},
    "preInput": {"s": 2},
    "record_1": {"z": 3 * T},
    "recPar": {"z": 7},
    "reinit2": {"x": 2 - T, "y": T - 1},
    "replace_1": {"z": 11},
    "timeWhen": {"v": 0.5},
    "twoClocks": {"a": 10, "b": 1 + 3 + 5 + 7 + 9},
    "whenChain": {"n": 1, "m": 1},
}  # fmt: skip


@pytest.fixture(scope="module")
def last(tmp_path_factory: pytest.TempPathFactory) -> Any:  # noqa: ANN401 - a record of a structured array
    names = [f"{component}.{name}" for component, values in EXPECTED.items() for name in values]
    fmu = export(LANGUAGE, "Language", tmp_path_factory.mktemp("language"))
    return fmpy.simulate_fmu(str(fmu), stop_time=T, output_interval=T, relative_tolerance=1e-9, output=names)[-1]


@pytest.mark.parametrize("component", sorted(EXPECTED))
def test_each_piece_of_the_language_gives_what_it_must(last: Any, component: str) -> None:  # noqa: ANN401
    found = {name: float(last[f"{component}.{name}"]) for name in EXPECTED[component]}
    assert found == pytest.approx(EXPECTED[component], rel=1e-6, abs=1e-6)
