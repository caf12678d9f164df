"""The thesis's voltage-profile controller (section 3.5) as one function of the tick, after FACTS, "Controller".

``step`` is called at t_k = k T_compute, k = 0, 1, 2, ..., with what the plant shows at t_k; it returns what holds from
t_k on. The order within a tick:

1. ADC and moving average: the mean of the last N = max(1, floor(T_filter / T_compute + 0.5)) currents, this one
   included; the buffer starts with zeros and the sum is always divided by N.
2. Current hold and window: on every m-th tick (k mod m = 0, m = round(T_sample / T_compute)), tick 0 included, the hold
   takes the average, or 0 while t_k < T_blank; the window of the last n_window held values, zeros at first, takes it
   too; i_limit = i_gain max(min(window), i_no_load). Between these ticks both keep their values.
3. Park edges: against the value at the tick before, which counts as true before tick 0, as the drive starts on the
   contact. On a falling edge period = (t_k - t_last) / 2, or 1 s if that is below 0.1 s, then t_last = t_k; at the
   start t_last = 0 and period = 1 s.
4. Chart: at most one transition, with all of the above; the check of the transitions precedes the during action, and
   the entered state shows its output with elapsed = 0.

Decisions at open spots, with their reason:

* Time is counted in ticks, and two times within 1e-9 s of each other are equal (DESIGN, "When things happen"):
  after(T) fires when elapsed >= T - 1e-9, "elapsed > x" when elapsed > x + 1e-9. A guard of half a tick would not do:
  the period is a multiple of half a tick, so that every other revolution puts period - 2 Ts between two ticks.
* elapsed counts from entry into the named state. For RUN.RUN -> turn_point_dec this is RUN.RUN; since ro = 0 is
  required and only entry into the superstate RUN resets ro, it equals the time since that entry. The transition out
  of RUN on 2 period - 2 Ts counts from entry into the superstate.
* Tick 0 leaves IDLE at once when enabled (figure 3.12 starts at 0.7).
* Out of RUN on park: a rising edge at this tick. The contact on which the revolution began gives none until it has
  opened; an edge at the very tick of entry into RUN, or before it, is not seen.
* Both transitions out of RUN precede those inside; ro is set on any exit from turn_point_dec.
* Soft_stop -> IDLE -> Soft_start is one path in one tick while enabled (``idle_step`` makes it one tick of IDLE).
* When enable is low, the drive runs on to the contact: a rising edge of park leads from any state to IDLE, before
  every other transition; the transition on 2 period - 2 Ts is not taken, as it would stop the drive short of the
  contact; Soft_stop leads to IDLE only if the contact was reached at its start or in it, else on to Soft_start.
* ``duty_min`` floors the duty in every state but IDLE.
* T_delay holds back all outputs together by round(T_delay / T_compute) ticks; before the first, they are those of a
  controller at rest in IDLE with no current seen.
* ``i_filtered`` is the average of 1, not the held value; that one is ``i_real``.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from math import floor
from typing import NamedTuple

SAME_INSTANT = 1e-9
"""Two times closer than this are one [s]."""


class State(Enum):
    """States of the chart (figure 3.11), in the order in which a revolution passes them."""

    IDLE = "IDLE"
    SOFT_START = "Soft_start"
    RUN = "RUN.RUN"
    TURN_POINT_DEC = "RUN.turn_point_dec"
    TURN_POINT_ACC = "RUN.turn_point_acc"
    SOFT_STOP = "Soft_stop"


class Outputs(NamedTuple):
    """What the controller shows from a tick on."""

    duty: float
    state: State
    i_filtered: float
    i_limit: float
    period: float
    i_real: float
    """The current that the chart compares with i_limit."""


@dataclass(frozen=True)
class Parameters:
    """Of the controller's interface; values of table 3.5, B.1.6 and FACTS."""

    T_compute: float = 1e-3
    T_sample: float = 20e-3
    T_ramp: float = 0.1
    """Ts of the chart."""
    acc_val: float = 0.7
    turn_val: float = 0.7
    T_filter: float = 0.0
    n_window: int = 50
    i_no_load: float = 0.58
    i_gain: float = 1.03
    duty_min: float = 0.0
    T_blank: float = 0.3
    T_delay: float = 0.0
    T_soft_stop: float | None = None
    """Length of Soft_stop; None: T_ramp / 2 (the chart), figure 3.12 draws T_ramp."""
    idle_step: bool = False
    """Spend one tick in IDLE between two revolutions."""
    shape: Callable[[float], float] = float
    """Share of a ramp's height over that of its duration; a straight line by default."""

    def ticks(self, duration: float) -> int:
        """The number of ticks nearest to a duration, halves up."""
        return floor(duration / self.T_compute + 0.5)


