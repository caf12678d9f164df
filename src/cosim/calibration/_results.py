"""What a fit finds."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cosim.calibration._data import Data
from cosim.calibration._uncertainty import Uncertainty
from cosim.errors import InputError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Estimate:
    """What was found of a parameter: value and standard error in ``unit``; ``of`` is a measurement if it is local."""

    name: str
    unit: str
    value: float
    error: float
    start: float
    of: str | None
    at_bound: bool


@dataclass(frozen=True)
class Agreement:
    """How well a measurement is met: root of the mean square of the residuals of current [A] and torque [N.m].

    ``noise`` [A] is that of the measured current, which the first would be at best. ``held_out`` tells that the
    measurement was not fitted, but for its initial state.
    """

    name: str
    current_rmse: float
    torque_rmse: float | None
    noise: float
    samples: int
    held_out: bool


@dataclass(frozen=True)
class Fit:
    """Parameters with their uncertainty, and how well each measurement is met by them.

    ``solved`` tells whether a minimum was found, ``limit`` what kept it from one. ``modelled`` has for each
    measurement the current [A] and torque [N.m] at its instants, shape (2, n).
    """

    estimates: tuple[Estimate, ...]
    uncertainty: Uncertainty
    agreements: tuple[Agreement, ...]
    solved: bool
    limit: str | None
    iterations: int
    notes: tuple[str, ...]
    data: tuple[Data, ...] = field(repr=False)
    modelled: tuple[Array, ...] = field(repr=False)

    @property
    def synthetic(self) -> bool:
        """Whether any of the data were computed, not measured."""
        return any(each.synthetic for each in self.data)

    def value(self, name: str, of: str | None = None) -> float:
        """Return the value of a parameter; of a measurement, by its name, if it is local.

        Raises `InputError` if it was not fitted, or is local and ``of`` is none of the measurements.
        """
        for estimate in self.estimates:
            if estimate.name == name and estimate.of in (None, of):
                return estimate.value
        known = ", ".join(e.name if e.of is None else f"{e.name} of '{e.of}'" for e in self.estimates)
        raise InputError(f"{name}{f' of {of!r}' if of else ''} was not fitted; fitted were {known}")
