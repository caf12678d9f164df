"""The initial system: as many conditions as unknowns, from fixed starts, initial equations and start values."""

from __future__ import annotations

import casadi as ca

from cosim.dae.blocks import extend
from cosim.dae.dae import Unknown
from cosim.dae.hybrid import SX, HybridSystem
from cosim.dae.structure import alternating, listed


def initial_system(
    system: HybridSystem,
    states: list[Unknown],
    torn: list[Unknown],
    algebraic: list[tuple[SX, str]],
    conditions: list[tuple[SX, str, int]],
) -> tuple[SX, list[str], list[bool]]:
    """Residuals of the initial system, their texts, and which unknowns simply have their start value.

    The conditions (fixed start values and initial equations) all hold. A state that they leave open keeps its start
    value, which the Modelica specification (8.6) leaves to the tool.

    Args:
        system: for the place of errors.
        states: the continuous states.
        torn: the torn unknowns.
        algebraic: residual and text of the algebraic equations, one for each torn unknown.
        conditions: residual, text and place of each initial condition.

    Raises:
        ModelError: more conditions than degrees of freedom.
    """
    unknowns = [*states, *torn]
    column = {u.symbol.name(): j for j, u in enumerate(unknowns)}
    rows = [*algebraic]
    rows += [(residual, system.source.with_line(text, at)) for residual, text, at in conditions]
    rows += [(u.symbol - u.start, f"{u.name} = its start value, which is not fixed") for u in states]
    incidence = [[column[s.name()] for s in ca.symvar(r) if s.name() in column] for r, _ in rows]
    matched: dict[int, int] = {}
    taken: list[int] = []
    required = len(torn) + len(conditions)
    for row in range(len(rows)):
        if extend(incidence, len(unknowns), matched, row):
            taken.append(row)
        elif row < required:
            conflict, columns = alternating(incidence, matched, row)
            texts = listed([rows[r][1] for r in conflict])
            names = listed([unknowns[j].name for j in columns])
            why = (
                f"these {len(conflict)} determine only {names}: {texts}" if columns else f"the equations decide {texts}"
            )
            raise system.source.error(
                f"{system.name}: one initial condition too many: {why}. Take fixed=true or an initial equation away",
                conditions[row - len(torn)][2] if row >= len(torn) else None,
            )
    kept = {u.symbol.name() for u in states for row in taken if ca.is_equal(rows[row][0], u.symbol - u.start, 20)}
    return (
        ca.vertcat(SX(0, 1), *(rows[row][0] for row in taken)),
        [rows[row][1] for row in taken],
        [u.symbol.name() in kept for u in unknowns],
    )
