"""A component in Initialization or Event Mode, where inputs may be set and outputs read as often as one likes."""

from __future__ import annotations

import math
from array import array
from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from ctypes import Array, c_double, c_uint
from sys import float_info
from typing import Any, NamedTuple

from cosim.engine.fmu._instance import Access, Call, CallError
from cosim.engine.fmu._variable import OPAQUE, Variable
from cosim.engine.signals._participant import InputGroup, Participant
from cosim.engine.system._wire import Wire

_NUDGE = 1e-6
"""Of an input's value, by which it is changed to see what becomes of it."""


class _Reader(NamedTuple):
    """A call that reads outputs of one type into its buffer; ``slots`` are their signals, None for those not wanted."""

    access: Access
    buffer: array[Any]
    slots: tuple[int | None, ...]


class _Derivative(NamedTuple):
    call: Call
    seed: Array[c_double]
    slope: Array[c_double]


class Port:
    """Reads and sets chosen outputs and inputs of a participant, and finds how the ones change with the others.

    ``exact`` tells that the FMU's directional derivatives are used for that, ``is_complete`` that all driven inputs
    have been set.
    """

    def __init__(
        self, participant: Participant, slots: Mapping[str, int], initialize: Callable[[], None] | None = None
    ) -> None:
        """Take over; ``slots`` are the signals of the outputs that are read.

        ``initialize`` initialises a component without Initialization Mode, after the first inputs have been set.
        """
        self.participant = participant
        self.is_complete = False
        self._fmu = participant.instance.fmu
        self._inputs = participant.inputs
        self._initialize = initialize
        self._slots = slots
        self._readers: dict[tuple[str, ...], list[_Reader]] = {}
        self._derivatives: dict[tuple[tuple[str, ...], tuple[str, ...]], _Derivative | None] = {}
        self._faulty = {one.slot: one for one in participant.faulty}
        self._fresh: set[int] = set()
        self._last: dict[int, float] = {}
        self._nudged: dict[int, tuple[float, InputGroup]] = {}
        self.exact = bool(self._fmu.capabilities["providesDirectionalDerivative"])
        self.wires: list[tuple[Wire, Variable, InputGroup]] = [
            (wire, self._fmu.variables[name], group)
            for group in participant.input_groups
            for wire, name in zip(group.wires, group.names, strict=True)
        ]

    def start(self) -> None:
        """Let driven inputs have their start values, as the FMU does, until they are set for the first time."""
        self._fresh = {group.start for group in self.participant.input_groups}
        for wire, variable, group in self.wires:
            if group.fmi_type not in OPAQUE:
                self._inputs[wire.target] = float(variable.start or 0.0)

    def input(self, name: str) -> float:
        """Return what a driven input was set to last."""
        return next(self._inputs[wire.target] for wire, variable, _ in self.wires if variable.name == name)

    def write(self, known: Container[int]) -> None:
        """Set the inputs whose sources are known, where they have changed or have not been set before."""
        participant, inputs = self.participant, self._inputs
        values = participant.values
        if participant.faults is not None:
            participant.faults.refresh(participant.faulty)
        self._nudged.clear()  # they are set back here
        self.is_complete = True
        for group in participant.input_groups:
            wires = [wire for wire in group.wires if self._origin(wire.source) in known]
            complete = len(wires) == len(group.wires)
            self.is_complete &= complete
            if not wires or (not complete and group.fmi_type in OPAQUE):
                continue
            changed = group.start in self._fresh
            for wire in wires:
                value = wire.translated(values[wire.source])
                if value != inputs[wire.target]:
                    inputs[wire.target] = value
                    changed = True
            if changed:
                participant.put(group)
                self._fresh.discard(group.start)
        if self._initialize is not None:
            self._initialize()
            self._initialize = None

    def read(self, names: tuple[str, ...]) -> list[float]:
        """Read outputs into the signals and return these, in the order of the names."""
        values = self.participant.values
        if any(self._fmu.fmi_types[name] in OPAQUE for name in names):
            self.participant.read(recording=False)
        else:
            self._last |= self._fetch(names)
            for name in names:
                values[self._slots[name]] = self._last[self._slots[name]]
        return [values[self._slots[name]] for name in names]

    def slopes(self, names: tuple[str, ...], seeds: Mapping[int, float]) -> list[float]:
        """Return how fast outputs change, in the order of the names, if signals change at the rates ``seeds``.

        The signals are those that drive inputs here. Without directional derivatives the inputs are set to values close
        by, and what the outputs were at the last ``read`` is compared; the next ``write`` sets the inputs back. Not a
        number where the FMU fails.
        """
        moved = [(w, v, g, self._rate(w, seeds)) for w, v, g in self.wires if self._origin(w.source) in seeds]
        moved = [move for move in moved if move[3] != 0.0]
        if not moved:
            return [0.0] * len(names)
        knowns = tuple(variable.name for _, variable, _, _ in moved)
        derivative = self._derivative(names, knowns) if self.exact else None
        if derivative is None:
            return self._differences(names, moved)
        derivative.seed[:] = [rate for _, _, _, rate in moved]
        if derivative.call() != 0 or not all(map(math.isfinite, derivative.slope)):
            self._derivatives[names, knowns] = None
            return self._differences(names, moved)
        return list(derivative.slope)

    def _origin(self, source: int) -> int:
        """Return the signal that a wire comes from, a fault between them or not."""
        return self._faulty[source].at.source if source in self._faulty else source

    def _rate(self, wire: Wire, seeds: Mapping[int, float]) -> float:
        """Return how fast an input changes."""
        if wire.source not in self._faulty:
            return wire.factor * seeds[wire.source]
        return self._faulty[wire.source].slope(self.participant.values) * seeds[self._origin(wire.source)]

    def _differences(
        self, names: tuple[str, ...], moved: Sequence[tuple[Wire, Variable, InputGroup, float]]
    ) -> list[float]:
        inputs = self._inputs
        groups = {group.start: group for _, group in self._nudged.values()}
        groups |= {group.start: group for _, _, group, _ in moved}
        for target, (value, _) in self._nudged.items():
            inputs[target] = value
        self._nudged = {wire.target: (inputs[wire.target], group) for wire, _, group, _ in moved}
        width = min(
            max(_NUDGE * (max(abs(inputs[wire.target]), variable.nominal or 0.0) or 1.0) / abs(rate), float_info.min)
            for wire, variable, _, rate in moved
        )
        for wire, _, _, rate in moved:
            inputs[wire.target] += width * rate
        try:
            for group in groups.values():
                self.participant.put(group)
            after = self._fetch(names)
        except CallError:
            return [math.nan] * len(names)
        return [(after[slot] - self._last[slot]) / width for slot in (self._slots[name] for name in names)]

    def _fetch(self, names: tuple[str, ...]) -> dict[int, float]:
        """Read outputs; return their values by signal."""
        if names not in self._readers:
            self._readers[names] = self._bind(names)
        found: dict[int, float] = {}
        for access, buffer, slots in self._readers[names]:
            self.participant.instance.check(access.function, access.call())
            found |= {slot: float(value) for slot, value in zip(slots, buffer, strict=True) if slot is not None}
        return found

    def _bind(self, names: tuple[str, ...]) -> list[_Reader]:
        """Bind the calls that read outputs, arrays as a whole."""
        instance = self.participant.instance
        arrays = {self._fmu.variables[name].array for name in names} - {None}
        wanted: Iterable[str] = names
        if arrays:
            wanted = [v.name for v in self._fmu.variables.values() if v.name in names or v.array in arrays]
        groups: dict[str, list[str]] = {}
        for name in wanted:
            groups.setdefault(self._fmu.fmi_types[name], []).append(name)
        readers: list[_Reader] = []
        for fmi_type, group in groups.items():
            buffer: array[Any] = array(instance.type_codes[fmi_type], [0] * len(group))
            access = instance.access("Get", group, buffer.buffer_info()[0])
            slots = tuple(self._slots[name] if name in names else None for name in group)
            readers.append(_Reader(access, buffer, slots))
        return readers

    def _derivative(self, names: tuple[str, ...], knowns: tuple[str, ...]) -> _Derivative | None:
        """Return the call for the derivative of outputs by inputs; None if FMI or the FMU has none."""
        if (names, knowns) not in self._derivatives:
            self._derivatives[names, knowns] = self._bind_derivative(names, knowns)
        return self._derivatives[names, knowns]

    def _bind_derivative(self, names: tuple[str, ...], knowns: tuple[str, ...]) -> _Derivative | None:
        variables = [self._fmu.variables[name] for name in (*names, *knowns)]
        if any(v.array is not None or self._fmu.fmi_types[v.name] not in ("Real", "Float64") for v in variables) or any(
            v.variability == "discrete" for v in variables
        ):
            return None

        def references(of: Sequence[str]) -> tuple[Array[c_uint], int]:
            return (c_uint * len(of))(*(self._fmu.variables[name].value_reference for name in of)), len(of)

        seed, slope = (c_double * len(knowns))(), (c_double * len(names))()
        try:
            call = self.participant.instance.directional_derivative(references(names), references(knowns), seed, slope)
        except AttributeError:  # its library lacks the function
            return None
        return _Derivative(call, seed, slope)
