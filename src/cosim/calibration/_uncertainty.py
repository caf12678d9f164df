"""How certain the parameters are, and which of them the data cannot tell apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_UNKNOWN = 0.1
"""A combination of parameters with a relative standard error above this is not determined by the data."""
_NO_NOISE = 1e-12
_SAME = 0.1
"""Coefficients that differ by less than this part of the largest one are called the same."""
_ANY = 1e3
_TAKES_PART = 0.2
"""A parameter takes part in a combination with at least this much of its largest coefficient."""


@dataclass(frozen=True)
class Sensitivity:
    """Derivatives of a measurement's residuals (over their noise), and the residuals themselves, shape (n,).

    ``by_state`` of shape (n, states) by its initial state, ``by_theta`` of shape (n, parameters) by the parameters over
    their scales; both along the solutions of the equations.
    """

    residuals: Array
    by_state: Array
    by_theta: Array


@dataclass(frozen=True)
class Direction:
    """A combination of relative changes of the parameters, and its standard error.

    ``coefficients`` have the length 1; all parameters that move by ``coefficients`` times this much, relative to their
    starting values, change the residuals no more than noise does.
    """

    coefficients: dict[str, float]
    singular_value: float
    error: float

    @property
    def determined(self) -> bool:
        """Whether the data tell it to a tenth."""
        return self.error <= _UNKNOWN

    def parts(self) -> list[str]:
        """Return the parameters that take part, the strongest first."""
        largest = max(abs(c) for c in self.coefficients.values())
        ordered = sorted(self.coefficients, key=lambda name: -abs(self.coefficients[name]))
        return [name for name in ordered if abs(self.coefficients[name]) >= _TAKES_PART * largest]

    def told(self) -> str:
        """Say in words what cannot be told apart."""
        names = self.parts()
        effect = f"changes {'nothing that was measured' if self.error > 1.0 else 'what was measured only a little'}"
        spread = f"standard error {self.error:.2g} times the values" if self.error < _ANY else "by any factor"
        if len(names) == 1:
            return f"{names[0]} is not determined: changing it {effect} ({spread})"
        listed = ", ".join(sorted(names))
        shares = np.array([self.coefficients[name] for name in names])
        if np.ptp(shares) <= _SAME * np.abs(shares).max():
            return f"cannot be told apart: {listed}; scaling all by the same factor {effect} ({spread})"
        moves = " and ".join(
            f"{'raising' if share > 0.0 else 'lowering'} {name} by {abs(share / shares[0]):.2g} %"
            for name, share in zip(names, shares, strict=True)
        )
        return f"cannot be told apart: {listed}; {moves} {effect} ({spread})"


@dataclass(frozen=True)
class Uncertainty:
    """Standard errors (of the parameters over their scales), correlation, and the directions from best to worst.

    ``chi`` is the root of the mean square of all residuals over their noise: 1 if the model is right and the noise as
    assumed. The data count as if their noise were larger by it; priors count as they are given.
    """

    names: tuple[str, ...]
    errors: Array
    correlation: Array
    directions: tuple[Direction, ...]
    chi: float

    @property
    def undetermined(self) -> list[Direction]:
        """The directions that the data do not tell."""
        return [direction for direction in self.directions if not direction.determined]


def uncertainty(names: Sequence[str], parts: Sequence[Sensitivity], priors: Array, theta: Array) -> Uncertainty:
    """Return the uncertainty of parameters whose initial states are free.

    Args:
        names: of the parameters.
        parts: one for each measurement.
        priors: of shape (parameters,), one over the standard deviation that each was known with beforehand, 0 if not.
        theta: the parameters over their scales.
    """
    projected = []
    for part in parts:
        # what a change of the initial state can make up for says nothing of the parameters
        basis, _ = np.linalg.qr(part.by_state)
        projected.append(part.by_theta - basis @ (basis.T @ part.by_theta))
    count = sum(len(part.residuals) for part in parts)
    squares = sum(float(part.residuals @ part.residuals) for part in parts)
    freedom = max(count - len(names) - sum(part.by_state.shape[1] for part in parts), 1)
    chi = float(np.sqrt(squares / freedom))
    jacobian = np.vstack([*(each / max(chi, _NO_NOISE) for each in projected), np.diag(priors)])
    relative = jacobian * np.where(theta == 0.0, 1.0, theta)
    _, values, rows = np.linalg.svd(np.linalg.qr(relative, mode="r"), full_matrices=False)
    tiny = np.finfo(float).eps * max(float(values[0]), 1e-300) * len(jacobian)
    spread = 1.0 / np.maximum(values, tiny)
    covariance = (rows.T * spread**2) @ rows
    errors = np.sqrt(np.diag(covariance))
    directions = tuple(
        Direction(
            dict(zip(names, (row * np.sign(row[np.abs(row).argmax()])).tolist(), strict=True)), float(v), float(e)
        )
        for row, v, e in zip(rows, values, spread, strict=True)
    )
    scaled = errors * np.abs(np.where(theta == 0.0, 1.0, theta))
    return Uncertainty(tuple(names), scaled, covariance / np.outer(errors, errors), directions, chi)
