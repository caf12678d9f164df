"""An estimate of what the exchange of continuous signals at communication points adds to the error of a run.

The run is repeated with all intervals between communication points divided by d. If the error falls with the power p
of these intervals, the order of the algorithm, then what both runs differ by is 1 - d^-p of the error of the first
(L. F. Richardson 1911). Where nothing continuous is exchanged, there is no such error and no second run.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cosim.engine._delays import delays_of
from cosim.engine._execution import Ending, Job
from cosim.engine.loop._plan import Layout, roles_of
from cosim.engine.loop._record import Record
from cosim.engine.system._connection import Connection, dotted
from cosim.engine.system._role import Role, fixed_step_of, has_period
from cosim.engine.system._system import System

EXACT = "none: sampled"
"""The note on a connection over which a discrete component acts, or is acted upon: at its instants, without error."""

_NO_RUN = "not estimated"
_DIVISION = 2
_ADAPTIVE_DIVISION = 4
"""The adaptive algorithm follows its tolerance in leaps: it takes more for an error that is surely smaller."""

Rows = NDArray[np.float64]


@dataclass(frozen=True)
class Deviation:
    """The largest error of a signal over a run, in its ``unit``, and as a share of its range (None if it has none)."""

    error: float
    unit: str | None
    relative: float | None


@dataclass(frozen=True)
class Estimate:
    """The deviation of every Real column, if there was a second run; ``note`` says why there was none.

    ``order`` is the power of the interval with which the error falls. ``interrupted`` tells that the user has ended
    the second run.
    """

    order: int
    columns: Mapping[str, Deviation]
    note: str = ""
    interrupted: bool = False


class Companion:
    """What a second run can tell about a run.

    ``notes`` has, for each connection of the system, why its error is none or cannot be told by a second run; it is
    empty for the others.
    """

    def __init__(self, job: Job) -> None:
        """Sort the connections."""
        self._job = job
        self._roles = roles_of(job.system)
        self.notes = _notes(job, self._roles)

    @property
    def job(self) -> Job | None:
        """The second run, None if it would tell nothing."""
        job = self._job
        if all(self.notes):
            return None
        if job.step is not None:
            return replace(job, method=replace(job.method, step=job.step / self._division))
        return replace(job, method=replace(job.method, parts=self._division * job.method.parts))

    @property
    def _division(self) -> int:
        return _ADAPTIVE_DIVISION if self._job.method.algorithm == "adaptive" else _DIVISION

    def compare(self, layout: Layout, coarse: Record, fine: Record, ending: Ending) -> Estimate:
        """Return how far the run was off, from it and the second one."""
        order = self._job.method.accuracy
        if ending.message is not None:
            note = f"{_NO_RUN}: with shorter intervals, {ending.message}"
            return Estimate(order, {}, note, ending.interrupted)
        factor = 1.0 / (1.0 - float(self._division) ** -order)
        columns: dict[str, Deviation] = {}
        for name, slot in layout.columns.items():
            variable = layout.variables[name]
            if variable.type == "Real":
                signal = coarse.rows[:, slot]
                error = factor * float(np.max(np.abs(signal - fine.rows[:, slot])))
                span = float(np.ptp(signal))
                if math.isfinite(error) and math.isfinite(span):
                    columns[name] = Deviation(error, variable.unit, error / span if span > 0.0 else None)
        return Estimate(order, columns)

    def account(self, layout: Layout, estimate: Estimate) -> list[dict[str, object]]:
        """Return what is known of each connection, ready for JSON: see ``Result.statistics``."""
        job = self._job
        delays = delays_of(job.system, self._roles, job.output_interval, job.method)
        return [
            _entry(connection, delay, note, layout, estimate)
            for connection, delay, note in zip(job.system.connections, delays, self.notes, strict=True)
        ]


def no_estimate(why: str) -> Estimate:
    """Return the estimate of a run without a second one."""
    return Estimate(0, {}, f"{_NO_RUN}: {why}")


def _entry(
    connection: Connection, delay: float | None, note: str, layout: Layout, estimate: Estimate
) -> dict[str, object]:
    source = dotted(connection.source)
    found = None if note else estimate.columns.get(source)
    affected = {} if note else _worst(connection.target[0], layout, estimate)
    note = note or estimate.note or ("" if found else f"{_NO_RUN}: it grows beyond all bounds")
    return {
        "source": source,
        "target": dotted(connection.target),
        "delay_s": delay,
        "error": found.error if found else None,
        "unit": layout.variables[source].unit if source in layout.variables else None,
        "relative": found.relative if found else None,
        "order": estimate.order if found else None,
        "target_outputs": affected,
        "note": note,
    }


def _worst(component: str, layout: Layout, estimate: Estimate) -> dict[str, object]:
    """Return the output of a component that is off most, for its range."""
    outputs = {
        name: deviation
        for name, deviation in estimate.columns.items()
        if name.startswith(f"{component}.") and layout.variables[name].causality == "output"
    }
    if not outputs:
        return {}
    name = max(outputs, key=lambda one: outputs[one].relative or 0.0)
    return {"output": name, **vars(outputs[name])}


def _notes(job: Job, roles: Mapping[str, Role]) -> list[str]:
    """Return, for each connection, why its error is none or cannot be told by shorter intervals, or nothing."""
    system = job.system
    if job.step is not None:
        why = _what_keeps_steps(system, roles)
        return [why or _why_not_real(system, connection) for connection in system.connections]
    steps = {c.name: fixed_step_of(c, job.output_interval) for c in system.components}
    continuous = {name for name, role in roles.items() if role is Role.CONTINUOUS}
    fixed = {name: _keeps(name, steps[name]) for name in continuous if steps[name] < math.inf}
    groups = _groups(system.connections, continuous)
    notes: list[str] = []
    for connection in system.connections:
        ends = {connection.source[0], connection.target[0]}
        touched = ends if ends - continuous else ends | groups[connection.source[0]]
        rigid = next((why for name, why in fixed.items() if name in touched), "")
        exact = EXACT if ends - continuous else ""
        notes.append(rigid or exact or _why_not_real(system, connection))
    return notes


def _keeps(name: str, step: float) -> str:
    return f"{_NO_RUN}: {name} takes steps of {step:g} s only, and cannot take shorter ones"


def _what_keeps_steps(system: System, roles: Mapping[str, Role]) -> str:
    """Return why the macro step of the Jacobi algorithm cannot be shorter, or nothing."""
    for component in system.components:
        if component.fmu.fixed_step is not None:
            return _keeps(component.name, component.fmu.fixed_step)
        if roles[component.name] is Role.SAMPLED and not has_period(component.fmu):
            return f"{_NO_RUN}: {component.name} samples at each of its steps, and would sample more often"
    return ""


def _why_not_real(system: System, connection: Connection) -> str:
    name, output = connection.source
    kind = next(c.fmu.variables[output].type for c in system.components if c.name == name)
    return "" if kind == "Real" else f"{_NO_RUN}: the signal is no Real"


def _groups(connections: Sequence[Connection], continuous: set[str]) -> dict[str, set[str]]:
    """Return, for each continuous component, those that act on it or that it acts on, directly or through others."""
    groups = {name: {name} for name in continuous}
    for connection in connections:
        source, target = connection.source[0], connection.target[0]
        if source in groups and target in groups:
            joined = groups[source] | groups[target]
            groups |= dict.fromkeys(joined, joined)
    return groups
