"""The generated functions that give exact derivatives of a model: forward along a direction, and in reverse.

Each costs a small multiple of the equations themselves, however many variables there are, and needs no Jacobian. The
runtime eliminates the algebraic unknowns by the implicit function theorem.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca

from cosim.dae import Dae
from cosim.dae.hybrid import SX
from cosim.dae.symbolic import substitute


@dataclass(frozen=True)
class Derivative:
    """A generated function of the continuous arguments and of seeds."""

    name: str
    about: str
    seeds: tuple[str, ...]
    """Arguments beside the continuous ones; ``x_dot`` is the rate of ``x`` and ``x_bar`` the weight of ``x``."""
    results: dict[str, SX]


def seeds(dae: Dae, outputs: int) -> dict[str, SX]:
    """A symbol for each rate and weight that is an argument; ``outputs`` is their number."""
    sizes = {
        "t_dot": 1,
        "v_dot": len(dae.unknowns),
        "u_dot": len(dae.inputs),
        "f_bar": len(dae.unknowns),
        "y_bar": outputs,
        "r_bar": len(dae.unknowns),
        "p_bar": len(dae.parameters),
    }
    return {name: SX.sym(name, size) for name, size in sizes.items()}


def derivatives(dae: Dae, outputs: SX, arguments: Mapping[str, SX], symbols: Mapping[str, SX]) -> list[Derivative]:
    """What ``model.h`` declares for directional and adjoint derivatives of f and of the outputs y.

    Args:
        dae: the model.
        outputs: the column of the outputs.
        arguments: the columns t, v, u, p of the symbols that all is a function of.
        symbols: what :func:`seeds` gave.

    Parameters have weights only. Where one is an exponent, the derivative by it need not exist, and a rate of zero
    would not make it harmless.
    """
    value, weights = ca.vertcat(dae.f, outputs), ca.vertcat(symbols["f_bar"], symbols["y_bar"])
    moved = ca.vertcat(*(arguments[name] for name in "tvu"))
    rates = ca.vertcat(*(symbols[f"{name}_dot"] for name in "tvu"))
    count = len(dae.unknowns)
    forward = ca.jtimes(value, moved, rates) if value.numel() else SX(0, 1)
    return [
        Derivative("model_forward", "rates of f and y", ("t_dot", "v_dot", "u_dot"),
                   {"f_dot": forward[:count], "y_dot": forward[count:]}),
        Derivative("model_reverse", "weights of what f and y are computed from", ("f_bar", "y_bar"),
                   reverse(value, weights, "tvup", arguments)),
    ]  # fmt: skip


def of_parameters(dae: Dae, weights: SX) -> SX:
    """The weights of the independent parameters from those of all; zero for the others."""
    if not dae.parameters:
        return SX(0, 1)
    values: dict[str, SX] = {}
    for parameter in dae.parameters:
        name = parameter.scalar.name
        values[name] = parameter.scalar.symbol if parameter.independent else substitute(parameter.value, values)
    p = ca.vertcat(*(parameter.scalar.symbol for parameter in dae.parameters))
    return ca.jtimes(ca.vertcat(*values.values()), p, weights, True)


def reverse(value: SX, weights: SX, by: str, arguments: Mapping[str, SX]) -> dict[str, SX]:
    """The weights of the arguments named ``by`` from the weights of a column of values."""
    moved = ca.vertcat(*(arguments[name] for name in by))
    result = ca.jtimes(value, moved, weights, True) if value.numel() else SX.zeros(moved.numel())
    parts: dict[str, SX] = {}
    first = 0
    for name in by:
        size = arguments[name].numel()
        parts[f"{name}_bar"] = result[first : first + size]
        first += size
    return parts
