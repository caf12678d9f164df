"""Alias elimination: equations such as a = b, a = -b, w = der(phi) or a = constant go, and a variable with each.

This comes before index reduction: connections make most of a model's equations, and each is trivial.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from cosim.dae.chains import Alias, Chains, Node
from cosim.dae.hybrid import SX, Equation, HybridSystem, Scalar
from cosim.dae.integer import cancel
from cosim.dae.structure import listed, placed
from cosim.dae.symbolic import without_cancelled

_PREFERENCE = {"never": 0, "avoid": 1, "default": 2, "prefer": 4, "always": 5}


def eliminate_aliases(system: HybridSystem) -> Chains:
    """Eliminate trivial equations until none is left, also those that appear when others are added up.

    Raises:
        ModelError: equations repeat or contradict each other.
    """
    state = _Elimination(system)
    while True:
        while state.round():
            pass
        if not state.cancel():
            return state.chains()


def plain_chains(system: HybridSystem) -> Chains:
    """The system as it stands, nothing eliminated."""
    state = _Elimination(system)
    return state.chains()


class _Elimination:
    """Union-find over names with signs; a class has at most one member that must stay (an input or a derivative)."""

    def __init__(self, system: HybridSystem) -> None:
        self._system = system
        self._equations = list(system.equations)
        self._variables: dict[str, SX] = {name: s.symbol for name, s in system.unknowns.items()}
        self._variables |= {name: s.symbol for name, s in system.inputs.items()}
        self._derivatives: dict[str, str] = {}
        """Name of the derivative symbol by the name of what it is the derivative of."""
        for name, symbol in system.derivatives.items():
            self._derivatives[name] = symbol.name()
            self._variables[symbol.name()] = symbol
        self._position = {name: position for position, name in enumerate(system.unknowns)}
        self._root: dict[str, tuple[str, float]] = {}
        self._known: dict[str, SX] = {}

    def _find(self, name: str) -> tuple[str, float]:
        sign = 1.0
        while name in self._root:
            name, step = self._root[name]
            sign *= step
        return name, sign

    def _stays(self, name: str) -> bool:
        return name in self._system.inputs or name not in self._system.unknowns

    def _rank(self, name: str) -> tuple[int, bool, int, int]:
        """Who stays: by the modeller's wish, then by nesting and place, never by what a name looks like."""
        scalar = self._system.unknowns[name]
        return _PREFERENCE[scalar.state_select], scalar.fixed, -name.count("."), -self._position[name]

    def round(self) -> bool:
        """Take out what is trivial now; true if anything was."""
        victims: dict[str, SX] = {}
        kept: list[Equation] = []
        for equation in self._equations:
            form = self._trivial(equation.residual)
            if form is None or not self._absorb(form, victims):
                kept.append(equation)
        if not victims:
            return False
        self._equations = kept
        self._substitute()
        return True

    def cancel(self) -> bool:
        """Take out variables that cancel, in an equation or in sums of several; true if there were any."""
        cleaned = [Equation(without_cancelled(e.residual), e.text, e.at) for e in self._equations]
        if any(new.residual is not old.residual for new, old in zip(cleaned, self._equations, strict=True)):
            self._equations = cleaned
            return True
        found = cancel(self._equations, self._is_algebraic)
        if found.repeated:
            source = self._system.source
            raise source.error(
                f"{self._system.name}: these equations say one thing twice, so that they leave something open (in a"
                " circuit, is there a ground?): "
                + listed([placed(source, self._equations[e]) for e in found.repeated]),
                self._equations[found.repeated[0]].at,
            )
        for position, equation in found.replaced.items():
            self._equations[position] = equation
        return bool(found.replaced)

    def _is_algebraic(self, name: str) -> bool:
        """Whether this is the highest derivative of an unknown."""
        return name in self._variables and name not in self._system.inputs and name not in self._derivatives

    def _trivial(self, residual: SX) -> tuple[list[tuple[str, float]], SX] | None:
        """(terms, rest) of a residual sum(sign * name) + rest with one or two unknowns, or ``None``."""
        involved = [s for s in ca.symvar(residual) if s.name() in self._variables]
        others = [s.name() for s in ca.symvar(residual) if s.name() not in self._variables]
        if len(involved) not in (1, 2) or any(n in self._system.discretes or "(" in n or n == "time" for n in others):
            return None
        unknown = ca.vertcat(*involved)
        jacobian = ca.jacobian(residual, unknown)
        if not jacobian.is_constant():
            return None
        coefficients = ca.DM(ca.densify(jacobian)).full().ravel()
        scale = abs(coefficients[0])
        if not 0 < scale < np.inf or any(abs(c) != scale for c in coefficients):
            return None
        rest = ca.simplify(ca.substitute(residual, unknown, ca.DM.zeros(len(involved))) / scale)
        if len(involved) == 2 and not rest.is_zero():
            return None
        return [(s.name(), float(c / scale)) for s, c in zip(involved, coefficients, strict=True)], rest

    def _absorb(self, form: tuple[list[tuple[str, float]], SX], victims: dict[str, SX]) -> bool:
        terms, rest = form
        if any(self._find(name)[0] in self._known for name, _ in terms):
            return False  # becomes trivial in the next round, with the value put in
        if len(terms) == 1:
            ((name, sign),) = terms
            root, root_sign = self._find(name)
            if self._stays(root):
                return False
            self._known[root] = -rest / (sign * root_sign)
            victims[root] = self._known[root]
            return True
        (a, sign_a), (b, sign_b) = terms
        (root_a, at_a), (root_b, at_b) = self._find(a), self._find(b)
        if root_a == root_b or (self._stays(root_a) and self._stays(root_b)):
            return False
        sign = -sign_a * sign_b * at_a * at_b
        if self._stays(root_a) or (not self._stays(root_b) and self._rank(root_a) >= self._rank(root_b)):
            root_a, root_b = root_b, root_a
        if self._is_derivative_of(root_b, root_a):
            return False  # x = der(x) is an equation of motion, not an alias
        self._root[root_a] = (root_b, sign)
        victims[root_a] = sign * self._variables[root_b]
        return True

    def _is_derivative_of(self, derivative: str, name: str) -> bool:
        """Whether ``derivative`` is in the chain from ``name``'s class on, perhaps by way of other classes."""
        inner = derivative
        while inner != name and inner.startswith("der("):
            inner = self._find(inner[4:-1])[0]
        return inner == name

    def _value(self, name: str) -> SX:
        root, sign = self._find(name)
        return sign * self._known.get(root, self._variables[root])

    def _substitute(self) -> None:
        """Put the values of what was eliminated, and of its derivatives, into the equations that are left."""
        pending = [name for name in self._variables if name in self._root or name in self._known]
        for name in pending:
            self._follow_derivative(name)
        names = [name for name in self._variables if name in self._root or name in self._known]
        old = ca.vertcat(*(self._variables[name] for name in names))
        new = ca.vertcat(*(self._value(name) for name in names))
        residuals = ca.substitute([e.residual for e in self._equations], [old], [new])
        self._equations = [
            Equation(residual, equation.text, equation.at)
            for residual, equation in zip(residuals, self._equations, strict=True)
        ]

    def _follow_derivative(self, name: str) -> None:
        """What x was eliminated for, der(x) is eliminated for the derivative of."""
        if name not in self._derivatives:
            return
        derivative = self._derivatives[name]
        root, sign = self._find(name)
        if root in self._known:
            self._known.setdefault(self._find(derivative)[0], SX(0.0))
        elif root in self._system.inputs:
            raise self._system.source.error(
                f"{name} equals the input {root}, whose derivative would be needed; pass the input through a filter",
                self._system.unknowns[name].declaration.at,
            )
        else:
            if root not in self._derivatives:
                symbol = SX.sym(f"der({root})")
                self._derivatives[root] = symbol.name()
                self._variables[symbol.name()] = symbol
            target = self._derivatives[root]
            if derivative not in self._root and derivative != target:
                self._root[derivative] = (target, sign)
        self._follow_derivative(derivative)

    def chains(self) -> Chains:
        """What is left, as derivative chains."""
        system = self._system
        symbols: dict[str, list[SX]] = {}
        for name, scalar in system.unknowns.items():
            if name in self._root or name in self._known:
                continue
            chain, link = [scalar.symbol], name
            while link in self._derivatives:
                link = self._derivatives[link]
                chain.append(self._variables[link])
            symbols[name] = chain
        chains = Chains(system, symbols, self._equations)
        for name in self._variables:
            if name in self._root or name in self._known:
                value = self._value(name)
                chains.aliases[name] = Alias(value, str(value))
        members: dict[Node, list[tuple[Scalar, float]]] = {}
        for name, scalar in system.unknowns.items():
            root, sign = self._find(name)
            node = chains.node(root)
            if node is not None and root not in self._known:
                members.setdefault(node, []).append((scalar, sign))
        for node, scalars in members.items():
            scalars.sort(key=lambda item: self._rank(item[0].name), reverse=True)
            chains.names[node] = scalars
        return chains
