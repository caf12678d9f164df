"""Matching and block lower triangular form: which unknowns are computed together, from what, in which order."""

from __future__ import annotations

import graphlib
from collections.abc import Sequence

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components, maximum_bipartite_matching

Incidence = Sequence[Sequence[int]]
"""For each equation, the columns (unknowns) it contains."""


def match(incidence: Incidence, columns: int) -> list[int] | None:
    """For each equation the unknown it is matched to, or ``None`` if there is no perfect matching."""
    rows = len(incidence)
    if rows != columns:
        return None
    if rows == 0:
        return []
    found = maximum_bipartite_matching(_matrix(incidence, columns), perm_type="column")
    return None if (found < 0).any() else [int(j) for j in found]


def triangular(incidence: Incidence, columns: int) -> list[tuple[list[int], list[int]]] | None:
    """Blocks (equations, unknowns) in the order of computation, or ``None`` if structurally singular."""
    matched = match(incidence, columns)
    if matched is None:
        return None
    owner = {j: i for i, j in enumerate(matched)}
    needs = [[owner[j] for j in row if owner[j] != i] for i, row in enumerate(incidence)]
    if not needs:
        return []
    count, labels = connected_components(_matrix(needs, len(needs)), directed=True, connection="strong")
    members: list[list[int]] = [[] for _ in range(count)]
    for i, label in enumerate(labels):
        members[label].append(i)
    graph: dict[int, set[int]] = {label: set() for label in range(count)}
    for i, row in enumerate(needs):
        graph[labels[i]] |= {int(labels[k]) for k in row if labels[k] != labels[i]}
    # first equations first among the blocks that could come next, so that the order does not depend on labels
    sorter = graphlib.TopologicalSorter(graph)
    sorter.prepare()
    order: list[int] = []
    ready: list[int] = []
    while sorter.is_active():
        ready = sorted([*ready, *sorter.get_ready()], key=lambda label: members[label][0])
        order.append(ready.pop(0))
        sorter.done(order[-1])
    return [(members[label], [matched[i] for i in members[label]]) for label in order]


def _matrix(incidence: Incidence, columns: int) -> csr_matrix:
    rows = [i for i, row in enumerate(incidence) for _ in row]
    indices = [j for row in incidence for j in row]
    return csr_matrix((np.ones(len(rows)), (rows, indices)), shape=(len(incidence), columns))


def extend(incidence: Incidence, columns: int, matched: dict[int, int], row: int) -> bool:
    """Match one more equation by an augmenting path; equations that are matched stay so.

    Args:
        incidence: columns of each equation.
        columns: how many unknowns there are.
        matched: the equation that each matched unknown belongs to; updated.
        row: the equation to add.
    """
    seen: set[int] = set()

    def augment(equation: int) -> bool:
        for j in incidence[equation]:
            if j in seen:
                continue
            seen.add(j)
            if j not in matched or augment(matched[j]):
                matched[j] = equation
                return True
        return False

    return len(matched) < columns and augment(row)
