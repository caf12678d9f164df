"""A component in a running simulation: takes its inputs from the signals, is computed, puts its outputs there."""

from __future__ import annotations

import math
from array import array
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeAlias

from cosim.engine._instance import (
    EARLY_RETURN,
    EVENT_NEEDED,
    NEXT_EVENT_DEFINED,
    TERMINATE,
    UPDATE_NEEDED,
    UPDATE_TERMINATES,
    Call,
    CallError,
    Instance,
)
from cosim.engine._log import FAILED
from cosim.engine._role import Role
from cosim.engine._system import SAME_INSTANT

_MOST_UPDATES = 100

Buffer: TypeAlias = "array[Any] | None"
"""Memory of an FMI call that does not use the doubles of the signals themselves."""


class Wire(NamedTuple):
    """``inputs[target] = factor * values[source] + offset``."""

    target: int
    source: int
    factor: float
    offset: float


class InputGroup(NamedTuple):
    """Driven inputs of one FMI type, set by one call if one of them changed.

    ``buffer`` is what the call reads, converted from ``inputs[start:]``; None if it reads those doubles themselves.
    """

    function: str
    call: Call
    start: int
    buffer: Buffer
    wires: tuple[Wire, ...]


class OutputGroup(NamedTuple):
    """Outputs of one FMI type, read by one call, into ``values[start:]`` or into ``buffer``, as for inputs."""

    function: str
    call: Call
    start: int
    buffer: Buffer


@dataclass
class Participant:
    """One component, its role, and where its inputs and outputs are in the signals of the system.

    ``due`` is the time [s] of its next event or sample (infinite for a continuous component), ``steps`` and ``events``
    count doStep calls and instants with an event. ``triggers`` are the wires from discrete sources: a change of one
    is an event for a component with event mode, even between its own events.
    """

    instance: Instance
    role: Role
    period: float
    values: array[float]
    inputs: array[float]
    input_groups: tuple[InputGroup, ...]
    output_groups: tuple[OutputGroup, ...]
    triggers: tuple[Wire, ...]
    time: float = 0.0
    ticks: int = 0
    steps: int = 0
    events: int = 0
    due: float = field(init=False)
    in_event_mode: bool = field(init=False)

    def __post_init__(self) -> None:
        """A discrete component is due at t = 0; FMI 3.0 leaves initialisation in Event Mode."""
        self.due = math.inf if self.role is Role.CONTINUOUS else 0.0
        self.in_event_mode = self.role is Role.EVENT

    def write(self, force: bool = False) -> None:
        """Set the inputs that changed, or all driven ones."""
        values, inputs = self.values, self.inputs
        for function, call, start, buffer, wires in self.input_groups:
            changed = force
            for target, source, factor, offset in wires:
                value = values[source] * factor + offset
                if value != inputs[target]:
                    inputs[target] = value
                    changed = True
            if changed:
                if buffer is not None:
                    self._convert(buffer, start)
                status = call()
                if status >= FAILED:
                    self.instance.check(function, status)

    def _convert(self, buffer: array[Any], start: int) -> None:
        for i, value in enumerate(self.inputs[start : start + len(buffer)]):
            try:
                buffer[i] = value if buffer.typecode == "f" else int(value)
            except OverflowError as error:
                raise CallError(
                    self.instance,
                    f"cannot take {value:.17g}: its input is an integer of {8 * buffer.itemsize} bits",
                    "drive it within its range",
                ) from error

    def read(self) -> None:
        """Read all outputs into the signals."""
        for function, call, start, buffer in self.output_groups:
            status = call()
            if status >= FAILED:
                self.instance.check(function, status)
            if buffer is not None:
                for i, value in enumerate(buffer, start):
                    self.values[i] = value

    def step(self, t: float, h: float) -> None:
        """Step from t [s] over h [s]."""
        instance = self.instance
        instance.t.value = t
        instance.h.value = h
        status = instance.do_step()
        self.steps += 1
        if status >= FAILED:
            instance.check("DoStep", status)
        if instance.flags.value & (TERMINATE | EARLY_RETURN):
            instance.fail_to_go_on(early=not instance.flags.value & TERMINATE)

    def carry(self, t: float) -> None:
        """Bring a component with event mode to t [s], where it may turn out to need an event."""
        if t > self.time:
            self.step(self.time, t - self.time)
            self.time = t
            if self.instance.flags.value & EVENT_NEEDED:
                self.due = t

    def triggered(self) -> bool:
        """Tell whether a discrete source of an input has changed."""
        values, inputs = self.values, self.inputs
        for target, source, factor, offset in self.triggers:
            if values[source] * factor + offset != inputs[target]:
                return True
        return False

    def sample(self) -> None:
        """Execute the sample of a sampled component that is due; its outputs hold until the next."""
        self.write()
        self.ticks += 1
        following = self.ticks * self.period
        self.step(self.due, following - self.due)
        self.due = self.time = following
        self.read()

    def event(self, t: float) -> None:
        """Handle an event at t [s] in event mode; the component stays in it until ``leave_event_mode``."""
        instance = self.instance
        if not self.in_event_mode:
            self.carry(self.due if abs(self.due - t) <= SAME_INSTANT else t)
            status = instance.enter_event()
            if status >= FAILED:
                instance.check("EnterEventMode", status)
            self.in_event_mode = True
        self.write()
        for _ in range(_MOST_UPDATES):
            status = instance.update()
            if status >= FAILED:
                instance.check("UpdateDiscreteStates", status)
            flags = instance.update_flags.value
            if flags & UPDATE_TERMINATES:
                instance.fail_to_go_on()
            if not flags & UPDATE_NEEDED:
                break
        else:
            raise CallError(
                instance,
                f"still needs to update its discrete states after {_MOST_UPDATES} updates",
                "break the cycle of events inside it",
            )
        self.due = instance.next_event.value if flags & NEXT_EVENT_DEFINED else math.inf
        if self.due <= t + SAME_INSTANT:
            raise CallError(
                instance,
                f"announces its next event at {self.due:.9g} s, which is not after the present one",
                "check its sample period",
            )
        self.read()

    def leave_event_mode(self) -> None:
        """Go back to Step Mode after an event."""
        self.events += 1
        self.in_event_mode = False
        status = self.instance.enter_step()
        if status >= FAILED:
            self.instance.check("EnterStepMode", status)
