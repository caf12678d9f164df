"""A Model Exchange FMU, presented to the loop as one that steps: its continuous states are integrated by CVode.

Between two steps the FMU is in Continuous-Time Mode until an input is set: that is an event, and restarts the solver.
The solver may go beyond the end of a step, with inputs as they are, and what is asked for is interpolated; if an input
changes, it is started again from there. Events within a step are handled where they are: roots of event indicators,
times that the FMU has announced, and those that fmi2CompletedIntegratorStep asks for.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from ctypes import CFUNCTYPE, POINTER, addressof, byref, c_bool, c_double, c_int, c_size_t, c_void_p, cast
from functools import partial
from math import inf, isfinite
from typing import Any, ClassVar

from fmpy.fmi2 import fmi2EventInfo

from cosim.engine._calls import Site
from cosim.engine._cvode import Cvode, CvodeError
from cosim.engine._evaluation import Evaluation
from cosim.engine._fmu import Fmu
from cosim.engine._instance import (
    EVENT_NEEDED,
    NEXT_EVENT_DEFINED,
    TERMINATE,
    UPDATE_NEEDED,
    UPDATE_TERMINATES,
    Access,
    CallError,
    Fmi2Instance,
    Fmi3Instance,
    Instance,
)
from cosim.engine._library import native_library
from cosim.engine._log import FAILED, STATUS
from cosim.engine._system import SAME_INSTANT

_MOST_UPDATES = 100
_MOST_EVENTS = 1000
"""At one instant."""

_LEAST_STEPS = 50
"""Into which a run is divided at least, so that no pair of events is stepped over."""

_FLAG = POINTER(c_bool)
_DO_STEP = CFUNCTYPE(c_int, c_void_p, c_double, c_double, c_bool, _FLAG, _FLAG, _FLAG, POINTER(c_double))
_UPDATE = CFUNCTYPE(c_int, c_void_p, _FLAG, _FLAG, _FLAG, _FLAG, _FLAG, POINTER(c_double))
_ENTER = CFUNCTYPE(c_int, c_void_p)
_SET = {
    2: CFUNCTYPE(c_int, c_void_p, c_void_p, c_size_t, c_void_p),
    3: CFUNCTYPE(c_int, c_void_p, c_void_p, c_size_t, c_void_p, c_size_t),
}
_SET_BINARY = CFUNCTYPE(c_int, c_void_p, c_void_p, c_size_t, c_void_p, c_void_p, c_size_t)


class ExchangeInstance(Instance):
    """What is common to Model Exchange in FMI 2.0 and 3.0.

    ``own_events`` tells that the loop leads the FMU through its events, those at the ends of steps; else each step
    ends with the events at its end handled. ``updates`` has changed values and nominals of the states in its bytes 2
    and 3, as fmi3UpdateDiscreteStates gives them.
    """

    plain_step = False
    names: ClassVar[tuple[str, str]]
    """Of the functions that give the rates of the states and update the discrete states."""
    _set_time: Callable[..., int]
    _set_states: Callable[..., int]
    _get_states: Callable[..., int]
    _get_nominals: Callable[..., int]
    _get_rates: Callable[..., int]
    _get_indicators: Callable[..., int]
    _event_mode: Callable[..., int]
    _continuous_time_mode: Callable[..., int]
    _complete: Callable[..., int]
    _new_states: Callable[..., int]
    _step_events: tuple[Any, Any]

    def __init__(self, name: str, fmu: Fmu, event_mode: bool, site: Site | None = None) -> None:
        """Instantiate; raises FmuError if the FMU refuses."""
        self.own_events = event_mode
        self._solver: Cvode | None = None
        self._evaluation: Evaluation | None = None
        self._failure: CallError | None = None  # of a call that has returned a bad status to the loop
        self._failed: tuple[str, int] | None = None  # function and status that have stopped the solver
        self._handed_on: list[object] = []  # callbacks, kept as long as the native loop may call them
        self._initialized = False
        self._in_events = self._dirty = True  # in Event Mode; its discrete states are to be updated
        self._stop: float | None = None
        self._tolerance = 0.0
        self._now = 0.0  # where the FMU is
        self._front = 0.0  # where the solver is, not before
        self._open = self._root = False  # its last step is not accepted yet; it has ended at a root
        self._next = inf  # time that the FMU has announced
        self._last, self._repeated = -inf, 0  # time of the last event, and how many there were
        super().__init__(name, fmu, event_mode, site)
        self.counts = dict.fromkeys(("steps", "rhs_evaluations", "state_events", "time_events", "step_events"), 0)

    def enter_initialization(self, tolerance: float, stop: float | None) -> None:
        """Enter Initialization Mode; tolerance and stop are for the solver, too."""
        self._tolerance, self._stop = tolerance, stop
        self._enter_initialization(tolerance, stop)

    def _bind_calls(self) -> None:
        self.do_step = self._do_step
        self.enter_event = self._guarded(self._enter_event)
        self.enter_step = self._guarded(self._enter_continuous_time)
        self.update = self._guarded(self._update)
        for name, function in (
            ("_set_time", "SetTime"),
            ("_set_states", "SetContinuousStates"),
            ("_get_states", "GetContinuousStates"),
            ("_get_nominals", "GetNominalsOfContinuousStates"),
            ("_get_rates", self.names[0]),
            ("_get_indicators", "GetEventIndicators"),
            ("_event_mode", "EnterEventMode"),
            ("_continuous_time_mode", "EnterContinuousTimeMode"),
        ):
            setattr(self, name, self._bind(self.symbol(function)))
        self._bind_own()

    @abstractmethod
    def _bind_own(self) -> None:
        """Bind what differs between the versions."""

    @abstractmethod
    def _enter_initialization(self, tolerance: float, stop: float | None) -> None: ...

    @abstractmethod
    def _update_discrete_states(self) -> int:
        """Update the discrete states once; fill in ``update_flags`` and ``next_event``, return the status."""

    @abstractmethod
    def _measure(self) -> tuple[int, int]:
        """Return how many states and event indicators there are."""

    # what the loop calls

    def access(self, verb: str, names: Sequence[str], address: int, sizes: int | None = None) -> Access:
        """Bind as for Co-Simulation; what sets variables leads the FMU into Event Mode first."""
        access = super().access(verb, names, address, sizes)
        if verb == "Get":
            return access
        bare = access.call

        def call() -> int:
            return self._before_inputs() or bare()

        return access._replace(call=call)

    def pointer(self, function: str) -> int:
        """Return the address of a function; those of the steps are Python's, for the native loop to call back."""
        if function == "DoStep":
            return self._hand_on(_DO_STEP(self._step_for_native))
        if function == "UpdateDiscreteStates":
            return self._hand_on(_UPDATE(self._update_for_native))
        if function == "EnterEventMode":
            return self._hand_on(_ENTER(lambda _: self.enter_event()))
        if function == "EnterStepMode":
            return self._hand_on(_ENTER(lambda _: self.enter_step()))
        if function.startswith("Set"):
            kind = _SET_BINARY if function == "SetBinary" else _SET[3 if self.tells_size else 2]
            bare = kind(super().pointer(function))

            def call(*arguments: object) -> int:
                return self._before_inputs() or self.site.noting(function, partial(bare, *arguments))()

            return self._hand_on(kind(call))
        return super().pointer(function)

    def _hand_on(self, callback: Any) -> int:  # noqa: ANN401 - a ctypes function
        self._handed_on.append(callback)
        return cast(callback, c_void_p).value or 0

    def _step_for_native(self, _: int, t: float, h: float, __: bool, event: Any, end: Any, ___: Any, ____: Any) -> int:  # noqa: ANN401
        self.t.value, self.h.value = t, h
        status = self.do_step()
        event[0] = bool(self.flags.value & EVENT_NEEDED)
        end[0] = bool(self.flags.value & TERMINATE)
        return status

    def _update_for_native(self, _: int, *places: Any) -> int:  # noqa: ANN401
        status = self.update()
        for byte, place in enumerate(places[:5]):
            place[0] = bool(self.update_flags.value >> (8 * byte) & 1)
        places[5][0] = self.next_event.value
        return status

    def exit_initialization(self) -> None:
        """Leave Initialization Mode, into Event Mode; the first events are handled unless the loop does that."""
        super().exit_initialization()
        self._initialized = True
        self._prepare(*self._measure())
        if not self.own_events:
            self._settle()

    def check(self, function: str, status: int) -> None:
        """Raise CallError for what has failed inside a step, or as for Co-Simulation."""
        if status >= FAILED and self._failure is not None:
            failure, self._failure = self._failure, None
            raise failure
        super().check(function, status)

    def free(self) -> None:
        """Free the solver, too."""
        if self._solver is not None:
            self._solver.free()
            self._solver = None
        super().free()

    # the steps

    def _do_step(self) -> int:
        self.flags.value = 0
        return self._guarded(self._step)()

    def _guarded(self, call: Callable[[], int]) -> Callable[[], int]:
        """Return the call with its failure kept for ``check``, which the loop asks."""

        def guarded() -> int:
            try:
                return call()
            except CallError as failure:
                self._failure = failure
                return FAILED

        return guarded

    def _step(self) -> int:
        """Integrate over the step, handling the events on the way."""
        target = self.t.value + self.h.value
        if self._in_events:
            if self._dirty:
                self._settle()
            self._enter_continuous_time()
        while self._front <= target + SAME_INSTANT:
            at_end = self._front >= target - SAME_INSTANT
            if (self._open and self._accept(at_end)) or at_end:
                return 0
            self._integrate(target)
        if self._solver is not None:
            self._place(target, self._solver.at(target))
        return 0

    def _integrate(self, target: float) -> None:
        """Take one step of the solver."""
        limit = self._limit()
        self._open, self._root = True, False
        if self._solver is None:
            self._front = min(limit, target)
        elif limit - self._front <= SAME_INSTANT:
            self._front = limit
        else:
            try:
                self._front, self._root = self._solver.step(limit if isfinite(limit) else self._front + 1.0)
            except CvodeError as error:
                failed = self._evaluation.failure if self._evaluation else self._failed
                if failed is not None:
                    Instance.check(self, *failed)
                raise CallError(
                    self,
                    f"CVode cannot go on from {self._front:.9g} s: {error}",
                    "check its parameters and its inputs at that time, or try another tolerance",
                ) from error
            self.counts["steps"] += 1
            if self._evaluation:
                self.counts["rhs_evaluations"] = self._evaluation.evaluations

    def _accept(self, at_end: bool) -> bool:
        """Put the FMU to the end of a step of the solver, handle what happens there; tell whether the step ends."""
        self._open = False
        self._place(self._front, self._solver.states if self._solver is not None else 0)
        wanted = self._completed()
        if self.flags.value & TERMINATE:
            return True
        timed = self._front >= self._next - SAME_INSTANT
        if not (wanted or timed or self._root):
            return False
        self._count_event("time_events" if timed else "state_events" if self._root else "step_events")
        if at_end and self.own_events:
            self.flags.value |= EVENT_NEEDED
            return True
        self._enter_event()
        self._settle()
        if not at_end:
            self._enter_continuous_time()
        return at_end  # then it stays in Event Mode, where inputs may be set

    def _completed(self) -> bool:
        """Tell the FMU that a step is accepted; return whether it wants an event."""
        if not self.fmu.needs_completed_step:
            return False
        self._call("CompletedIntegratorStep", self._complete())
        wanted, ended = self._step_events
        if ended.value:
            self.flags.value |= TERMINATE
        return bool(wanted.value)

    def _count_event(self, kind: str) -> None:
        self.counts[kind] += 1
        self._repeated = self._repeated + 1 if self._front - self._last <= SAME_INSTANT else 0
        self._last = self._front
        if self._repeated == _MOST_EVENTS:
            raise CallError(
                self,
                f"has had {_MOST_EVENTS} events at {self._front:.9g} s",
                "look for an event that sets itself off, or for ever shorter intervals between events",
            )

    def _place(self, t: float, states: int) -> None:
        self._now = t
        self._call("SetTime", self._set_time(c_double(t)))
        if self.n_states:
            self._call("SetContinuousStates", self._set_states(c_void_p(states), c_size_t(self.n_states)))

    # the modes

    def _before_inputs(self) -> int:
        """Make sure that inputs may be set: from initialisation on that is in Event Mode; return the status."""
        self._dirty = True
        return self.enter_event() if self._initialized else 0

    def _enter_event(self) -> int:
        if not self._in_events:
            self._call("EnterEventMode", self._event_mode())
            self._in_events = True
        self._dirty = True
        return 0

    def _settle(self) -> None:
        """Update the discrete states until they rest."""
        for _ in range(_MOST_UPDATES):
            self._update()
            if self.update_flags.value & UPDATE_TERMINATES:
                self.fail_to_go_on()
            if not self.update_flags.value & UPDATE_NEEDED:
                break
        else:
            raise CallError(
                self,
                f"still needs to update its discrete states after {_MOST_UPDATES} updates",
                "break the cycle of events inside it",
            )
        if self._next <= self._now + SAME_INSTANT:
            raise CallError(
                self,
                f"announces its next event at {self._next:.9g} s, which is not after the present one",
                "check its sample period",
            )

    def _update(self) -> int:
        self._call(self.names[1], self._update_discrete_states())
        self._next = self.next_event.value if self.update_flags.value & NEXT_EVENT_DEFINED else inf
        self._dirty = False
        return 0

    def _enter_continuous_time(self) -> int:
        """Leave Event Mode, and start the solver from the states that the FMU has now."""
        self._call("EnterContinuousTimeMode", self._continuous_time_mode())
        self._in_events = self._open = self._root = False
        self._front = self._now
        if self._solver is not None:
            n = c_size_t(self.n_states)
            if self.n_states:
                self._call("GetContinuousStates", self._get_states(self._states, n))
                self._call("GetNominalsOfContinuousStates", self._get_nominals(self._nominals, n))
            limit = self._limit()
            stop = limit if isfinite(limit) and limit > self._now + SAME_INSTANT else None
            self._solver.start(self._now, addressof(self._states), addressof(self._nominals), stop)
        return 0

    def _limit(self) -> float:
        """Return the time [s] beyond which the solver must not go."""
        return self._next if self._stop is None else min(self._next, self._stop)

    def _prepare(self, n_states: int, n_indicators: int) -> None:
        """Make the solver; a system without states has one that rests, so that its indicators are watched."""
        self.n_states, self.n_indicators = n_states, n_indicators
        size = max(n_states, 1)
        self._states, self._nominals = (c_double * size)(*[1.0] * size), (c_double * size)(*[1.0] * size)
        if n_states or n_indicators:
            longest = inf if self._stop is None else self._stop / _LEAST_STEPS
            native = self._evaluation = self._native_evaluation()
            self._solver = Cvode(
                size,
                n_indicators,
                native.rates if native else self._rates,
                native.indicators if native else self._indicators,
                self._tolerance,
                longest,
                native.data if native else 0,
            )

    def _native_evaluation(self) -> Evaluation | None:
        """Return the functions that CVode calls in C; None without a library, so that those here are called."""
        library = native_library()
        if library is None:
            return None
        names = ("SetTime", "SetContinuousStates", self.names[0], "GetEventIndicators")
        pointers = [super(ExchangeInstance, self).pointer(name) for name in names]
        sizes = (self.n_states, self.n_indicators)
        return Evaluation(library, self.component, names, pointers, sizes, self.site)

    def _rates(self, t: float, states: int, rates: int) -> int:
        self.counts["rhs_evaluations"] += 1
        status = self._set_time(c_double(t))
        if not self.n_states:
            c_double.from_address(rates).value = 0.0
            return self._outcome("SetTime", status)
        n = c_size_t(self.n_states)
        status = max(status, self._set_states(c_void_p(states), n))
        if status < FAILED:
            status = self._get_rates(c_void_p(rates), n)
        return self._outcome(self.names[0], status)

    def _indicators(self, t: float, states: int, indicators: int) -> int:
        status = self._set_time(c_double(t))
        if self.n_states:
            status = max(status, self._set_states(c_void_p(states), c_size_t(self.n_states)))
        if status < FAILED:
            status = self._get_indicators(c_void_p(indicators), c_size_t(self.n_indicators))
        return self._outcome("GetEventIndicators", status)

    def _outcome(self, function: str, status: int) -> int:
        """Return what CVode is told: it may try a shorter step if the FMU discards this one."""
        if status < FAILED:
            return 0
        if status == STATUS.index("Discard"):
            return 1
        self._failed = (function, status)
        return -1

    def _call(self, function: str, status: int) -> None:
        if status >= FAILED:
            super().check(function, status)


