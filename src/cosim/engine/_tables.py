"""The tables of the native loop: the structures of native/engine.h, filled in from the plan of a simulation."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from ctypes import Array, Structure, addressof, c_double, c_int32, c_int64, c_size_t, c_void_p
from typing import Any

from cosim.engine._channels import Line, Schedule
from cosim.engine._instance import Access
from cosim.engine._participant import Binaries, InputGroup, OutputGroup, Participant, Wire
from cosim.engine._plan import Plan
from cosim.engine._record import Record
from cosim.engine._role import Role

_TYPES = {code: number for number, code in enumerate("dfbBhHiIqQ")}
_OPAQUE = {"String": 10, "Binary": 11}
_ROLES = {Role.CONTINUOUS: 0, Role.EVENT: 1, Role.SAMPLED: 2}


class _Wire(Structure):
    _fields_ = [("factor", c_double), ("offset", c_double), ("source", c_int64)]


class _Extent(Structure):
    _fields_ = [("references", c_int64), ("values", c_int64)]


class _Group(Structure):
    _fields_ = [
        *((name, c_void_p) for name in ("access", "references", "memory", "sizes", "limits", "doubles", "wires")),
        ("extents", 2 * _Extent),
        *((name, c_int32) for name in ("type", "number")),
    ]


class _Trigger(Structure):
    _fields_ = [("wire", _Wire), ("input", c_void_p)]


class _Component(Structure):
    _functions = ("do_step", "enter_event_mode", "enter_step_mode", "update_discrete_states")
    _fields_ = [
        ("instance", c_void_p),
        *((name, c_void_p) for name in _functions),
        *((name, c_void_p) for name in ("inputs", "outputs", "triggers")),
        *((name, c_int64) for name in ("n_inputs", "n_triggers")),
        ("n_outputs", 2 * c_int64),
        *((name, c_double) for name in ("period", "due", "time")),
        *((name, c_int64) for name in ("ticks", "steps", "events")),
        *((name, c_int32) for name in ("fmi", "role", "number", "in_event_mode", "event_needed", "stale")),
    ]


class _Change(Structure):
    _fields_ = [("time", c_double), ("value", c_double), ("slot", c_int64)]


class _Line(Structure):
    _fields_ = [
        *((name, c_void_p) for name in ("times", "values")),
        ("count", c_int64),
        ("start", c_double),
        *((name, c_int64) for name in ("slot", "middle")),
    ]


class _Text(Structure):
    _fields_ = [("bytes", c_void_p), ("size", c_size_t), ("room", c_size_t)]


class _Failure(Structure):
    _fields_ = [
        ("value", c_double),
        *((name, c_int32) for name in ("kind", "component", "function", "status", "group", "unused")),
    ]


class Engine(Structure):
    """The structure that the native loop works on; names as in engine.h."""

    _fields_ = [
        *(
            (name, c_void_p)
            for name in ("values", "grid", "rows", "discrete", "continuous", "changes", "lines", "texts")
        ),
        *((name, c_int64) for name in ("n_values", "n_recorded", "n_rows", "first_text")),
        *((name, c_int64) for name in ("n_discrete", "n_continuous", "n_changes", "n_lines")),
        *((name, c_int64) for name in ("row", "change", "exchanges", "macro_steps")),
        *((name, c_double) for name in ("now", "step")),
        *((name, c_int32) for name in ("coupled", "started", "not_a_number", "unused")),
        ("failure", _Failure),
    ]


SIZES = tuple(ctypes.sizeof(s) for s in (_Wire, _Group, _Trigger, _Component, _Change, _Line, _Text, Engine))
"""Of the structures, in the order in which the library reports its own."""


class Tables:
    """The tables of one run, and all memory that they refer to.

    ``participants`` and ``groups`` are in the order in which a failure counts them.
    """

    def __init__(self, plan: Plan, record: Record, step: float | None) -> None:
        """Fill in the tables; ``step`` [s] is the macro step of the Jacobi algorithm, None for the default one."""
        self.participants = [*plan.discrete, *plan.continuous]
        self.groups: list[InputGroup | OutputGroup] = []
        self._plan = plan
        self._record = record
        self._memory: list[object] = []
        values = plan.values
        self._values = values.buffer_info()[0]
        self._inputs = plan.inputs.buffer_info()[0]
        components = [self._component(number, participant) for number, participant in enumerate(self.participants)]
        split = len(plan.discrete)
        self._discrete = (_Component * split)(*components[:split])
        self._continuous = (_Component * len(plan.continuous))(*components[split:])
        lines = [self._line(line) for line in plan.lines]
        self.engine = Engine(
            values=self._values,
            grid=record.grid.ctypes.data,
            rows=record.rows.ctypes.data,
            discrete=addressof(self._discrete),
            continuous=addressof(self._continuous),
            changes=self._changes(plan.schedule),
            lines=self._keep((_Line * len(lines))(*lines)),
            texts=self._keep((_Text * (len(values) - plan.first_text))()),
            n_values=len(values),
            first_text=plan.first_text,
            n_recorded=plan.recorded,
            n_rows=len(record.grid),
            n_discrete=split,
            n_continuous=len(plan.continuous),
            n_changes=len(plan.schedule.changes),
            n_lines=len(lines),
            step=step or 0.0,
            coupled=plan.coupled,
        )

    def take_back(self) -> None:
        """Put what the native loop has counted into the record and the participants."""
        engine, record = self.engine, self._record
        record.count, record.now, record.exchanges = engine.row, engine.now, engine.exchanges
        for participant, component in zip(self.participants, [*self._discrete, *self._continuous], strict=True):
            participant.due = component.due
            participant.time = component.time
            participant.ticks = component.ticks
            participant.steps = component.steps
            participant.events = component.events
            participant.in_event_mode = bool(component.in_event_mode)

    def _keep(self, memory: Array[Any]) -> int:
        self._memory.append(memory)
        return addressof(memory)

    def _component(self, number: int, participant: Participant) -> _Component:
        instance = participant.instance
        component = _Component(
            instance=instance.component,
            do_step=instance.pointer("DoStep"),
            period=participant.period,
            due=participant.due,
            time=participant.time,
            fmi=int(instance.fmu.fmi_version[0]),
            role=_ROLES[participant.role],
            number=number,
            in_event_mode=participant.in_event_mode,
            n_inputs=len(participant.input_groups),
            n_outputs=_counts(participant.output_groups),
            n_triggers=len(participant.triggers),
        )
        if participant.role is Role.EVENT:
            component.enter_event_mode = instance.pointer("EnterEventMode")
            component.enter_step_mode = instance.pointer("EnterStepMode")
            component.update_discrete_states = instance.pointer("UpdateDiscreteStates")
        inputs = [self._input_group(participant, group) for group in participant.input_groups]
        outputs = [self._output_group(participant, group) for group in participant.output_groups]
        triggers = [_Trigger(_wire(wire), self._inputs + 8 * wire.target) for wire in participant.triggers]
        component.inputs = self._keep((_Group * len(inputs))(*inputs))
        component.outputs = self._keep((_Group * len(outputs))(*outputs))
        component.triggers = self._keep((_Trigger * len(triggers))(*triggers))
        return component

    def _input_group(self, participant: Participant, group: InputGroup) -> _Group:
        number = self._number(group)
        return _Group(
            access=participant.instance.pointer(group.access.function),
            references=addressof(group.access.references),
            memory=group.access.address,
            **_binaries(group),
            doubles=self._inputs + 8 * group.start,
            wires=self._keep((_Wire * len(group.wires))(*map(_wire, group.wires))),
            extents=_extents(None, group.access),
            type=_type(participant, group),
            number=number,
        )

    def _output_group(self, participant: Participant, group: OutputGroup) -> _Group:
        number = self._number(group)
        return _Group(
            access=participant.instance.pointer(group.whole.function),
            references=addressof(group.whole.references),
            memory=group.whole.address,
            **_binaries(group),
            doubles=self._values + 8 * group.start,
            extents=_extents(group.connected, group.whole),
            type=_type(participant, group),
            number=number,
        )

    def _number(self, group: InputGroup | OutputGroup) -> int:
        self.groups.append(group)
        return len(self.groups) - 1

    def _changes(self, schedule: Schedule) -> int:
        changes = [_Change(time, value, slot) for time, slot, value in schedule.changes]
        return self._keep((_Change * len(changes))(*changes))

    def _line(self, line: Line) -> _Line:
        times, values = (_doubles(numbers) for numbers in (line.times, line.values))
        self._memory += [times, values]
        return _Line(addressof(times), addressof(values), len(times), line.start, line.slot, line.middle)


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


def _extents(connected: Access | None, whole: Access) -> Array[_Extent]:
    return (_Extent * 2)(*(_Extent(len(a.references), a.length) if a else _Extent() for a in (connected, whole)))


def _wire(wire: Wire) -> _Wire:
    return _Wire(wire.factor, wire.offset, wire.source)


def _doubles(numbers: Sequence[float]) -> Array[c_double]:
    return (c_double * len(numbers))(*numbers)
