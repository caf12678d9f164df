"""A Model Exchange FMU, presented to the loop as one that steps: with a solver, and led through its events.

Between two steps the FMU is in Continuous-Time Mode until an input is set: that is an event, and restarts the solver.
The solver may go beyond the end of a step, with inputs as they are, and what is asked for is interpolated; if an input
changes, it is started again from there. Events within a step are handled where they are: roots of event indicators,
times that the FMU has announced, and those that it asks for after a step of the solver.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from ctypes import CFUNCTYPE, c_bool, c_int, c_void_p
from typing import Any, ClassVar

from cosim.engine.fmu._calls import Site
from cosim.engine.fmu._fmu import Fmu
from cosim.engine.fmu._instance import Access, Call, CallError, Instance
from cosim.engine.fmu._log import FAILED


class Stepper(ABC):
    """What integrates and leads one FMU: calls as a Co-Simulation FMU has them, which return the FMI status.

    ``counts`` is what the solver has done. ``component`` is the instance, and ``pointer`` the address of a function for
    it, for the native loop.
    """

    do_step: Call
    enter_event: Call
    enter_step: Call
    update: Call
    before_inputs: Call
    """Makes sure that inputs may be set."""
    tolerance: float = 0.0
    """Relative, of the solver, for messages."""

    @property
    @abstractmethod
    def counts(self) -> dict[str, int]: ...

    @property
    @abstractmethod
    def component(self) -> int: ...

    @abstractmethod
    def begin(self, tolerance: float, stop: float | None) -> int:
        """Make the solver, for a run to ``stop`` [s] with a relative tolerance; handle the first events."""

    @abstractmethod
    def failure(self) -> CallError | None:
        """Return why the last call has failed, once."""

    @abstractmethod
    def pointer(self, function: str) -> int:
        """Return the address of a function by its FMI name without prefix, as it is for Co-Simulation in FMI 3.0."""

    @abstractmethod
    def free(self) -> None:
        """Free the solver."""


class ExchangeInstance(Instance):
    """What is common to Model Exchange in FMI 2.0 and 3.0.

    ``own_events`` tells that the loop leads the FMU through its events, those at the ends of steps; else each step
    ends with the events at its end handled. ``updates`` has changed values and nominals of the states in its bytes 2
    and 3, as fmi3UpdateDiscreteStates gives them.
    """

    plain_step = False
    names: ClassVar[tuple[str, str]]
    """Of the functions that give the rates of the states and update the discrete states."""
    complete: Callable[..., int]
    """Tells of an accepted step, and fills ``step_events``: whether the FMU wants an event, or the end."""
    step_events: tuple[Any, Any]
    _stepper: Stepper

    def __init__(self, name: str, fmu: Fmu, event_mode: bool, site: Site | None = None) -> None:
        """Instantiate; raises FmuError if the FMU refuses."""
        self.own_events = event_mode
        self._initialized = False
        self._stop: float | None = None
        self._tolerance = 0.0
        super().__init__(name, fmu, event_mode, site)

    def enter_initialization(self, tolerance: float, stop: float | None) -> None:
        """Enter Initialization Mode; tolerance and stop are for the solver, too."""
        self._tolerance, self._stop = tolerance, stop
        self._enter_initialization(tolerance, stop)

    def _bind_calls(self) -> None:
        self.no_return = c_bool(True)
        self._bind_own()
        self._stepper = self._make_stepper()
        self.do_step = self._stepper.do_step
        self.enter_event = self._stepper.enter_event
        self.enter_step = self._stepper.enter_step
        self.update = self._stepper.update

    @abstractmethod
    def _bind_own(self) -> None:
        """Bind what differs between the versions."""

    @abstractmethod
    def _make_stepper(self) -> Stepper: ...

    @abstractmethod
    def _enter_initialization(self, tolerance: float, stop: float | None) -> None: ...

    @abstractmethod
    def update_discrete_states(self) -> int:
        """Update the discrete states once; fill in ``update_flags`` and ``next_event``, return the status."""

    @abstractmethod
    def measure(self) -> tuple[int, int]:
        """Return how many states and event indicators there are."""

    @property
    def counts(self) -> dict[str, int]:
        """What the solver has done."""
        return self._stepper.counts

    @property
    def component(self) -> int:
        """The instance that steps, for the functions of ``pointer``."""
        return self._stepper.component

    @property
    def bare_component(self) -> int:
        """The FMU's own handle."""
        return super().component

    def bind(self, function: str, *arguments: object) -> Call:
        """Return the FMU's function of that name without prefix, with its first arguments."""
        return self._bind(self.symbol(function), *arguments)

    def bare_pointer(self, function: str) -> int:
        """Return the address of the FMU's own function, 0 if it has none."""
        try:
            return super().pointer(function)
        except AttributeError:
            return 0

    def access(self, verb: str, names: Sequence[str], address: int, sizes: int | None = None) -> Access:
        """Bind as for Co-Simulation; what sets variables leads the FMU into Event Mode first."""
        access = super().access(verb, names, address, sizes)
        if verb == "Get":
            return access
        bare = access.call

        def call() -> int:
            return (self._stepper.before_inputs() if self._initialized else 0) or bare()

        return access._replace(call=call)

    def pointer(self, function: str) -> int:
        """Return the address of a function for ``component``."""
        return self._stepper.pointer(function)

    def _state(self, verb: str, place: c_void_p) -> None:
        function = self.state_symbol(verb)
        call = CFUNCTYPE(c_int, c_void_p, c_void_p)(self.pointer(function))
        self.check(function, call(self.component, place))

    def exit_initialization(self) -> None:
        """Leave Initialization Mode, into Event Mode; the first events are handled unless the loop does that."""
        super().exit_initialization()
        self._initialized = True
        self.check("NewDiscreteStates", self._stepper.begin(self._tolerance, self._stop))

    def go_on(self, tolerance: float) -> None:
        """Take it that a state of after initialisation was set, in a run with this relative tolerance."""
        self._tolerance = self._stepper.tolerance = tolerance
        self._initialized = True

    def check(self, function: str, status: int) -> None:
        """Raise CallError for what has failed inside a step, or as for Co-Simulation."""
        if status >= FAILED:
            failure = self._stepper.failure()
            if failure is not None:
                raise failure
        self.check_call(function, status)

    def check_call(self, function: str, status: int, when: str = "") -> None:
        """Raise CallError if a call of the FMU itself has failed; ``when`` ends the sentence."""
        try:
            Instance.check(self, function, status)
        except CallError as failure:
            failure.what += when
            raise

    def free(self) -> None:
        """Free the solver, too."""
        self._stepper.free()
        super().free()
