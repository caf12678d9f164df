"""Notes which function of which FMU is running, where a supervisor can read it if the process dies in it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from cosim.engine.native._structures import NOWHERE, Position

_TYPES = (
    *("Real", "Integer", "Boolean", "String", "Binary", "Float64", "Float32"),
    *("Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64"),
)

LOADING, UNLOADING = "loading", "unloading"
"""Not functions, but moments at which an FMU's binary may run code of its own."""

CALLS = (
    # the first ones as in native/engine.h
    *("DoStep", "EnterEventMode", "EnterStepMode", "UpdateDiscreteStates"),
    *(f"{verb}{kind}" for verb in ("Get", "Set") for kind in _TYPES),
    *("SetupExperiment", "EnterInitializationMode", "ExitInitializationMode"),
    *("SetTime", "SetContinuousStates", "GetContinuousStates", "GetNominalsOfContinuousStates", "GetDerivatives"),
    *("GetContinuousStateDerivatives", "GetEventIndicators", "EnterContinuousTimeMode", "CompletedIntegratorStep"),
    *("NewDiscreteStates", "InitializeSlave"),
    *(f"{verb}FMU{letter}tate" for verb in ("Get", "Set", "Free") for letter in "sS"),
    *("GetDirectionalDerivative",),
    *("SerializedFMUstateSize", "SerializeFMUstate", "DeSerializeFMUstate"),
    *("SerializedFMUStateSize", "SerializeFMUState", "DeserializeFMUState"),
    *("Instantiate", "SetDebugLogging", "GetBooleanStatus", "Terminate", "FreeInstance"),
    *(LOADING, UNLOADING),
)
"""The functions of FMUs that the engine calls, without the prefix "fmi2", in the order of their numbers."""

NUMBERS = {name: number for number, name in enumerate(CALLS)}


@dataclass
class Site:
    """Where one component's calls are noted.

    ``number`` is that of the component in the system. ``watched`` tells that somebody supervises the run, so that
    calls that the Python loop makes are worth the time of a note; ``say`` hands on what the FMU has said.
    """

    position: Position = field(default_factory=Position)
    number: int = 0
    watched: bool = False
    say: Callable[[str], None] | None = None

    def enter(self, function: str) -> None:
        """Note that a function is about to be called."""
        position = self.position
        position.calls += 1
        position.function = NUMBERS[function]
        position.component = self.number

    def leave(self) -> None:
        """Note that it has returned."""
        self.position.component = NOWHERE

    def noting(self, function: str, call: Callable[..., int]) -> Callable[..., int]:
        """Return a call that notes itself if that is worth it."""
        if not self.watched:
            return call

        def noted(*arguments: object) -> int:
            self.enter(function)
            status = call(*arguments)
            self.leave()
            return status

        return noted
