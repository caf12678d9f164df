"""What the choice of states rests on: constraints that must stay solvable for what was not chosen.

A static choice is right only where the constraints' Jacobian by the dummy derivatives is regular. It is kept with the
model, so that a simulation that ends where it is not can say so, and which variables would do as states there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca

from cosim.dae.blocks import Incidence, triangular
from cosim.dae.chains import Chains, Node
from cosim.dae.hybrid import SX
from cosim.dae.index_reduction import Differentiated
from cosim.dae.state_selection import Selection


@dataclass(frozen=True)
class Constraints:
    """Constraints of one level, in block lower triangular order.

    Rows of ``jacobian`` are equations, its columns first as many dummy derivatives, then the derivatives of states.
    """

    equations: list[str]
    """Text and place of the constraint that each row belongs to."""
    blocks: list[int]
    """The number of the block that each row, and the dummy derivative of the same position, is in."""
    variables: list[str]
    """For each column, the variables that are states if it is not a dummy."""
    jacobian: SX


def constraints_of(selection: Selection, system: Differentiated, resolve: Callable[[SX], SX]) -> list[Constraints]:
    """The constraints that could lose their rank while a simulation runs.

    Args:
        selection: the choice of states.
        system: the equations and their derivatives.
        resolve: puts an expression in terms of the Dae's arguments.
    """
    chains = system.chains
    constant = {parameter.scalar.name for parameter in chains.system.parameters}
    found: list[Constraints] = []
    seen: set[tuple[frozenset[str], frozenset[str]]] = set()
    for group in selection.groups:
        origins = [system.origin(e) for e in group.equations]
        nodes = [*group.dummies, *group.others]
        residuals = ca.vertcat(*(system.equations[e].residual for e in group.equations))
        jacobian = ca.jacobian(residuals, ca.vertcat(*(chains.symbol(node) for node in nodes)))
        changing: list[list[int]] = [[] for _ in origins]
        incidence: list[list[int]] = [[] for _ in origins]
        for row, column in zip(*jacobian.sparsity().get_triplet(), strict=True):
            incidence[row].append(column)
            if any(s.name() not in constant for s in ca.symvar(jacobian[row, column])):
                changing[row].append(column)
        kept = _relevant(incidence, changing)
        blocks = {
            (frozenset(origins[row].text for row in rows), frozenset(nodes[column].base for column in columns))
            for rows, columns in kept
        }
        if blocks <= seen:
            continue  # nothing, or what the level above has too: the Jacobian is the same
        seen |= blocks
        rows = [row for rows, _ in kept for row in rows]
        columns = [column for _, columns in kept for column in columns]
        columns += sorted({j for row in rows for j in incidence[row] if j >= len(origins)})
        found.append(
            Constraints(
                [chains.system.source.with_line(origins[row].text, origins[row].at) for row in rows],
                [block for block, (rows, _) in enumerate(kept) for _ in rows],
                [_states(chains, nodes[column]) for column in columns],
                resolve(jacobian[rows, columns]),
            )
        )
    return found


def _relevant(incidence: Incidence, changing: Incidence) -> list[tuple[list[int], list[int]]]:
    """The blocks (rows, dummies) whose Jacobian changes, and those that they are computed from, in order."""
    count = len(incidence)
    blocks = triangular([[j for j in row if j < count] for row in incidence], count) or []
    wanted: set[int] = set()
    kept: list[tuple[list[int], list[int]]] = []
    for rows, columns in reversed(blocks):
        if wanted & set(columns) or any(j in columns for row in rows for j in changing[row]):
            kept.insert(0, (rows, columns))
            wanted |= {j for row in rows for j in incidence[row] if j < count}
    return kept


def _states(chains: Chains, derivative: Node) -> str:
    names = [chains.label(Node(derivative.base, order)) for order in range(derivative.order)]
    return " and ".join(name for name in names if not name.startswith("der(")) or names[0]
