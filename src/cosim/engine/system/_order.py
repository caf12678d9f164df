"""The order in which components are computed at one instant."""

from __future__ import annotations

from collections.abc import Sequence

from cosim.engine.system._connection import Connection
from cosim.engine.system._system import Component


def discrete_order(components: Sequence[Component], connections: Sequence[Connection]) -> list[Component]:
    """Sort discrete components so that each comes after those that drive it: it samples what they have just put out.

    In a loop the given order stays.
    """
    return _sorted(components, _inner(components, connections))


def continuous_order(components: Sequence[Component], connections: Sequence[Connection]) -> list[Component]:
    """Sort components so that one whose outputs depend directly on its inputs precedes those that it drives.

    Stepped in this order (Gauss-Seidel), a continuous controller acts on its plant in the interval for which it was
    computed. Without dependencies in the model description every output counts as dependent on every input. In a loop
    of such components, and where there is no dependence, the given order stays.
    """
    inner = _inner(components, connections)
    by_name = {component.name: component for component in components}
    driven = {connection.target for connection in inner}
    direct: list[Connection] = []
    for connection in inner:
        name, output = connection.source
        known = by_name[name].fmu.dependencies.get(output)
        inputs = [variable for owner, variable in driven if owner == name]
        if any(known is None or variable in known for variable in inputs):
            direct.append(connection)
    return _sorted(components, direct)


def _inner(components: Sequence[Component], connections: Sequence[Connection]) -> list[Connection]:
    names = {component.name for component in components}
    return [c for c in connections if c.source[0] in names and c.target[0] in names and c.source[0] != c.target[0]]


def _sorted(components: Sequence[Component], edges: Sequence[Connection]) -> list[Component]:
    """Sort by repeatedly taking the first component that waits for no other; if all do, the first of all."""
    order: list[Component] = []
    waiting = list(components)
    while waiting:
        left = {component.name for component in waiting}
        held = {edge.target[0] for edge in edges if edge.source[0] in left}
        component = next((c for c in waiting if c.name not in held), waiting[0])
        waiting.remove(component)
        order.append(component)
    return order
