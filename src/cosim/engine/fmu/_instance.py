"""An instantiated FMU: fmpy's object for what happens once, calls bound to fixed memory for the instants."""

from __future__ import annotations

import copy
from abc import ABC, abstractmethod
from array import array
from collections.abc import Callable, Sequence
from contextlib import suppress
from ctypes import Array, addressof, c_bool, c_double, c_int, c_size_t, c_uint, c_uint32, c_uint64, c_void_p, cast
from functools import partial
from typing import Any, ClassVar, NamedTuple, NoReturn

from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import fmi2Terminated

from cosim.engine.fmu._calls import LOADING, Site
from cosim.engine.fmu._fmu import Fmu
from cosim.engine.fmu._log import FAILED, STATUS, Log, fmi2_callbacks
from cosim.engine.fmu._variable import OPAQUE, Value, Variable
from cosim.errors import FmuError

Call = Callable[[], int]
"""An FMI function with all its arguments; returns the FMI status."""

EVENT_NEEDED, TERMINATE, EARLY_RETURN = 0x1, 0x100, 0x10000
"""Bits of ``Instance.flags``, which doStep sets."""

UPDATE_NEEDED, UPDATE_TERMINATES, NEXT_EVENT_DEFINED = 0x1, 0x100, 0x100000000
"""Bits of ``Instance.update_flags``, which updateDiscreteStates sets."""


class Access(NamedTuple):
    """A call that reads or sets variables of one FMI type, and what it is made of.

    ``function`` is its name without the prefix "fmi2", ``references`` are the value references, ``length`` is the
    number of values (arrays have several to a reference) and ``address`` the memory that it fills or reads.
    """

    call: Call
    function: str
    references: Array[c_uint]
    length: int
    address: int


class CallError(Exception):
    """A component cannot go on: what happened, and what to try."""

    def __init__(self, instance: Instance, what: str, remedy: str) -> None:
        """Keep all three."""
        super().__init__(what)
        self.instance = instance
        self.what = what
        self.remedy = remedy

    @property
    def refusal(self) -> str | None:
        """Return the assertion that the component reports as violated; None if there is none."""
        return self.instance.log.assertion

    def __str__(self) -> str:
        """Return which component it is, what happened, what the FMU says and what to try."""
        instance = self.instance
        return f"{instance.name} ({instance.fmu.name}): {self.what}; {instance.log}; {self.remedy}"


