"""Pantelides' algorithm: which equations must be differentiated, and how often, before every unknown can be computed.

C. C. Pantelides, The consistent initialization of differential-algebraic systems, SIAM J. Sci. Stat. Comput. 9 (1988).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import maximum_bipartite_matching

from cosim.dae.chains import Chains, Node
from cosim.dae.hybrid import Equation
from cosim.errors import ModelError

_HIGHEST_ORDER = 8


@dataclass
class Differentiated:
    """The equations with their derivatives.

    ``predecessor[e]`` is the equation of which equation ``e`` is the time derivative; ``successor`` the reverse.
    """

    chains: Chains
    equations: list[Equation]
    predecessor: dict[int, int] = field(default_factory=dict)
    successor: dict[int, int] = field(default_factory=dict)

    def level(self, equation: int) -> int:
        """How often an equation is a derivative."""
        count = 0
        while equation in self.predecessor:
            equation, count = self.predecessor[equation], count + 1
        return count

    @property
    def index(self) -> int:
        """The structural differentiation index of the given equations (1 if none had to be differentiated)."""
        return 1 + max((self.level(e) for e in range(len(self.equations))), default=0)


def reduce_index(chains: Chains) -> Differentiated:
    """Differentiate what must be differentiated.

    Raises:
        ModelError: the equations do not determine the unknowns, whatever the numbers; or an input's derivative is
            needed.
    """
    check_structure(chains)
    return _Pantelides(chains).run()


class _Pantelides:
    def __init__(self, chains: Chains) -> None:
        self._chains = chains
        self._result = Differentiated(chains, list(chains.equations))
        self._nodes_of = [set(chains.nodes_in(e.residual)) for e in chains.equations]
        self._highest = {base: len(chain) - 1 for base, chain in chains.symbols.items()}
        self._assigned: dict[Node, int] = {}
        self._seen_nodes: set[Node] = set()
        self._seen_equations: set[int] = set()

    def run(self) -> Differentiated:
        for original in range(len(self._chains.equations)):
            equation = original
            while True:
                self._seen_nodes, self._seen_equations = set(), set()
                if self._augment(equation):
                    break
                equation = self._differentiate(equation)
        return self._result

    def _candidates(self, equation: int) -> list[Node]:
        return self._chains.ordered(n for n in self._nodes_of[equation] if n.order == self._highest[n.base])

    def _augment(self, equation: int) -> bool:
        self._seen_equations.add(equation)
        candidates = self._candidates(equation)
        for node in candidates:
            if node not in self._assigned and node not in self._seen_nodes:
                self._assigned[node] = equation
                return True
        for node in candidates:
            if node not in self._seen_nodes:
                self._seen_nodes.add(node)
                if self._augment(self._assigned[node]):
                    self._assigned[node] = equation
                    return True
        return False

    def _differentiate(self, equation: int) -> int:
        result = self._result
        for node in self._seen_nodes:
            if node.order >= _HIGHEST_ORDER:
                raise _singular(self._chains, sorted(self._seen_equations), self._chains.ordered(self._seen_nodes))
        for node in self._seen_nodes:
            self._highest[node.base] = node.order + 1
        for old in sorted(self._seen_equations):
            new = len(result.equations)
            result.equations.append(self._chains.differentiate(result.equations[old]))
            result.predecessor[new], result.successor[old] = old, new
            self._nodes_of.append(set(self._chains.nodes_in(result.equations[new].residual)))
        for node in self._chains.ordered(self._seen_nodes):
            self._chains.symbol(Node(node.base, node.order + 1))
            self._assigned[Node(node.base, node.order + 1)] = result.successor[self._assigned[node]]
        return result.successor[equation]


def check_structure(chains: Chains) -> None:
    """Refuse a system in which some variables have too few equations, naming them and those that have too many.

    Raises:
        ModelError: there is no way to pair equations and variables.
    """
    bases = list(chains.symbols)
    column = {base: j for j, base in enumerate(bases)}
    incidence = [sorted({column[n.base] for n in chains.nodes_in(e.residual)}) for e in chains.equations]
    rows = [i for i, columns in enumerate(incidence) for _ in columns]
    columns = [j for columns in incidence for j in columns]
    shape = (len(chains.equations), len(bases))
    if 0 in shape:
        match = np.full(shape[0], -1)
    else:
        match = maximum_bipartite_matching(csr_matrix((np.ones(len(rows)), (rows, columns)), shape), perm_type="column")
    unmatched_rows = [i for i in range(shape[0]) if match[i] < 0]
    unmatched_columns = sorted(set(range(shape[1])) - {int(j) for j in match if j >= 0})
    if not unmatched_rows and not unmatched_columns:
        return
    by_column = {int(j): i for i, j in enumerate(match) if j >= 0}
    # over-determined part: from an equation too many, alternate equation -> variable -> the equation it is matched to
    too_many, pending = set(unmatched_rows), list(unmatched_rows)
    while pending:
        for j in incidence[pending.pop()]:
            if j in by_column and by_column[j] not in too_many:
                too_many.add(by_column[j])
                pending.append(by_column[j])
    users = {j: [i for i, columns in enumerate(incidence) if j in columns] for j in range(shape[1])}
    too_few, open_columns = set(unmatched_columns), list(unmatched_columns)
    while open_columns:
        for i in users[open_columns.pop()]:
            j = int(match[i])
            if j >= 0 and j not in too_few:
                too_few.add(j)
                open_columns.append(j)
    raise _singular(chains, sorted(too_many), [Node(bases[j], 0) for j in sorted(too_few)])


def _singular(chains: Chains, equations: list[int], nodes: list[Node]) -> ModelError:
    parts = []
    at = None
    if nodes:
        names = [chains.label(node) for node in nodes]
        parts.append(f"not enough equations for {_some(names)}")
        scalar = chains.system.unknowns.get(nodes[0].base)
        at = scalar.declaration.at if scalar else None
    if equations:
        count = len(chains.equations)
        texts = [chains.equations[e].text for e in equations if e < count]
        parts.append(f"too many equations in: {_some(texts)}")
        at = next((chains.equations[e].at for e in equations if e < count and chains.equations[e].at), at)
    count, unknowns = len(chains.equations), len(chains.symbols)
    what = "is structurally singular"
    if count != unknowns:
        what = f"has {count} equation{'s' * (count != 1)} for {unknowns} unknown{'s' * (unknowns != 1)}"
    message = f"{chains.system.name} {what}: {'; '.join(parts)}"
    return chains.system.source.error(message, at)


def _some(texts: list[str], most: int = 6) -> str:
    shown = ", ".join(texts[:most])
    return shown + (f" and {len(texts) - most} more" if len(texts) > most else "")
