"""The structures of the native loop, as native/engine.h has them, and the place in a run that all loops write down."""

from __future__ import annotations

import ctypes
from ctypes import Structure, c_double, c_int32, c_int64, c_size_t, c_uint64, c_void_p

NOWHERE = -1
"""Number of the component while no function of an FMU is running."""


class Position(Structure):
    """Where a run is: it can be read by another process while the run goes on, and after it has died.

    ``now`` [s] is the last instant reached, ``row`` the number of rows recorded, ``exchanges`` the number of instants
    at which values were handed over, ``calls`` that of calls so far, except for those of the native loop. Of the last
    call ``component`` is the number of the component in the system, ``function`` that of the FMI function in ``CALLS``.
    """

    _fields_ = [
        ("now", c_double),
        *((name, c_int64) for name in ("row", "exchanges", "calls")),
        *((name, c_int32) for name in ("component", "function")),
    ]
    now: float
    row: int
    exchanges: int
    calls: int
    component: int
    function: int


class Wire(Structure):
    _fields_ = [
        ("factor", c_double),
        ("offset", c_double),
        ("source", c_int64),
        ("table", c_void_p),
        ("pairs", c_int64),
    ]


class Extent(Structure):
    _fields_ = [("references", c_int64), ("values", c_int64)]


class Group(Structure):
    _fields_ = [
        *((name, c_void_p) for name in ("access", "references", "memory", "sizes", "limits", "doubles", "wires")),
        ("extents", 2 * Extent),
        *((name, c_int32) for name in ("type", "number", "component", "function")),
    ]


class FaultState(Structure):
    """Where a fault is; see engine.h."""

    _fields_ = [
        *((name, c_double) for name in ("kept", "next")),
        *((name, c_int64) for name in ("period", "first", "count", "jump")),
        *((name, c_int32) for name in ("active", "passing")),
    ]
    kept: float
    next: float
    period: int
    first: int
    count: int
    jump: int
    active: int
    passing: int


class SignalFault(Structure):
    _fields_ = [
        *((name, c_double) for name in ("amount", "start", "stop", "watch", "every")),
        *((name, c_void_p) for name in ("draws", "points", "state")),
        *((name, c_int64) for name in ("boundary", "capacity")),
        *((name, c_int32) for name in ("kind", "stepwise")),
    ]


class FaultyInput(Structure):
    _fields_ = [
        ("at", Wire),
        ("held", Wire),
        ("slot", c_int64),
        ("line", c_void_p),
        ("faults", c_void_p),
        ("n_faults", c_int64),
        ("linked", c_int64),
    ]


class FaultClock(Structure):
    """Of all faulty inputs: what their faults are asked for, and when the next one does something; see engine.h."""

    _fields_ = [
        *((name, c_double) for name in ("time", "until", "next")),
        *((name, c_int32) for name in ("stepping", "full", "changed", "unused")),
    ]
    time: float
    until: float
    next: float
    stepping: int
    full: int
    changed: int


class Trigger(Structure):
    _fields_ = [("wire", Wire), ("input", c_void_p)]


class Component(Structure):
    _functions = ("do_step", "enter_event_mode", "enter_step_mode", "update_discrete_states")
    _fields_ = [
        ("instance", c_void_p),
        *((name, c_void_p) for name in _functions),
        *((name, c_void_p) for name in ("inputs", "outputs", "triggers", "faulty")),
        *((name, c_int64) for name in ("n_inputs", "n_triggers", "n_faulty")),
        ("n_outputs", 2 * c_int64),
        *((name, c_double) for name in ("period", "due", "time")),
        *((name, c_int64) for name in ("ticks", "steps", "events")),
        *(
            (name, c_int32)
            for name in ("fmi", "role", "number", "in_event_mode", "event_needed", "stale", "plain_step", "no_return")
        ),
    ]


class Link(Structure):
    _fields_ = [
        ("wire", Wire),
        ("slot", c_int64),
        ("faulty", c_void_p),
        *((name, c_int32) for name in ("ahead", "holds_end", "observed", "unused")),
    ]


