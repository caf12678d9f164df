"""Components that act on each other continuously: the links between them, and one macro step of all of them.

From t to t + h an input follows its source as a polynomial through what is known: values of before, the value at t, and
one at t + h, which is that of the source if this has been stepped before the target, and else predicted. FMI has no
such inputs that all FMUs take, so the target is given one value for the whole step, the polynomial's mean: what its
states make of it is exact but for terms of third order in h. An output that feeds the input through is off by the
difference between the value at the end and the one that is held; it is corrected by the FMU's directional derivative
times that difference. An FMU without directional derivatives holds the value at the end if its outputs feed through.
"""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from contextlib import suppress
from ctypes import Array, addressof, c_double, c_uint, c_void_p, sizeof
from dataclasses import dataclass, field

from cosim.engine.coupling._power_meter import PowerMeter
from cosim.engine.fmu._instance import Access, Call, CallError
from cosim.engine.fmu._log import FAILED
from cosim.engine.signals._participant import Participant
from cosim.engine.signals._signal_faults import FaultyInput, SignalFaults
from cosim.engine.system._channels import Line
from cosim.engine.system._method import Method
from cosim.engine.system._wire import Wire

SMALL = 1e-6
"""A signal that stays within this part of its nominal value (1 in its unit if it has none) counts as zero."""

CLOSE = 0.01
"""Of a step's length: a polynomial through values that are closer to each other says nothing about the step."""

_FEW = 4
"""Steps that may be too inexact without a remark: an event or the start has one now and then."""

OUTER, INNER = 0, 1
"""Two places for what is to be gone back to: one within the other."""


@dataclass(frozen=True)
class Link:
    """A connection between two components that are stepped together.

    ``wire`` gives the value of the input, called ``name``, from the signals; what the target gets is the signal
    ``slot``, or what the faults of ``faulty`` make of it. ``ahead`` tells that the source is stepped before the target,
    ``holds_end`` that the input holds the value at the end of a macro step, not the mean, and ``observed`` that all
    states of the source are compared. Values up to ``small`` count as zero.
    """

    wire: Wire
    name: str
    slot: int
    ahead: bool
    holds_end: bool
    observed: bool
    small: float
    faulty: FaultyInput | None = None

    def of(self, values: array[float]) -> float:
        """Return what the source makes of the input."""
        return values[self.wire.source] * self.wire.factor + self.wire.offset


@dataclass(frozen=True)
class Correction:
    """The outputs of a component that depend directly on linked inputs, and their derivative along a change of these.

    ``links`` are those of the inputs, ``slots`` the signals of the outputs: the first ``n_connected`` are needed
    between rows, all for one. A call, one for either case, puts into ``slope`` what ``seed`` makes of the outputs;
    ``raw`` are these as the FMU has given them.
    """

    links: tuple[int, ...]
    slots: tuple[int, ...]
    n_connected: int
    calls: tuple[Call, Call]
    inputs: Array[c_uint]
    outputs: Array[c_uint]
    seed: Array[c_double]
    slope: Array[c_double]
    raw: Array[c_double]


@dataclass(frozen=True)
class Observed:
    """The continuous states of a component, as far as its model description names them: ``access`` reads ``values``.

    ``scale`` are their largest magnitudes so far, ``full`` is what they were after a step taken whole.
    """

    access: Access
    values: array[float]
    full: array[float]
    scale: array[float]


@dataclass(frozen=True)
class Member:
    """A component that is stepped together with others.

    ``links`` are those that it is the target of, ``observed`` are its states where the algorithm compares them;
    ``states`` are two states of the whole FMU to go back to.
    """

    participant: Participant
    links: tuple[int, ...]
    correction: Correction | None
    observed: Observed | None
    states: Array[c_void_p] = field(default_factory=c_void_p * 2)

    def observe(self) -> None:
        """Read the continuous states."""
        if self.observed is not None:
            access = self.observed.access
            status = access.call()
            if status >= FAILED:
                self.participant.instance.check(access.function, status)

    def save(self, place: int) -> None:
        """Keep the FMU's state at this place."""
        self.participant.instance.save_state(addressof(self.states) + place * sizeof(c_void_p))

    def restore(self, place: int) -> None:
        """Put the FMU back to the state that was kept there."""
        self.participant.instance.restore_state(self.states[place] or 0)

    def free(self) -> None:
        """Free the kept states."""
        for place in (OUTER, INNER):
            if self.states[place] and not self.participant.instance.is_broken:
                with suppress(CallError):  # what the FMU keeps then, it frees with the instance, or nobody does
                    self.participant.instance.free_state(addressof(self.states) + place * sizeof(c_void_p))


