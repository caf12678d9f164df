"""Model Exchange in plain Python, for where there is no native library: integrated by CVode, as a reference."""

from __future__ import annotations

from collections.abc import Callable
from math import inf

from cosim.engine.exchange._exchange import ExchangeInstance, Stepper
from cosim.engine.exchange._exchange_failures import (
    MOST_EVENTS,
    MOST_UPDATES,
    announces_the_past,
    never_settles,
    without_end,
)
from cosim.engine.exchange._integration import Functions, Integration
from cosim.engine.fmu._instance import (
    EVENT_NEEDED,
    NEXT_EVENT_DEFINED,
    TERMINATE,
    UPDATE_NEEDED,
    UPDATE_TERMINATES,
    CallError,
)
from cosim.engine.fmu._log import FAILED
from cosim.engine.system._system import SAME_INSTANT
from cosim.errors import BuildError


class PythonStepper(Stepper):
    """Leads the FMU through its modes as native/exchange.c does."""

    _integration: Integration
    """From the end of initialisation on."""

    def __init__(self, instance: ExchangeInstance) -> None:
        """Bind what is called."""
        self._instance = instance
        self._failure: CallError | None = None
        self._in_events = self._dirty = True  # in Event Mode; its discrete states are to be updated
        self._stop: float | None = None
        self._front = 0.0  # where the solver is, not before
        self._open = self._root = False  # its last step is not accepted yet; it has ended at a root
        self._next = inf  # time that the FMU has announced
        self._last, self._repeated = -inf, 0  # time of the last event, and how many there were
        self._began = False
        self._counts = dict.fromkeys(("steps", "rhs_evaluations", "state_events", "time_events", "step_events"), 0)
        self.do_step = self._do_step
        self.enter_event = self._guarded(self._enter_event)
        self.enter_step = self._guarded(self._enter_continuous_time)
        self.update = self._guarded(self._update)
        self.before_inputs = self._before_inputs
        bind = instance.bind
        self._functions = Functions(
            bind("SetTime"),
            bind("SetContinuousStates"),
            bind("GetContinuousStates"),
            bind("GetNominalsOfContinuousStates"),
            bind(instance.names[0]),
            bind("GetEventIndicators"),
        )
        self._event_mode = bind("EnterEventMode")
        self._continuous_time_mode = bind("EnterContinuousTimeMode")

    @property
    def counts(self) -> dict[str, int]:
        """What CVode has done, and the events."""
        return self._counts

    @property
    def component(self) -> int:
        """The FMU's own handle."""
        return self._instance.bare_component

    def begin(self, tolerance: float, stop: float | None) -> int:
        """Make CVode; raises FmuError if there is none for this computer."""
        instance = self._instance
        self._stop = stop
        self._integration = Integration(instance, self._counts, self._functions, instance.measure(), tolerance, stop)
        self._began = True
        if not instance.own_events:
            self._settle()
        return 0

    def failure(self) -> CallError | None:
        """Return it."""
        failure, self._failure = self._failure, None
        return failure

    def pointer(self, function: str) -> int:
        """Refuse: a loop that wants addresses is one that has been compiled, and with it the other stepper."""
        raise BuildError(f"the native loop cannot call {function} of a Model Exchange FMU that Python leads")

    def free(self) -> None:
        """Free CVode."""
        if self._began:
            self._integration.free()

    def _guarded(self, call: Callable[[], int]) -> Callable[[], int]:
        """Return the call with its failure kept for whoever checks its status."""

        def guarded() -> int:
            try:
                return call()
            except CallError as failure:
                self._failure = failure
                return FAILED

        return guarded

    def _do_step(self) -> int:
        self._instance.flags.value = 0
        return self._guarded(self._step)()

    def _step(self) -> int:
        """Integrate over the step, handling the events on the way."""
        target = self._instance.t.value + self._instance.h.value
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
        flags = self._instance.flags
        self._open = False
        self._integration.put_to_end(self._front)
        wanted = self._completed()
        if flags.value & TERMINATE:
            return True
        timed = self._front >= self._next - SAME_INSTANT
        if not (wanted or timed or self._root):
            return False
        self._count_event("time_events" if timed else "state_events" if self._root else "step_events")
        if at_end and self._instance.own_events:
            flags.value |= EVENT_NEEDED
            return True
        self._enter_event()
        self._settle()
        if not at_end:
            self._enter_continuous_time()
        return at_end  # then it stays in Event Mode, where inputs may be set

    def _completed(self) -> bool:
        """Tell the FMU that a step is accepted; return whether it wants an event."""
        if not self._instance.fmu.needs_completed_step:
            return False
        self._call("CompletedIntegratorStep", self._instance.complete())
        wanted, ended = self._instance.step_events
        if ended.value:
            self._instance.flags.value |= TERMINATE
        return bool(wanted.value)

    def _count_event(self, kind: str) -> None:
        self._counts[kind] += 1
        self._repeated = self._repeated + 1 if self._front - self._last <= SAME_INSTANT else 0
        self._last = self._front
        if self._repeated == MOST_EVENTS:
            raise without_end(self._instance, self._front)

    def _before_inputs(self) -> int:
        """Be in Event Mode."""
        self._dirty = True
        return self.enter_event()

    def _enter_event(self) -> int:
        if not self._in_events:
            self._call("EnterEventMode", self._event_mode())
            self._in_events = True
        self._dirty = True
        return 0

    def _settle(self) -> None:
        """Update the discrete states until they rest."""
        flags = self._instance.update_flags
        for _ in range(MOST_UPDATES):
            self._update()
            if flags.value & UPDATE_TERMINATES:
                self._instance.fail_to_go_on()
            if not flags.value & UPDATE_NEEDED:
                break
        else:
            raise never_settles(self._instance)
        if self._next <= self._integration.now + SAME_INSTANT:
            raise announces_the_past(self._instance, self._next)

    def _update(self) -> int:
        instance = self._instance
        self._call(instance.names[1], instance.update_discrete_states())
        self._next = instance.next_event.value if instance.update_flags.value & NEXT_EVENT_DEFINED else inf
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
            self._instance.check_call(function, status)