class Instance(ABC):
    """One instance of an FMU, from instantiation to freeing.

    ``do_step`` steps from ``t`` over ``h`` [s] and leaves ``flags``; ``update`` leaves ``update_flags`` and
    ``next_event`` [s]. All are bound once, since a call through fmpy costs ten times as much as the bare one.
    """

    type_codes: ClassVar[dict[str, str]]
    enumeration_type: ClassVar[str]
    tells_size: ClassVar[bool]
    plain_step: ClassVar[bool] = True
    """The function that steps takes no flags, as in FMI 1.0 and 2.0."""
    initializes_at_once: ClassVar[bool] = False
    """There is no Initialization Mode: inputs are set before the call that initialises, as in FMI 1.0."""
    no_return: c_bool | c_int = c_int(1)
    """What doStep is told: whether the FMU will never be put back to a state of before the step."""
    do_step: Call
    enter_event: Call
    enter_step: Call
    update: Call

    def __init__(self, name: str, fmu: Fmu, event_mode: bool, site: Site | None = None) -> None:
        """Instantiate; raises FmuError if the FMU refuses."""
        self.name = name
        self.fmu = fmu
        self.site = site or Site()
        self.log = Log(self.site.say)
        self.t = c_double()
        self.h = c_double()
        self.flags = c_uint32()
        self.update_flags = c_uint64()
        self.next_event = c_double()
        self._fatal = False
        self.site.enter(LOADING)
        self._slave = copy.copy(fmu.slave())
        self._slave.instanceName = name
        levels = ("logStatusWarning", "logStatusDiscard", "logStatusError", "logStatusFatal")
        categories = [category for category in fmu.log_categories if category in levels]
        try:
            self.site.enter("Instantiate")
            self._instantiate(event_mode, logging=not categories)
            if categories:
                self.site.enter("SetDebugLogging")
                self._slave.setDebugLogging(True, categories)
            self.site.leave()
        except Exception as error:
            check = "check that the file is complete"
            if fmu.capabilities["needsExecutionTool"]:
                tool = fmu.generation_tool or "the tool that exported it"
                check = f"it needs {tool} on this computer: check that this is installed and has its licence"
            raise FmuError(f"{name} ({fmu.name}) cannot be instantiated; {self.log}; {check}", file=fmu.path) from error
        self._bind_calls()

    @abstractmethod
    def _instantiate(self, event_mode: bool, logging: bool) -> None: ...

    @abstractmethod
    def _bind_calls(self) -> None: ...

    def access(self, verb: str, names: Sequence[str], address: int, sizes: int | None = None) -> Access:
        """Bind the function that gets ("Get") or sets ("Set") variables of one FMI type; they lie at ``address``.

        Of an array all elements have to be there, in a row. Binary variables have their sizes at ``sizes``.
        """
        variables = [self.fmu.variables[name] for name in names]
        own = [v for v, last in zip(variables, [None, *variables], strict=False) if _has_own_reference(v, last)]
        references = [variable.value_reference for variable in own]
        function = f"{verb}{self.accessed_as(self.fmu.fmi_types[names[0]])}"
        referred = (c_uint * len(references))(*references)
        places = [c_void_p(address)] if sizes is None else [c_void_p(sizes), c_void_p(address)]
        count = [c_size_t(len(names))] if self.tells_size else []
        call = self._bind(self.symbol(function), referred, c_size_t(len(references)), *places, *count)
        return Access(call, function, referred, len(names), address)

    @abstractmethod
    def set_opaque(self, fmi_type: str, reference: int, values: list[str]) -> None:
        """Set a String or a Binary, whose bytes are given in hexadecimal digits, or all elements of an array."""

    @abstractmethod
    def enter_initialization(self, tolerance: float, stop: float | None) -> None:
        """Enter Initialization Mode at t = 0; ``stop`` [s], or None if steps may go beyond it."""

    def exit_initialization(self) -> None:
        """Leave Initialization Mode."""
        self.once("ExitInitializationMode", self._slave.exitInitializationMode)

    def go_on(self, tolerance: float) -> None:  # noqa: B027 - most need nothing
        """Take it that a state of after initialisation was set, in a run with this relative tolerance."""

    def symbol(self, function: str) -> str:
        """Return the name that a function has in the FMU's library."""
        return f"fmi{self.fmu.fmi_version[0]}{function}"

    def state_symbol(self, verb: str) -> str:
        """Return the name of a function that concerns the FMU's state ("Get", "Set", "Free"), without its prefix."""
        return f"{verb}FMU{'s' if self.fmu.fmi_version == '2.0' else 'S'}tate"

    def save_state(self, address: int) -> None:
        """Keep the FMU's whole state, to which the pointer at this address refers from now on.

        It may be null, or that of a state that was kept before, whose memory is used again. The FMU must be able to
        (canGetAndSetFMUstate). Raises CallError.
        """
        self._state("Get", c_void_p(address))

    def restore_state(self, state: int) -> None:
        """Put the FMU back to a state that was kept; raises CallError."""
        self._state("Set", c_void_p(state))

    def free_state(self, address: int) -> None:
        """Free the state to which the pointer at this address refers; raises CallError."""
        self._state("Free", c_void_p(address))

    def _state(self, verb: str, place: c_void_p) -> None:
        function = self.state_symbol(verb)
        self.check(function, self._bind(self.symbol(function), place)())

    def directional_derivative(
        self,
        unknowns: tuple[Array[c_uint], int],
        knowns: tuple[Array[c_uint], int],
        seed: Array[c_double],
        slope: Array[c_double],
    ) -> Call:
        """Bind the function that puts into ``slope`` how unknowns change if knowns change by ``seed``.

        Of both the value references are given, and how many of these count. The FMU must be able to.
        """
        (outputs, n), (inputs, m) = ((references, c_size_t(count)) for references, count in (unknowns, knowns))
        sizes = (m, slope, n) if self.tells_size else (slope,)
        return self._bind(self.symbol("GetDirectionalDerivative"), outputs, n, inputs, m, seed, *sizes)

    def pointer(self, function: str) -> int:
        """Return the address of a function of the FMU's library."""
        return cast(self._slave.dll[self.symbol(function)], c_void_p).value or 0

    @property
    def counts(self) -> dict[str, int]:
        """What the solver that the engine gives a Model Exchange FMU has done."""
        return {}

    @property
    def component(self) -> int:
        """The FMU's own handle of the instance: the first argument of all its functions."""
        return int(self._slave.component)

    def _bind(self, function: str, *arguments: object) -> Call:
        bare = self._slave.dll[function]  # without argtypes: every argument is a ctypes object of the right type
        bare.restype = c_int
        call = partial(bare, c_void_p(self._slave.component), *arguments)
        return self.site.noting(function.removeprefix(self.symbol("")), call)

    def accessed_as(self, fmi_type: str) -> str:
        """Return the type whose functions read and set variables of an FMI type."""
        return self.enumeration_type if fmi_type == "Enumeration" else fmi_type

    def set_values(self, values: dict[str, Value]) -> None:
        """Set variables before Initialization Mode; elements of an array that are not named keep their start values."""
        for name in values:
            variable = self.fmu.variables[name]
            elements = [v for v in self.fmu.variables.values() if v.array == variable.array]
            together = [variable] if variable.array is None else elements
            self._set({v.name: values.get(v.name, v.start) for v in together})

    def _set(self, values: dict[str, Value | None]) -> None:
        """Set a scalar, or all elements of an array."""
        names = list(values)
        fmi_type = self.fmu.fmi_types[names[0]]
        for name, value in values.items():
            if value is None:
                raise FmuError(f"{self.name}.{name}: has no start value; set it, too, or no element of its array")
        if fmi_type in OPAQUE:
            texts = [str(value) for value in values.values()]
            reference = self.fmu.variables[names[0]].value_reference
            call = partial(self.set_opaque, fmi_type, reference, texts)
            self.once(f"Set{fmi_type}({', '.join(names)})", call)
            return
        code = self.type_codes[fmi_type]
        buffer: array[Any] = array(code, [])
        for name, value in values.items():
            assert value is not None and not isinstance(value, str)
            try:
                buffer.append(value if code in "df" else int(value))
            except OverflowError as error:
                raise FmuError(f"{self.name}.{name}: {value} does not fit; it is an {fmi_type}") from error
        access = self.access("Set", names, buffer.buffer_info()[0])
        self.check(f"{access.function}({', '.join(names)})", access.call())

    def get_value(self, name: str) -> float:
        """Return one number by name."""
        buffer = array(self.type_codes[self.fmu.fmi_types[name]], [0])
        access = self.access("Get", [name], buffer.buffer_info()[0])
        self.check(f"{access.function}({name})", access.call())
        return buffer[0]

    def once(self, function: str, call: Callable[[], object]) -> None:
        """Call through fmpy; raises CallError with the status that the FMU returned."""
        self.site.enter(function.partition("(")[0])
        try:
            call()
        except Exception as error:
            self.check(function, int(getattr(error, "status", 3)))
        finally:
            self.site.leave()

    def check(self, function: str, status: int) -> None:
        """Raise CallError if a status says that a call failed."""
        if status >= FAILED:
            self._fatal = status == STATUS.index("Fatal")
            name = STATUS[status] if status < len(STATUS) else str(status)
            raise CallError(self, f"{self.symbol(function)} returned {name}", self._remedy(function, status))

    def _remedy(self, function: str, status: int) -> str:
        any_step = self.fmu.capabilities["canHandleVariableCommunicationStepSize"]
        if function == "DoStep" and not any_step and self.fmu.fixed_step is None:
            return (
                "it takes steps of one length only and does not say which, so it was given the output interval: "
                "set output_interval to the length that it takes"
            )
        if status == STATUS.index("Discard"):
            return "it could not finish this step: try a smaller output interval or a looser tolerance"
        return "check its parameters and its inputs at that time, or try another tolerance"

    def fail_to_go_on(self, early: bool = False) -> NoReturn:
        """Raise CallError for a component that asked for the end of the simulation, or did not finish a step."""
        if early:
            what = "returned early from a step, which it was not allowed to"
            raise CallError(self, what, "try a smaller output interval, or report it to whoever exported the FMU")
        raise CallError(self, "asked to end the simulation", "set stop before that time, or change what makes it end")

    @property
    def is_broken(self) -> bool:
        """Whether the FMU has declared that nothing can be done with it any more."""
        return self._fatal

    def free(self) -> None:
        """Terminate and free the instance, unless the FMU has declared itself broken."""
        if self._fatal or not self._slave.component:
            return
        self.site.enter("Terminate")
        with suppress(FMICallException):  # after an error an FMU may refuse to terminate; it is freed all the same
            self._slave.terminate()
        self.site.enter("FreeInstance")
        getattr(self._slave, f"fmi{self.fmu.fmi_version[0]}FreeInstance")(self._slave.component)
        self.site.leave()
        self._slave.component = None


