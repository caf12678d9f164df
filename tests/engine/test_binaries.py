"""Binary variables and arrays of them (FMI 3.0) on connections."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from both_loops import simulate
from fmpy.validation import validate_fmu

from cosim.engine import (
    Algorithm,
    Channel,
    Component,
    Connection,
    Fmu,
    PartialResultError,
    Result,
    System,
    explain_timing,
)
from cosim.errors import CosimError

Get = Callable[..., Fmu]


def ring(fmu: Get) -> System:
    parcel = fmu("parcel")
    links = [(source, target, i) for source, target in ("ab", "ba") for i in (1, 2)]
    return System(
        [Component("a", parcel), Component("b", parcel)],
        [Connection((source, f"y[{i}]"), (target, f"u[{i}]")) for source, target, i in links],
    )


def run(system: System, steps: int = 20, algorithm: Algorithm = "gauss-seidel") -> Result:
    step = 0.1 if algorithm == "jacobi" else None
    if step is None:
        return simulate(system, stop=0.1 * steps, output_interval=0.1, tolerance=1e-6)
    return simulate(system, stop=0.1 * steps, output_interval=0.1, tolerance=1e-6, algorithm=algorithm, step=step)


def total(k: int) -> int:
    """Sum of k bytes 0, 1, 2, ..., in this order or back to front."""
    return k * (k - 1) // 2


def test_the_test_fmu_is_valid(fmu_path: Callable[[str, int], Path]) -> None:
    assert validate_fmu(str(fmu_path("parcel", 3))) == []


def test_bytes_arrive_whole_and_at_once(fmu: Get) -> None:
    """In step k, b is stepped after a: it gets a's k bytes, zero among them, and the k - 1 of b that a sends back."""
    result = run(ring(fmu))
    assert list(result.columns) == ["a.sum", "a.size", "a.set", "b.sum", "b.size", "b.set"]
    later = range(2, 21)
    assert result.columns["b.size"].tolist()[2:] == [k + k - 1 for k in later]
    assert result.columns["b.sum"].tolist()[2:] == [total(k) + total(k - 1) for k in later]
    assert result.columns["a.size"].tolist()[2:] == [k - 1 + k - 1 for k in later]
    assert result.columns["a.sum"].tolist()[2:] == [2 * total(k - 1) for k in later]


def test_jacobi_hands_bytes_on_one_step_later(fmu: Get) -> None:
    """The k - 1 bytes of the step before, and the k - 2 of the one before that, sent back."""
    result = run(ring(fmu), algorithm="jacobi")
    for name in "ab":
        assert result.columns[f"{name}.size"].tolist()[3:] == [k - 1 + k - 2 for k in range(3, 21)]
        assert result.columns[f"{name}.sum"].tolist()[3:] == [total(k - 1) + total(k - 2) for k in range(3, 21)]


def test_what_has_not_changed_is_not_set_again(fmu: Get) -> None:
    """Elements of one's own output that a sends back to itself: y[2] of an empty u[1] stays empty."""
    parcel = fmu("parcel")
    links = [Connection(("a", "y[2]"), ("a", f"u[{i}]")) for i in (1, 2)]
    result = run(System([Component("a", parcel)], links))
    assert len(set(result.columns["a.set"].tolist())) == 1


def test_more_bytes_than_the_input_takes(fmu: Get) -> None:
    with pytest.raises(PartialResultError) as caught:
        run(ring(fmu), steps=80)
    assert str(caught.value) == (
        "the simulation failed at t = 6 s: b (parcel): cannot take a Binary of 61 bytes: its input is declared for "
        "fewer; the FMU gave no reason; connect a source that puts out less"
    )


def refused(system: System) -> str:
    with pytest.raises(CosimError) as caught:
        run(system)
    return str(caught.value)


def test_what_does_not_fit_is_refused_before_the_run(fmu: Get) -> None:
    system = ring(fmu)
    system.connections[0] = Connection(("a", "z[1]"), ("b", "u[1]"))
    assert refused(system) == (
        "a.z[1] -> b.u[1]: the source is of the type image/png, but the target takes application/octet-stream; "
        "connect what agrees"
    )
    system.connections[0] = Connection(("a", "sum"), ("b", "u[1]"))
    assert refused(system) == "a.sum -> b.u[1]: a Real cannot drive a Binary; it takes Binary"
    del system.connections[0]
    assert refused(system) == "b.u: nothing drives b.u[1]; drive all elements of an array of Binary"
    alone = Component("a", fmu("parcel"))
    assert refused(System([alone], channels=[Channel(("a", "u[1]"), [0.0], [1.0])])) == (
        "channel a.u[1]: is a Binary; a channel has numbers only"
    )


def test_the_explanation_of_the_timing_tells_sizes(fmu: Get) -> None:
    lines = explain_timing(ring(fmu), stop=2.0, output_interval=0.1).splitlines()
    assert lines[lines.index("  b.y[1] -> a.u[1]") + 3] == "    1 byte: put out at 0.1 s, acts from 0.1 s on"
    assert lines[lines.index("  b.y[1] -> a.u[1]") + 4] == "    2 bytes: put out at 0.2 s, acts from 0.2 s on"


def test_a_parameter_has_bytes(fmu: Get) -> None:
    """Each put out in front of the k bytes of step k; elements that are not named keep their start value."""
    system = ring(fmu)
    system.components[0] = Component("a", fmu("parcel"), {"first[1]": "0aFF"})
    result = run(system)
    assert result.columns["b.size"].tolist()[2:] == [2 + k + k - 1 for k in range(2, 21)]
    assert result.columns["b.sum"].tolist()[2:] == [0x0A + 0xFF + total(k) + total(k - 1) for k in range(2, 21)]


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ("0a0", "a.first[2]: '0a0' does not fit; it takes a text of two hexadecimal digits for each byte"),
        ("0x", "a.first[2]: '0x' does not fit; it takes a text of two hexadecimal digits for each byte"),
        (12.0, "a.first[2]: 12.0 does not fit; it takes a text of two hexadecimal digits for each byte"),
        ("0102030405", "a.first[2]: has 5 bytes; it takes at most 4"),
    ],
)
def test_a_parameter_that_is_no_binary(fmu: Get, value: str | float, message: str) -> None:
    assert refused(System([Component("a", fmu("parcel"), {"first[2]": value})])) == message
