"""Where faulty inputs lie among the signals, and the tables that their faults need: random numbers, history."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from zlib import crc32

import numpy as np

from cosim.engine.signals._signal_faults import FaultyInput, SignalFault
from cosim.engine.system._channels import Line
from cosim.engine.system._connection import dotted
from cosim.engine.system._fault import RANDOM, Fault
from cosim.engine.system._role import Role, fixed_step_of, sample_period
from cosim.engine.system._system import SAME_INSTANT, System
from cosim.engine.system._wire import Wire
from cosim.errors import InputError

MOST_DRAWS = 10_000_000
"""Random numbers that one fault may need."""

Source = tuple[int, float, float, tuple[tuple[float, float], ...]]
"""Slot, factor, offset and table of what drives an input."""


def resolved_faults(system: System, stop: float, output_interval: float) -> list[Fault]:
    """Return the faults of a checked system, all that need a period ``every`` [s] having one.

    Raises InputError if one would draw too many random numbers up to ``stop`` [s].
    """
    faults: list[Fault] = []
    for fault in system.faults:
        if fault.kind not in RANDOM:
            faults.append(fault)
            continue
        every = fault.every or _period(system, fault.target, output_interval)
        if (min(fault.stop, stop) - fault.start) / every > MOST_DRAWS:
            raise InputError(
                f"fault {dotted(fault.target)} {fault.kind}: with a period of {every:g} s it draws more than "
                f"{MOST_DRAWS:,} random numbers; give it a longer one or less time"
            )
        faults.append(replace(fault, every=every))
    return faults


def _period(system: System, target: tuple[str, str], output_interval: float) -> float:
    sources = [connection.source[0] for connection in system.connections if connection.target == target]
    for name in (target[0], *sources):
        component = next(component for component in system.components if component.name == name)
        period = sample_period(component, output_interval)
        if period is not None:
            return period
    return output_interval


def faulty_inputs(
    system: System,
    stop: float,
    output_interval: float,
    sources: Mapping[tuple[str, str], Source],
    signals: Mapping[tuple[str, str], int],
    slots: Mapping[tuple[str, str], int],
    roles: Mapping[str, Role],
    lines: list[Line],
    zero: int,
) -> dict[tuple[str, str], FaultyInput]:
    """Return the inputs with faults.

    ``sources`` are what drives the inputs while a component is stepped, ``signals`` the slots of outputs and channels,
    ``slots`` those of the faulty inputs; the slot ``zero`` holds 0.
    """
    by_name = {component.name: component for component in system.components}
    faults = resolved_faults(system, stop, output_interval)
    found: dict[tuple[str, str], FaultyInput] = {}
    for target, slot in slots.items():
        variable = by_name[target[0]].fmu.variables[target[1]]
        held = sources.get(target, (zero, 1.0, float(variable.start or 0.0), ()))
        natural = {c.target: c.source for c in system.connections} | {c.target: c.target for c in system.channels}
        at = (signals[natural[target]], *held[1:]) if target in natural else held
        line = next((line for line in lines if line.slot == at[0]), None)
        stepwise = line is None and _is_stepwise(system, target, natural, roles, output_interval)
        own = [fault for fault in faults if fault.target == target]
        found[target] = FaultyInput(
            slot,
            at=Wire(-1, *at),
            held=Wire(-1, *held),
            line=line,
            faults=[_signal_fault(fault, own[:number], stop, stepwise) for number, fault in enumerate(own)],
            triggers=line is None and not _is_put_out_between(natural.get(target), target, roles),
        )
    return found


def _is_put_out_between(source: tuple[str, str] | None, target: tuple[str, str], roles: Mapping[str, Role]) -> bool:
    """Tell whether what drives an input is an output of a continuous component, which changes at any time."""
    return source not in (None, target) and source is not None and roles[source[0]] is Role.CONTINUOUS


def _is_stepwise(
    system: System,
    target: tuple[str, str],
    natural: Mapping[tuple[str, str], tuple[str, str]],
    roles: Mapping[str, Role],
    output_interval: float,
) -> bool:
    """Tell whether what drives an input, not a linear channel, keeps its value between two communication points."""
    source = natural.get(target)
    if not _is_put_out_between(source, target, roles) or source is None:
        return True
    component = next(component for component in system.components if component.name == source[0])
    variable = component.fmu.variables[source[1]]
    return (
        variable.type != "Real"
        or variable.variability != "continuous"
        or fixed_step_of(component, output_interval) < math.inf
    )


def _signal_fault(fault: Fault, before: list[Fault], stop: float, stepwise: bool) -> SignalFault:
    """Return a fault as the loops need it; ``before`` are those of the same input that act before it."""
    boundary, draws, watch = 1, np.empty(0), fault.start
    if fault.every is not None:
        boundary = _first_after(fault.start, fault.every)
        end = min(fault.stop, stop)
        count = max(0, math.ceil((end - boundary * fault.every) / fault.every)) + 2
        alike = sum(other.kind == fault.kind and other.seed == fault.seed for other in before)
        name = crc32(f"{dotted(fault.target)} {fault.kind}".encode())
        generator = np.random.Generator(np.random.Philox(np.random.SeedSequence([fault.seed, name, alike])))
        if fault.kind == "noise":
            draws = fault.amount * generator.standard_normal(count)
        else:
            draws = (generator.random(count) < fault.amount).astype(np.float64)
            on_time = abs((boundary - 1) * fault.every - fault.start) <= SAME_INSTANT
            if not on_time:
                draws[0] = 1.0  # it begins between two instants: nothing arrives then
            watch = max(0.0, (boundary - 1 - on_time) * fault.every)
    return SignalFault(fault, watch, boundary, draws.tolist(), stepwise)


def _first_after(start: float, every: float) -> int:
    """Return the number of the first multiple of ``every`` after ``start`` [s]."""
    number = math.floor(start / every)
    while number * every <= start + SAME_INSTANT:
        number += 1
    return number