class Fmi2Instance(Instance):
    """An FMI 2.0 instance; it has no event mode."""

    enumeration_type = "Integer"
    tells_size = False
    type_codes: ClassVar[dict[str, str]] = {"Real": "d", "Integer": "i", "Boolean": "i", "Enumeration": "i"}

    def _instantiate(self, event_mode: bool, logging: bool) -> None:
        self._slave.instantiate(callbacks=fmi2_callbacks(self.log), loggingOn=logging)

    def _bind_calls(self) -> None:
        self.no_return = c_int(1)
        self.do_step = self._bind("fmi2DoStep", self.t, self.h, self.no_return)

    def check(self, function: str, status: int) -> None:
        """Raise CallError as for FMI 3.0; a doStep that returns Discard may also mean that the FMU wants to end."""
        if function == "DoStep" and status == STATUS.index("Discard"):
            self.site.enter("GetBooleanStatus")
            try:
                ended = self._slave.getBooleanStatus(fmi2Terminated)
            except FMICallException:
                ended = False
            self.site.leave()
            if ended:
                self.fail_to_go_on()
        super().check(function, status)

    def set_opaque(self, fmi_type: str, reference: int, values: list[str]) -> None:
        """Call fmi2SetString."""
        self._slave.setString([reference], values)

    def enter_initialization(self, tolerance: float, stop: float | None) -> None:
        """Call fmi2SetupExperiment and fmi2EnterInitializationMode."""
        setup = partial(self._slave.setupExperiment, tolerance=tolerance, startTime=0.0, stopTime=stop)
        self.once("SetupExperiment", setup)
        self.once("EnterInitializationMode", self._slave.enterInitializationMode)


