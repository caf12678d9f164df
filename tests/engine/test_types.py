"""Every type of number on a connection, and what does not fit it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from both_loops import simulate

from cosim.engine import Channel, Component, Connection, Fmu, PartialResultError, System

Get = Callable[..., Fmu]

VALUES = {
    "Float64": 0.1,
    "Float32": 0.1,
    "Int8": -128,
    "UInt8": 255,
    "Int16": -32768,
    "UInt16": 65535,
    "Int32": -(2**31),
    "UInt32": 2**32 - 1,
    "Int64": -(2**53),
    "UInt64": 2**53,
    "Boolean": 1,
    "Enumeration": 3,
}
FMI2_VALUES = {kind: min(max(value, -(2**31)), 2**31 - 1) for kind, value in VALUES.items()}


@pytest.mark.parametrize(("version", "values"), [(2, FMI2_VALUES), (3, VALUES)])
def test_every_type_comes_through(fmu: Get, version: int, values: dict[str, float]) -> None:
    channels = [Channel(("a", f"u_{kind}"), [0.0], [float(value)]) for kind, value in values.items()]
    connections = [Connection(("a", f"y_{kind}"), ("b", f"u_{kind}")) for kind in values]
    mirror = fmu("mirror", version)
    system = System([Component("a", mirror), Component("b", mirror)], connections, channels)
    result = simulate(system, stop=0.3, output_interval=0.1, tolerance=1e-6)
    for kind, value in values.items():
        exact = float(np.float32(value)) if kind == "Float32" and version == 3 else value
        assert result.columns[f"a.y_{kind}"].tolist()[1:] == [exact] * 3
        assert result.columns[f"b.y_{kind}"][-1] == exact


@pytest.mark.parametrize(
    ("source", "value", "target", "bits"),
    [
        ("Int64", 128, "Int8", 8),
        ("Int64", -129, "Int8", 8),
        ("Int64", -1, "UInt8", 8),
        ("Int64", 256, "UInt8", 8),
        ("Int32", 2**15, "Int16", 16),
        ("Int32", -1, "UInt16", 16),
        ("Int64", 2**31, "Int32", 32),
        ("Int64", 2**32, "UInt32", 32),
        ("UInt64", 2**63, "Int64", 64),
        ("Int64", -1, "UInt64", 64),
    ],
)
def test_a_number_beyond_the_range_of_its_target(fmu: Get, source: str, value: int, target: str, bits: int) -> None:
    system = System(
        [Component("a", fmu("mirror")), Component("b", fmu("mirror"))],
        [Connection(("a", f"y_{source}"), ("b", f"u_{target}"))],
        [Channel(("a", f"u_{source}"), [0.0, 0.25], [0.0, float(value)])],
    )
    with pytest.raises(PartialResultError) as caught:
        simulate(system, stop=0.5, output_interval=0.1, tolerance=1e-6)
    assert f"b (mirror): cannot take {value:.17g}: its input is an integer of {bits} bits" in str(caught.value)


def test_the_limits_of_a_type_fit_it(fmu: Get) -> None:
    system = System(
        [Component("a", fmu("mirror")), Component("b", fmu("mirror"))],
        [Connection(("a", "y_Int64"), ("b", "u_Int8")), Connection(("a", "y_UInt64"), ("b", "u_UInt16"))],
        [
            Channel(("a", "u_Int64"), [0.0, 0.25], [-128.0, 127.0]),
            Channel(("a", "u_UInt64"), [0.0, 0.25], [0.0, 65535.0]),
        ],
    )
    result = simulate(system, stop=0.5, output_interval=0.1, tolerance=1e-6)
    assert result.columns["b.y_Int8"].tolist()[-1] == 127
    assert result.columns["b.y_UInt16"].tolist()[-1] == 65535
