"""An FMU's binary: loaded through fmpy also if it lacks functions that a run does not need."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable
from ctypes import CDLL
from pathlib import Path
from typing import Any

from cosim.errors import FmuError, FmuWarning

_OPTIONAL = (
    *("FMUstate", "FMUState", "Serialize", "DeSerialize", "Deserialize", "DirectionalDerivative", "AdjointDerivative"),
    *("OutputDerivatives", "InputDerivatives", "CancelStep", "Status", "Clock", "Interval", "Shift", "Dependencies"),
    *("ConfigurationMode", "EvaluateDiscreteStates", "ActivateModelPartition", "ScheduledExecution", "Reset"),
    *("GetTypesPlatform", "GetModelTypesPlatform", "GetVersion"),
)
"""Parts of the names of functions that the engine can do without."""

_OF_THE_OTHER_INTERFACE = {
    "Slave": ("ModelExchange", "ContinuousTime", "IntegratorStep", "SetTime", "ContinuousState", "EventIndicators"),
    "Model": ("CoSimulation", "StepMode", "DoStep"),
}

_ACCESS = ("Get", "Set")


def load(kind: type[Any], types: Iterable[str], path: Path, **arguments: object) -> Any:  # noqa: ANN401 - fmpy has no types
    """Return fmpy's object of this class for an FMU whose variables have these FMI types.

    Warns (FmuWarning) of functions that the standard demands, but that no run needs. Raises FmuError if the binary
    cannot be loaded or lacks another one.
    """
    missing: list[str] = []
    read = {"Integer" if t == "Enumeration" and not kind.__name__.startswith("FMU3") else t for t in types}
    read |= {"Int64"} if "Enumeration" in read else set()

    def needed(symbol: str) -> bool:
        name = symbol.rpartition("fmi")[2].lstrip("23")
        if any(part in name for part in (*_OPTIONAL, *_OF_THE_OTHER_INTERFACE[kind.__name__[-5:]])):
            return False
        accessed = name[3:]
        return not (name[:3] in _ACCESS and accessed in _TYPES and accessed not in read)

    def load_functions(self: Any) -> None:  # noqa: ANN401
        library = self.dll
        self.dll = _Lookup(library, needed, missing)
        try:
            kind._loadFunctions(self)
        finally:
            self.dll = library

    forgiving = type(kind.__name__, (kind,), {"_loadFunctions": load_functions})
    try:
        loaded = forgiving(**arguments)
    except FmuError as error:
        raise FmuError(f"its binary {error}", file=path) from error
    except Exception as error:
        raise FmuError(f"its binary cannot be loaded: {error}", file=path) from error
    if missing:
        warnings.warn(
            f"{path}: its binary lacks {', '.join(missing)}, which the standard demands; no run here needs them",
            FmuWarning,
            stacklevel=2,
        )
    return loaded


_TYPES = frozenset(
    "Real Integer Boolean String Binary Float64 Float32 Int8 UInt8 Int16 UInt16 Int32 UInt32 Int64 UInt64".split()
)


class _Absent:
    """Stands for a function that is not there."""


class _Lookup:
    """Finds the functions of a library; of those that are not there, ``missing`` has the names."""

    def __init__(self, library: CDLL, needed: Callable[[str], bool], missing: list[str]) -> None:
        self._library = library
        self._needed = needed
        self._missing = missing

    def __getattr__(self, symbol: str) -> object:
        try:
            return getattr(self._library, symbol)
        except AttributeError as error:
            if self._needed(symbol):
                raise FmuError(
                    f"lacks the function {symbol}, without which it cannot be used; report it to whoever exported it"
                ) from error
            self._missing.append(symbol)
            return _Absent()
