"""Refuses systems whose equations and variables cannot be paired, and names the smallest part that shows it.

The parts are those of A. L. Dulmage, N. S. Mendelsohn, Coverings of bipartite graphs, Can. J. Math. 10 (1958), split
further: from one equation or variable that is left over, along the paths that alternate with the pairs.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import maximum_bipartite_matching

from cosim.dae.blocks import Incidence
from cosim.dae.chains import Chains, Node
from cosim.dae.hybrid import Equation
from cosim.errors import ModelError
from cosim.modelica.source import Source

_SHOWN = 6


def check_structure(chains: Chains) -> None:
    """Refuse a system in which some variables have too few equations, or too many.

    Raises:
        ModelError: there is no way to pair equations and variables.
    """
    bases = list(chains.symbols)
    column = {base: j for j, base in enumerate(bases)}
    incidence = [sorted({column[n.base] for n in chains.nodes_in(e.residual)}) for e in chains.equations]
    over, under = deficient(incidence, len(bases))
    if not over[0] and not under[1]:
        return
    count, unknowns = len(chains.equations), len(bases)
    what = "is structurally singular"
    if count != unknowns:
        what = f"has {count} equation{'s' * (count != 1)} for {unknowns} unknown{'s' * (unknowns != 1)}"
    labels = [chains.label(Node(base, 0)) for base in bases]
    raise singular(f"{chains.system.name} {what}", chains, chains.equations, labels, (over, under))


Part = tuple[list[int], list[int]]
"""Rows and columns."""


def deficient(incidence: Incidence, columns: int) -> tuple[Part, Part]:
    """The smallest part with more rows than columns, and the smallest one with more columns than rows.

    A part is empty if there is none of its kind.
    """
    rows = len(incidence)
    row_mate = np.full(rows, -1)
    if rows and columns:
        entries = [(i, j) for i, row in enumerate(incidence) for j in row]
        matrix = csr_matrix((np.ones(len(entries)), tuple(np.array(entries).reshape(-1, 2).T)), (rows, columns))
        row_mate = maximum_bipartite_matching(matrix, perm_type="column")
    column_mate = {int(j): i for i, j in enumerate(row_mate) if j >= 0}
    users: list[list[int]] = [[] for _ in range(columns)]
    for i, row in enumerate(incidence):
        for j in row:
            users[j].append(i)
    over = [alternating(incidence, column_mate, i) for i in range(rows) if row_mate[i] < 0]
    back = {i: int(j) for i, j in enumerate(row_mate) if j >= 0}
    under = [alternating(users, back, j) for j in range(columns) if j not in column_mate]
    return (
        min(over, key=lambda part: len(part[0]), default=([], [])),
        min(((rows, columns) for columns, rows in under), key=lambda part: len(part[1]), default=([], [])),
    )


def alternating(incidence: Incidence, mate: dict[int, int], start: int) -> Part:
    """Rows reached from a row without a mate by way of columns and their mates, and the columns on the way."""
    rows, columns, pending = {start}, set[int](), [start]
    while pending:
        for j in incidence[pending.pop()]:
            columns.add(j)
            if j in mate and mate[j] not in rows:
                rows.add(mate[j])
                pending.append(mate[j])
    return sorted(rows), sorted(columns)


def singular(
    what: str, chains: Chains, equations: Sequence[Equation], labels: Sequence[str], parts: tuple[Part, Part]
) -> ModelError:
    """The error for what :func:`deficient` has found among these equations and variables."""
    source = chains.system.source
    (over, determined), (involved, under) = parts
    sentences = []
    at = None
    if under:
        names = listed([labels[j] for j in under])
        if involved:
            number = f"only {len(involved)} equation{'s' * (len(involved) > 1)}"
            texts = listed([placed(source, equations[e]) for e in involved])
            sentences.append(f"for {names} there {'are' if len(involved) > 1 else 'is'} {number}: {texts}")
        else:
            sentences.append(f"there is no equation for {names}")
        scalar = chains.system.unknowns.get(labels[under[0]])
        at = scalar.declaration.at if scalar else None
    if over:
        texts = listed([placed(source, equations[e]) for e in over])
        if determined:
            names = listed([labels[j] for j in determined])
            sentences.append(f"for {names} alone there are {len(over)} equations: {texts}")
        else:
            sentences.append(f"there is nothing left to determine in {texts}")
        at = next((equations[e].at for e in over if equations[e].at), at)
    return source.error(f"{what}: {'; '.join(sentences)}", at)


def placed(source: Source, equation: Equation) -> str:
    """An equation's text, with its place if it has one."""
    return source.with_line(equation.text, equation.at) if equation.at else equation.text


def listed(texts: Sequence[str]) -> str:
    """Some of the texts, and how many more there are."""
    return ", ".join(texts[:_SHOWN]) + (f" and {len(texts) - _SHOWN} more" if len(texts) > _SHOWN else "")
