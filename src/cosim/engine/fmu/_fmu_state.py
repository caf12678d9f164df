"""The state of an instantiated FMU as the FMU itself keeps it: saved, set again, turned into bytes and back."""

from __future__ import annotations

from collections.abc import Callable
from ctypes import CFUNCTYPE, byref, c_char_p, c_int, c_size_t, c_void_p, create_string_buffer

from cosim.engine.fmu._fmu import Fmu
from cosim.engine.fmu._instance import CallError, Instance
from cosim.engine.native._library import native_library
from cosim.worker import machine_memory

_GET, _SET, _FREE, _SIZE, _WRITE, _READ = range(6)
_NAMES = {
    "2.0": (
        *("GetFMUstate", "SetFMUstate", "FreeFMUstate"),
        *("SerializedFMUstateSize", "SerializeFMUstate", "DeSerializeFMUstate"),
    ),
    "3.0": (
        *("GetFMUState", "SetFMUState", "FreeFMUState"),
        *("SerializedFMUStateSize", "SerializeFMUState", "DeserializeFMUState"),
    ),
}
_TYPES = tuple(
    CFUNCTYPE(c_int, c_void_p, *arguments)
    for arguments in (
        *((c_void_p,), (c_void_p,), (c_void_p,)),
        *((c_void_p, c_void_p), (c_void_p, c_void_p, c_size_t), (c_char_p, c_size_t, c_void_p)),
    )
)
_REMEDY = "it claims that it can do this: report it to whoever exported it"


def why_not_saved(fmu: Fmu) -> str | None:
    """Return why the engine cannot save and set the state of such an FMU; None if it can."""
    if fmu.fmi_version == "1.0":
        return "is of FMI 1.0, which cannot save states"
    if not fmu.capabilities["canGetAndSetFMUstate"]:
        return f"cannot save its state (its description does not claim {_claim(fmu, 'canGetAndSet')})"
    if fmu.interface == "ModelExchange" and native_library() is None:
        return "is for Model Exchange, and without the native library its solver (CVode) cannot save its own state"
    return None


def why_not_written(fmu: Fmu) -> str | None:
    """Return why such a state cannot be turned into bytes either; None if it can."""
    if not fmu.capabilities["canSerializeFMUstate"]:
        return f"cannot write its state down (its description does not claim {_claim(fmu, 'canSerialize')})"
    return None


def _claim(fmu: Fmu, verb: str) -> str:
    return f"{verb}FMUstate" if fmu.fmi_version == "2.0" else f"{verb}FMUState"


class FmuState:
    """A saved state of one instance, in memory of the FMU: of use until ``free``, and no longer than the instance.

    That of a Model Exchange FMU has its solver's in it.
    """

    def __init__(self, instance: Instance, content: bytes | None = None) -> None:
        """Save the present state, or take over what ``to_bytes`` gave; raises CallError if the FMU does not do it."""
        self._instance = instance
        self._names = _NAMES[instance.fmu.fmi_version]
        self._handle = c_void_p()
        self._set = self._function(_SET)
        if content is None:
            self._call(_GET, byref(self._handle))
        else:
            self._call(_READ, content, len(content), byref(self._handle))

    def restore(self) -> None:
        """Put the instance into this state; it may be done again and again. Raises CallError."""
        site = self._instance.site
        site.enter(self._names[_SET])
        status = self._set(self._instance.component, self._handle)
        site.leave()
        if status:
            self._check(_SET, status)

    def to_bytes(self) -> bytes:
        """Return the state as bytes, which another instance of the same FMU can take over; raises CallError."""
        size = c_size_t()
        self._call(_SIZE, self._handle, byref(size))
        if not 0 < size.value < machine_memory():
            raise CallError(self._instance, f"gives its state a size of {size.value} bytes", _REMEDY)
        content = create_string_buffer(size.value)
        self._call(_WRITE, self._handle, content, size)
        return content.raw

    def free(self) -> None:
        """Give the memory back."""
        if self._handle:
            self._call(_FREE, byref(self._handle))
            self._handle = c_void_p()

    def _function(self, which: int) -> Callable[..., int]:
        name = self._names[which]
        try:
            return _TYPES[which](self._instance.pointer(name))
        except AttributeError:
            what = f"has no function {self._instance.symbol(name)}"
            raise CallError(self._instance, what, _REMEDY) from None

    def _call(self, which: int, *arguments: object) -> None:
        function, site = self._function(which), self._instance.site
        site.enter(self._names[which])
        status = function(self._instance.component, *arguments)
        site.leave()
        self._check(which, status)

    def _check(self, which: int, status: int) -> None:
        try:
            self._instance.check(self._names[which], status)
        except CallError as error:
            raise CallError(error.instance, error.what, _REMEDY) from None
