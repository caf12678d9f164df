"""Pantelides' algorithm: which equations must be differentiated, and how often, before every unknown can be computed.

C. C. Pantelides, The consistent initialization of differential-algebraic systems, SIAM J. Sci. Stat. Comput. 9 (1988).
"""

from __future__ import annotations

from dataclasses import dataclass, field

from cosim.dae.chains import Chains, Node
from cosim.dae.hybrid import Equation
from cosim.dae.structure import Part, check_structure, singular

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

    def origin(self, equation: int) -> Equation:
        """The given equation that this one is a derivative of, or is."""
        while equation in self.predecessor:
            equation = self.predecessor[equation]
        return self.equations[equation]

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

    def _refuse(self) -> None:
        chains, rows = self._chains, sorted(self._seen_equations)
        nodes = chains.ordered({Node(node.base, 0) for node in self._seen_nodes})
        parts: tuple[Part, Part] = (rows, list(range(len(nodes)))), ([], [])
        labels = [chains.label(node) for node in nodes]
        what = f"{chains.system.name} is structurally singular, however often its equations are differentiated"
        raise singular(what, chains, self._result.equations, labels, parts)

    def _differentiate(self, equation: int) -> int:
        result = self._result
        for node in self._seen_nodes:
            if node.order >= _HIGHEST_ORDER:
                self._refuse()
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
