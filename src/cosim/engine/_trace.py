"""What happens when, written down while the Python loop runs over the tables of a plan."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

from cosim.engine.loop._plan import Plan
from cosim.engine.signals._participant import Participant
from cosim.engine.system._connection import dotted
from cosim.engine.system._role import Role
from cosim.engine.system._system import SAME_INSTANT
from cosim.engine.system._wire import Wire

_MOST_COMPUTATIONS = 50_000
_MOST_BYTES = 60


class Enough(Exception):  # noqa: N818
    """Ends a trace that has seen what it needs; no error."""


@dataclass
class Travel:
    """A value on its way: what was put out at ``born`` [s] acts at the target, as ``value``, from ``acts`` [s] on.

    ``initial`` tells that it comes from initialisation, before any computation of the source.
    """

    born: float
    acts: float
    value: float | str
    initial: bool


class Birth(NamedTuple):
    """A value was put out at ``t`` [s], by the computation of this number: 0 is initialisation, None a channel."""

    t: float
    number: int | None


class Taken(NamedTuple):
    """An input was set to ``value``; ``birth`` is that of the source's value, None if a channel drives it."""

    wire: Wire
    birth: Birth | None
    value: float | str


@dataclass
class Component:
    """When one component was computed: instants that it asked for, others, and the lengths of its steps [s]."""

    own: list[float] = field(default_factory=list)
    caused: list[float] = field(default_factory=list)
    steps: list[float] = field(default_factory=list)


class Trace:
    """The instants of all components, and what travelled on each wire, by the number of its input.

    It ends the run as soon as every discrete component has been computed ``wanted`` times, or all together very often.
    """

    def __init__(self, wanted: int) -> None:
        """Start empty."""
        self.wanted = wanted
        self.roles: dict[str, Role] = {}
        self.components: dict[str, Component] = {}
        self.travels: dict[int, list[Travel]] = {}
        self.until = 0.0
        self._born: dict[int, Birth] = {}
        self._last: dict[int, Birth] = {}
        self._entries: dict[int, list[float]] = {}
        self._count = 0

    def begin(self, plan: Plan, entries: dict[tuple[str, str], list[float]]) -> None:
        """Note that all outputs are there at 0 s, and where the channels are, with these entries [s] by target."""
        lines = {line.slot for line in plan.lines}
        slots = {plan.columns[dotted(target)]: times for target, times in entries.items()}
        self._entries = {slot: times for slot, times in slots.items() if slot not in lines}
        for participant in [*plan.continuous, *plan.discrete]:
            self.born(participant, 0.0)

    def computed(self, name: str, t: float, own: bool) -> None:
        """Note that a discrete component is computed at t [s]."""
        entry = self.components[name]
        instants = entry.own if own else entry.caused
        if not instants or t > instants[-1] + SAME_INSTANT:
            instants.append(t)
        self._go_on(t)

    def stepped(self, name: str, t: float, h: float) -> None:
        """Note that a continuous component is stepped from t over h [s]."""
        self.components[name].steps.append(h)
        self._go_on(t)

    def taken(self, participant: Participant) -> list[Taken]:
        """Return what the inputs of a component have just been set to."""
        return [
            Taken(wire, self._born.get(wire.source), _value(participant, wire))
            for group in participant.input_groups
            for wire in group.wires
        ]

    def used(self, taken: list[Taken], t: float) -> None:
        """Note that this acts from t [s] on, if it has not acted before; what acts for no time at all is dropped."""
        for wire, birth, value in taken:
            born = birth or Birth(self._entered(wire.source, t), None)
            travels = self.travels.setdefault(wire.target, [])
            if self._last.get(wire.target) == born:
                continue
            self._last[wire.target] = born
            if travels and travels[-1].acts == t:
                travels.pop()
            travels.append(Travel(born.t, t, value, initial=born.number == 0))

    def _entered(self, slot: int, t: float) -> float:
        """Return the time [s] of the channel's entry that acts at t; an interpolated one has a value for each t."""
        times = self._entries.get(slot, [])
        return max((time for time in times if time <= t + SAME_INSTANT), default=0.0) if times else t

    def born(self, participant: Participant, t: float) -> None:
        """Note that the outputs of a component are now those at t [s]."""
        for group in participant.output_groups:
            for slot in range(group.start, group.start + group.whole.length):
                self._born[slot] = Birth(t, self._count)

    def _go_on(self, t: float) -> None:
        self.until = max(self.until, t)
        self._count += 1
        waiting = [
            name
            for name, entry in self.components.items()
            if self.roles[name] is not Role.CONTINUOUS and len(entry.own) + len(entry.steps) < self.wanted
        ]
        if self._count > _MOST_COMPUTATIONS or (not waiting and self._count > self.wanted * len(self.components)):
            raise Enough


def _value(participant: Participant, wire: Wire) -> float | str:
    text = participant.texts.get(wire.source)
    if text is None:
        return participant.inputs[wire.target]
    shown = text[:_MOST_BYTES].decode(errors="replace")
    readable = len(text) <= _MOST_BYTES and shown.isprintable() and "\N{REPLACEMENT CHARACTER}" not in shown
    return f'"{shown}"' if readable else f"{len(text)} byte{'s' * (len(text) != 1)}"


@dataclass
class TracedParticipant(Participant):
    """A participant that tells a trace what it does. ``trace.roles`` has its role before an algorithm overrode it."""

    trace: Trace = field(default_factory=lambda: Trace(0))
    taken: list[Taken] = field(default_factory=list)

    def write(self) -> None:
        """Set the inputs."""
        super().write()
        self.taken = self.trace.taken(self)

    def step(self, t: float, h: float) -> None:
        """Step, the inputs acting from t on; an FMU that samples holds outputs of the beginning of its step."""
        super().step(t, h)
        if self.role is Role.CONTINUOUS:
            name = self.instance.name
            self.trace.stepped(name, t, h)
            self.trace.used(self.taken, t)
            self.trace.born(self, t + h if self.trace.roles[name] is Role.CONTINUOUS else t)

    def sample(self, recording: bool) -> None:
        """Take the sample that is due."""
        t = self.due
        super().sample(recording)
        self._computed(t, own=True)

    def event(self, t: float, recording: bool) -> None:
        """Handle an event."""
        own = self.due <= t + SAME_INSTANT
        super().event(t, recording)
        self._computed(t, own)

    def _computed(self, t: float, own: bool) -> None:
        self.trace.computed(self.instance.name, t, own)
        self.trace.used(self.taken, t)
        self.trace.born(self, t)
