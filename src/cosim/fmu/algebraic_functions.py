"""The C of what is needed seldom, and which takes what it can from the functions that are needed often.

These are the algebraic equations alone, where Newton's method is the last resort, and the initial system, most of
whose equations are those of the model itself. To compute more than is needed costs less than a second copy of the
equations in each FMU.
"""

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


def algebraic_functions(dae: Dae) -> list[str] | None:
    """``model_residual`` and ``model_linearise_residual``, or ``None`` if the model is too large for that."""
    n, x, z = len(dae.unknowns), len(dae.states), len(dae.torn)
    if n > LARGEST:
        return None
    head = "MODEL_COLD void "
    residual = [
        f"double f[MODEL_ROOM({n})];",
        "model_rhs(t, v, u, p, d, c, f);",
        f"for (int i = 0; i < {z}; i++) r[i] = f[{x} + i];",
    ]
    linearise = [
        f"double f[MODEL_ROOM({n})], A[MODEL_ROOM({n * n})], ft[MODEL_ROOM({n})];",
        "model_linearise(t, v, u, p, d, c, f, A, ft);",
        f"for (int i = 0; i < {z}; i++) r[i] = f[{x} + i];",
        f"for (int k = 0; k < {z}; k++)",
        f"    for (int i = 0; i < {z}; i++) J[k * {z} + i] = A[({x} + k) * {n} + {x} + i];",
    ]
    return [
        *remark("the residuals alone"),
        *function(f"{head}model_residual(MODEL_CONTINUOUS_ARGUMENTS, double *r)", residual),
        *remark("the residuals and their derivatives by z"),
        *function(
            "MODEL_COLD void model_linearise_residual(MODEL_CONTINUOUS_ARGUMENTS, double *r, double *J)", linearise
        ),
    ]


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
        "MODEL_COLD void model_initial_residual(MODEL_CONTINUOUS_ARGUMENTS, double *r)", lines
    )

    lines = [f"{_UNUSED}, (void)J;"]
    if pairs:
        lines += [f"double f[{n}], A[{n * n}], ft[{n}];", "model_linearise(t, v, u, p, d, c, f, A, ft);"]
        lines += [f"for (int k = 0; k < {n}; k++) {{"]
        lines += [*(f"    J[k * {n} + {i}] = A[k * {n} + {row}];" for i, row in pairs), "}"]
    places = [k * n + i for k in range(n) for i in own]
    lines += _into(places, "J", body(continuous, [("own", ca.jacobian(residuals, dae.v))]) if m else [])
    text += remark("dr/dv, column by column")
    text += function("MODEL_COLD void model_initial_jacobian(MODEL_CONTINUOUS_ARGUMENTS, double *J)", lines)

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
        "MODEL_COLD void model_initial_reverse(MODEL_CONTINUOUS_ARGUMENTS, const double *r_bar, double *t_bar,\n"
        "                                      double *u_bar, double *p_bar)"
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
