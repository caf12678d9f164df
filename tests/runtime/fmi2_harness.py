"""Call the FMI 2.0 shell of a hand-written sample model through ctypes."""

from __future__ import annotations

from ctypes import CDLL, byref, c_char, c_double, c_int, c_size_t, c_uint, c_void_p
from pathlib import Path
from typing import Any, Self

from fmpy.fmi2 import fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from runtime_harness import TOKEN, FmiError, built, library_of

KINDS: dict[str, Any] = {"Real": c_double, "Integer": c_int, "Boolean": c_int}
CO_SIMULATION = 1
TERMINATED, LAST_SUCCESSFUL_TIME = 3, 2
DISCARD = 2


class Sample2:
    """An FMI 2.0 instance of a sample model; its methods raise FmiError if a function does not return OK.

    ``log`` holds what the last call said, as (status, category, text), where the text is a printf format.
    """

    def __init__(
        self, name: str, *, folder: Path | None = None, guid: str = TOKEN, called: str | None = None,
        kind: int = CO_SIMULATION, logging: bool = False,
    ) -> None:  # fmt: skip
        self.log: list[tuple[int, str, str]] = []
        self.callbacks = fmi2CallbackFunctions()
        self.callbacks.logger = fmi2CallbackLoggerTYPE(
            lambda _env, _name, status, category, text: self.log.append((status, category.decode(), text.decode()))
        )
        self.dll = CDLL(str(library_of(name, folder or built(name, 2), 2)))
        self.dll.fmi2Instantiate.restype = c_void_p
        instance = self.dll.fmi2Instantiate(
            (name if called is None else called).encode(), kind, guid.encode(), None, byref(self.callbacks), 0, logging
        )
        if not instance:
            raise FmiError("\n".join(text for _, _, text in self.log))
        self.instance = c_void_p(instance)
        self.time = 0.0
        self.status = 0

    def call(self, function: str, *arguments: object) -> None:
        """Call an FMI function with the instance and these arguments."""
        self.log.clear()
        self.status = getattr(self.dll, function)(self.instance, *arguments)
        if self.status != 0:
            texts = "\n".join(text for _, _, text in self.log)
            raise FmiError(texts or f"{function} returned {self.status} and logged nothing")

    def free(self) -> None:
        self.dll.fmi2FreeInstance(self.instance)

    def set_up(self, tolerance: float | None = None, start: float = 0.0, stop: float | None = None) -> Self:
        self.time = start
        self.call(
            "fmi2SetupExperiment", tolerance is not None, c_double(tolerance or 0.0), c_double(start),
            stop is not None, c_double(stop or 0.0),
        )  # fmt: skip
        return self

    def enter(self) -> Self:
        self.call("fmi2EnterInitializationMode")
        return self

    def exit(self) -> Self:
        self.call("fmi2ExitInitializationMode")
        return self

    def start(self, tolerance: float | None = None, start: float = 0.0, **parameters: float) -> Self:
        """Set the parameters given as v<value reference>, then initialise."""
        for name, value in parameters.items():
            self.set(int(name[1:]), value)
        return self.set_up(tolerance, start).enter().exit()

    def step(self, h: float) -> None:
        """Step by h from where the last step ended."""
        self.step_to(self.time + h)

    def step_to(self, end: float) -> None:
        self.call("fmi2DoStep", c_double(self.time), c_double(end - self.time), 1)
        self.time = end

    def last_time(self) -> float:
        value = c_double()
        self.call("fmi2GetRealStatus", LAST_SUCCESSFUL_TIME, byref(value))
        return value.value

    def terminated(self) -> bool:
        value = c_int()
        self.call("fmi2GetBooleanStatus", TERMINATED, byref(value))
        return bool(value.value)

    def get(self, *references: int, kind: str = "Real") -> Any:  # noqa: ANN401
        """The value, or a list of the values if there are several references."""
        n = len(references)
        values = (KINDS[kind] * n)()
        self.call(f"fmi2Get{kind}", (c_uint * n)(*references), c_size_t(n), values)
        return values[0] if n == 1 else list(values)

    def set(self, reference: int, value: float, kind: str = "Real") -> None:
        self.call(f"fmi2Set{kind}", (c_uint * 1)(reference), c_size_t(1), (KINDS[kind] * 1)(value))

    def save(self) -> c_void_p:
        state = c_void_p()
        self.call("fmi2GetFMUstate", byref(state))
        return state

    def restore(self, state: c_void_p) -> None:
        self.call("fmi2SetFMUstate", state)

    def forget(self, state: c_void_p) -> None:
        self.call("fmi2FreeFMUstate", byref(state))

    def serialize(self, state: c_void_p) -> bytes:
        size = c_size_t()
        self.call("fmi2SerializedFMUstateSize", state, byref(size))
        buffer = (c_char * size.value)()
        self.call("fmi2SerializeFMUstate", state, buffer, size)
        return buffer.raw

    def deserialize(self, data: bytes) -> c_void_p:
        state = c_void_p()
        self.call("fmi2DeSerializeFMUstate", (c_char * len(data)).from_buffer_copy(data), c_size_t(len(data)),
                  byref(state))  # fmt: skip
        return state
