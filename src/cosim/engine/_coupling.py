"""Continuously coupled components: the links between them, and one macro step of all.

Over a macro step from t to t + h an input follows its source as a polynomial through what is known: values of before,
the value at t, and one at t + h, which is that of the source if this has been stepped before the target, and else
predicted from the others. FMI has no such inputs that all FMUs take, so that the target is given the polynomial's mean,
its *held* value: what its states make of it is exact but for terms of third order in h. An output that feeds the input
through is off by the difference between the value at the end and the one that is held; it is corrected with the FMU's
directional derivative times that difference. Where an FMU has none, and no state that the mean is better for, the input
holds the value at the end.

All numbers that change during a run are in arrays, so that they can be saved and restored.
"""

from __future__ import annotations

from array import array
from collections.abc import Mapping, Sequence
from ctypes import addressof, c_double, c_size_t, c_uint, c_void_p
from dataclasses import dataclass, field
from typing import Any

from cosim.engine._instance import Call, Instance
from cosim.engine._log import FAILED
from cosim.engine._method import Method
from cosim.engine._participant import Participant, Wire
from cosim.engine._system import Connection, System, dotted
from cosim.engine._variable import Variable

MEAN, END = 0, 1
"""Which value of the polynomial a link holds."""

SMALL = 1e-6
"""A signal that never leaves this range around zero counts as zero, in its unit."""


@dataclass
class Link:
    """A Real connection between two components that are stepped together.

    ``wire`` gives the input's value from the signals, its ``target`` being the slot of the signal that is handed on in
    its place. ``ahead`` tells that the source is stepped before the target, ``holds`` is MEAN or END.
    """

    wire: Wire
    name: str
    source: int
    target: int
    ahead: bool
    holds: int = MEAN

    def of(self, values: array[float]) -> float:
        """Return what the source makes of the input."""
        return values[self.wire.source] * self.wire.factor + self.wire.offset


@dataclass
class Correction:
    """Outputs that depend directly on linked inputs, and the call for the directional derivative between them.

    ``links`` are those of the inputs, ``slots`` the signals of the outputs; ``seed``, ``slope`` and ``raw``, the outputs
    as the FMU has given them, are as long as these.
    """

    call: Call
    function: str
    inputs: Any
    outputs: Any
    links: tuple[int, ...]
    slots: tuple[int, ...]
    seed: Any
    slope: Any
    raw: array[float]


@dataclass
class Member:
    """A component that is stepped together with others: its links as a target, and its states to go back to."""

    participant: Participant
    links: tuple[int, ...]
    correction: Correction | None
    states: Any = field(default_factory=lambda: (c_void_p * 2)())

    def save(self, place: int) -> None:
        """Keep the FMU's state at this place, 0 or 1."""
        instance = self.participant.instance
        status = instance.get_state(addressof(self.states) + 8 * place)
        if status >= FAILED:
            instance.check("GetFMUState", status)

    def restore(self, place: int) -> None:
        """Put the FMU back to the state that was kept there."""
        instance = self.participant.instance
        status = instance.set_state(self.states[place])
        if status >= FAILED:
            instance.check("SetFMUState", status)

    def free(self) -> None:
        """Free the states."""
        for place in range(2):
            if self.states[place]:
                self.participant.instance.free_state(addressof(self.states) + 8 * place)


class Coupling:
    """The links and members of one run, and what is known of the links: all arrays are by link, but for ``times``.

    ``start`` and ``end`` are values at the beginning and the end of the present macro step, ``scale`` the largest
    magnitude so far; ``last`` and ``before`` are values at ``times[0]`` and ``times[1]`` [s], the beginnings of the last
    two steps, of which there are ``known``. ``steady`` are the signals that drive the members otherwise, with their
    values in ``was``: when one changes, the polynomials begin anew.
    """

    def __init__(self, method: Method, tolerance: float, stop: float, links: list[Link], members: list[Member]) -> None:
        """Begin with nothing known."""
        self.method = method
        self.tolerance = tolerance
        self.stop = stop
        self.links = links
        self.members = members
        n = len(links)
        self.start, self.end, self.last, self.before = (array("d", bytes(8 * n)) for _ in range(4))
        self.scale = array("d", [SMALL] * n)
        self.times = array("d", [0.0, 0.0])
        self.known = 0
        linked = {link.wire.target for link in links}
        self.steady = [
            wire.source
            for member in members
            for group in member.participant.input_groups
            for wire in group.wires
            if wire.source not in linked
        ]
        self.was = array("d", bytes(8 * len(self.steady)))

    def begin(self, values: array[float]) -> None:
        """Note that what drives the members otherwise may have changed."""
        changed = False
        for i, slot in enumerate(self.steady):
            if values[slot] != self.was[i]:
                self.was[i] = values[slot]
                changed = True
        if changed:
            self.known = 0

    def predict(self, values: array[float], t: float, h: float) -> None:
        """Take the values at t as those at the beginning, and continue them to t + h."""
        order = min(self.known, self.method.order)
        t1, t2 = self.times
        for i, link in enumerate(self.links):
            self.start[i] = value = link.of(values)
            if order > 0:
                slope = (value - self.last[i]) / (t - t1)
                value += h * slope
                if order > 1:
                    value += h * (t + h - t1) * ((slope - (self.last[i] - self.before[i]) / (t1 - t2)) / (t - t2))
            self.end[i] = value

    def held(self, i: int, t: float, h: float) -> float:
        """Return what a link holds from t over h: the mean of the polynomial through its end, or the end itself."""
        start, end = self.start[i], self.end[i]
        if self.links[i].holds == END:
            return end
        mean = 0.5 * (start + end)
        if self.known > 0 and self.method.order > 1:
            t1 = self.times[0]
            curvature = ((end - start) / h - (start - self.last[i]) / (t - t1)) / (t + h - t1)
            mean -= h * h / 6.0 * curvature
        return mean

    def push(self, t: float) -> None:
        """Note that a step from t has been taken: its beginning is known from now on."""
        self.times[1] = self.times[0]
        self.times[0] = t
        self.known = min(self.known + 1, 2)
        for i in range(len(self.links)):
            self.before[i] = self.last[i]
            self.last[i] = self.start[i]
