"""Rules on how variables depend on each other: what is declared against what a small change of a known does.

In Co-Simulation the knowns are the inputs and the unknowns the outputs in Initialization Mode, where FMI 2.0 and 3.0
both let an importer set and get by turns; in Model Exchange the states and their derivatives in Continuous-Time Mode
come to that.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Protocol

from fmpy.fmi1 import FMICallException
from fmpy.model_description import ModelVariable, Unknown

from cosim.check._bench import Bench, Instance, Value, is_real
from cosim.check._rules import Found, Severity
from cosim.check._run_rules import RUN_RULES

_STEP = 6e-6
"""Relative step of central differences: the cube root of the rounding error, where error and rounding meet."""

_NOISE = 1e-10
"""Relative error of what an FMU computes by iteration; divided by the step it is that of a difference."""

_ROUNDING = 1e-15
"""The least error of a variable that passes through zero, relative to its nominal value."""

_ALLOWED = 1e-4
_KINK = 1e-2
_POINTS = 3
_MOST_KNOWNS = 40
_ADD = "add it to the dependencies in ModelStructure"
_REMEDY = "correct the derivative, or do not claim to provide it"


class _Knowns(Protocol):
    """Where an instance is, as a vector that can be changed."""

    names: list[str]
    references: list[int]
    scales: list[float]
    values: list[float]

    def put(self, k: int, value: float) -> None:
        """Set one of them in the FMU."""


@dataclass
class _Inputs:
    """The continuous inputs."""

    instance: Instance
    variables: list[ModelVariable]

    def __post_init__(self) -> None:
        """Read where they are."""
        self.names = [variable.name for variable in self.variables]
        self.references = [variable.valueReference for variable in self.variables]
        self.values = self.instance.reals(self.variables)
        self.scales = [_scale(v, value) for v, value in zip(self.variables, self.values, strict=True)]

    def put(self, k: int, value: float) -> None:
        """Set an input."""
        self.instance.set(self.variables[k], value)


@dataclass
class _States:
    """The continuous states."""

    instance: Instance
    variables: list[ModelVariable]

    def __post_init__(self) -> None:
        """Read where they are."""
        self.names = [variable.name for variable in self.variables]
        self.references = [variable.valueReference for variable in self.variables]
        self.values = self.instance.states()
        self.scales = self.instance.nominals()

    def put(self, k: int, value: float) -> None:
        """Set a state."""
        self.instance.set_states([*self.values[:k], value, *self.values[k + 1 :]])


def _scale(variable: ModelVariable, value: float) -> float:
    try:
        nominal = abs(float(variable.nominal or 1.0)) or 1.0
    except ValueError:
        nominal = 1.0
    return max(nominal, abs(value))


def _states_of(bench: Bench) -> list[ModelVariable]:
    return [unknown.variable.derivative for unknown in bench.subject.description.derivatives]


def _derivatives_of(bench: Bench) -> list[ModelVariable]:
    if bench.is_cs:
        return []
    found = [unknown.variable for unknown in bench.subject.description.derivatives]
    return found if all(not variable.shape for variable in found) else []


def _knowns(bench: Bench, instance: Instance) -> list[_Knowns]:
    """Return what can be changed: inputs, and in Model Exchange the states."""
    groups: list[_Knowns] = [_Inputs(instance, bench.reals("input")[:_MOST_KNOWNS])]
    states = _states_of(bench)
    if not bench.is_cs and states and all(state is not None and not state.shape for state in states):
        groups.append(_States(instance, states))
    return groups


def _points(bench: Bench) -> Iterator[tuple[Instance, list[ModelVariable], list[_Knowns]]]:
    """Yield an instance at its start, and where its knowns are moved by a seeded random bit."""
    unknowns = [*_derivatives_of(bench), *bench.reals("output")]
    for point in range(_POINTS if unknowns else 0):
        numbers = random.Random(point)
        with bench.instance() as instance:
            instance.enter_initialization()
            if not bench.is_cs:
                instance.exit_initialization()
            groups = _knowns(bench, instance)
            try:
                for group in groups if point else ():
                    for k, value in enumerate(group.values):
                        group.values[k] = value + 0.1 * numbers.uniform(-1.0, 1.0) * group.scales[k]
                        group.put(k, group.values[k])
                instance.reals(unknowns)
            except FMICallException:
                continue  # a point where the model has no solution says nothing
            yield instance, unknowns, groups


def _moved(instance: Instance, unknowns: list[ModelVariable], group: _Knowns, k: int, by: float) -> list[float]:
    """Return the unknowns with one known moved, which is put back."""
    group.put(k, group.values[k] + by)
    found = instance.reals(unknowns)
    group.put(k, group.values[k])
    return found


@dataclass(frozen=True)
class _Slope:
    """A difference quotient of each unknown, and how far it can be trusted; NaN where there is a kink."""

    values: list[float]
    allowed: list[float]


def _slope(instance: Instance, unknowns: list[ModelVariable], group: _Knowns, k: int) -> _Slope:
    """Return the central differences by one known; all left out if the model has no solution on one side."""
    try:
        return _differences(instance, unknowns, group, k)
    except FMICallException:
        return _Slope([math.nan] * len(unknowns), [math.nan] * len(unknowns))
    finally:
        with suppress(FMICallException):
            group.put(k, group.values[k])


def _differences(instance: Instance, unknowns: list[ModelVariable], group: _Knowns, k: int) -> _Slope:
    h = _STEP * group.scales[k]
    here = instance.reals(unknowns)
    indicators = instance.indicators() if not instance.bench.is_cs else []
    above, below = (_moved(instance, unknowns, group, k, by) for by in (h, -h))
    is_switched = False
    for by in (h, -h) if indicators else ():
        group.put(k, group.values[k] + by)
        moved = instance.indicators()
        is_switched |= any((a > 0.0) != (b > 0.0) for a, b in zip(indicators, moved, strict=True))
        group.put(k, group.values[k])
    values, allowed = [], []
    for variable, y, up, down in zip(unknowns, here, above, below, strict=True):
        forward, backward = (up - y) / h, (y - down) / h
        size = max(abs(forward), abs(backward))
        noise = (_NOISE * max(abs(y), abs(up)) + _ROUNDING * _scale(variable, y)) / h
        has_kink = is_switched or abs(forward - backward) > _KINK * size + 10.0 * noise
        values.append(math.nan if has_kink else (up - down) / (2.0 * h))
        allowed.append(_ALLOWED * size + 10.0 * noise + abs(forward - backward))
    return _Slope(values, allowed)


@RUN_RULES("run.directional", Severity.ERROR, instances=_POINTS)
def directional(bench: Bench) -> Iterator[Found]:
    """Directional derivatives agree with finite differences, apart from points within a step of a mode switch."""
    if not _provides_directional(bench):
        return
    told: set[tuple[str, str]] = set()
    for instance, unknowns, groups in _points(bench):
        for group in groups:
            for k, known in enumerate(group.names):
                slope = _slope(instance, unknowns, group, k)
                given = instance.directional([v.valueReference for v in unknowns], group.references[k])
                for variable, value, by_difference, allowed in zip(
                    unknowns, given, slope.values, slope.allowed, strict=True
                ):
                    is_wrong = not abs(value - by_difference) <= allowed and not math.isnan(by_difference)
                    if is_wrong and (variable.name, known) not in told:
                        told.add((variable.name, known))
                        what = f"the derivative by {known} is {value:.9g}, finite differences give {by_difference:.9g}"
                        yield Found(what, variable.name, _REMEDY)


def _provides_directional(bench: Bench) -> bool:
    return bench.claims("providesDirectionalDerivatives")


@RUN_RULES("run.adjoint", Severity.ERROR, instances=_POINTS)
def adjoint(bench: Bench) -> Iterator[Found]:
    """Adjoint derivatives are those of the directional ones, if both are claimed."""
    if not (bench.claims("providesAdjointDerivatives") and _provides_directional(bench)):
        return
    for instance, unknowns, groups in _points(bench):
        for group in groups:
            rows = [instance.adjoint(v.valueReference, group.references) for v in unknowns] if group.names else []
            for k, known in enumerate(group.names):
                column = instance.directional([v.valueReference for v in unknowns], group.references[k])
                for variable, row, value in zip(unknowns, rows, column, strict=True):
                    if not math.isclose(row[k], value, rel_tol=1e-9, abs_tol=1e-12):
                        what = f"the adjoint derivative by {known} is {row[k]:.9g}, the directional {value:.9g}"
                        yield Found(what, variable.name, _REMEDY)
                        return


def _listed(unknowns: Iterable[Unknown]) -> dict[str, set[tuple[str, int]]]:
    """Return what unknowns are said to depend on, by type and value reference, as aliases are the same."""
    return {
        unknown.variable.name: {(known.type, known.valueReference) for known in unknown.dependencies}
        for unknown in unknowns
        if unknown.dependencies is not None and is_real(unknown.variable) and not unknown.variable.shape
    }


@RUN_RULES("run.dependencies", Severity.ERROR)
def dependencies(bench: Bench) -> Iterator[Found]:
    """An output does not change with an input that its declared dependencies in InitialUnknowns leave out."""
    declared = _listed(bench.subject.description.initialUnknowns)
    outputs = [v for v in bench.compared if v.name in declared and v.causality == "output"]
    inputs = [v for v in bench.compared if v.causality == "input" and v.type != "String" and not v.shape]
    with bench.instance() as instance:
        instance.enter_initialization()
        for known in inputs[:_MOST_KNOWNS]:
            unlisted = [v for v in outputs if (known.type, known.valueReference) not in declared[v.name]]
            before, at = instance.values(unlisted), instance.values([known])[known.name][0]
            try:
                instance.set(known, _other(known, at))
                after = instance.values(unlisted)
                instance.set(known, at)
            except FMICallException:
                return
            for variable in unlisted:
                if _changed(before[variable.name], after[variable.name]):
                    yield Found(f"changes with {known.name}, which its dependencies leave out", variable.name, _ADD)
        instance.exit_initialization()


@RUN_RULES("run.structure", Severity.ERROR)
def structure(bench: Bench) -> Iterator[Found]:
    """In Model Exchange, derivatives and outputs change with no state or input that their dependencies leave out."""
    if bench.is_cs:
        return
    description = bench.subject.description
    declared = _listed([*description.derivatives, *description.outputs])
    unknowns = [v for v in (*_derivatives_of(bench), *bench.reals("output")) if v.name in declared]
    with bench.instance() as instance:
        instance.initialize()
        before = instance.reals(unknowns)
        for group in _knowns(bench, instance):
            for k, (known, reference) in enumerate(zip(group.names, group.references, strict=True)):
                try:
                    after = _moved(instance, unknowns, group, k, 0.1 * group.scales[k])
                except FMICallException:
                    with suppress(FMICallException):
                        group.put(k, group.values[k])
                    continue
                for variable, one, other in zip(unknowns, before, after, strict=True):
                    is_listed = any(there == reference for _, there in declared[variable.name])
                    if not is_listed and _changed([one], [other]):
                        yield Found(f"changes with {known}, which its dependencies leave out", variable.name, _ADD)


def _other(variable: ModelVariable, value: Value) -> Value:
    """Return another value that the variable can have."""
    if isinstance(value, bytes):
        return value
    if variable.type == "Boolean":
        return not value
    step = 0.1 * _scale(variable, float(value)) if isinstance(value, float) else 1
    is_high = variable.max is not None and float(value) + step > float(variable.max)
    return value - step if is_high else value + step


def _changed(before: Sequence[Value], after: Sequence[Value]) -> bool:
    """Tell whether a value has changed by more than an iteration may."""
    for one, other in zip(before, after, strict=True):
        if isinstance(one, bytes) or isinstance(other, bytes):
            continue
        if abs(one - other) > 1e-7 * max(abs(one), abs(other), 1e-3):
            return True
    return False
