"""What faults remember: how far each is, and the histories of delayed signals, as far as they are still needed."""

from __future__ import annotations

import math
from array import array
from ctypes import sizeof

from cosim.engine.native._structures import FaultClock, FaultState
from cosim.engine.signals._signal_faults import MOST_NEW_POINTS, SignalFault, SignalFaults

_STATE, _CLOCK = sizeof(FaultState), sizeof(FaultClock)
_POINT = 16


class FaultMemory:
    """All of it for one run: the clock, and for each fault its state and its points in use."""

    def __init__(self, faults: SignalFaults) -> None:
        """Keep the faults."""
        self._clock = faults.clock
        self._faults = [fault for one in faults.inputs for fault in one.faults]

    def to_bytes(self) -> bytes:
        """Return the clock and the faults, one after the other."""
        return bytes(self._clock) + b"".join(map(_bytes_of, self._faults))

    def from_bytes(self, content: bytes) -> None:
        """Take that over; raises ValueError if a fault could not have come to such a state."""
        clock = FaultClock.from_buffer_copy(content)
        if math.isnan(clock.next) or not math.isfinite(clock.time):
            raise ValueError("no time")
        rest = content[_CLOCK:]
        for fault in self._faults:
            rest = _take(fault, rest)
        if rest:
            raise ValueError("too long")
        self._clock.time, self._clock.next = clock.time, clock.next
        self._clock.changed = bool(clock.changed)
        self._clock.stepping = self._clock.full = 0


def _bytes_of(fault: SignalFault) -> bytes:
    """Return a state whose points begin at 0, and these."""
    state = FaultState.from_buffer_copy(fault.state)
    points = fault.points[2 * state.first : 2 * state.count]
    state.jump, state.count, state.first = state.jump - state.first, state.count - state.first, 0
    return bytes(state) + points.tobytes()


def _take(fault: SignalFault, content: bytes) -> bytes:
    """Take over what is at the front; return what follows."""
    state = FaultState.from_buffer_copy(content)
    end = _STATE + _POINT * state.count
    possible = (
        state.first == 0
        and 0 <= state.jump <= state.count
        and len(content) >= end
        and -1 <= state.period < max(1, len(fault.draws))
        and (fault.is_delay or state.count == 0)
        and (not state.active or (state.period >= 0 and (state.count > 0 or not fault.is_delay)))
    )
    if not possible:
        raise ValueError("no state of this fault")
    while fault.is_delay and fault.capacity < state.count + MOST_NEW_POINTS:
        fault.grow()
    fault.points[: 2 * state.count] = array("d", content[_STATE:end])
    memoryview(fault.state).cast("B")[:] = content[:_STATE]
    return content[end:]
