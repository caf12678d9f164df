"""The continuous states of a Model Exchange FMU, integrated by CVode through the FMU's own functions.

A system without states has one that rests, so that its event indicators are watched.
"""

from __future__ import annotations

from collections.abc import Callable
from ctypes import addressof, c_double, c_size_t, c_void_p
from math import inf, isfinite
from typing import NamedTuple

from cosim.engine.exchange._cvode import Cvode, CvodeError, Step
from cosim.engine.exchange._exchange import ExchangeInstance
from cosim.engine.fmu._instance import CallError
from cosim.engine.fmu._log import FAILED, STATUS
from cosim.engine.system._system import SAME_INSTANT

_LEAST_STEPS = 50
"""Into which a run is divided at least, so that no pair of events is stepped over."""


class Functions(NamedTuple):
    """Those of the FMU that concern its continuous states; each returns the FMI status."""

    set_time: Callable[..., int]
    set_states: Callable[..., int]
    get_states: Callable[..., int]
    get_nominals: Callable[..., int]
    get_rates: Callable[..., int]
    get_indicators: Callable[..., int]


class Integration:
    """The solver of one instance, which calls ``functions``; ``now`` is where the FMU is [s].

    ``sizes`` are the numbers of states and indicators. It counts in ``counts``.
    """

    def __init__(
        self,
        instance: ExchangeInstance,
        counts: dict[str, int],
        functions: Functions,
        sizes: tuple[int, int],
        tolerance: float,
        stop: float | None,
    ) -> None:
        """Make the solver, for a run to ``stop`` [s]; raises FmuError if there is no CVode for this computer."""
        self.now = 0.0
        self._instance = instance
        self._functions = functions
        self._counts = counts
        self.n_states, self.n_indicators = sizes
        self._solver: Cvode | None = None
        self._failed: tuple[str, int] | None = None  # function and status that have stopped the solver
        size = max(self.n_states, 1)
        self._states, self._nominals = (c_double * size)(*[1.0] * size), (c_double * size)(*[1.0] * size)
        if not any(sizes):
            return
        self._solver = Cvode(
            size,
            self.n_indicators,
            self._rates,
            self._indicators,
            tolerance,
            inf if stop is None else stop / _LEAST_STEPS,
        )

    def start(self, limit: float) -> None:
        """Start from the states that the FMU has now; never go beyond ``limit`` [s]."""
        if self._solver is None:
            return
        n = c_size_t(self.n_states)
        if self.n_states:
            self._call("GetContinuousStates", self._functions.get_states(self._states, n))
            self._call("GetNominalsOfContinuousStates", self._functions.get_nominals(self._nominals, n))
        stop = limit if isfinite(limit) and limit > self.now + SAME_INSTANT else None
        self._solver.start(self.now, addressof(self._states), addressof(self._nominals), stop)

    def step(self, t: float, target: float, limit: float) -> Step:
        """Take one step of the solver from t, towards ``target``, not beyond ``limit`` [s]; raises CallError."""
        if self._solver is None:
            return Step(min(limit, target), False)
        if limit - t <= SAME_INSTANT:
            return Step(limit, False)
        try:
            step = self._solver.step(limit if isfinite(limit) else t + 1.0)
        except CvodeError as error:
            if self._failed is not None:
                self._call(*self._failed)
            raise CallError(
                self._instance,
                f"CVode cannot go on from {t:.9g} s: {error}",
                "check its parameters and its inputs at that time, or try another tolerance",
            ) from error
        self._counts["steps"] += 1
        return step

    def put_to_end(self, t: float) -> None:
        """Put the FMU to t [s], where the solver's last step has ended."""
        self._place(t, self._solver.states if self._solver is not None else 0)

    def put_within(self, t: float) -> None:
        """Put the FMU to t [s], within the solver's last step."""
        if self._solver is not None:
            self._place(t, self._solver.at(t))

    def free(self) -> None:
        """Free the solver."""
        if self._solver is not None:
            self._solver.free()
            self._solver = None

    def _place(self, t: float, states: int) -> None:
        self.now = t
        self._call("SetTime", self._functions.set_time(c_double(t)))
        if self.n_states:
            status = self._functions.set_states(c_void_p(states), c_size_t(self.n_states))
            self._call("SetContinuousStates", status)

    def _rates(self, t: float, states: int, rates: int) -> int:
        self._counts["rhs_evaluations"] += 1
        status = self._functions.set_time(c_double(t))
        if not self.n_states:
            c_double.from_address(rates).value = 0.0
            return self._outcome("SetTime", status)
        n = c_size_t(self.n_states)
        status = max(status, self._functions.set_states(c_void_p(states), n))
        if status < FAILED:
            status = self._functions.get_rates(c_void_p(rates), n)
        return self._outcome(self._instance.names[0], status)

    def _indicators(self, t: float, states: int, indicators: int) -> int:
        status = self._functions.set_time(c_double(t))
        if self.n_states:
            status = max(status, self._functions.set_states(c_void_p(states), c_size_t(self.n_states)))
        if status < FAILED:
            status = self._functions.get_indicators(c_void_p(indicators), c_size_t(self.n_indicators))
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
        self._instance.check_call(function, status)
