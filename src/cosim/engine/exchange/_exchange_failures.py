"""Why a Model Exchange FMU cannot go on, in words."""

from __future__ import annotations

from cosim.engine.fmu._instance import CallError, Instance

MOST_UPDATES = 100
"""Of the discrete states in one event."""

MOST_EVENTS = 1000
"""At one instant."""


def without_end(instance: Instance, t: float) -> CallError:
    """Return the error for too many events at one time [s]."""
    return CallError(
        instance,
        f"has had {MOST_EVENTS} events at {t:.9g} s",
        "look for an event that sets itself off, or for ever shorter intervals between events",
    )


def never_settles(instance: Instance) -> CallError:
    """Return the error for too many updates of the discrete states."""
    return CallError(
        instance,
        f"still needs to update its discrete states after {MOST_UPDATES} updates",
        "break the cycle of events inside it",
    )


def announces_the_past(instance: Instance, t: float) -> CallError:
    """Return the error for a next event at a time [s] that is not in the future."""
    return CallError(
        instance,
        f"announces its next event at {t:.9g} s, which is not after the present one",
        "check its sample period",
    )


def not_finite(instance: Instance, t: float, state: str) -> CallError:
    """Return the error for a derivative that is not a finite number at a time [s], however short the step."""
    return CallError(
        instance,
        f"gives no finite number for the derivative of {state} at {t:.9g} s, whatever the step size",
        "check for a division by zero, the root or logarithm of a negative number, and for inputs and parameters out "
        "of range",
    )


def too_small(instance: Instance, t: float, h: float, state: str, tolerance: float) -> CallError:
    """Return the error for a step of h [s] at t [s] that still errs by more than the tolerance."""
    return CallError(
        instance,
        f"cannot be integrated from {t:.9g} s on: the step size had to be reduced to {h:.2g} s without reaching the "
        f"tolerance {tolerance:.2g}; the largest error is in {state}",
        "try a looser tolerance; check for a solution that grows beyond bounds, for a discontinuity without an event, "
        "and for inputs and parameters out of range",
    )


def singular(instance: Instance, t: float, state: str) -> CallError:
    """Return the error for equations of a step at t [s] that have no solution, however short the step."""
    return CallError(
        instance,
        f"cannot be integrated from {t:.9g} s on: the derivatives by its states are not finite; the state concerned "
        f"is {state}",
        "check its parameters and its inputs at that time",
    )


def no_progress(instance: Instance, t: float, covered: float, state: str) -> CallError:
    """Return the error for very many steps up to t [s] that have covered next to no time [s]."""
    return CallError(
        instance,
        f"cannot be integrated from {t:.9g} s on: the last 10,000 steps have covered {covered:.2g} s; the largest "
        f"error is in {state}",
        "check for a derivative that jumps to and fro without an event, and smooth it or give it a hysteresis",
    )