class Coupling:
    """The links and members of one run; ``others`` are the continuous components beside them.

    Arrays are by link: ``start`` and ``end`` are values at the beginning and the end of the present macro step,
    ``scale`` is the largest magnitude so far; ``last`` and ``before`` are the values at ``times`` [s], the beginnings
    of the last two steps, of which there are ``known``. ``steady`` are the signals that drive the members otherwise,
    ``was`` their last values: when one changes, the polynomials begin anew. ``matrix`` is that of the iteration, of as
    many rows and columns as there are links ``cut``, those against the order of the steps; ``has_matrix`` tells that it
    has been measured. ``wanted`` [s] is the adaptive algorithm's next step, ``usual`` its last one with polynomials,
    ``error`` its last estimate over the tolerance.
    """

    def __init__(
        self,
        method: Method,
        tolerance: float,
        stop: float,
        links: Sequence[Link],
        members: Sequence[Member],
        others: Sequence[Participant],
        signals: tuple[array[float], array[float], int],
        lines: Sequence[Line],
        faults: SignalFaults,
        power: PowerMeter,
    ) -> None:
        """Begin with nothing known; ``signals`` are the signals, the inputs, and how many signals are no texts."""
        self.method = method
        self.tolerance = tolerance
        self.stop = stop
        self.links = links
        self.members = members
        self.others = others
        self.values, self.inputs, self.n_numbers = signals
        self.lines = lines
        self.faults = faults
        self.power = power
        n = len(links)
        self.start, self.end, self.last, self.before, self.full = (array("d", bytes(8 * n)) for _ in range(5))
        self.scale = array("d", [link.small for link in links])
        self.times = array("d", [0.0, 0.0])
        self.known = 0
        self.cut = [i for i, link in enumerate(links) if not link.ahead]
        self.matrix = array("d", bytes(8 * len(self.cut) ** 2))
        self.has_matrix = False
        self.wanted, self.usual = stop, stop / 100.0
        self.divisor = 2.0**method.accuracy - 1.0
        self.error = 1.0
        self.macro_steps = self.rejected = self.repeated = self.forced = 0
        slots = {slot for link in links for slot in (link.slot, link.faulty.slot if link.faulty else link.slot)}
        wires = [wire for member in members for group in member.participant.input_groups for wire in group.wires]
        middles = {line.middle for line in lines}
        self.steady = [wire.source for wire in wires if wire.source not in slots | middles]
        self.was = array("d", bytes(8 * len(self.steady)))
        self._kept: list[tuple[array[float], ...]] = [(), ()]
        self._known_then = [0, 0]

    def notice(self) -> None:
        """Begin the polynomials anew if what drives the members otherwise has changed, or what a fault does to them."""
        if self.faults.clock.changed:
            self.faults.clock.changed = self.known = 0
        for i, slot in enumerate(self.steady):
            if self.values[slot] != self.was[i]:
                self.was[i] = self.values[slot]
                self.known = 0

    def predict(self, t: float, h: float) -> None:
        """Take the signals as those at t [s], the beginning of a step, and continue the links over h [s].

        Values of before that lie too close to each other are left out: errors that the FMUs make in the last digits
        would grow with the ratio of h to their distance.
        """
        t1, t2 = self.times
        if self.known > 0 and t - t1 < CLOSE * h:
            self.known = 0
        elif self.known > 1 and t1 - t2 < CLOSE * h:
            self.known = 1
        order = min(self.known, self.method.order)
        for i, link in enumerate(self.links):
            value = link.of(self.values)
            self.start[i] = value
            if order > 0:
                slope = (value - self.last[i]) / (t - t1)
                if order > 1:
                    bend = (slope - (self.last[i] - self.before[i]) / (t1 - t2)) / (t - t2)
                    slope = slope + bend * (t + h - t1)
                value = value + slope * h
            self.end[i] = value

    def held(self, i: int, t: float, h: float) -> float:
        """Return what a link holds from t over h [s]."""
        start, end = self.start[i], self.end[i]
        if self.links[i].holds_end:
            return end
        mean = 0.5 * (start + end)
        if self.known > 0 and self.method.order > 1:
            t1 = self.times[0]
            bend = ((end - start) / h - (start - self.last[i]) / (t - t1)) / (t + h - t1)
            mean = mean - bend * h * h / 6.0
        return mean

    def take(self, t: float, h: float, recording: bool) -> None:
        """Step all members from t over h [s], each with what is known of those before it."""
        values, links = self.values, self.links
        for line in self.lines:
            values[line.middle] = line.at(t + 0.5 * h)
        self.faults.begin_step(t, h)
        for member in self.members:
            for i in member.links:
                if links[i].ahead:
                    self.end[i] = links[i].of(values)
                values[links[i].slot] = self.held(i, t, h)
            participant = member.participant
            participant.write()
            participant.step(t, h)
            participant.read(recording)
            if member.correction is not None:
                for k, slot in enumerate(member.correction.slots):
                    member.correction.raw[k] = values[slot]
                self._correct(member.participant, member.correction, recording)

    def correct_again(self, recording: bool) -> None:
        """Correct the outputs once more, now that the ends of all links are known."""
        for member in self.members:
            if (correction := member.correction) is not None:
                changed = False
                for i in correction.links:
                    value = self.links[i].of(self.values)
                    if value != self.end[i]:
                        self.end[i] = value
                        changed = True
                if changed:
                    self._correct(member.participant, correction, recording)

    def _correct(self, participant: Participant, correction: Correction, recording: bool) -> None:
        values = self.values
        for k, i in enumerate(correction.links):
            end, held = self.end[i], self.links[i].slot
            if (faulty := self.links[i].faulty) is not None:
                end, held = self.faults.at_end(faulty, end), faulty.slot
            correction.seed[k] = end - values[held]
        n = len(correction.slots) if recording else correction.n_connected
        if n == 0:
            return
        status = correction.calls[recording]()
        if status >= FAILED:
            participant.instance.check("GetDirectionalDerivative", status)
        for k in range(n):
            values[correction.slots[k]] = correction.raw[k] + correction.slope[k]

    def push(self, t: float, h: float) -> None:
        """Note that the step from t over h [s] stays."""
        self.power.end(self.values, self.inputs, h)
        self.times[1] = self.times[0]
        self.times[0] = t
        self.known = min(self.known + 1, 2)
        for i in range(len(self.links)):
            self.before[i] = self.last[i]
            self.last[i] = self.start[i]

    def enlarge(self) -> None:
        """Note the magnitudes of what a step which stays has led to."""
        for i, link in enumerate(self.links):
            self.scale[i] = max(self.scale[i], abs(link.of(self.values)))
        for member in self.members:
            if (observed := member.observed) is not None:
                for k, value in enumerate(observed.values):
                    observed.scale[k] = max(observed.scale[k], abs(value))

    def save(self, place: int) -> None:
        """Keep all that a step changes."""
        for member in self.members:
            member.save(place)
        self._kept[place] = tuple(array("d", part) for part in self._parts())
        self._known_then[place] = self.known

    def restore(self, place: int) -> None:
        """Go back to what was kept there."""
        for member in self.members:
            member.restore(place)
        for part, kept in zip(self._parts(), self._kept[place], strict=True):
            part[:] = memoryview(kept)
        self.known = self._known_then[place]
        for member in self.members:
            member.participant.read_texts()

    def _parts(self) -> list[memoryview]:
        return [
            memoryview(self.values)[: self.n_numbers],
            *(memoryview(numbers) for numbers in (self.inputs, self.last, self.before, self.times)),
            *(memoryview(numbers) for numbers in (self.power.energies, self.power.start)),
        ]

    def account(self) -> dict[str, object]:
        """Return what was done: macro steps that stay, rejected ones, repeated passes, steps not made any shorter."""
        return {
            "name": self.method.algorithm,
            "order": self.method.order,
            "macro_steps": self.macro_steps,
            "rejected": self.rejected,
            "repeated": self.repeated,
            "forced": self.forced,
        }

    @property
    def remarks(self) -> list[str]:
        """What the user should know about the steps: more than a few errs by more than the tolerance allows."""
        if self.forced <= max(_FEW, 0.01 * self.macro_steps):
            return []
        return [
            f"the tolerance {self.tolerance:g} is not reached: {self.forced} of {self.macro_steps} macro steps err by "
            "more than it allows, and shorter ones would, too, because of the errors of the FMUs' solvers or of what "
            "happens inside the FMUs; choose a looser tolerance"
        ]

    def free(self) -> None:
        """Free the kept states of the FMUs."""
        for member in self.members:
            member.free()
