"""The numbers that ask for a simulation, checked before anything runs."""

from __future__ import annotations

import math
from typing import Literal, get_args

from cosim.engine._system import SAME_INSTANT, System
from cosim.errors import InputError

LEAST_TOLERANCE = 1e-12
"""Relative tolerance below which a solver in double precision would follow rounding errors."""

Algorithm = Literal["gauss-seidel", "jacobi"]
"""How the components of a system are stepped; see ``simulate``."""


def check_arguments(stop: float, output_interval: float, tolerance: float) -> None:
    for name, value, unit in (
        ("stop", stop, " s"),
        ("output_interval", output_interval, " s"),
        ("tolerance", tolerance, ""),
    ):
        if not (math.isfinite(value) and value > 0.0):
            raise InputError(f"{name} is {value:g}{unit}; it must be above 0")
    if tolerance < LEAST_TOLERANCE:
        raise InputError(
            f"tolerance is {tolerance:g}; below {LEAST_TOLERANCE:g} rounding errors count for more than those of the "
            f"method; write {LEAST_TOLERANCE:g} or more"
        )
    if output_interval < 1e-8:
        raise InputError(f"output_interval is {output_interval:g} s; it must be at least 1e-08 s")


def check_step(algorithm: str, step: float | None, stop: float, output_interval: float) -> None:
    if algorithm not in get_args(Algorithm):
        raise InputError(f"algorithm is {algorithm!r}; it can be {' or '.join(get_args(Algorithm))}")
    if algorithm != "jacobi":
        if step is not None:
            raise InputError("step is given, but only the algorithm jacobi takes one; leave it out")
        return
    if step is None or not (math.isfinite(step) and step > 2.0 * SAME_INSTANT):
        raise InputError(f"step is {step}; the algorithm jacobi needs a macro step above {2.0 * SAME_INSTANT} s")
    for name, value in (("output_interval", output_interval), ("stop", stop)):
        if abs(value - round(value / step) * step) > 0.5 * SAME_INSTANT or value < step:
            raise InputError(f"{name} is {value:g} s; it must be a multiple of the macro step, {step:g} s")


def check_fixed_steps(system: System, step: float | None) -> None:
    """Raise InputError for a component that cannot take the macro step ``step`` [s] of the Jacobi algorithm."""
    for component in system.components:
        own = component.fmu.fixed_step
        if step is not None and own is not None and abs(step - own) > SAME_INSTANT:
            raise InputError(
                f"step is {step:g} s, but {component.name} ({component.fmu.name}) takes steps of {own:g} s only; "
                f"choose {own:g} s, or the default algorithm, which gives each component its own steps"
            )
