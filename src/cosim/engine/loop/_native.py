"""Runs the native loop: one call per piece of wall time, and its failures in the words of the Python loop."""

from __future__ import annotations

import ctypes
from array import array
from collections.abc import Callable
from ctypes import byref
from math import inf

from cosim.engine.coupling._adaptive import lost
from cosim.engine.coupling._agreement import disagreement
from cosim.engine.fmu._instance import CallError
from cosim.engine.loop._interrupt import DeferredInterrupt
from cosim.engine.loop._loop import PROGRESS_INTERVAL, check_numbers, endless
from cosim.engine.loop._plan import Plan
from cosim.engine.loop._record import Record
from cosim.engine.loop._tables import Tables
from cosim.engine.signals._participant import InputGroup
from cosim.engine.system._method import Method

_UNFINISHED, _FINISHED, _BROKEN, _PAUSED = range(4)
(
    _CALL_FAILED,
    _ASKS_TO_END,
    _RETURNED_EARLY,
    _NEVER_SETTLES,
    _ANNOUNCES_THE_PAST,
    _WITHOUT_END,
    _NOT_A_NUMBER,
    _OUT_OF_RANGE,
    _OUT_OF_MEMORY,
    _DISAGREEMENT,
    _LOST,
) = range(1, 12)
_FUNCTIONS = ("DoStep", "EnterEventMode", "EnterStepMode", "UpdateDiscreteStates")
_SAVE, _RESTORE, _DERIVE = 5, 6, 7

_PIECE = 0.1
"""Wall time [s] after which Python looks whether the user wants to interrupt."""


def _loop_for(plan: Plan, method: Method, pause: float) -> str:
    """Return which of the three loops does it; they differ in what they are able to."""
    instances = [participant.instance for participant in (*plan.discrete, *plan.continuous)]
    if any(instance.site.watched for instance in instances):
        return "cosim_run_watched"
    divided = method.parts > 1 or (method.step is not None and not method.is_fixed)
    besides = plan.coupling is not None or plan.faults.inputs or plan.power.bonds or pause < inf
    return "cosim_run" if divided or besides or not all(i.no_return.value for i in instances) else "cosim_run_plain"


def run_native(
    library: ctypes.CDLL,
    plan: Plan,
    record: Record,
    method: Method,
    progress: Callable[[float], None] | None,
    pause: float = inf,
) -> None:
    """Do what ``run`` does, or ``run_jacobi`` if the method asks for it, with the same numbers, bit for bit."""
    tables = Tables(plan, record, method, pause)
    engine = tables.engine
    go_on = getattr(library, _loop_for(plan, method, pause))
    limit = 0.0 if progress is not None else _PIECE
    outcome = _UNFINISHED
    try:
        for slot, text in plan.texts.items():
            library.cosim_set_text(byref(engine), slot, text, len(text))
        with DeferredInterrupt() as interrupt:
            while outcome == _UNFINISHED:
                outcome = go_on(byref(engine), limit)
                interrupt.check()
                tables.make_room()
                if progress is not None and outcome == _UNFINISHED:
                    progress(engine.at.now)
                    limit = PROGRESS_INTERVAL
    finally:
        tables.take_back()
        library.cosim_free_texts(byref(engine))
    if outcome == _BROKEN:
        _raise(tables, plan)
    if progress is not None and outcome == _FINISHED:
        progress(float(record.grid[-1]))


def _raise(tables: Tables, plan: Plan) -> None:
    """Raise the CallError that the Python loop would have raised."""
    failure = tables.engine.failure
    participant = tables.participants[failure.component]
    instance = participant.instance
    if failure.kind == _NOT_A_NUMBER:
        check_numbers(plan)
    elif failure.kind == _WITHOUT_END:
        raise endless(plan)
    elif failure.kind == _ANNOUNCES_THE_PAST:
        raise participant.announces_the_past()
    elif failure.kind == _NEVER_SETTLES:
        raise participant.never_settles()
    elif failure.kind in (_ASKS_TO_END, _RETURNED_EARLY):
        instance.fail_to_go_on(early=failure.kind == _RETURNED_EARLY)
    if failure.kind == _DISAGREEMENT and plan.coupling is not None:
        raise disagreement(plan.coupling, failure.value)
    if failure.kind == _LOST and plan.coupling is not None and (error := lost(plan.coupling)) is not None:
        raise error
    if failure.kind == _CALL_FAILED and failure.function in (_SAVE, _RESTORE, _DERIVE):
        get, put = instance.state_symbol("Get"), instance.state_symbol("Set")
        names = {_SAVE: get, _RESTORE: put, _DERIVE: "GetDirectionalDerivative"}
        instance.check(names[failure.function], failure.status)
    if failure.kind == _CALL_FAILED and failure.function < len(_FUNCTIONS):
        instance.check(_FUNCTIONS[failure.function], failure.status)
    if failure.kind == _CALL_FAILED and failure.group < 0 and plan.coupling is not None:
        reads = next(m.observed for m in plan.coupling.members if m.participant is participant)
        instance.check(reads.access.function if reads is not None else "", failure.status)
    group = tables.groups[failure.group]
    if failure.kind == _OUT_OF_RANGE and isinstance(group, InputGroup) and isinstance(group.buffer, array):
        raise participant.out_of_range(failure.value, group.buffer)
    if failure.kind == _OUT_OF_RANGE:
        raise participant.too_long(int(failure.value))
    if failure.kind == _CALL_FAILED:
        access = group.access if isinstance(group, InputGroup) else group.whole
        instance.check(access.function, failure.status)
    if failure.kind == _OUT_OF_MEMORY:
        raise CallError(instance, "has put out a text or Binary for which there is no memory", "let it put out less")
    raise CallError(instance, f"ended for a reason of the number {failure.kind}", "report this as a defect of cosim")
