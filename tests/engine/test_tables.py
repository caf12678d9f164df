"""Connections that hand on one value for another: the same in both loops, and what cannot be a table."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from both_loops import simulate

from cosim.engine import Channel, Component, Connection, Fmu, System
from cosim.errors import InputError

Get = Callable[..., Fmu]
Table = tuple[tuple[float, float], ...]


def through(fmu: Get, kind: str, table: Table, values: list[float]) -> list[int]:
    """Return what the second mirror puts out for these inputs of the first, one each 0.1 s, at the end of each."""
    mirror = fmu("mirror", 3)
    connection = Connection(("a", f"y_{kind}"), ("b", f"u_{kind}"), table=table)
    channel = Channel(("a", f"u_{kind}"), [0.1 * k for k in range(len(values))], values)
    system = System([Component("a", mirror), Component("b", mirror)], [connection], [channel])
    stop = 0.1 * len(values)
    columns = simulate(system, stop=stop, output_interval=0.1, tolerance=1e-6).columns
    assert columns[f"a.y_{kind}"].tolist()[1:] == values
    return [int(value) for value in columns[f"b.y_{kind}"][1:]]


@pytest.mark.parametrize(
    ("kind", "table", "values", "expected"),
    [
        ("Boolean", ((0.0, 1.0), (1.0, 0.0)), [1, 0, 1, 1], [0, 1, 0, 0]),
        ("Int32", ((3.0, -7.0), (-7.0, 4.0)), [3, -7, 5, 3], [-7, 4, 5, -7]),
        ("Enumeration", ((1.0, 3.0), (2.0, 1.0), (3.0, 2.0)), [1, 2, 3, 1], [3, 1, 2, 3]),
    ],
)
def test_values_are_replaced_and_others_stay(
    fmu: Get, kind: str, table: Table, values: list[float], expected: list[int]
) -> None:
    assert through(fmu, kind, table, values) == expected


def test_a_replaced_value_triggers_an_event(fmu: Get) -> None:
    """The sampler in event mode sees the negated contact at the instant of its change."""
    connection = Connection(("a", "enabled"), ("b", "enable"), table=((0.0, 1.0), (1.0, 0.0)))
    sampler = fmu("sampler", 3)
    channel = Channel(("a", "enable"), [0.0, 0.013, 0.031], [1.0, 0.0, 1.0])
    system = System([Component("a", sampler), Component("b", sampler)], [connection], [channel])
    columns = simulate(system, stop=0.04, output_interval=0.001, tolerance=1e-6).columns
    assert columns["a.enabled"].tolist() == [1] * 13 + [0] * 18 + [1] * 10
    assert columns["b.enabled"].tolist() == [0] * 13 + [1] * 18 + [0] * 10


@pytest.mark.parametrize(
    ("source", "target", "table", "message"),
    [
        ("y_Float64", "u_Float64", ((1.0, 2.0),), "a table maps whole numbers, Booleans and enumerations, not a Real"),
        (
            "y_Boolean",
            "u_Boolean",
            ((1.0, 2.0),),
            "the table gives 2, which the target, of the type Boolean, cannot take",
        ),
        (
            "y_Int32",
            "u_Enumeration",
            ((1.0, 4.0),),
            "the table gives 4, which the target, of the type Enumeration, cannot take",
        ),
        (
            "y_Int32",
            "u_Int32",
            ((1.0, 0.5),),
            "the table gives 0.5, which the target, of the type Integer, cannot take",
        ),
    ],
)
def test_tables_that_do_not_fit(fmu: Get, source: str, target: str, table: Table, message: str) -> None:
    mirror = fmu("mirror", 3)
    system = System(
        [Component("a", mirror), Component("b", mirror)], [Connection(("a", source), ("b", target), table=table)]
    )
    with pytest.raises(InputError) as caught:
        system.check()
    assert str(caught.value).startswith(f"a.{source} -> b.{target}: {message}")
