"""Model Exchange by the native library: the project's own solver in C, native/exchange.h, over the structures here."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from ctypes import (
    CFUNCTYPE,
    Structure,
    addressof,
    byref,
    c_bool,
    c_double,
    c_int,
    c_int32,
    c_int64,
    c_uint,
    c_void_p,
    cast,
)
from functools import partial
from math import inf

from cosim.engine.exchange import _exchange_failures as failures
from cosim.engine.exchange._exchange import ExchangeInstance, Stepper
from cosim.engine.fmu._calls import NUMBERS
from cosim.engine.fmu._instance import CallError
from cosim.errors import BuildError, FmuError

_TYPES = (
    *("Real", "Integer", "Boolean", "String", "Binary", "Float64", "Float32"),
    *("Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64"),
)
_STEPPING = ("DoStep", "EnterEventMode", "EnterStepMode", "UpdateDiscreteStates")
_STATES = ("GetFMUState", "SetFMUState", "FreeFMUState")
_BYTES = ("SerializedFMUStateSize", "SerializeFMUState", "DeserializeFMUState")
_COUNTERS = ("steps", "rejected_steps", "rhs_evaluations", "jacobians", "state_events", "time_events", "step_events")

(
    _FUNCTION_FAILED,
    _NOT_FINITE,
    _STEP_TOO_SMALL,
    _SINGULAR,
    _NO_PROGRESS,
    _EVENTS_WITHOUT_END,
    _UPDATES_WITHOUT_END,
    _EVENT_IN_THE_PAST,
    _WANTS_TO_END,
) = range(1, 10)

_DO_STEP = CFUNCTYPE(c_int, c_void_p, c_double, c_double, c_bool, *(4 * [c_void_p]))
_UPDATE = CFUNCTYPE(c_int, c_void_p, *(6 * [c_void_p]))
_ENTER = CFUNCTYPE(c_int, c_void_p)
_BEGIN = CFUNCTYPE(c_int, c_void_p, c_double, c_double)


def _functions(fmi_version: str, names: tuple[str, str]) -> tuple[str, ...]:
    """Return the names of what is called, in the order of native/exchange.h; ``names`` are the instance's."""
    rates, update = names
    states: tuple[str, ...] = (*_STATES, *_BYTES)
    if fmi_version == "2.0":
        states = tuple(name.replace("State", "state").replace("Deserialize", "DeSerialize") for name in states)
    return (
        *("SetTime", "SetContinuousStates", "GetContinuousStates", "GetNominalsOfContinuousStates", rates),
        *("GetEventIndicators", "GetDirectionalDerivative", "EnterEventMode", "EnterContinuousTimeMode", update),
        *("CompletedIntegratorStep", *states),
        *(f"{verb}{kind}" for kind in _TYPES for verb in ("Get", "Set")),
    )


_COUNT = len(_functions("3.0", ("", "")))


class _Known(Structure):
    _fields_ = [
        ("instance", c_void_p),
        ("at", c_void_p),
        ("functions", _COUNT * c_void_p),
        *((name, c_void_p) for name in ("states", "rates", "owners")),
        *((name, c_int64) for name in ("n_states", "n_indicators", "n_colours")),
        ("numbers", _COUNT * c_int32),
        *((name, c_int32) for name in ("number", "fmi", "own_events", "completes", "autonomous", "unused")),
    ]


class _Trouble(Structure):
    _fields_ = [
        *((name, c_double) for name in ("t", "h", "value")),
        *((name, c_int32) for name in ("kind", "function", "status", "state")),
    ]