class Correction(Structure):
    _fields_ = [
        *((name, c_void_p) for name in ("derivative", "inputs", "outputs", "links", "slots", "seed", "slope", "raw")),
        ("n_links", c_int64),
        ("n_slots", 2 * c_int64),
    ]


class Member(Structure):
    _fields_ = [
        *((name, c_void_p) for name in ("component", "links", "correction", "reads", "observed", "full", "scale")),
        *((name, c_void_p) for name in ("save", "restore", "states")),
        *((name, c_int64) for name in ("n_links", "n_observed")),
        ("numbers", 4 * c_int32),
    ]


class Coupling(Structure):
    _arrays = ("start", "end", "last", "before", "full", "magnitudes", "times", "was", "matrix", "inputs")
    _scratch = ("residual", "change", "probed", "scratch", "energies", "powers")
    _counts = ("n_links", "n_members", "n_others", "n_cut", "n_steady", "n_numbers", "n_inputs", "known")
    _fields_ = [
        *((name, c_void_p) for name in ("links", "members", "others", "cut", "steady", *_arrays, *_scratch)),
        ("kept", 2 * c_void_p),
        *((name, c_int64) for name in _counts),
        ("known_then", 2 * c_int64),
        *((name, c_int64) for name in ("macro_steps", "rejected", "repeated", "forced")),
        *((name, c_double) for name in ("tolerance", "stop", "wanted", "usual", "error", "divisor", "allowed")),
        *((name, c_double) for name in ("front", "deadline")),
        *((name, c_int64) for name in ("number", "earlier")),
        *((name, c_int32) for name in ("method", "order", "loops", "has_matrix", "under_way", "out_of_time")),
    ]


class Change(Structure):
    _fields_ = [("time", c_double), ("value", c_double), ("slot", c_int64)]


class Line(Structure):
    _fields_ = [
        *((name, c_void_p) for name in ("times", "values")),
        ("count", c_int64),
        ("start", c_double),
        *((name, c_int64) for name in ("slot", "middle")),
    ]


class Bond(Structure):
    _fields_ = [
        *((name, c_int64) for name in ("effort", "flow")),
        *((name, c_void_p) for name in ("held_effort", "held_flow")),
        *((name, c_double) for name in ("effort_factor", "effort_offset", "flow_factor", "flow_offset", "watts")),
        *((name, c_void_p) for name in ("start", "energies")),
    ]


class Text(Structure):
    _fields_ = [("bytes", c_void_p), ("size", c_size_t), ("room", c_size_t)]


class Failure(Structure):
    _fields_ = [
        ("value", c_double),
        *((name, c_int32) for name in ("kind", "component", "function", "status", "group", "unused")),
    ]


class Engine(Structure):
    """The structure that the native loop works on; names as in engine.h."""

    _fields_ = [
        ("at", Position),
        *(
            (name, c_void_p)
            for name in (
                *("values", "grid", "rows", "discrete", "continuous", "changes", "lines", "coupling", "texts"),
                *("faulty", "fault_clock", "bonds"),
            )
        ),
        *((name, c_int64) for name in ("n_values", "n_recorded", "n_rows", "first_text")),
        *((name, c_int64) for name in ("n_discrete", "n_continuous", "n_changes", "n_lines", "n_faulty", "n_bonds")),
        ("change", c_int64),
        *((name, c_double) for name in ("step", "longest", "pause")),
        *((name, c_int32) for name in ("coupled", "started", "not_a_number", "parts")),
        ("failure", Failure),
    ]


WRONG_ADDRESS, STACK_OVERFLOW = 1, 2
"""Kinds of a ``Fault``."""


class Fault(Structure):
    """What has ended the process; ``kind`` is 0 if nothing is known."""

    _fields_ = [("address", c_uint64), ("kind", c_int32), ("unused", c_int32)]
    address: int
    kind: int


SIZES = tuple(
    ctypes.sizeof(structure)
    for structure in (
        *(Wire, Group, FaultState, SignalFault, FaultyInput, FaultClock, Trigger, Component),
        *(Change, Line, Bond, Text, Engine, Fault, Link, Correction, Member, Coupling),
    )
)
"""Of the structures, in the order in which the library reports its own."""