class Controller:
    """Chart, period and current conditioning."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.p = p = parameters or Parameters()
        self.k = 0
        self._filter = deque([0.0] * max(1, p.ticks(p.T_filter)), maxlen=max(1, p.ticks(p.T_filter)))
        self._every = max(1, p.ticks(p.T_sample))
        self._window = deque([0.0] * p.n_window, maxlen=p.n_window)
        self._i_real = 0.0
        self._i_limit = p.i_gain * p.i_no_load
        self._last_park = True
        self._t_last = 0.0
        self._period = 1.0
        self._state = State.IDLE
        self._entry = 0
        self._run_entry = 0
        self._turned = False
        self._contact_reached = False
        at_rest = Outputs(0.0, State.IDLE, 0.0, self._i_limit, self._period, 0.0)
        self._delayed = deque([at_rest] * p.ticks(p.T_delay))

    def step(self, t: float, i_motor: float, park: bool, enable: bool) -> Outputs:
        """One tick; ``t`` must be k T_compute."""
        p, k = self.p, self.k
        if abs(t - k * p.T_compute) > SAME_INSTANT:
            raise ValueError(f"Tick {k} of the controller is at {k * p.T_compute} s, but was called at {t} s.")
        self._filter.append(i_motor)
        i_filtered = sum(self._filter) / len(self._filter)
        if k % self._every == 0:
            self._i_real = 0.0 if t < p.T_blank - SAME_INSTANT else i_filtered
            self._window.append(self._i_real)
            self._i_limit = p.i_gain * max(min(self._window), p.i_no_load)

        rising, falling = park and not self._last_park, self._last_park and not park
        self._last_park = park
        if falling:
            period = (t - self._t_last) / 2
            self._period = 1.0 if period < 0.1 - SAME_INSTANT else period
            self._t_last = t

        self._transition(rising, enable)
        result = Outputs(self._duty(), self._state, i_filtered, self._i_limit, self._period, self._i_real)
        self.k += 1
        self._delayed.append(result)
        return self._delayed.popleft()

    def _elapsed(self, entry: int) -> float:
        return (self.k - entry) * self.p.T_compute

    def _after(self, duration: float) -> bool:
        return self._elapsed(self._entry) >= duration - SAME_INSTANT

    def _soft_stop_time(self) -> float:
        return self.p.T_ramp / 2 if self.p.T_soft_stop is None else self.p.T_soft_stop

    def _transition(self, rising: bool, enable: bool) -> None:
        state, p = self._state, self.p
        if state is State.IDLE:
            if enable:
                self._enter(State.SOFT_START)
        elif rising and not enable:
            self._enter(State.IDLE)
        elif state is State.SOFT_START:
            if self._after(p.T_ramp):
                self._run_entry, self._turned = self.k, False
                self._enter(State.RUN)
        elif state is State.SOFT_STOP:
            self._contact_reached |= rising
            if self._after(self._soft_stop_time()):
                goes_on = (enable and not p.idle_step) or not (enable or self._contact_reached)
                self._enter(State.SOFT_START if goes_on else State.IDLE)
        else:
            self._transition_in_run(rising, enable)

    def _transition_in_run(self, rising: bool, enable: bool) -> None:
        p = self.p
        end = 2 * self._period - 2 * p.T_ramp + SAME_INSTANT
        if rising or (enable and self._turned and self._elapsed(self._run_entry) > end):
            self._contact_reached = rising
            self._enter(State.SOFT_STOP)
        elif self._state is State.RUN:
            half = self._period - 2 * p.T_ramp + SAME_INSTANT
            if self._elapsed(self._entry) > half and not self._turned and self._i_real < self._i_limit:
                self._enter(State.TURN_POINT_DEC)
        elif self._after(p.T_ramp):
            self._enter(State.TURN_POINT_ACC if self._state is State.TURN_POINT_DEC else State.RUN)

    def _enter(self, state: State) -> None:
        if self._state is State.TURN_POINT_DEC:
            self._turned = True
        self._state, self._entry = state, self.k

    def _duty(self) -> float:
        p, elapsed = self.p, self._elapsed(self._entry)
        ramp = p.shape(elapsed / p.T_ramp)
        match self._state:
            case State.IDLE:
                return 0.0
            case State.SOFT_START:
                y = p.acc_val + ramp * (1 - p.acc_val)
            case State.RUN:
                y = 1.0
            case State.TURN_POINT_DEC:
                y = 1 - ramp * p.turn_val
            case State.TURN_POINT_ACC:
                y = (1 - p.turn_val) + ramp * p.turn_val
            case State.SOFT_STOP:
                y = 1 - p.shape(elapsed / self._soft_stop_time()) * (1 - p.acc_val)
        return max(y, p.duty_min)
