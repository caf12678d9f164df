"""Relations whose change is known beforehand, because nothing in them moves between events but time."""

from __future__ import annotations

import casadi as ca

from cosim.dae.event_functions import HELD_FLOOR
from cosim.dae.hybrid import SX, HybridSystem
from cosim.dae.symbolic import is_arithmetic


def slope_in_time(indicator: SX, system: HybridSystem) -> float:
    """The constant rate [1/s] of an indicator that is slope * time + what holds between events; 0 for any other.

    Relations of floor() and its like are none of these: a held integer must have changed where its relation says so, to
    the last bit, while time events closer than a nanosecond count as one.
    """
    symbols = {symbol.name() for symbol in ca.symvar(indicator)}
    held = system.discretes.keys() | {parameter.scalar.name for parameter in system.parameters}
    others = symbols - {system.time.name()}
    if system.time.name() not in symbols or not others <= held or any(n.startswith(HELD_FLOOR) for n in others):
        return 0.0
    rate = ca.jacobian(indicator, system.time)
    if not is_arithmetic(indicator) or not rate.is_constant():
        return 0.0
    return float(rate)
