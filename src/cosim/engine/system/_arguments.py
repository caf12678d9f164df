"""The numbers that ask for a simulation, checked before anything runs."""

from __future__ import annotations

import math

from cosim.engine.system._system import SAME_INSTANT, System
from cosim.errors import InputError

LEAST_TOLERANCE = 1e-12
"""Relative tolerance below which a solver in double precision would follow rounding errors."""


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


def check_fixed_steps(system: System, step: float | None) -> None:
    """Raise InputError for a component that cannot take the macro step ``step`` [s] of the Jacobi algorithm."""
    for component in system.components:
        own = component.fmu.fixed_step
        if step is not None and own is not None and abs(step - own) > SAME_INSTANT:
            raise InputError(
                f"step is {step:g} s, but {component.name} ({component.fmu.name}) takes steps of {own:g} s only; "
                f"choose {own:g} s, or the default algorithm, which gives each component its own steps"
            )
