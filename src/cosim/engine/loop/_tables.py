"""The tables of the native loop: the structures of native/engine.h, filled in from the plan of a simulation."""

from __future__ import annotations

from collections.abc import Sequence
from ctypes import Array, addressof, c_double, c_int64, sizeof, string_at
from math import inf
from typing import Any

from cosim.engine.coupling._coupling_table import CouplingTable
from cosim.engine.fmu._calls import NUMBERS
from cosim.engine.fmu._instance import Access
from cosim.engine.loop._plan import Plan
from cosim.engine.loop._record import Record
from cosim.engine.native import _structures as structures
from cosim.engine.signals._participant import Binaries, InputGroup, OutputGroup, Participant
from cosim.engine.signals._signal_faults import FaultyInput, SignalFault
from cosim.engine.system._channels import Line, Schedule
from cosim.engine.system._method import Method
from cosim.engine.system._role import Role
from cosim.engine.system._system import SAME_INSTANT
from cosim.engine.system._wire import Wire

_TYPES = {code: number for number, code in enumerate("dfbBhHiIqQ")}
_OPAQUE = {"String": 10, "Binary": 11}
_ROLES = {Role.CONTINUOUS: 0, Role.EVENT: 1, Role.SAMPLED: 2}


class Tables:
    """The tables of one run, and all memory that they refer to.

    ``participants`` are by the number of their component in the system, ``groups`` in the order in which a failure
    counts them. ``engine`` lies in the memory that the record has for it.
    """

    def __init__(self, plan: Plan, record: Record, method: Method, pause: float = inf) -> None:
        """Fill in the tables for a run that goes on from where the plan and the record are, until ``pause`` [s]."""
        participants = [*plan.discrete, *plan.continuous]
        self.participants = {participant.instance.site.number: participant for participant in participants}
        self.groups: list[InputGroup | OutputGroup] = []
        self._plan = plan
        self._memory: list[object] = []
        values = plan.values
        self._values = values.buffer_info()[0]
        self._inputs = plan.inputs.buffer_info()[0]
        self._lines = (structures.Line * len(plan.lines))(*map(self._line, plan.lines))
        self._delays: list[tuple[SignalFault, structures.SignalFault]] = []
        self._faulty = (structures.FaultyInput * len(plan.faults.inputs))(*map(self._faulty_input, plan.faults.inputs))
        components = [self._component(participant) for participant in participants]
        split = len(plan.discrete)
        self._discrete = (structures.Component * split)(*components[:split])
        self._continuous = (structures.Component * len(plan.continuous))(*components[split:])
        self._texts = (structures.Text * (len(values) - plan.first_text))()
        places = {component.number: addressof(component) for component in (*self._discrete, *self._continuous)}
        self._coupling = (
            CouplingTable(plan.coupling, places, self._wire, self._faulty_place, method.parts)
            if plan.coupling is not None
            else None
        )
        self.engine = structures.Engine.from_buffer(record.header)
        _fill(
            self.engine,
            values=self._values,
            grid=record.grid.ctypes.data,
            rows=record.rows.ctypes.data,
            discrete=addressof(self._discrete),
            continuous=addressof(self._continuous),
            changes=self._changes(plan.schedule),
            lines=addressof(self._lines),
            texts=addressof(self._texts),
            coupling=self._coupling.address if self._coupling is not None else 0,
            n_values=len(values),
            first_text=plan.first_text,
            n_recorded=plan.recorded,
            n_rows=len(record.grid),
            n_discrete=split,
            n_continuous=len(plan.continuous),
            n_changes=len(plan.schedule.changes),
            n_lines=len(self._lines),
            faulty=addressof(self._faulty),
            n_faulty=len(self._faulty),
            fault_clock=addressof(plan.faults.clock),
            bonds=self._bonds(),
            n_bonds=len(plan.power.bonds),
            change=plan.schedule.position,
            step=method.step if method.is_fixed and method.step else 0.0,
            longest=method.step or inf,
            pause=pause - SAME_INSTANT,
            coupled=plan.coupled,
            parts=method.parts,
            started=record.exchanges > 0,
            not_a_number=True,  # as far as is known here
        )

    def take_back(self) -> None:
        """Put what the native loop has counted into the participants; no function of an FMU is running any more."""
        self.engine.at.component = structures.NOWHERE
        for component in (*self._discrete, *self._continuous):
            participant = self.participants[component.number]
            participant.due = component.due
            participant.time = component.time
            participant.ticks = component.ticks
            participant.steps = component.steps
            participant.events = component.events
            participant.in_event_mode = bool(component.in_event_mode)
            participant.stale = bool(component.stale)
        self._plan.schedule.skip(self.engine.at.now)
        for slot, text in enumerate(self._texts, self._plan.first_text):
            if text.bytes:
                self._plan.texts[slot] = string_at(text.bytes, text.size)
        if self._coupling is not None:
            self._coupling.take_back()

    def make_room(self) -> None:
        """Give more memory to the histories of delayed signals that need it before the next macro step."""
        if not self._plan.faults.clock.full:
            return
        for fault, structure in self._delays:
            if not fault.make_room():
                fault.grow()
                structure.points, structure.capacity = fault.points.buffer_info()[0], fault.capacity

    def _keep(self, memory: Array[Any]) -> int:
        self._memory.append(memory)
        return addressof(memory)

    def _component(self, participant: Participant) -> structures.Component:
        instance = participant.instance
        component = structures.Component(
            instance=instance.component,
            do_step=instance.pointer("DoStep"),
            period=participant.period,
            due=participant.due,
            time=participant.time,
            ticks=participant.ticks,
            steps=participant.steps,
            events=participant.events,
            fmi=int(instance.fmu.fmi_version[0]),
            role=_ROLES[participant.role],
            number=instance.site.number,
            in_event_mode=participant.in_event_mode,
            stale=participant.stale,
            plain_step=instance.plain_step,
            no_return=bool(instance.no_return.value),
            n_inputs=len(participant.input_groups),
            n_outputs=_counts(participant.output_groups),
            n_triggers=len(participant.triggers),
            n_faulty=len(participant.faulty),
        )
        if participant.faulty:
            component.faulty = self._faulty_place(participant.faulty[0])
        if participant.role is Role.EVENT:
            component.enter_event_mode = instance.pointer("EnterEventMode")
            component.enter_step_mode = instance.pointer("EnterStepMode")
            component.update_discrete_states = instance.pointer("UpdateDiscreteStates")
        inputs = [self._input_group(participant, group) for group in participant.input_groups]
        outputs = [self._output_group(participant, group) for group in participant.output_groups]
        triggers = [structures.Trigger(self._wire(w), self._inputs + 8 * w.target) for w in participant.triggers]
        component.inputs = self._keep((structures.Group * len(inputs))(*inputs))
        component.outputs = self._keep((structures.Group * len(outputs))(*outputs))
        component.triggers = self._keep((structures.Trigger * len(triggers))(*triggers))
        return component

    def _input_group(self, participant: Participant, group: InputGroup) -> structures.Group:
        number = self._number(group)
        return structures.Group(
            access=participant.instance.pointer(group.access.function),
            references=addressof(group.access.references),
            memory=group.access.address,
            **_binaries(group),
            doubles=self._inputs + 8 * group.start,
            wires=self._keep((structures.Wire * len(group.wires))(*map(self._wire, group.wires))),
            extents=_extents(None, group.access),
            type=_type(participant, group),
            number=number,
            component=participant.instance.site.number,
            function=NUMBERS[group.access.function],
        )

    def _wire(self, wire: Wire) -> structures.Wire:
        pairs = _doubles([number for pair in wire.table for number in pair])
        table = self._keep(pairs) if wire.table else 0
        return structures.Wire(wire.factor, wire.offset, wire.source, table, len(wire.table))

    def _output_group(self, participant: Participant, group: OutputGroup) -> structures.Group:
        number = self._number(group)
        return structures.Group(
            access=participant.instance.pointer(group.whole.function),
            references=addressof(group.whole.references),
            memory=group.whole.address,
            **_binaries(group),
            doubles=self._values + 8 * group.start,
            extents=_extents(group.connected, group.whole),
            type=_type(participant, group),
            number=number,
            component=participant.instance.site.number,
            function=NUMBERS[group.whole.function],
        )

    def _number(self, group: InputGroup | OutputGroup) -> int:
        self.groups.append(group)
        return len(self.groups) - 1

    def _faulty_place(self, one: FaultyInput) -> int:
        return addressof(self._faulty) + self._plan.faults.inputs.index(one) * sizeof(structures.FaultyInput)

    def _faulty_input(self, one: FaultyInput) -> structures.FaultyInput:
        faults = (structures.SignalFault * len(one.faults))(*map(self._signal_fault, one.faults))
        self._delays += [(fault, structure) for fault, structure in zip(one.faults, faults, strict=True)]
        line = None
        if one.line is not None:
            line = addressof(self._lines) + self._plan.lines.index(one.line) * sizeof(structures.Line)
        at, held = self._wire(one.at), self._wire(one.held)
        return structures.FaultyInput(at, held, one.slot, line, self._keep(faults), len(faults), one.linked)

    def _signal_fault(self, fault: SignalFault) -> structures.SignalFault:
        return structures.SignalFault(
            amount=fault.amount,
            start=fault.start,
            stop=fault.stop,
            watch=fault.watch,
            every=fault.every,
            draws=fault.draws.buffer_info()[0],
            points=fault.points.buffer_info()[0],
            state=addressof(fault.state),
            boundary=fault.boundary,
            capacity=fault.capacity,
            kind=fault.kind,
            stepwise=fault.stepwise,
        )

    def _bonds(self) -> int:
        power = self._plan.power
        start, energies = power.start.buffer_info()[0], power.energies.buffer_info()[0]
        bonds = [
            structures.Bond(
                bond.effort,
                bond.flow,
                self._inputs + 8 * bond.held_effort,
                self._inputs + 8 * bond.held_flow,
                bond.effort_factor,
                bond.effort_offset,
                bond.flow_factor,
                bond.flow_offset,
                bond.watts,
                start + 16 * i,
                energies + 24 * i,
            )
            for i, bond in enumerate(power.bonds)
        ]
        return self._keep((structures.Bond * len(bonds))(*bonds))

    def _changes(self, schedule: Schedule) -> int:
        changes = [structures.Change(time, value, slot) for time, slot, value in schedule.changes]
        return self._keep((structures.Change * len(changes))(*changes))

    def _line(self, line: Line) -> structures.Line:
        times, values = (_doubles(numbers) for numbers in (line.times, line.values))
        self._memory += [times, values]
        return structures.Line(addressof(times), addressof(values), len(times), line.start, line.slot, line.middle)


def _fill(engine: structures.Engine, **fields: object) -> None:
    for name, value in fields.items():
        setattr(engine, name, value)


def _type(participant: Participant, group: InputGroup | OutputGroup) -> int:
    if group.fmi_type in _OPAQUE:
        return _OPAQUE[group.fmi_type]
    return _TYPES[participant.instance.type_codes[group.fmi_type]]


def _binaries(group: InputGroup | OutputGroup) -> dict[str, int]:
    """Return where the sizes of Binary variables lie, and their limits."""
    buffer = group.buffer
    if not isinstance(buffer, Binaries):
        return {}
    return {"sizes": addressof(buffer.sizes), "limits": addressof(buffer.limits)}


def _counts(groups: Sequence[OutputGroup]) -> Array[c_int64]:
    return (c_int64 * 2)(sum(group.connected is not None for group in groups), len(groups))


def _extents(connected: Access | None, whole: Access) -> Array[structures.Extent]:
    extent = structures.Extent
    return (extent * 2)(*(extent(len(a.references), a.length) if a else extent() for a in (connected, whole)))


def _doubles(numbers: Sequence[float]) -> Array[c_double]:
    return (c_double * len(numbers))(*numbers)
