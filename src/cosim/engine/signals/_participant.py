"""A component in a running simulation: takes its inputs from the signals, is computed, puts its outputs there."""

from __future__ import annotations

import math
from array import array
from collections.abc import Sequence
from ctypes import Array, c_char_p, c_size_t, c_void_p, cast, string_at
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeAlias

from cosim.engine.fmu._instance import (
    EARLY_RETURN,
    EVENT_NEEDED,
    NEXT_EVENT_DEFINED,
    TERMINATE,
    UPDATE_NEEDED,
    UPDATE_TERMINATES,
    Access,
    CallError,
    Instance,
)
from cosim.engine.fmu._log import FAILED
from cosim.engine.signals._signal_faults import FaultyInput, SignalFaults
from cosim.engine.system._role import Role
from cosim.engine.system._system import SAME_INSTANT
from cosim.engine.system._wire import Wire

MOST_UPDATES = 100


class Binaries:
    """Memory of an FMI call for Binary variables: where each lies, and how many bytes it has.

    ``limits`` are the most bytes that each may have.
    """

    def __init__(self, limits: Sequence[int]) -> None:
        """Make room for as many as there are limits."""
        self.limits = (c_size_t * len(limits))(*limits)
        self.places = (c_void_p * len(limits))()
        self.sizes = (c_size_t * len(limits))()
        self._given: list[c_char_p] = []

    def give(self, values: list[bytes]) -> None:
        """Point to these values."""
        self._given = [c_char_p(value) for value in values]
        self.places[:] = [cast(value, c_void_p) for value in self._given]
        self.sizes[:] = [len(value) for value in values]

    def take(self, count: int) -> list[bytes]:
        """Return copies of the first values, which the FMU owns."""
        found = zip(self.places[:count], self.sizes[:count], strict=True)
        return [string_at(place, size) if place else b"" for place, size in found]


Buffer: TypeAlias = "array[Any] | Array[c_char_p] | Binaries | None"
"""Memory of an FMI call that does not use the doubles of the signals themselves: numbers, texts or Binary."""


class InputGroup(NamedTuple):
    """Driven inputs of one FMI type, set by one call if one of them changed.

    ``buffer`` is what the call reads, converted from ``inputs[start:]``; None if it reads those doubles themselves.
    """

    fmi_type: str
    access: Access
    start: int
    buffer: Buffer
    wires: tuple[Wire, ...]
    names: tuple[str, ...]


class OutputGroup(NamedTuple):
    """Outputs of one FMI type, read by one call, into ``values[start:]`` or into ``buffer``, as for inputs.

    ``whole`` reads all of them, ``connected`` those, at the front, that somebody takes; it is None if nobody does.
    """

    fmi_type: str
    whole: Access
    connected: Access | None
    start: int
    buffer: Buffer


