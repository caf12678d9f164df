"""The order in which components are computed at one instant."""

from __future__ import annotations

from collections.abc import Sequence

from cosim.engine._system import Component, Connection


def computing_order(components: Sequence[Component], connections: Sequence[Connection]) -> list[Component]:
    """Sort components so that one whose outputs depend directly on its inputs precedes those that it drives.

    Stepped in this order (Gauss-Seidel), a controller acts on its plant in the interval for which it was computed.
    Without dependencies in the model description every output counts as dependent on every input. In a loop of such
    components, and where there is no dependence, the given order stays.
    """
    names = {component.name for component in components}
    inner = [c for c in connections if c.source[0] in names and c.target[0] in names and c.source[0] != c.target[0]]
    driven = {connection.target for connection in inner}
    before: dict[str, set[str]] = {name: set() for name in names}
    by_name = {component.name: component for component in components}
    for connection in inner:
        name, output = connection.source
        known = by_name[name].fmu.dependencies.get(output)
        inputs = [variable for owner, variable in driven if owner == name]
        if any(known is None or variable in known for variable in inputs):
            before[connection.target[0]].add(name)
    order: list[Component] = []
    waiting = list(components)
    while waiting:
        left = {component.name for component in waiting}
        component = next((c for c in waiting if not before[c.name] & left), waiting[0])
        waiting.remove(component)
        order.append(component)
    return order
