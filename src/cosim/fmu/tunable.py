"""Which parameters an importer may set while a simulation runs: those for which that means something physical."""

from __future__ import annotations

from collections.abc import Iterable

import casadi as ca

from cosim.dae import Dae
from cosim.dae.hybrid import SX


def tunable_parameters(dae: Dae) -> frozenset[str]:
    """The parameters that are tunable, dependent ones included.

    An independent Real parameter is, unless it

    * matters at the start only, as start values and initial equations do;
    * stands in a constraint that was differentiated, such as the length of a rod: positions would jump, and the speeds
      that belong to such a jump are not finite;
    * gives the period or the start of a sample clock;
    * gives an Integer, Boolean or enumeration parameter: such a number counts things (the length of a filter, say) that
      were laid out at the start.
    """
    fixed = _names(_everything(c.start, c.interval) for c in dae.clocks) | dae.constrained
    running = [dae.derivatives, dae.residuals]
    running += [p.value for p in dae.published if p.scalar.name not in dae.parameter_values]
    running += [r.indicator for r in dae.relations]
    running += [_everything(a.values, a.guard) for a in dae.assignments]
    running += [_everything(r.value, r.guard) for r in dae.resets]
    used = _names(running)
    sources: dict[str, set[str]] = {}
    """For each parameter, the independent ones that it comes from."""
    for parameter in dae.parameters:
        name = parameter.scalar.name
        if parameter.independent:
            sources[name] = {name}
        else:
            sources[name] = set().union(*(sources.get(n, set()) for n in _names([parameter.value])))
    real = {p.scalar.name for p in dae.parameters if p.scalar.type == "Real"}
    independent = {p.scalar.name for p in dae.parameters if p.independent}
    matters = set().union(*(sources[name] for name in used & sources.keys()))
    stays = set().union(*(sources[name] for name in (fixed & sources.keys()) | (sources.keys() - real)))
    found = (independent & real & matters) - stays
    return frozenset(found | {name for name in sources if name not in independent and sources[name] & found})


def _everything(*expressions: SX | None) -> SX:
    return ca.vertcat(SX(0, 1), *(ca.vec(e) for e in expressions if e is not None))


def _names(expressions: Iterable[SX]) -> set[str]:
    return {symbol.name() for expression in expressions for symbol in ca.symvar(expression)}
