"""The C of the initial system. Most of its equations are those of the model itself, so it takes them from there."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import casadi as ca

from cosim.dae import Dae
from cosim.dae.hybrid import SX
from cosim.fmu.c_text import comment, function, remark
from cosim.fmu.derivatives import reverse

LARGEST = 64
"""The most unknowns whose Jacobian the C may have on its stack a second time."""
_UNUSED = "(void)t, (void)v, (void)u, (void)p, (void)d, (void)c"

Body = Callable[[Sequence[str], Sequence[tuple[str, SX]]], list[str]]
"""Prints the lines that compute arrays from arguments."""


def initial_functions(dae: Dae, arguments: Mapping[str, SX], weights: SX, body: Body) -> list[str]:
    """``model_initial_residual``, ``model_initial_jacobian`` and ``model_initial_reverse``.

    Args:
        dae: the model.
        arguments: the columns of the symbols that all is a function of, by C names; those of the weights included.
        weights: the symbols of the residuals' weights, ``r_bar``.
        body: prints what computes arrays from arguments of these names.
    """
    shared = _shared_rows(dae)
    own = [i for i, row in enumerate(shared) if row is None]
    pairs = [(i, row) for i, row in enumerate(shared) if row is not None]
    residuals = dae.initial_residuals[own]
    continuous = ("t", "v", "u", "p", "d", "c")
    n, m = len(shared), len(own)

    lines = [f"{_UNUSED}, (void)r;"]
    if pairs:
        lines += [f"double f[{n}];", "model_rhs(t, v, u, p, d, c, f);", *(f"r[{i}] = f[{row}];" for i, row in pairs)]
    lines += _into(own, "r", body(continuous, [("own", residuals)]))
    text = remark(comment("; ".join(dae.initial_texts))) + function(
        "void model_initial_residual(MODEL_CONTINUOUS_ARGUMENTS, double *r)", lines
    )

    lines = [f"{_UNUSED}, (void)J;"]
    if pairs:
        lines += [f"double f[{n}], A[{n * n}], ft[{n}];", "model_linearise(t, v, u, p, d, c, f, A, ft);"]
        lines += [f"for (int k = 0; k < {n}; k++) {{"]
        lines += [*(f"    J[k * {n} + {i}] = A[k * {n} + {row}];" for i, row in pairs), "}"]
    places = [k * n + i for k in range(n) for i in own]
    lines += _into(places, "J", body(continuous, [("own", ca.jacobian(residuals, dae.v))]) if m else [])
    text += remark("dr/dv, column by column")
    text += function("void model_initial_jacobian(MODEL_CONTINUOUS_ARGUMENTS, double *J)", lines)

    lines = [f"{_UNUSED}, (void)r_bar;"]
    lines += [f"double f_bar[MODEL_ROOM({n})] = {{0}}, v_bar[MODEL_ROOM({n})], y_bar[MODEL_ROOM(MODEL_NY)] = {{0}};"]
    lines += [f"f_bar[{row}] += r_bar[{i}];" for i, row in pairs]
    lines += ["model_reverse(t, v, u, p, d, c, f_bar, y_bar, t_bar, v_bar, u_bar, p_bar);"]
    added = reverse(residuals, weights[own], "tup", arguments)
    entries = [(array, k) for array, column in added.items() for k in range(column.numel()) if _nonzero(column, k)]
    values = [added[array][k] for array, k in entries]
    if values:
        lines += [f"double own[{len(values)}];", *body([*continuous, "r_bar"], [("own", ca.vertcat(*values))])]
        lines += [f"{array}[{k}] += own[{j}];" for j, (array, k) in enumerate(entries)]
    head = (
        "void model_initial_reverse(MODEL_CONTINUOUS_ARGUMENTS, const double *r_bar, double *t_bar, double *u_bar,\n"
        "                           double *p_bar)"
    )
    return (
        text + remark("weights of what the initial residuals are computed from, at constant v") + function(head, lines)
    )


def _shared_rows(dae: Dae) -> list[int | None]:
    """For each initial equation, the row of f that it is, if any; none if that would not spare much."""
    rows: list[int | None] = [None] * dae.initial_residuals.numel()
    if not dae.torn or len(dae.unknowns) > LARGEST:
        return rows
    f = dae.f
    places = {f[k].element_hash(): k for k in range(f.numel())}
    return [places.get(dae.initial_residuals[i].element_hash()) for i in range(len(rows))]


def _into(places: Sequence[int], array: str, lines: list[str]) -> list[str]:
    """Lines that compute ``own``, and its elements put where they belong."""
    if not places:
        return []
    moves = [f"{array}[{place}] = own[{j}];" for j, place in enumerate(places)]
    if list(places) == list(range(len(places))):
        return [line.replace("own[", f"{array}[") if line.startswith("own[") else line for line in lines]
    return [f"double own[{len(places)}];", *lines, *moves]


def _nonzero(column: SX, k: int) -> bool:
    return not SX(column[k]).is_zero()
