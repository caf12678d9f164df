"""Derivative chains: x, der(x), der(der(x)), ... of each continuous unknown, and the equations on them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import casadi as ca

from cosim.dae.hybrid import SX, Equation, HybridSystem, Scalar


@dataclass(frozen=True)
class Node:
    """The ``order``-th derivative of ``base``."""

    base: str
    order: int


@dataclass(frozen=True)
class Alias:
    """An eliminated variable: ``sign`` times a node or input, or an expression of parameters."""

    value: SX
    text: str


@dataclass
class Chains:
    """The continuous equations, on the variables that are left, and what was eliminated.

    ``symbols[base][k]`` is the symbol of the k-th derivative. ``aliases`` give the eliminated variables, in terms of
    what is left. ``names`` has, for a node, all variables that are equal to it up to sign.
    """

    system: HybridSystem
    symbols: dict[str, list[SX]]
    equations: list[Equation]
    aliases: dict[str, Alias] = field(default_factory=dict)
    names: dict[Node, list[tuple[Scalar, float]]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Index the symbols by name."""
        self._position = {base: position for position, base in enumerate(self.symbols)}
        self._nodes = {s.name(): Node(b, k) for b, chain in self.symbols.items() for k, s in enumerate(chain)}

    def node(self, name: str) -> Node | None:
        """The node that a symbol of this name stands for, if it is a continuous unknown that is left."""
        return self._nodes.get(name)

    def symbol(self, node: Node) -> SX:
        """The symbol of a node; missing links of the chain are made."""
        chain = self.symbols[node.base]
        while len(chain) <= node.order:
            symbol = SX.sym(f"der({chain[-1].name()})")
            self._nodes[symbol.name()] = Node(node.base, len(chain))
            chain.append(symbol)
        return chain[node.order]

    def nodes(self) -> list[Node]:
        """All nodes, chain by chain."""
        return [Node(base, k) for base, chain in self.symbols.items() for k in range(len(chain))]

    def ordered(self, nodes: Iterable[Node]) -> list[Node]:
        """Nodes in the order of declaration, so that no choice depends on names."""
        return sorted(nodes, key=lambda node: (self._position[node.base], node.order))

    def nodes_in(self, expression: SX) -> list[Node]:
        """The nodes an expression depends on, in the order of appearance."""
        found = (self.node(symbol.name()) for symbol in ca.symvar(expression))
        return [node for node in found if node is not None]

    def differentiate(self, equation: Equation) -> Equation:
        """The total time derivative of an equation.

        Raises:
            ModelError: it would need the derivative of an input.
        """
        residual = equation.residual
        result = ca.jacobian(residual, self.system.time)
        for symbol in ca.symvar(residual):
            node = self.node(symbol.name())
            if node is not None:
                result = result + ca.jacobian(residual, symbol) * self.symbol(Node(node.base, node.order + 1))
            elif symbol.name() in self.system.inputs:
                raise self.system.source.error(
                    f"{equation.text}: the derivative of the input {symbol.name()} would be needed here; an input"
                    " cannot prescribe what is a state of the model. Prescribe a force, torque or voltage instead, or"
                    " pass the input through a filter",
                    equation.at,
                )
        return Equation(ca.simplify(result), f"der({equation.text})", equation.at)

    def label(self, node: Node) -> str:
        """The name a user knows a node by."""
        known = self.names.get(node)
        if known:
            return known[0][0].name
        return self.symbol(node).name()
