"""Static state selection by dummy derivatives.

S. E. Mattsson, G. Söderlind, Index reduction in differential-algebraic equations using dummy derivatives, SIAM J. Sci.
Comput. 14 (1993). Among the selections that are regular, the modeller's ``stateSelect`` and fixed start values decide.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np
import numpy.typing as npt

from cosim.dae.chains import Chains, Node
from cosim.dae.hybrid import SX
from cosim.dae.index_reduction import Differentiated
from cosim.dae.rank import dependent_rows
from cosim.dae.structure import listed, placed
from cosim.dae.symbolic import evaluate

_WISH = {"never": 0.0, "avoid": 1.0, "default": 2.0, "prefer": 4.0, "always": 5.0}
_REGULAR = 1e-9


@dataclass(frozen=True)
class Selection:
    """Which nodes are states, and which are unknowns to be computed from them."""

    states: list[Node]
    unknowns: list[Node]
    dummies: list[Node]
    groups: list[Group]
    """The choices that were made, highest derivatives first."""


@dataclass(frozen=True)
class Group:
    """Constraints of one level: they give the derivatives ``dummies`` from the derivatives ``others``."""

    equations: list[int]
    dummies: list[Node]
    others: list[Node]


def select_states(system: Differentiated, values: dict[str, float]) -> Selection:
    """Choose the states.

    Args:
        system: the equations and their derivatives.
        values: numbers for parameters, inputs, discrete variables and start values, by symbol name, at which the
            regularity of a choice is judged.

    Raises:
        ModelError: no choice is regular there; or the choice contradicts ``StateSelect.always`` or ``never``.
    """
    chains = system.chains
    dummies: list[Node] = []
    groups: list[Group] = []
    group = [e for e in range(len(system.equations)) if e not in system.successor and e in system.predecessor]
    candidates = [Node(base, len(chain) - 1) for base, chain in chains.symbols.items() if len(chain) > 1]
    point = _Point(values)
    while group:
        jacobian = point.jacobian(
            [system.equations[e].residual for e in group], [chains.symbol(node) for node in candidates]
        )
        chosen = _choose(jacobian, [_wish(chains, node) for node in candidates])
        if len(chosen) < len(group):
            dependent = [system.origin(group[i]) for i in dependent_rows(jacobian, _REGULAR)]
            texts = listed([placed(chains.system.source, equation) for equation in dependent])
            raise chains.system.source.error(
                f"{chains.system.name}: these constraints contradict or repeat each other at the start values, so that"
                f" no states can be chosen: {texts}",
                dependent[0].at,
            )
        taken = chains.ordered(candidates[j] for j in chosen)
        dummies += taken
        groups.append(Group(group, taken, [node for node in candidates if node not in taken]))
        group = [system.predecessor[e] for e in group if system.level(e) > 1]
        candidates = [Node(n.base, n.order - 1) for n in taken if n.order > 1]
    dummy = set(dummies)
    nodes = chains.nodes()
    known = set(nodes)
    states = [n for n in nodes if (up := Node(n.base, n.order + 1)) in known and up not in dummy]
    taken_states = set(states)
    _check_always(chains, taken_states)
    return Selection(states, [n for n in nodes if n not in taken_states], dummies, groups)


def _wish(chains: Chains, derivative: Node) -> float:
    """How much the modeller wants what this is the derivative of to be a state."""
    node = Node(derivative.base, derivative.order - 1)
    scalars = [scalar for scalar, _ in chains.names.get(node, [])]
    wish = max((_WISH[s.state_select] for s in scalars), default=_WISH["default"])
    return wish + (0.5 if any(s.fixed for s in scalars) else 0.0)


def _check_always(chains: Chains, states: set[Node]) -> None:
    for node, members in chains.names.items():
        for scalar, _ in members:
            if scalar.state_select == "always" and node not in states:
                raise chains.system.source.error(
                    f"{scalar.name} has StateSelect.always but cannot be a state together with the others; its"
                    " constraints leave no freedom for it",
                    scalar.declaration.at,
                )


def _choose(jacobian: npt.NDArray[np.float64], wishes: list[float]) -> list[int]:
    """Columns that make the rows regular: the least wanted as states first, among equals the best conditioned."""
    rows, columns = jacobian.shape
    scale = np.abs(jacobian).max(axis=1, keepdims=True)
    left = jacobian / np.where(scale > 0, scale, 1.0)
    size = np.linalg.norm(left, axis=0)
    chosen: list[int] = []
    for wish in sorted(set(wishes)):
        open_columns = [j for j in range(columns) if wishes[j] == wish]
        while open_columns and len(chosen) < rows:
            remaining = [np.linalg.norm(left[:, j]) for j in open_columns]
            best = int(np.argmax(remaining))
            j = open_columns.pop(best)
            if remaining[best] <= _REGULAR * max(1.0, size[j]):
                break
            direction = left[:, j] / remaining[best]
            left = left - np.outer(direction, direction @ left)
            chosen.append(j)
    return chosen


class _Point:
    """Evaluates Jacobians at the start values; what has none gets a fixed generic number."""

    def __init__(self, values: dict[str, float]) -> None:
        self._values = values
        self._random = np.random.default_rng(20180601)

    def _value(self, name: str) -> float:
        if name not in self._values:
            self._values[name] = float(self._random.uniform(0.5, 1.5))
        return self._values[name]

    def jacobian(self, residuals: list[SX], unknowns: list[SX]) -> npt.NDArray[np.float64]:
        matrix = ca.densify(ca.jacobian(ca.vertcat(*residuals), ca.vertcat(*unknowns)))
        values = {s.name(): self._value(s.name()) for s in ca.symvar(matrix)}
        result: npt.NDArray[np.float64] = evaluate(matrix, values).full()
        return result
