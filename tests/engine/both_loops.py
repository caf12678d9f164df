"""``simulate`` as tests use it: by the native loop and by the Python loop, which must agree in every bit."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import TypedDict, Unpack

import pytest

from cosim.engine import Algorithm, PartialResultError, Result, System
from cosim.engine import simulate as simulate_once
from cosim.errors import CosimError


class Arguments(TypedDict, total=False):
    stop: float
    output_interval: float
    tolerance: float
    progress: Callable[[float], None]
    algorithm: Algorithm
    step: float
    extrapolation: int
    coupling_error: bool


Ending = Result | CosimError


def simulate(system: System, **arguments: Unpack[Arguments]) -> Result:
    """Simulate with both loops and compare them; return or raise what the native loop gives."""
    if "progress" not in arguments:
        reference = ending("python", system, **arguments)
        native = ending("native", system, **arguments)
        compare(native, reference)
    else:
        native = ending("native", system, **arguments)
    if isinstance(native, CosimError):
        raise native
    return native


def ending(loop: str, system: System, **arguments: Unpack[Arguments]) -> Ending:
    """Return the result of one loop, or the error that it ended with."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(os.environ, "COSIM_ENGINE", loop)
        try:
            result = simulate_once(system, **arguments)
        except CosimError as error:
            return error
    assert result.statistics["loop"] == loop
    return result


def compare(native: Ending, reference: Ending) -> None:
    """Assert that two endings are the same, whichever loop they come from."""
    assert type(native) is type(reference)
    if isinstance(native, CosimError) or isinstance(reference, CosimError):
        assert str(native) == str(reference)
        if isinstance(native, PartialResultError) and isinstance(reference, PartialResultError):
            compare(native.result, reference.result)
        return
    assert native.message == reference.message
    assert native.complete == reference.complete
    assert native.time.tobytes() == reference.time.tobytes()
    assert list(native.columns) == list(reference.columns)
    for name, column in native.columns.items():
        assert column.dtype == reference.columns[name].dtype
        assert column.tobytes() == reference.columns[name].tobytes(), name
    assert _counted(native) == _counted(reference)


def _counted(result: Result) -> dict[str, object]:
    return {key: value for key, value in result.statistics.items() if key not in ("wall_s", "second_wall_s", "loop")}
