"""Algebraic loops of components that may be set and read at will, in Initialization and Event Mode, and their solution.

Real outputs that cut a loop are found by Newton's method, all others follow from them. Outputs of other types are held
while this is done, and replaced by what has come out of it until they agree with it.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from cosim.engine.algebra._newton import Matrix, Scale, Solution, Vector, iterate, solve
from cosim.engine.algebra._port import Port
from cosim.engine.algebra._schedule import Reading, schedule
from cosim.engine.fmu._instance import CallError
from cosim.engine.fmu._variable import Variable
from cosim.engine.signals._signal_faults import SignalFaults
from cosim.engine.system._connection import Connection, dotted
from cosim.engine.system._graph import Depends, End, Loop
from cosim.engine.system._system import System

_MOST_ROUNDS = 50
_SHOWN = 12
_DOUBLE, _SINGLE = 1e-9, 1e-6
"""Relative differences that rounding, to double and to single precision, may make on a long way round."""
_REMEDY = "change a gain or an offset in it, or break it: by a state, a sample or a delay in one of its components"


class Signals(Protocol):
    """What is needed of the plan of a run: where the signals are, their values, and the faults of inputs."""

    signals: dict[tuple[str, str], int]
    values: array[float]
    texts: dict[int, bytes]
    faults: SignalFaults


class LoopError(CallError):
    """An algebraic loop that cannot be solved: no FMU is to blame."""

    @property
    def refusal(self) -> None:
        """Return nothing: what FMUs have said of values that were tried does not count."""

    def __str__(self) -> str:
        """Return what is wrong and what to do."""
        return f"{self.what}; {self.remedy}"


@dataclass
class Network:
    """Components that may be set and read, by name, and what drives them.

    ``slots`` are the signals of connected outputs in ``values``; ``known`` are the signals that have a value by now.
    ``texts`` are as in ``Participant``. ``tolerance`` is the relative one of the run. Of what has been found ``sizes``
    are the largest magnitudes met of the signals in loops, and ``remarks`` what the user should know.
    """

    ports: Mapping[str, Port]
    connections: Sequence[Connection]
    depends: Depends
    slots: Mapping[End, int]
    values: array[float]
    texts: Mapping[int, bytes]
    known: set[int]
    tolerance: float
    remarks: list[str] = field(default_factory=list)
    sizes: dict[int, float] = field(default_factory=dict)

    @classmethod
    def of(
        cls, plan: Signals, system: System, ports: Mapping[str, Port], depends: Depends, tolerance: float
    ) -> Network:
        """Return the components that have ports, of which no output is known yet, and the connections between them."""
        connections = [c for c in system.connections if c.source[0] in ports and c.target[0] in ports]
        unknown = {plan.signals[connection.source] for connection in connections}
        unknown |= {faulty.slot for faulty in plan.faults.inputs}
        known = set(range(len(plan.values))) - unknown
        return cls(ports, connections, depends, plan.signals, plan.values, plan.texts, known, tolerance)

    def agreement(self, single: bool) -> float:
        """Return the relative difference up to which an output and an input that it drives agree."""
        return max(1e-2 * self.tolerance, _SINGLE if single else _DOUBLE)

    def settle(self) -> None:
        """Compute all connected outputs; raises CallError if a component fails, or LoopError."""
        for step in schedule(self.connections, self.depends, list(self.ports)):
            if isinstance(step, Loop):
                self.solve(step)
            else:
                self.compute(step)

    def compute(self, reading: Reading) -> None:
        """Set what is known and read outputs; raises CallError if one is not a number."""
        port = self.ports[reading.component]
        port.write(self.known)
        for output, value in zip(reading.outputs, port.read(_names(reading)), strict=True):
            if math.isnan(value):
                raise CallError(
                    port.participant.instance,
                    f"its output {output[1]} is not a number (NaN)",
                    "check its parameters and its inputs at that time, or try another tolerance",
                )
            self.known.add(self.slots[output])

    def solve(self, loop: Loop) -> None:
        """Find values with which all connections of a loop are fulfilled; raises CallError or LoopError."""
        members = (*loop.torn, *loop.others)
        discrete = [output for output in members if self.variable(output).type != "Real"]
        if discrete:
            self._solve_discrete(loop, discrete)
        else:
            _RealLoop(self, loop).solve()

    def _solve_discrete(self, loop: Loop, discrete: list[End]) -> None:
        """Replace what is not Real by what comes out until it stays; Real loops inside are solved each time."""
        steps = schedule(loop.connections, self.depends, list(self.ports), discrete)
        for output in discrete:
            if self.slots[output] not in self.known and self.variable(output).type not in ("String", "Binary"):
                self.values[self.slots[output]] = self.guess(loop, output)
                self.known.add(self.slots[output])
        seen: list[tuple[object, ...]] = [self._state(discrete)]
        remarks = len(self.remarks)
        for _ in range(_MOST_ROUNDS):
            del self.remarks[remarks:]
            failure: LoopError | None = None
            for step in steps:
                try:
                    if isinstance(step, Loop):
                        self.solve(step)
                    else:
                        self.compute(step)
                except LoopError as error:  # with other discrete values there may be a solution
                    failure = error
            state = self._state(discrete)
            if state == seen[-1]:
                if failure is not None:
                    raise failure
                return
            if state in seen:
                self._fail_to_settle(loop, discrete, [*seen[seen.index(state) :], state])
            seen.append(state)
        self._fail_to_settle(loop, discrete, seen[-2:])

    def _state(self, outputs: Iterable[End]) -> tuple[object, ...]:
        return tuple(self.texts.get(self.slots[o], self.values[self.slots[o]]) for o in outputs)

    def _fail_to_settle(self, loop: Loop, discrete: list[End], states: list[tuple[object, ...]]) -> None:
        ways = [
            f"{dotted(output)} {' -> '.join(self._shown(output, state[i]) for state in states[:_SHOWN])}"
            for i, output in enumerate(discrete[:_SHOWN])
            if len({state[i] for state in states}) > 1
        ]
        raise LoopError(
            self.ports[loop.torn[0][0]].participant.instance,
            f"the algebraic loop {loop} does not come to rest: {', '.join(ways)}, and so on",
            "change start values of its inputs, or break it: by a sample or a delay in one of its components",
        )

    def _shown(self, output: End, value: object) -> str:
        if self.variable(output).type == "Boolean":
            return "true" if value else "false"
        return f"{value:g}" if isinstance(value, float) else repr(value)

    def variable(self, output: End) -> Variable:
        """Return what is known of an output."""
        return self.ports[output[0]].participant.instance.fmu.variables[output[1]]

    def is_single(self, end: End) -> bool:
        """Tell whether a variable is in single precision."""
        return self.ports[end[0]].participant.instance.fmu.fmi_types[end[1]] == "Float32"

    def guess(self, loop: Loop, output: End) -> float:
        """Return the value with which the first input that an output drives would be what it was set to last."""
        connection = next(c for c in loop.connections if c.source == output)
        name, variable = connection.target
        taken = self.ports[name].input(variable)
        if connection.table:
            return next((value for value, mapped in connection.table if mapped == taken), taken)
        return (taken - connection.offset) / connection.factor if connection.factor else 0.0


class _RealLoop:
    """One solution of a loop whose outputs are all Real: the torn ones are the unknowns x, of shape (n,)."""

    def __init__(self, network: Network, loop: Loop) -> None:
        self.network = network
        self.loop = loop
        self.slots = [network.slots[output] for output in loop.torn]
        steps = schedule(loop.connections, network.depends, list(network.ports), loop.torn)
        self.readings = [step for step in steps if isinstance(step, Reading)]
        self.failure: CallError | None = None
        self.last: tuple[Vector, Vector] | None = None

    def solve(self) -> None:
        """Find the solution; raises CallError or LoopError."""
        network = self.network
        logs = [network.ports[name].participant.instance.log for name in {r.component for r in self.readings}]
        said = [log.messages for log in logs]
        with np.errstate(all="ignore"):
            found = self._best(np.array([network.guess(self.loop, output) for output in self.loop.torn]))
        if not found.solved:
            self._fail(found)
        for log, messages in zip(logs, said, strict=True):
            log.messages = messages  # without what was said of values that were only tried
        network.known.update(network.slots[output] for output in (*self.loop.torn, *self.loop.others))
        if found.free:
            network.remarks.append(
                f"the algebraic loop {self.loop} does not determine its variables at initialisation: around it a "
                f"change comes back unchanged; of all solutions this one, close to the start values, was taken: "
                f"{self._values()}; give the inputs other start values for another one"
            )

    def _best(self, start: Vector) -> Solution:
        """Try until one way leads to a solution; else return what comes closest to one."""
        network, tried = self.network, list[Solution]()
        first = self.evaluate(start)
        suspicious = not self._is_declared() and np.all(np.isfinite(first)) and not np.array_equal(start, first)
        if suspicious and np.array_equal(first, self.evaluate(first)):  # it is no loop in fact
            return Solution(first, first, True, 0)
        nominal = np.array([network.variable(output).nominal or 1.0 for output in self.loop.torn])
        starts = [start, first, start + nominal, start - nominal]
        ports = [network.ports[name] for name in {reading.component for reading in self.readings}]
        exact = [port for port in ports if port.exact]
        ways: list[Callable[[Vector], Solution]] = [self._newton(nominal)]
        if exact:
            ways.append(self._newton(nominal))
        for number, way in enumerate(ways):
            for port in exact:
                port.exact = number == 0
            for one in starts:
                tried.append(way(one))
                if tried[-1].solved:
                    break
            if tried[-1].solved:
                break
        for port in exact:
            port.exact = True
        if tried[-1].solved:
            return tried[-1]
        tried.append(iterate(self.evaluate, start, Scale(nominal), _MOST_ROUNDS))
        if tried[-1].solved:
            return tried[-1]
        finite = [one for one in tried if np.all(np.isfinite(one.residual))]
        if not finite and self.failure is not None:
            raise self.failure
        best = min(finite or tried, key=lambda one: float(np.max(np.abs(one.residual))))
        self.evaluate(best.x)
        return best

    def _newton(self, nominal: Vector) -> Callable[[Vector], Solution]:
        enough = 0.1 * self.network.agreement(single=self._is_single())
        return lambda start: solve(self.evaluate, self.slope, start, Scale(nominal), enough)

    def _is_single(self) -> bool:
        """Tell whether a variable of the loop is in single precision."""
        ends = (end for connection in self.loop.connections for end in (connection.source, connection.target))
        return any(map(self.network.is_single, ends))

    def _is_declared(self) -> bool:
        ports = self.network.ports
        return all(
            ports[name].participant.instance.fmu.initial_dependencies.get(output) is not None
            for name, output in (*self.loop.torn, *self.loop.others)
        )

    def evaluate(self, x: Vector) -> Vector:
        """Return what comes back around the loop if the torn outputs are x; not a number where a component fails."""
        network = self.network
        if self.last is not None and np.array_equal(x, self.last[0]):
            return self.last[1]
        for slot, value in zip(self.slots, x, strict=True):
            network.values[slot] = value
        known = network.known | set(self.slots)
        back = np.full_like(x, np.nan)
        try:
            for reading in self.readings:
                port = network.ports[reading.component]
                port.write(known)
                for output, value in zip(reading.outputs, port.read(_names(reading)), strict=True):
                    slot = network.slots[output]
                    if abs(value) > network.sizes.get(slot, 0.0):
                        network.sizes[slot] = abs(value)
                    if slot in self.slots:
                        k = self.slots.index(slot)
                        back[k] = value
                        network.values[slot] = x[k]
                    known.add(slot)
        except CallError as failure:
            self.failure = failure
            back = np.full_like(x, np.nan)
        self.last = x, back
        return back

    def slope(self) -> Matrix:
        """Return the derivative of what comes back, of shape (n, n), at the last x that was evaluated."""
        network, n = self.network, len(self.slots)
        self.last = None  # inputs may be changed
        slope = np.zeros((n, n))
        for k in range(n):
            rates = {slot: float(i == k) for i, slot in enumerate(self.slots)}
            for reading in self.readings:
                found = network.ports[reading.component].slopes(_names(reading), rates)
                for output, rate in zip(reading.outputs, found, strict=True):
                    slot = network.slots[output]
                    if slot in self.slots:
                        slope[self.slots.index(slot), k] = rate
                    else:
                        rates[slot] = rate
        return slope

    def _fail(self, found: Solution) -> None:
        if found.free:
            why = "has no solution, or none close by: around it a change comes back unchanged (a gain of 1)"
        else:
            why = "has no solution that Newton's method or repeated evaluation finds"
        residuals = ", ".join(
            f"{dotted(output)} = {self._quantity(output, x)} comes back as {self._quantity(output, back)} "
            f"(residual {self._quantity(output, back - x)})"
            for output, x, back in zip(self.loop.torn[:_SHOWN], found.x, found.g, strict=False)
        )
        raise LoopError(
            self.network.ports[self.loop.torn[0][0]].participant.instance,
            f"the algebraic loop {self.loop} {why}; closest: {residuals}, with {self._values(inputs=True)}",
            _REMEDY,
        )

    def _values(self, inputs: bool = False) -> str:
        """Return the values of the loop's variables, in the order of the way round."""
        network = self.network
        shown: dict[str, str] = {}
        for connection in self.loop.connections:
            value = network.values[network.slots[connection.source]]
            if not (inputs and connection.source in self.loop.torn):
                shown[dotted(connection.source)] = self._quantity(connection.source, value)
            taken = value * connection.factor + connection.offset
            shown[dotted(connection.target)] = self._quantity(connection.target, taken)
        more = f" and {len(shown) - _SHOWN} more" if len(shown) > _SHOWN else ""
        return ", ".join(f"{name} = {text}" for name, text in list(shown.items())[:_SHOWN]) + more

    def _quantity(self, end: End, value: float) -> str:
        unit = self.network.variable(end).unit
        return f"{value:.6g}" + (f" {unit}" if unit not in (None, "1") else "")


def _names(reading: Reading) -> tuple[str, ...]:
    return tuple(name for _, name in reading.outputs)
