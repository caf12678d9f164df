"""The state of an instantiated FMU as the FMU itself keeps it: saved, set again, turned into bytes and back."""

from __future__ import annotations

from ctypes import CFUNCTYPE, addressof, byref, c_char_p, c_int, c_size_t, c_void_p, create_string_buffer

from cosim.engine._fmu import Fmu
from cosim.engine._instance import CallError, Instance
from cosim.worker import machine_memory

_SIZE, _WRITE, _READ = range(3)
_NAMES = {
    "2.0": ("SerializedFMUstateSize", "SerializeFMUstate", "DeSerializeFMUstate"),
    "3.0": ("SerializedFMUStateSize", "SerializeFMUState", "DeserializeFMUState"),
}
_ARGUMENTS = ((c_void_p, c_void_p), (c_void_p, c_void_p, c_size_t), (c_char_p, c_size_t, c_void_p))
_REMEDY = "it claims that it can do this: report it to whoever exported it"


def why_not_saved(fmu: Fmu) -> str | None:
    """Return why the engine cannot save and set the state of such an FMU; None if it can."""
    if fmu.interface == "ModelExchange":
        return "is for Model Exchange, and the solver that integrates it here cannot be put back to an earlier time"
    if fmu.fmi_version == "1.0":
        return "is of FMI 1.0, which cannot save states"
    if not fmu.capabilities["canGetAndSetFMUstate"]:
        return f"cannot save its state (its description does not claim {_claim(fmu, 'canGetAndSet')})"
    return None


def why_not_written(fmu: Fmu) -> str | None:
    """Return why such a state cannot be turned into bytes either; None if it can."""
    if not fmu.capabilities["canSerializeFMUstate"]:
        return f"cannot write its state down (its description does not claim {_claim(fmu, 'canSerialize')})"
    return None


def _claim(fmu: Fmu, verb: str) -> str:
    return f"{verb}FMUstate" if fmu.fmi_version == "2.0" else f"{verb}FMUState"


class FmuState:
    """A saved state of one instance, in memory of the FMU: of use until ``free``, and no longer than the instance."""

    def __init__(self, instance: Instance, content: bytes | None = None) -> None:
        """Save the present state, or take over what ``to_bytes`` gave; raises CallError if the FMU does not do it."""
        self._instance = instance
        self._handle = c_void_p()
        if content is None:
            instance.save_state(addressof(self._handle))
        else:
            self._call(_READ, content, len(content), byref(self._handle))

    def restore(self) -> None:
        """Put the instance into this state; it may be done again and again. Raises CallError."""
        self._instance.restore_state(self._handle.value or 0)

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
            self._instance.free_state(addressof(self._handle))
            self._handle = c_void_p()

    def _call(self, which: int, *arguments: object) -> None:
        instance = self._instance
        name = _NAMES[instance.fmu.fmi_version][which]
        try:
            function = CFUNCTYPE(c_int, c_void_p, *_ARGUMENTS[which])(instance.pointer(name))
        except AttributeError:
            raise CallError(instance, f"has no function {instance.symbol(name)}", _REMEDY) from None
        instance.site.enter(name)
        status = function(instance.component, *arguments)
        instance.site.leave()
        try:
            instance.check(name, status)
        except CallError as error:
            raise CallError(error.instance, error.what, _REMEDY) from None
