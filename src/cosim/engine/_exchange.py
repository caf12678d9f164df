"""A Model Exchange FMU, presented to the loop as one that steps: integrated by CVode, and led through its events.

Between two steps the FMU is in Continuous-Time Mode until an input is set: that is an event, and restarts the solver.
The solver may go beyond the end of a step, with inputs as they are, and what is asked for is interpolated; if an input
changes, it is started again from there. Events within a step are handled where they are: roots of event indicators,
times that the FMU has announced, and those that fmi2CompletedIntegratorStep asks for.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from math import inf
from typing import Any, ClassVar

from cosim.engine._callbacks import Callbacks
from cosim.engine._calls import Site
from cosim.engine._fmu import Fmu
from cosim.engine._instance import (
    EVENT_NEEDED,
    NEXT_EVENT_DEFINED,
    TERMINATE,
    UPDATE_NEEDED,
    UPDATE_TERMINATES,
    Access,
    CallError,
    Instance,
)
from cosim.engine._integration import Functions, Integration
from cosim.engine._log import FAILED
from cosim.engine._system import SAME_INSTANT

_MOST_UPDATES = 100
_MOST_EVENTS = 1000
"""At one instant."""


class ExchangeInstance(Instance):
    """What is common to Model Exchange in FMI 2.0 and 3.0.

    ``own_events`` tells that the loop leads the FMU through its events, those at the ends of steps; else each step
    ends with the events at its end handled. ``updates`` has changed values and nominals of the states in its bytes 2
    and 3, as fmi3UpdateDiscreteStates gives them.
    """

    plain_step = False
    names: ClassVar[tuple[str, str]]
    """Of the functions that give the rates of the states and update the discrete states."""
    _functions: Functions
    _integration: Integration
    """From the end of initialisation on."""
    _event_mode: Callable[..., int]
    _continuous_time_mode: Callable[..., int]
    _complete: Callable[..., int]
    _new_states: Callable[..., int]
    _step_events: tuple[Any, Any]

    def __init__(self, name: str, fmu: Fmu, event_mode: bool, site: Site | None = None) -> None:
        """Instantiate; raises FmuError if the FMU refuses."""
        self.own_events = event_mode
        self._failure: CallError | None = None  # of a call that has returned a bad status to the loop
        self._callbacks = Callbacks(self)
        self._initialized = False
        self._in_events = self._dirty = True  # in Event Mode; its discrete states are to be updated
        self._stop: float | None = None
        self._tolerance = 0.0
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
        bind = self._bind
        self._functions = Functions(
            bind(self.symbol("SetTime")),
            bind(self.symbol("SetContinuousStates")),
            bind(self.symbol("GetContinuousStates")),
            bind(self.symbol("GetNominalsOfContinuousStates")),
            bind(self.symbol(self.names[0])),
            bind(self.symbol("GetEventIndicators")),
        )
        self._event_mode = bind(self.symbol("EnterEventMode"))
        self._continuous_time_mode = bind(self.symbol("EnterContinuousTimeMode"))
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
        own = self._callbacks.mode(function)
        if own is not None:
            return own
        if function.startswith("Set"):
            return self._callbacks.setter(function, super().pointer(function), self._before_inputs)
        return super().pointer(function)

    def exit_initialization(self) -> None:
        """Leave Initialization Mode, into Event Mode; the first events are handled unless the loop does that."""
        super().exit_initialization()
        names = ("SetTime", "SetContinuousStates", self.names[0], "GetEventIndicators")
        pointers = [super(ExchangeInstance, self).pointer(name) for name in names]
        sizes = self._measure()
        self._integration = Integration(self, self._functions, names, pointers, sizes, self._tolerance, self._stop)
        self._initialized = True
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
        if self._initialized:
            self._integration.free()
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
        self._integration.put_within(target)
        return 0

    def _integrate(self, target: float) -> None:
        """Take one step of the solver."""
        self._open, self._root = True, False
        self._front, self._root = self._integration.step(self._front, target, self._limit())

    def _accept(self, at_end: bool) -> bool:
        """Put the FMU to the end of a step of the solver, handle what happens there; tell whether the step ends."""
        self._open = False
        self._integration.put_to_end(self._front)
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
        if self._next <= self._integration.now + SAME_INSTANT:
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
        self._front = self._integration.now
        self._integration.start(self._limit())
        return 0

    def _limit(self) -> float:
        """Return the time [s] beyond which the solver must not go."""
        return self._next if self._stop is None else min(self._next, self._stop)

    def _call(self, function: str, status: int) -> None:
        if status >= FAILED:
            super().check(function, status)
