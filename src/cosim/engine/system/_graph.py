"""The graph of variables that act on each other without delay, and its loops.

Its nodes are the connected outputs of components. An arrow leads from one output to another if the first drives an
input that the second depends on directly, as the model description of its FMU says; without a statement every output
counts as dependent on every input. The strong components of this graph are the algebraic loops of a system.
"""

from __future__ import annotations

import enum
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from cosim.engine.system._connection import Connection, dotted
from cosim.engine.system._role import Role
from cosim.engine.system._system import Component, System

End: TypeAlias = tuple[str, str]
"""A variable of a component: (component, variable)."""

Arrows: TypeAlias = Mapping[End, Sequence[End]]
"""For each connected output those that depend on it directly."""

Depends = Callable[[End, str], bool]
"""Tells whether an output depends directly on an input, given by its name, of the same component."""

_MANY = 40
"""Outputs in a loop above which it is cut component by component, so that the search does not take long."""


class Phase(enum.Enum):
    """When the graph holds: dependencies differ, and in time only continuous components act on each other."""

    INITIALIZATION = "initialization"
    TIME = "time"


@dataclass(frozen=True)
class Loop:
    """An algebraic loop: a strong component of the graph.

    Without the ``torn`` outputs no loop is left in it; ``others`` are in an order in which each comes after those that
    it depends on, apart from the torn ones. ``connections`` lead from these outputs, the torn ones first, to inputs
    that outputs of the loop depend on.
    """

    torn: tuple[End, ...]
    others: tuple[End, ...]
    connections: tuple[Connection, ...]
    shortest: tuple[Connection, ...]
    """A shortest way round, from the first torn output."""

    def __str__(self) -> str:
        """Return the shortest way round as a user reads it: "a.y -> b.u -> b.y -> a.u"."""
        return " -> ".join(f"{dotted(c.source)} -> {dotted(c.target)}" for c in self.shortest)


def loops(system: System, roles: Mapping[str, Role], phase: Phase) -> list[Loop]:
    """Return the algebraic loops of a checked system, each before those that it leads to."""
    at = phase is Phase.INITIALIZATION
    names = {c.name for c in system.components if at or roles[c.name] is Role.CONTINUOUS}
    inner = [c for c in system.connections if c.source[0] in names and c.target[0] in names]
    return loops_among(inner, declared(system.components, phase))


def loops_among(connections: Sequence[Connection], depends: Depends) -> list[Loop]:
    """Return the algebraic loops that connections make, each before those that it leads to."""
    arrows = arrows_between(connections, depends)
    return [
        _loop(group, arrows, connections, depends) for group in strong_components(arrows) if _is_loop(group, arrows)
    ]


def declared(components: Iterable[Component], phase: Phase) -> Depends:
    """Return what the model descriptions say."""
    fmus = {component.name: component.fmu for component in components}

    def depends(output: End, name: str) -> bool:
        fmu = fmus[output[0]]
        known = (fmu.dependencies if phase is Phase.TIME else fmu.initial_dependencies).get(output[1])
        return known is None or name in known

    return depends


def arrows_between(connections: Iterable[Connection], depends: Depends) -> dict[End, list[End]]:
    """Return the graph of these connections, its nodes in the order in which they are first mentioned."""
    connections = list(connections)
    arrows: dict[End, dict[End, None]] = {connection.source: {} for connection in connections}
    outputs: dict[str, list[End]] = {}
    for source in arrows:
        outputs.setdefault(source[0], []).append(source)
    for connection in connections:
        name, variable = connection.target
        arrows[connection.source] |= dict.fromkeys(o for o in outputs.get(name, ()) if depends(o, variable))
    return {source: list(targets) for source, targets in arrows.items()}


def strong_components(arrows: Arrows) -> list[list[End]]:
    """Return the strong components, each before those that it leads to; their nodes in the order of ``arrows``.

    Tarjan, Depth-first search and linear graph algorithms, SIAM Journal on Computing 1 (1972), without recursion.
    """
    index: dict[End, int] = {}
    low: dict[End, int] = {}
    stack: list[End] = []
    closed: set[End] = set()
    found: list[list[End]] = []
    way: list[tuple[End, Iterator[End]]] = []
    position = {node: i for i, node in enumerate(arrows)}

    def enter(node: End) -> None:
        index[node] = low[node] = len(index)
        stack.append(node)
        way.append((node, iter(arrows[node])))

    for root in reversed(position):
        if root not in index:
            enter(root)
        while way:
            node, following = way[-1]
            for target in following:
                if target not in index:
                    enter(target)
                    break
                if target not in closed:
                    low[node] = min(low[node], index[target])
            else:
                way.pop()
                if way:
                    low[way[-1][0]] = min(low[way[-1][0]], low[node])
                if low[node] == index[node]:
                    first = stack.index(node)
                    closed.update(stack[first:])
                    found.append(sorted(stack[first:], key=position.__getitem__))
                    del stack[first:]
    return found[::-1]


def tearing(group: Sequence[End], arrows: Arrows) -> list[End]:
    """Return outputs of a strong component without which no loop is left in it; few of them, not always the fewest.

    One that cuts all is taken if there is one, else that with the most ways in and out; in a large one, the outputs of
    the component that has the fewest.
    """
    if not _is_loop(group, arrows):
        return []
    members = set(group)
    inner = {node: [target for target in arrows[node] if target in members] for node in group}
    if len(group) > _MANY:
        owners = Counter(name for name, _ in group)
        fewest = min(owners, key=owners.__getitem__)
        cut = [node for node in group if node[0] == fewest]
    else:
        for node in group:
            if not any(_is_loop(part, inner) for part in strong_components(_without(inner, [node]))):
                return [node]
        ways_in = {node: sum(node in targets for targets in inner.values()) for node in group}
        cut = [max(group, key=lambda node: ways_in[node] * len(inner[node]))]
    rest = _without(inner, cut)
    return [*cut, *(node for part in strong_components(rest) for node in tearing(part, rest))]


def _is_loop(group: Sequence[End], arrows: Arrows) -> bool:
    """Tell whether a strong component is a loop: more than one output, or one that depends on itself."""
    return len(group) > 1 or group[0] in arrows[group[0]]


def _without(arrows: Arrows, nodes: Iterable[End]) -> dict[End, list[End]]:
    cut = set(nodes)
    return {node: [t for t in targets if t not in cut] for node, targets in arrows.items() if node not in cut}


def _loop(group: Sequence[End], arrows: Arrows, connections: Sequence[Connection], depends: Depends) -> Loop:
    torn = tearing(group, arrows)
    members = set(group)
    rest = _without({node: [t for t in arrows[node] if t in members] for node in group}, torn)
    others = [node for part in strong_components(rest) for node in part]
    place = {source: i for i, source in enumerate([*torn, *others])}

    def leads_to(connection: Connection) -> list[End]:
        name, variable = connection.target
        return [output for output in place if output[0] == name and depends(output, variable)]

    inner = sorted((c for c in connections if c.source in place and leads_to(c)), key=lambda c: place[c.source])
    ways = [[c] for c in inner if c.source == torn[0]]
    seen: set[End] = set()
    for way in ways:  # grows
        reached = leads_to(way[-1])
        if torn[0] in reached:
            return Loop(tuple(torn), tuple(others), tuple(inner), tuple(way))
        ways += [[*way, c] for c in inner if c.source in reached and c.source not in seen]
        seen.update(reached)
    raise AssertionError("a strong component leads back to each of its nodes")