class NativeStepper(Stepper):
    """Leads and integrates the FMU in C; Python is not called back."""

    def __init__(self, instance: ExchangeInstance, library: ctypes.CDLL) -> None:
        """Bind what is called; raises BuildError if the library has other structures."""
        library.cosim_exchange_size.restype = c_int64
        if library.cosim_exchange_size() != ctypes.sizeof(_Known):
            raise BuildError("the native library has another structure for Model Exchange than is expected; delete it")
        library.cosim_exchange_new.restype = c_void_p
        self._instance = instance
        self._library = library
        self._names = _functions(instance.fmu.fmi_version, instance.names)
        self._exchange: int | None = None
        self._memory: list[object] = []
        flags = [addressof(instance.flags) + byte for byte in range(3)]
        updates = [addressof(instance.update_flags) + byte for byte in range(5)]
        self._reached = c_double()
        step = self._bound(_DO_STEP, "DoStep")
        self.do_step = lambda: step(
            instance.t.value, instance.h.value, instance.no_return.value, *flags, addressof(self._reached)
        )
        self.update = partial(self._bound(_UPDATE, "UpdateDiscreteStates"), *updates, addressof(instance.next_event))
        self.enter_event = self._bound(_ENTER, "EnterEventMode")
        self.enter_step = self._bound(_ENTER, "EnterStepMode")
        self.before_inputs = self._bound(_ENTER, "before_inputs")

    def begin(self, tolerance: float, stop: float | None) -> int:
        """Start the solver."""
        self.tolerance = tolerance
        return self._bound(_BEGIN, "begin")(tolerance, inf if stop is None else stop)

    @property
    def counts(self) -> dict[str, int]:
        """What the solver has done."""
        counts = (c_int64 * len(_COUNTERS))()
        if self._exchange is not None:
            self._library.cosim_exchange_count(c_void_p(self._exchange), counts)
        return dict(zip(_COUNTERS, counts, strict=True))

    @property
    def component(self) -> int:
        """The instance, made when it is first asked for. Raises FmuError if there is no memory for it."""
        if self._exchange is None:
            known = self._known()
            self._exchange = self._library.cosim_exchange_new(byref(known))
            if self._exchange is None:
                path = self._instance.fmu.path
                raise FmuError(f"has {known.n_states} states, for which there is no memory", file=path)
        return self._exchange

    def _known(self) -> _Known:
        instance = self._instance
        fmu, states = instance.fmu, instance.fmu.states
        n, n_indicators = instance.measure()
        owners = states.owners() if len(states.dependencies) == n else _dense(n)
        directions = bool(fmu.capabilities["providesDirectionalDerivative"]) and len(states.references) == n
        has_directions = directions and instance.bare_pointer("GetDirectionalDerivative") != 0
        return _Known(
            instance=instance.bare_component,
            at=addressof(instance.site.position),
            functions=(c_void_p * _COUNT)(*map(instance.bare_pointer, self._names)),
            states=self._kept(c_uint, states.references) if has_directions else None,
            rates=self._kept(c_uint, states.rates) if has_directions else None,
            owners=self._kept(c_int32, [state for colour in owners for state in colour]),
            n_states=n,
            n_indicators=n_indicators,
            n_colours=len(owners),
            numbers=(c_int32 * _COUNT)(*(NUMBERS[name] for name in self._names)),
            number=instance.site.number,
            fmi=int(fmu.fmi_version[0]),
            own_events=instance.own_events,
            completes=fmu.needs_completed_step,
            autonomous=states.autonomous and len(states.dependencies) == n,
        )

    def _kept(self, kind: type[c_uint | c_int32], numbers: Sequence[int]) -> int:
        array = (kind * len(numbers))(*numbers)
        self._memory.append(array)
        return addressof(array)

    def _bound(self, kind: type[ctypes._CFunctionType], name: str) -> Callable[..., int]:
        function = kind((f"cosim_exchange_{name}", self._library))
        return lambda *arguments: int(function(self.component, *arguments))

    def pointer(self, function: str) -> int:
        """Return the address; raises AttributeError if there is no such function."""
        version = self._instance.fmu.fmi_version
        if function in _STEPPING:
            symbol = f"cosim_exchange_{function}"
        elif function in self._names:
            if not self._instance.bare_pointer(function):
                raise AttributeError(function)
            states = dict(zip(_functions(version, ("", "")), _functions("3.0", ("", "")), strict=True))
            symbol = f"cosim_exchange_{states[function]}"
            if not hasattr(self._library, symbol):
                symbol = f"cosim_exchange{version[0]}_{function}"
        else:
            raise AttributeError(function)
        return cast(self._library[symbol], c_void_p).value or 0

    def failure(self) -> CallError | None:
        """Return why the last call has failed, in words."""
        instance, trouble = self._instance, _Trouble()
        if self._exchange is None:
            return None
        self._library.cosim_exchange_explain(c_void_p(self._exchange), byref(trouble))
        state = self._state(trouble.state)
        if trouble.kind == _NOT_FINITE:
            return failures.not_finite(instance, trouble.t, state)
        if trouble.kind == _STEP_TOO_SMALL:
            return failures.too_small(instance, trouble.t, trouble.h, state, self.tolerance)
        if trouble.kind == _SINGULAR:
            return failures.singular(instance, trouble.t, state)
        if trouble.kind == _NO_PROGRESS:
            return failures.no_progress(instance, trouble.t, trouble.h, state)
        if trouble.kind == _EVENTS_WITHOUT_END:
            return failures.without_end(instance, trouble.t)
        if trouble.kind == _UPDATES_WITHOUT_END:
            return failures.never_settles(instance)
        if trouble.kind == _EVENT_IN_THE_PAST:
            return failures.announces_the_past(instance, trouble.value)
        try:
            if trouble.kind == _WANTS_TO_END:
                instance.fail_to_go_on()
            if trouble.kind == _FUNCTION_FAILED:
                when = f" for t = {trouble.t:.9g} s"
                instance.check_call(self._names[trouble.function], trouble.status, when)
        except CallError as failure:
            return failure
        return None

    def _state(self, number: int) -> str:
        names = self._instance.fmu.states.names
        return names[number] if number < len(names) else f"state {number + 1}"

    def free(self) -> None:
        """Give the memory back."""
        if self._exchange is not None:
            self._library.cosim_exchange_delete(c_void_p(self._exchange))
            self._exchange = None


def _dense(n: int) -> list[list[int]]:
    return [[state] * n for state in range(n)]
