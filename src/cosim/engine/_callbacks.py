"""Functions of a Model Exchange instance as the native loop calls them, which knows Co-Simulation only.

Those that step, change the mode and set inputs lead the FMU through its modes, in Python; the native loop gets their
addresses.
"""

from __future__ import annotations

from collections.abc import Callable
from ctypes import CFUNCTYPE, POINTER, c_bool, c_double, c_int, c_size_t, c_void_p, cast
from functools import partial
from typing import Any

from cosim.engine._instance import EVENT_NEEDED, TERMINATE, Instance

_FLAG = POINTER(c_bool)
_DO_STEP = CFUNCTYPE(c_int, c_void_p, c_double, c_double, c_bool, _FLAG, _FLAG, _FLAG, POINTER(c_double))
_UPDATE = CFUNCTYPE(c_int, c_void_p, _FLAG, _FLAG, _FLAG, _FLAG, _FLAG, POINTER(c_double))
_ENTER = CFUNCTYPE(c_int, c_void_p)
_SET = {
    2: CFUNCTYPE(c_int, c_void_p, c_void_p, c_size_t, c_void_p),
    3: CFUNCTYPE(c_int, c_void_p, c_void_p, c_size_t, c_void_p, c_size_t),
}
_SET_BINARY = CFUNCTYPE(c_int, c_void_p, c_void_p, c_size_t, c_void_p, c_void_p, c_size_t)


class Callbacks:
    """The callbacks of one instance, kept as long as the native loop may call them."""

    def __init__(self, instance: Instance) -> None:
        """Make none yet."""
        self._instance = instance
        self._handed_on: list[object] = []

    def mode(self, function: str) -> int | None:
        """Return the address of a function that steps or changes the mode, by its name; None if it is neither."""
        instance = self._instance
        if function == "DoStep":
            return self._hand_on(_DO_STEP(self._step))
        if function == "UpdateDiscreteStates":
            return self._hand_on(_UPDATE(self._update))
        if function == "EnterEventMode":
            return self._hand_on(_ENTER(lambda _: instance.enter_event()))
        if function == "EnterStepMode":
            return self._hand_on(_ENTER(lambda _: instance.enter_step()))
        return None

    def setter(self, function: str, pointer: int, before: Callable[[], int]) -> int:
        """Return the address of one that calls ``before`` and, if that went well, the setter at ``pointer``."""
        instance = self._instance
        kind = _SET_BINARY if function == "SetBinary" else _SET[3 if instance.tells_size else 2]
        bare = kind(pointer)

        def call(*arguments: object) -> int:
            return before() or instance.site.noting(function, partial(bare, *arguments))()

        return self._hand_on(kind(call))

    def _hand_on(self, callback: Any) -> int:  # noqa: ANN401 - a ctypes function
        self._handed_on.append(callback)
        return cast(callback, c_void_p).value or 0

    def _step(self, _: int, t: float, h: float, __: bool, event: Any, end: Any, ___: Any, ____: Any) -> int:  # noqa: ANN401
        instance = self._instance
        instance.t.value, instance.h.value = t, h
        status = instance.do_step()
        event[0] = bool(instance.flags.value & EVENT_NEEDED)
        end[0] = bool(instance.flags.value & TERMINATE)
        return status

    def _update(self, _: int, *places: Any) -> int:  # noqa: ANN401
        instance = self._instance
        status = instance.update()
        for byte, place in enumerate(places[:5]):
            place[0] = bool(instance.update_flags.value >> (8 * byte) & 1)
        places[5][0] = instance.next_event.value
        return status
