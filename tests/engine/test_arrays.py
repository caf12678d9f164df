"""Arrays (FMI 3.0), element by element."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from both_loops import simulate
from fmpy.validation import validate_fmu

from cosim.engine import Channel, Component, Connection, Fmu, System
from cosim.errors import FmuError

Get = Callable[..., Fmu]


def test_the_test_fmu_is_valid(fmu_path: Callable[[str, int], Path]) -> None:
    assert validate_fmu(str(fmu_path("vector", 3))) == []


def test_an_array_is_described_by_its_elements(fmu: Get) -> None:
    vector = fmu("vector")
    assert list(vector.variables)[1:] == [
        "last",
        *(f"u[{i}]" for i in (1, 2, 3)),
        *(f"K[{i},1]" for i in (1, 2, 3)),
        *(f"{name}[{i}]" for name in ("y", "n", "m") for i in (1, 2, 3)),
    ]
    assert [vector.variables[f"u[{i}]"].start for i in (1, 2, 3)] == [0.5, 1.5, 2.5]
    assert {vector.variables[f"K[{i},1]"].array for i in (1, 2, 3)} == {"K"}
    assert vector.variables["last"].array is None
    assert vector.dependencies["y[2]"] == frozenset()


def test_elements_on_connections_and_channels(fmu: Get) -> None:
    """Nobody drives a.u[2], b.u[1] and b.u[2]: they keep their start values, 1.5, 0.5 and 1.5."""
    system = System(
        [Component("a", fmu("vector"), {"K[2,1]": 10.0}), Component("b", fmu("vector"), {"K[1,1]": 4, "K[3,1]": -1.0})],
        [
            Connection(("a", "y[2]"), ("b", "u[3]"), factor=2.0),
            Connection(("a", "m[3]"), ("b", "n[1]")),
            Connection(("a", "m[1]"), ("b", "n[2]")),
        ],
        [
            Channel(("a", "u[1]"), [0.0], [7.0]),
            Channel(("a", "u[3]"), [0.0, 0.1], [8.0, 9.0]),
            Channel(("a", "n[3]"), [0.0], [-300.0]),
        ],
    )
    result = simulate(system, stop=0.4, output_interval=0.1, tolerance=1e-6)
    final = {name: column[-1] for name, column in result.columns.items()}
    assert [final[f"a.y[{i}]"] for i in (1, 2, 3)] == [7.0, 15.0, 9.0]
    assert [final[f"b.y[{i}]"] for i in (1, 2, 3)] == [2.0, 1.5, -30.0]
    assert [final[f"b.m[{i}]"] for i in (1, 2, 3)] == [-300, 0, 0]
    assert (final["a.last"], final["b.last"]) == (9.0, 30.0)
    assert result.units["a.y[2]"] == "m"
    coarse = simulate(system, stop=0.4, output_interval=0.1, tolerance=1e-6, algorithm="jacobi", step=0.02)
    assert {name: column[-1] for name, column in coarse.columns.items()} == final


def test_the_whole_array_has_no_name_of_its_own(fmu: Get) -> None:
    system = System([Component("a", fmu("vector"))], channels=[Channel(("a", "u"), [0.0], [7.0])])
    with pytest.raises(FmuError, match=r"^a.u: vector has no input u; its inputs are u\[1\], u\[2\], u\[3\], n\[1\]"):
        simulate(system, stop=0.4, output_interval=0.1, tolerance=1e-6)