@dataclass
class Participant:
    """One component, its role, and where its inputs and outputs are in the signals of the system.

    ``due`` is the time [s] of its next event or sample (infinite for a continuous component), ``steps`` and ``events``
    count doStep calls and instants with an event. ``triggers`` are the wires from discrete sources: a change of one
    is an event for a component with event mode, even between its own events. ``stale`` tells that outputs which are
    only recorded have not been read since the component was computed. The signal of a text or a Binary counts how often
    it has changed; ``texts``, which all participants share, has the bytes themselves. ``faulty`` are its inputs with
    faults, which ``faults`` computes.
    """

    instance: Instance
    role: Role
    period: float
    values: array[float]
    inputs: array[float]
    input_groups: tuple[InputGroup, ...]
    output_groups: tuple[OutputGroup, ...]
    triggers: tuple[Wire, ...]
    texts: dict[int, bytes]
    time: float = 0.0
    ticks: int = 0
    steps: int = 0
    events: int = 0
    due: float = field(init=False)
    in_event_mode: bool = field(init=False)
    stale: bool = False
    faulty: Sequence[FaultyInput] = ()
    faults: SignalFaults | None = None

    def __post_init__(self) -> None:
        """A discrete component is due at t = 0, a fixed step at its end; FMI 3.0 initialises into Event Mode."""
        self.due = self.period if self.role is Role.CONTINUOUS else 0.0
        self.in_event_mode = self.role is Role.EVENT

    def write(self) -> None:
        """Set the inputs that changed."""
        if self.faults is not None:
            self.faults.refresh(self.faulty)
        values, inputs = self.values, self.inputs
        for group in self.input_groups:
            changed = False
            for target, source, factor, offset, table in group.wires:
                value = values[source] * factor + offset
                if table:
                    value = dict(table).get(value, value)
                if value != inputs[target]:
                    inputs[target] = value
                    changed = True
            if changed:
                self.put(group)

    def put(self, group: InputGroup) -> None:
        """Set the inputs of a group to what stands in ``inputs``, or in the texts."""
        _, access, start, buffer, wires, _ = group
        if isinstance(buffer, Array):
            buffer[:] = [self.texts.get(wire.source, b"") for wire in wires]
        elif isinstance(buffer, Binaries):
            self._give(buffer, wires)
        elif buffer is not None:
            self._convert(buffer, start)
        status = access.call()
        if status >= FAILED:
            self.instance.check(access.function, status)

    def _give(self, buffer: Binaries, wires: tuple[Wire, ...]) -> None:
        values = [self.texts.get(wire.source, b"") for wire in wires]
        for value, limit in zip(values, buffer.limits, strict=True):
            if len(value) > limit:
                raise self.too_long(len(value))
        buffer.give(values)

    def too_long(self, size: int) -> CallError:
        """Return the error for a Binary that an input cannot take."""
        return CallError(
            self.instance,
            f"cannot take a Binary of {size} bytes: its input is declared for fewer",
            "connect a source that puts out less",
        )

    def _convert(self, buffer: array[Any], start: int) -> None:
        for i, value in enumerate(self.inputs[start : start + len(buffer)]):
            try:
                buffer[i] = value if buffer.typecode == "f" else int(value)
            except OverflowError as error:
                raise self.out_of_range(value, buffer) from error

    def out_of_range(self, value: float, buffer: array[Any]) -> CallError:
        """Return the error for a value that an integer input cannot take."""
        return CallError(
            self.instance,
            f"cannot take {value:.17g}: its input is an integer of {8 * buffer.itemsize} bits",
            "drive it within its range",
        )

    def read(self, recording: bool = True) -> None:
        """Read into the signals the outputs that somebody takes, and, if ``recording``, all others too."""
        for _, whole, connected, start, buffer in self.output_groups:
            access = whole if recording else connected
            if access is not None:
                self._read(access, start, buffer)
        self.stale = not recording

    def _read(self, access: Access, start: int, buffer: Buffer) -> None:
        status = access.call()
        if status >= FAILED:
            self.instance.check(access.function, status)
        if isinstance(buffer, Array):
            self._take([text or b"" for text in buffer[: access.length]], start)
        elif isinstance(buffer, Binaries):
            self._take(buffer.take(access.length), start)
        elif buffer is not None:
            for i in range(access.length):
                self.values[start + i] = buffer[i]

    def read_texts(self) -> None:
        """Read the texts and Binary outputs that somebody takes, and nothing else."""
        for _, _, connected, start, buffer in self.output_groups:
            if connected is not None and isinstance(buffer, Array | Binaries):
                self._read(connected, start, buffer)

    def _take(self, texts: list[bytes], start: int) -> None:
        for slot, given in enumerate(texts, start):
            if given != self.texts.get(slot):
                self.texts[slot] = given
                self.values[slot] += 1.0

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

    def begin_fixed_step(self, now: float) -> None:
        """Set the inputs if a step of the one length that the component takes begins now [s]."""
        if abs(now - self.time) <= SAME_INSTANT:
            self.write()

    def end_fixed_step(self, t: float) -> None:
        """Take the step of the one length if it ends at t [s]; the outputs hold until the next one does."""
        if t >= self.due - SAME_INSTANT:
            self.step(self.time, self.period)
            self.ticks += 1
            self.time = self.due
            self.due = (self.ticks + 1) * self.period
            self.read()

    def carry(self, t: float) -> None:
        """Bring a component with event mode to t [s], where it may turn out to need an event."""
        if t > self.time:
            self.step(self.time, t - self.time)
            self.time = t
            if self.instance.flags.value & EVENT_NEEDED:
                self.due = t

    def triggered(self) -> bool:
        """Tell whether a discrete source of an input has changed."""
        if self.faults is not None:
            self.faults.refresh(self.faulty)
        values, inputs = self.values, self.inputs
        for target, source, factor, offset, table in self.triggers:
            value = values[source] * factor + offset
            if (dict(table).get(value, value) if table else value) != inputs[target]:
                return True
        return False

    def sample(self, recording: bool) -> None:
        """Execute the sample of a sampled component that is due; its outputs hold until the next."""
        self.write()
        self.ticks += 1
        following = self.ticks * self.period
        self.step(self.due, following - self.due)
        self.due = self.time = following
        self.read(recording)

    def event(self, t: float, recording: bool) -> None:
        """Handle an event at t [s] in event mode; the component stays in it until ``leave_event_mode``."""
        instance = self.instance
        if not self.in_event_mode:
            self.carry(self.due if abs(self.due - t) <= SAME_INSTANT else t)
            status = instance.enter_event()
            if status >= FAILED:
                instance.check("EnterEventMode", status)
            self.in_event_mode = True
        self.write()
        for _ in range(MOST_UPDATES):
            status = instance.update()
            if status >= FAILED:
                instance.check("UpdateDiscreteStates", status)
            flags = instance.update_flags.value
            if flags & UPDATE_TERMINATES:
                instance.fail_to_go_on()
            if not flags & UPDATE_NEEDED:
                break
        else:
            raise self.never_settles()
        self.due = instance.next_event.value if flags & NEXT_EVENT_DEFINED else math.inf
        if self.due <= t + SAME_INSTANT:
            raise self.announces_the_past()
        self.read(recording)

    def never_settles(self) -> CallError:
        """Return the error for an event that needs ever more updates."""
        return CallError(
            self.instance,
            f"still needs to update its discrete states after {MOST_UPDATES} updates",
            "break the cycle of events inside it",
        )

    def announces_the_past(self) -> CallError:
        """Return the error for a next event, at ``due``, that is not in the future."""
        return CallError(
            self.instance,
            f"announces its next event at {self.due:.9g} s, which is not after the present one",
            "check its sample period",
        )

    def leave_event_mode(self) -> None:
        """Go back to Step Mode after an event."""
        self.events += 1
        self.in_event_mode = False
        status = self.instance.enter_step()
        if status >= FAILED:
            self.instance.check("EnterStepMode", status)
