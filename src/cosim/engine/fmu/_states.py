"""The continuous states of a Model Exchange FMU, and which of their derivatives depend on which of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from fmpy.model_description import ModelDescription


@dataclass(frozen=True)
class States:
    """All that the model description says of the n states, in their order; elements of arrays are states each.

    ``names`` are theirs, ``references`` and ``rates`` the value references of the states and of their derivatives,
    empty if some of them are arrays, whose elements have none. ``dependencies`` are, for each derivative, the numbers
    of the states that it depends on, None where the description does not say; ``autonomous`` tells that none depends
    on time.
    """

    names: tuple[str, ...] = ()
    references: tuple[int, ...] = ()
    rates: tuple[int, ...] = ()
    dependencies: tuple[frozenset[int] | None, ...] = ()
    autonomous: bool = False

    def owners(self) -> list[list[int]]:
        """Return, for each colour, of each derivative the state of this colour that it depends on, or -1.

        States of one colour are those that no derivative depends on together: one direction tells of all of them. They
        are found greedily (A. R. Curtis, M. J. D. Powell, J. K. Reid, IMA Journal of Applied Mathematics 13, 1974).
        """
        n = len(self.names)
        columns: list[set[int]] = [set() for _ in range(n)]
        for rate, states in enumerate(self.dependencies):
            for state in range(n) if states is None else states:
                columns[state].add(rate)
        colours: list[list[int]] = []
        for state, rates in enumerate(columns):
            if not rates:
                continue
            free = next((c for c in colours if all(c[rate] < 0 for rate in rates)), None)
            if free is None:
                free = [-1] * n
                colours.append(free)
            for rate in rates:
                free[rate] = state
        return colours


def states_of(description: ModelDescription) -> States:
    """Return what the model description says of the states."""
    rates = [unknown.variable for unknown in description.derivatives]
    states = [rate.derivative for rate in rates]
    if any(state is None for state in states):
        return States(tuple(f"state {number}" for number in range(1, len(states) + 1)))
    names = [name for state in states for name in _elements(state.name, state.shape)]
    if len(names) != len(states) or len(set(names)) != len(names):
        return States(tuple(names), dependencies=(None,) * len(names))
    number = {state.name: i for i, state in enumerate(states)}
    listed = [None if u.dependencies is None else [v.name for v in u.dependencies] for u in description.derivatives]
    clocks = {v.name for v in description.modelVariables if v.causality == "independent"}
    return States(
        tuple(names),
        tuple(int(state.valueReference) for state in states),
        tuple(int(rate.valueReference) for rate in rates),
        tuple(None if known is None else frozenset(number[v] for v in known if v in number) for known in listed),
        bool(clocks) and all(known is not None and not clocks & set(known) for known in listed),
    )


def _elements(name: str, shape: Sequence[int] | None) -> list[str]:
    names = [name]
    for size in shape or ():
        names = [f"{prefix}[{i}]" for prefix in names for i in range(1, size + 1)]
    return names
