"""The discrete equations as groups that are computed together, and what of ``pre`` they need when they write over it.

A model that changes with its clocks only has its discrete variables overwritten where they are: each group reads all it
needs before it writes, and what a later group still needs of the values before the event is kept.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca

from cosim.dae import Dae
from cosim.dae.hybrid import SX, Assignment
from cosim.dae.symbolic import substitute
from cosim.fmu.c_expressions import MOST_NAMED
from cosim.fmu.loops import SHORTEST


@dataclass(frozen=True)
class Group:
    """Discrete variables that are assigned while ``guard`` is true (always, if it is None).

    ``positions`` are their indices, ``values`` what they become; none waits for another one of the group. ``text`` is
    the Modelica text they come from.
    """

    guard: SX | None
    positions: list[int]
    values: list[SX]
    text: str


@dataclass(frozen=True)
class Keeping:
    """Indices of discrete variables whose ``pre`` is kept: before all groups, and before each one if it takes place.

    ``place`` says where each is kept, in order and without gaps.
    """

    at_head: frozenset[int]
    in_group: tuple[frozenset[int], ...]
    place: dict[int, int]


def group_assignments(dae: Dae) -> list[Group]:
    """The assignments of ``dae`` in order; neighbours with the same guard share a group."""
    index = {s.name: k for k, s in enumerate(dae.discretes)}
    return [_group(neighbours, index) for neighbours in _neighbours(dae.assignments)]


def is_all_clocked(dae: Dae) -> bool:
    """Whether one pass over the discrete equations is a whole event, as nothing but ticks and inputs changes them.

    So it is if each equation waits for a tick, or follows at once from inputs and other variables, such as a Boolean
    that one block hands on to the next: from nothing that is over after the event, as a tick and ``pre`` are.
    """
    still = {clock.fired.name(): SX(0.0) for clock in dae.clocks}
    over = {symbol.name() for symbol in dae.pre.values()} | set(still)

    def at_once(assignment: Assignment) -> bool:
        return assignment.guard is None and not over & {s.name() for s in ca.symvar(assignment.values)}

    def on_a_tick(assignment: Assignment) -> bool:
        return assignment.guard is not None and substitute(assignment.guard, still).is_zero()

    return (
        not dae.unknowns
        and not dae.relations
        and all(at_once(assignment) or on_a_tick(assignment) for assignment in dae.assignments)
    )


def what_to_keep(dae: Dae, groups: Sequence[Group]) -> Keeping:
    """The entries of ``pre`` that are read after they were overwritten, if ``pre`` and ``d`` are the same array.

    Loops over array elements write while they read, and so do many values that are not named first: a group that may
    have either keeps all that it both reads and overwrites.
    """
    index = {dae.pre[s.name].name(): k for k, s in enumerate(dae.discretes)}

    def reads(*values: SX) -> frozenset[int]:
        return frozenset(index[s.name()] for s in ca.symvar(ca.vertcat(*values)) if s.name() in index)

    written: frozenset[int] = frozenset()
    at_head: frozenset[int] = frozenset()
    in_group = []
    for group in groups:
        read, writes = reads(*group.values), frozenset(group.positions)
        at_head |= (read if group.guard is None else read | reads(group.guard)) & written
        in_place = len(writes) >= SHORTEST or len(read) > MOST_NAMED
        in_group.append(read & writes if in_place else frozenset())
        written |= writes
    at_head |= reads(SX(0, 1), *(guard for guard, _ in dae.terminations)) & written
    in_group = [entries - at_head for entries in in_group]
    kept = sorted(at_head.union(*in_group))
    return Keeping(at_head, tuple(in_group), {entry: place for place, entry in enumerate(kept)})


def _group(assignments: Sequence[Assignment], index: dict[str, int]) -> Group:
    values: dict[str, SX] = {}
    for assignment in assignments:
        results = ca.vertsplit(ca.vec(substitute(assignment.values, values)))
        values |= {f"new({target})": value for target, value in zip(assignment.targets, results, strict=True)}
    targets = [target for assignment in assignments for target in assignment.targets]
    expressions = [values[f"new({target})"] for target in targets]
    text = "; ".join(dict.fromkeys(a.text for a in assignments))
    return Group(assignments[0].guard, [index[target] for target in targets], expressions, text)


def _neighbours(assignments: Sequence[Assignment]) -> list[list[Assignment]]:
    found: list[list[Assignment]] = []
    for assignment in assignments:
        last = found[-1][0].guard if found else None
        same = found and (
            (last is None and assignment.guard is None)
            or (last is not None and assignment.guard is not None and ca.is_equal(last, assignment.guard, 20))
        )
        if same:
            found[-1].append(assignment)
        else:
            found.append([assignment])
    return found