class Fmi2Exchange(ExchangeInstance, Fmi2Instance):
    """Model Exchange in FMI 2.0."""

    _enter_initialization = Fmi2Instance.enter_initialization
    names = ("GetDerivatives", "NewDiscreteStates")

    def _instantiate(self, event_mode: bool, logging: bool) -> None:
        Fmi2Instance._instantiate(self, event_mode, logging)

    def _bind_own(self) -> None:
        self._info = fmi2EventInfo()
        self._step_events = (c_int(), c_int())
        self._new_states = self._bind("fmi2NewDiscreteStates", byref(self._info))
        self._complete = self._bind("fmi2CompletedIntegratorStep", c_int(1), *map(byref, self._step_events))

    def _measure(self) -> tuple[int, int]:
        return self.fmu.n_states_and_indicators

    def _update_discrete_states(self) -> int:
        status = self._new_states()
        info = self._info
        flags = (
            info.newDiscreteStatesNeeded,
            info.terminateSimulation,
            info.nominalsOfContinuousStatesChanged,
            info.valuesOfContinuousStatesChanged,
            info.nextEventTimeDefined,
        )
        self.update_flags.value = sum(bool(flag) << (8 * byte) for byte, flag in enumerate(flags))
        self.next_event.value = info.nextEventTime
        return status


class Fmi3Exchange(ExchangeInstance, Fmi3Instance):
    """Model Exchange in FMI 3.0."""

    _enter_initialization = Fmi3Instance.enter_initialization
    names = ("GetContinuousStateDerivatives", "UpdateDiscreteStates")

    def _instantiate(self, event_mode: bool, logging: bool) -> None:
        log = self.log
        self._slave.instantiate(
            loggingOn=logging,
            logMessage=lambda environment, status, category, message: log.add(status, message),
        )

    def _bind_own(self) -> None:
        self._step_events = (c_bool(), c_bool())
        updates = [c_void_p(addressof(self.update_flags) + byte) for byte in range(5)]
        next_event = c_void_p(addressof(self.next_event))
        self._new_states = self._bind("fmi3UpdateDiscreteStates", *updates, next_event)
        self._complete = self._bind("fmi3CompletedIntegratorStep", c_bool(True), *map(byref, self._step_events))

    def _update_discrete_states(self) -> int:
        return self._new_states()

    def _measure(self) -> tuple[int, int]:
        return self._slave.getNumberOfContinuousStates(), self._slave.getNumberOfEventIndicators()
