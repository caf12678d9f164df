"""Faults on purpose: what is done to an input's signal for a stretch of time, and whether that can be done."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, get_args

from cosim.engine.fmu._variable import OPAQUE, Variable
from cosim.errors import FmuError, InputError

FaultKind = Literal["override", "bias", "scale", "freeze", "delay", "drop", "quantise", "noise"]
KINDS: tuple[FaultKind, ...] = get_args(FaultKind)
RANDOM: tuple[FaultKind, ...] = ("drop", "noise")
"""Kinds that draw lots: they have a seed and a period."""
FOR_ALL_TYPES: tuple[FaultKind, ...] = ("override", "freeze", "delay", "drop")
"""Kinds that leave a value what it is, or give one; the others do arithmetic, and are for a Real alone."""

SHORTEST = 2e-9
"""A delay, a period and a stretch of time are longer [s]: instants less than half of it apart are one."""


@dataclass(frozen=True)
class Fault:
    """What happens to the signal of one input, ``target`` as (component, variable), from ``start`` to ``stop`` [s].

    ``kind`` and ``amount`` tell what the input gets in the place of x(t), which is what drives it, or its start value:

    * ``override``: ``amount``
    * ``bias``: x(t) + ``amount``; ``scale``: ``amount`` x(t)
    * ``freeze``: what the signal was before anything happened at ``start``
    * ``delay``: x(t - ``amount``), in seconds; before t = 0 the value of initialisation
    * ``drop``: x(t_k), t_k = k ``every`` being the last instant at which a value arrived; each is lost with the
      probability ``amount``, from ``start`` on. The input keeps what has arrived last
    * ``quantise``: ``amount`` round(x(t) / ``amount``), half a step going to the even one
    * ``noise``: x(t) + ``amount`` n_k from k ``every`` on, the n_k being independent and normal with a variance of 1

    ``amount`` and the signal have the input's unit. ``every`` [s] is by default the sample period of the input's
    component, else that of the source's, else the output interval. ``seed`` begins the random numbers; they also depend
    on the input's name, so that two inputs may have one seed. Faults of one input act one after the other.
    """

    target: tuple[str, str]
    kind: FaultKind
    amount: float = 0.0
    start: float = 0.0
    stop: float = math.inf
    every: float | None = None
    seed: int = 1

    def check(self, variable: Variable) -> None:
        """Raise InputError (FmuError for a text) if this cannot be done to an input, the variable."""
        _check(self, variable)


def described(fault: Fault, unit: str | None) -> str:
    """Return a fault in words, its amount in the ``unit`` of the input: "bias 0.5 A from 2 s to 5 s"."""
    of_amount = {"freeze": "", "delay": " s", "drop": " %", "scale": ""}.get(fault.kind, f" {unit}" if unit else "")
    amount = 100.0 * fault.amount if fault.kind == "drop" else fault.amount
    parts: list[str] = [fault.kind] if fault.kind == "freeze" else [f"{fault.kind} {amount:.15g}{of_amount}"]
    if fault.kind in RANDOM:
        parts.append(f"seed {fault.seed}")
        parts += [] if fault.every is None else [f"every {fault.every:.15g} s"]
    parts += [f"from {fault.start:.15g} s"] if fault.start > 0.0 else []
    parts += [f"to {fault.stop:.15g} s"] if fault.stop < math.inf else []
    return " ".join(parts)


def _check(fault: Fault, variable: Variable) -> None:
    name = f"fault {'.'.join(fault.target)} {fault.kind}"
    if fault.kind not in KINDS:
        raise InputError(f"{name}: there is no such kind; there are {', '.join(KINDS)}")
    if variable.type in OPAQUE:
        raise FmuError(f"{name}: is a {variable.type}; a fault changes numbers only")
    if variable.type != "Real" and fault.kind not in FOR_ALL_TYPES:
        raise InputError(f"{name}: needs a Real, but it is a {variable.type}; it takes {', '.join(FOR_ALL_TYPES)}")
    _check_window(fault, name)
    _check_lots(fault, name)
    if not math.isfinite(fault.amount):
        raise InputError(f"{name}: its amount is {fault.amount}; it must be finite")
    if fault.kind == "override":
        _check_value(fault.amount, name, variable)
    elif fault.kind == "delay" and not fault.amount > SHORTEST:
        raise InputError(f"{name}: the delay is {fault.amount:g} s; it must be above {SHORTEST:g} s")
    elif fault.kind == "drop" and not 0.0 <= fault.amount <= 1.0:
        raise InputError(f"{name}: the probability is {fault.amount:g}; it must be from 0 to 1")
    elif fault.kind == "quantise" and not fault.amount > 0.0:
        raise InputError(f"{name}: the step is {fault.amount:g}; it must be above 0")
    elif fault.kind == "noise" and not fault.amount >= 0.0:
        raise InputError(f"{name}: the standard deviation is {fault.amount:g}; it must not be below 0")


def _check_window(fault: Fault, name: str) -> None:
    if not (math.isfinite(fault.start) and fault.start >= 0.0):
        raise InputError(f"{name}: it begins at {fault.start:g} s; a simulation starts at 0 s")
    if not fault.stop > fault.start + SHORTEST:
        raise InputError(f"{name}: it ends at {fault.stop:g} s; it must end after its begin at {fault.start:g} s")


def _check_lots(fault: Fault, name: str) -> None:
    if fault.every is not None:
        if fault.kind not in RANDOM:
            raise InputError(f"{name}: has a period; only {' and '.join(RANDOM)} take one")
        if not (math.isfinite(fault.every) and fault.every > SHORTEST):
            raise InputError(f"{name}: its period is {fault.every:g} s; it must be above {SHORTEST:g} s")
    if fault.seed < 0:
        raise InputError(f"{name}: the seed is {fault.seed}; it must be a whole number from 0 on")


def _check_value(value: float, name: str, variable: Variable) -> None:
    if variable.type != "Real" and value != int(value):
        raise InputError(f"{name}: a {variable.type} takes whole numbers only, not {value:g}")
    if variable.type == "Boolean" and value not in (0.0, 1.0):
        raise InputError(f"{name}: a Boolean takes 0 and 1 only, not {value:g}")
    if variable.literals and not 1 <= value <= len(variable.literals):
        names = ", ".join(f"{i} {literal}" for i, literal in enumerate(variable.literals, 1))
        raise InputError(f"{name}: an Enumeration takes its numbers only, not {value:g}: {names}")