class Fmi3Instance(Instance):
    """An FMI 3.0 instance."""

    enumeration_type = "Int64"
    tells_size = True
    plain_step = False
    type_codes: ClassVar[dict[str, str]] = {
        "Float64": "d",
        "Float32": "f",
        "Int8": "b",
        "UInt8": "B",
        "Int16": "h",
        "UInt16": "H",
        "Int32": "i",
        "UInt32": "I",
        "Int64": "q",
        "UInt64": "Q",
        "Boolean": "B",
        "Enumeration": "q",
    }

    def _instantiate(self, event_mode: bool, logging: bool) -> None:
        log = self.log
        self._slave.instantiate(
            loggingOn=logging,
            eventModeUsed=event_mode,
            logMessage=lambda environment, status, category, message: log.add(status, message),
        )

    def _bind_calls(self) -> None:
        flags = [c_void_p(addressof(self.flags) + byte) for byte in range(3)]
        self.no_return = c_bool(True)
        self._reached = c_double()
        reached = c_void_p(addressof(self._reached))
        self.do_step = self._bind("fmi3DoStep", self.t, self.h, self.no_return, *flags, reached)
        updates = [c_void_p(addressof(self.update_flags) + byte) for byte in range(5)]
        self.update = self._bind("fmi3UpdateDiscreteStates", *updates, c_void_p(addressof(self.next_event)))
        self.enter_event = self._bind("fmi3EnterEventMode")
        self.enter_step = self._bind("fmi3EnterStepMode")

    def set_opaque(self, fmi_type: str, reference: int, values: list[str]) -> None:
        """Call fmi3SetString or fmi3SetBinary."""
        if fmi_type == "String":
            self._slave.setString([reference], values)
        else:
            self._slave.setBinary([reference], [bytes.fromhex(value) for value in values])

    def enter_initialization(self, tolerance: float, stop: float | None) -> None:
        """Call fmi3EnterInitializationMode."""
        enter = partial(self._slave.enterInitializationMode, tolerance=tolerance, startTime=0.0, stopTime=stop)
        self.once("EnterInitializationMode", enter)


def _has_own_reference(variable: Variable, last: Variable | None) -> bool:
    """Tell whether a variable needs a reference of its own after the last one: an array has one for all elements."""
    return variable.array is None or last is None or last.array != variable.array
