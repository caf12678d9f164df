"""The delay of each connection: from the instant for which a value is put out to that from which it acts.

It follows from what the loop does, so that it costs no run; ``explain_timing`` finds the same by looking on. What a
component holds back inside itself is not in it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress

from cosim.engine.system._connection import Connection
from cosim.engine.system._method import Method, links_of
from cosim.engine.system._order import continuous_order, discrete_order
from cosim.engine.system._role import Role, fixed_step_of, has_period, period_of
from cosim.engine.system._system import SAME_INSTANT, Component, System
from cosim.errors import FmuError


def delays_of(system: System, roles: Mapping[str, Role], output_interval: float, method: Method) -> list[float | None]:
    """Return the longest delay [s] on each connection, None where it depends on events that nobody knows in advance.

    ``roles`` are those that the model descriptions imply. Where signals are held over a step, a source that is stepped
    before its target has a negative delay: what it puts out at the end of a step acts from the beginning on. A signal
    that is continued into the step has none.
    """
    if method.is_fixed:
        late = {name: 0.0 if role is Role.CONTINUOUS else method.step for name, role in roles.items()}
        return [late[connection.source[0]] for connection in system.connections]
    periods = {c.name: _period(c, roles[c.name], output_interval) for c in system.components}
    known = [period for period in periods.values() if period is not None and period > 0.0]
    longest = min([output_interval, *known])
    longest /= method.divisions(longest)
    place = _places(system.components, system.connections, roles)
    links = {c.target for c in links_of(system, roles, output_interval)} if method.is_coupled else set()
    return [
        0.0 if connection.target in links else _delay(connection, roles, periods, place, longest)
        for connection in system.connections
    ]


def _period(component: Component, role: Role, output_interval: float) -> float | None:
    """Return the time [s] between the instants that compute a component: 0 if any can, None if they are unknown."""
    if role is Role.CONTINUOUS:
        step = fixed_step_of(component, output_interval)
        return step if step < math.inf else 0.0
    if role is Role.SAMPLED or has_period(component.fmu):
        with suppress(FmuError):  # of a period that cannot be, the run has told
            return period_of(component, output_interval)
    return None


def _places(
    components: Sequence[Component], connections: Sequence[Connection], roles: Mapping[str, Role]
) -> dict[str, int]:
    """Return the place of each component in the order in which an instant computes them."""
    continuous = [c for c in components if roles[c.name] is Role.CONTINUOUS]
    discrete = [c for c in components if roles[c.name] is not Role.CONTINUOUS]
    order = [*continuous_order(continuous, connections), *discrete_order(discrete, connections)]
    return {component.name: place for place, component in enumerate(order)}


def _delay(
    connection: Connection,
    roles: Mapping[str, Role],
    periods: Mapping[str, float | None],
    place: Mapping[str, int],
    longest: float,
) -> float | None:
    source, target = connection.source[0], connection.target[0]
    put_out, taken = periods[source], periods[target]
    discrete = roles[source] is not Role.CONTINUOUS
    if roles[target] is Role.EVENT and discrete:
        return 0.0  # a change is an event
    if taken == 0.0:
        ahead = not discrete and put_out == 0.0 and place[source] < place[target]
        return -longest if ahead else 0.0
    if put_out == 0.0:
        return 0.0
    if put_out is None or taken is None:
        return taken
    shorter = min(put_out, taken)
    late = roles[target] is Role.SAMPLED and place[source] >= place[target]
    return shorter if late else shorter - _common(put_out, taken)


def _common(first: float, second: float) -> float:
    """Return the longest time [s] of which both periods are multiples, the shortest offset between their instants."""
    ticks = math.gcd(round(first / SAME_INSTANT), round(second / SAME_INSTANT))
    return ticks * SAME_INSTANT
