"""All measurements in one collocation problem, and its solution by IPOPT."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from cosim.calibration._collocation import Collocation, collocate
from cosim.calibration._data import Data
from cosim.calibration._ipopt import Progress, solve
from cosim.calibration._model import OUTPUTS, Model
from cosim.calibration._uncertainty import Sensitivity, Uncertainty, sensitivity, uncertainty
from cosim.errors import InputError

Array = NDArray[np.float64]
_HUBER = 3.0
"""Residuals beyond this many standard deviations count linearly if the loss is robust."""
_REST = 0.05
"""Speed [rad/s] that a crank may have reached between the instant of switching on and the first sample after it."""
_LOOSE = 0.3
_WIDE = 10.0
"""Without bounds, a parameter may become this many times larger or smaller."""


@dataclass(frozen=True)
class Free:
    """A parameter to fit: bounds, and what is known of it beforehand (mean and standard deviation), in its unit.

    Without bounds it stays between a tenth and ten times its starting value, unless that is zero. ``local`` gives each
    measurement a value of its own.
    """

    name: str
    lower: float | None = None
    upper: float | None = None
    prior: tuple[float, float] | None = None
    local: bool = False


@dataclass(frozen=True)
class Part:
    """A measurement inside the problem: its equations, and which entries of theta it uses."""

    data: Data
    collocation: Collocation
    entries: list[int]
    held_out: bool


@dataclass(frozen=True)
class Motion:
    """A measurement's part of a solution: the initial state ``x0`` and the values ``w`` at the points, scaled."""

    x0: Array
    w: Array


@dataclass(frozen=True)
class Solution:
    """Parameters over their scales, a motion for each fitted measurement, and how IPOPT ended."""

    theta: Array
    motions: tuple[Motion, ...]
    status: str
    iterations: int


class Problem:
    """All measurements, and one vector theta of the parameters over their scales.

    ``labels`` tell for each entry which of the free parameters it is, and of which measurement if it is local.
    """

    def __init__(self, model: Model, free: Sequence[Free], data: Sequence[Data], held_out: Sequence[Data] = ()) -> None:
        """Set up the equations; raises InputError if bounds or priors contradict each other or the starting values."""
        if [f.name for f in free] != list(model.names):
            raise InputError(
                f"to be fitted are {', '.join(f.name for f in free)}, but the model was made for "
                f"{', '.join(model.names)}; name the same ones in the same order"
            )
        if not data:
            raise InputError("there is nothing to fit to; give at least one measurement that is not held out")
        self.model = model
        self.free = tuple(free)
        self.labels: list[tuple[int, int | None]] = [(k, None) for k, f in enumerate(free) if not f.local]
        self.labels += [(k, number) for number in range(len(data)) for k, f in enumerate(free) if f.local]
        self.scale = np.array([model.scale[k] for k, _ in self.labels])
        self.start = np.array([model.start[k] for k, _ in self.labels]) / self.scale
        self.lower, self.upper = self._bounds()
        self.parts = [self._part(number, each, False) for number, each in enumerate(data)]
        # a local parameter of what is held out is that of the first measurement
        self.parts += [self._part(0, each, True) for each in held_out]

    @property
    def fitted(self) -> list[Part]:
        """The measurements that are not held out."""
        return [part for part in self.parts if not part.held_out]

    def label(self, entry: int) -> str:
        """Return what to call an entry of theta."""
        k, number = self.labels[entry]
        name = self.free[k].name
        return name if number is None else f"{name} ({self.parts[number].data.name})"

    def solve(self, robust: bool, most_iterations: int, progress: Progress | None) -> Solution:
        """Minimise the loss; ``progress`` is told the iteration and the root mean square of all residuals over noise.

        Raises SimulationError if IPOPT found nothing finite.
        """
        theta = ca.MX.sym("theta", len(self.labels))
        variables, starts, lower, upper = [theta], [self.start], [self.lower], [self.upper]
        # what the data do not tell stays near its start: known to a third, far too weak to move what they tell
        residuals, constraints = [(theta - self.start) / _LOOSE, *self._priors(theta)], []
        known = sum(each.numel() for each in residuals)
        for part in self.fitted:
            own, q, w, r = self._motion(part, theta[part.entries])
            residuals.append(r)
            constraints.append(part.collocation.residuals(q, w))
            for variable, guess in zip(own, self._guess(part), strict=True):
                variables.append(variable)
                starts.append(guess)
                lower.append(np.full(len(guess), -np.inf))
                upper.append(np.full(len(guess), np.inf))
        r = ca.vertcat(*residuals)
        turns = np.full(r.numel(), _HUBER if robust else np.inf)
        turns[:known] = np.inf
        count = r.numel() - known
        found, status, iterations = solve(
            ca.vertcat(*variables), r, ca.vertcat(*constraints), turns, starts, (lower, upper), most_iterations,
            None if progress is None else lambda k, f: progress(k, float(np.sqrt(max(2.0 * f, 0.0) / count))),
        )  # fmt: skip
        theta_found, *rest = np.split(found, np.cumsum([len(start) for start in starts])[:-1])
        motions = tuple(Motion(x0, w) for x0, w in zip(rest[::2], rest[1::2], strict=True))
        return Solution(theta_found, motions, status, iterations)

    def follow(self, part: Part, theta: Array, most_iterations: int) -> Motion:
        """Return the motion with given parameters that meets a measurement best: only its initial state is free."""
        (x0, _), q, w, r = self._motion(part, ca.DM(theta[part.entries]))
        starts = self._guess(part)
        free = [np.full(len(start), np.inf) for start in starts]
        found, _, _ = solve(
            ca.vertcat(x0, w), r, part.collocation.residuals(q, w), np.full(r.numel(), np.inf), starts,
            ([-f for f in free], free), most_iterations, None,
        )  # fmt: skip
        return Motion(found[: len(starts[0])], found[len(starts[0]) :])

    def modelled(self, part: Part, theta: Array, motion: Motion) -> Array:
        """Return the OUTPUTS at the instants of the data, shape (2, n)."""
        outputs = part.collocation.outputs(np.concatenate((motion.x0, theta[part.entries])), motion.w)
        return np.array(ca.mtimes(outputs, part.collocation.sampling.T), dtype=np.float64)

    def sensitivity(self, part: Part, theta: Array, motion: Motion) -> Sensitivity:
        """Return how a measurement's residuals change with its initial state and with theta."""
        q = ca.MX.sym("q", len(motion.x0) + len(part.entries))
        w = ca.MX.sym("w", len(motion.w))
        residuals = ca.Function("r", [q, w], [self._residuals(part, q, w)])
        at = np.concatenate((motion.x0, theta[part.entries]))
        return sensitivity(
            part.collocation.residuals, residuals, at, motion.w, len(motion.x0), part.entries, len(theta)
        )

    def uncertainty(self, solution: Solution) -> Uncertainty:
        """Return how certain the parameters of a solution are."""
        known = [self.free[k].prior for k, _ in self.labels]
        strengths = [0.0 if p is None else abs(s) / p[1] for p, s in zip(known, self.scale, strict=True)]
        names = [self.label(entry) for entry in range(len(self.labels))]
        parts = [self.sensitivity(p, solution.theta, m) for p, m in zip(self.fitted, solution.motions, strict=True)]
        return uncertainty(names, parts, np.array(strengths), solution.theta)

    def mode_changes(self, solution: Solution) -> list[str]:
        """Tell where a relation that is held would have changed: the fit is not to be trusted there."""
        notes = []
        x_scale, z_scale = self.model.scales
        scales = np.concatenate((x_scale, z_scale))
        for part, motion in zip(self.fitted, solution.motions, strict=True):
            columns = motion.w.reshape(-1, len(scales)).T * scales[:, None]
            x, z = columns[: len(x_scale)], columns[len(x_scale) :]
            u = self.model.input_column(part.data.supply_at(part.collocation.points))
            change = self.model.first_change(x, z, u, solution.theta[part.entries])
            if change is not None:
                column, text = change
                notes.append(
                    f"{part.data.name}: at {part.collocation.points[column]:.3f} s the relation '{text}' changes, "
                    "which the fit takes to stay as it is; choose another window"
                )
        return notes

    def _part(self, number: int, data: Data, held_out: bool) -> Part:
        entries = [self.labels.index((k, number if f.local else None)) for k, f in enumerate(self.free)]
        return Part(data, collocate(self.model, data), entries, held_out)

    def _guess(self, part: Part) -> list[Array]:
        return [part.collocation.guess_q[: self.model.sizes[0]], part.collocation.guess_w]

    def _motion(self, part: Part, own_theta: ca.MX | ca.DM) -> tuple[list[ca.MX], ca.MX, ca.MX, ca.MX]:
        """Return a measurement's variables [x0, w], q and w of its equations, and its residuals."""
        x0 = ca.MX.sym("x0", self.model.sizes[0])
        w = ca.MX.sym("w", len(part.collocation.guess_w))
        q = ca.vertcat(x0, own_theta)
        return [x0, w], q, w, self._residuals(part, q, w)

    def _residuals(self, part: Part, q: ca.MX, w: ca.MX) -> ca.MX:
        """Return the residuals of a measurement over their noise, and its speed at the start if that is from rest."""
        data = part.data
        outputs = part.collocation.outputs(q, w)
        current, torque = (ca.mtimes(part.collocation.sampling, outputs[row, :].T) for row in range(len(OUTPUTS)))
        found = [(current - data.current) / data.noise[0]]
        if data.torque is not None:
            found.append((torque - data.torque) / data.noise[1])
        if data.from_rest:
            speed = self.model.state("w_crank")
            found.append(q[speed] * self.model.scales[0][speed] / _REST)
        return ca.vertcat(*found)

    def _priors(self, theta: ca.MX) -> list[ca.MX]:
        """Return the deviations of theta from what is known beforehand, over their standard deviations."""
        known = [self.free[k].prior for k, _ in self.labels]
        return [
            (theta[entry] * self.scale[entry] - prior[0]) / prior[1]
            for entry, prior in enumerate(known)
            if prior is not None
        ]

    def _bounds(self) -> tuple[Array, Array]:
        lower, upper = np.full(len(self.labels), -np.inf), np.full(len(self.labels), np.inf)
        for entry, (k, _) in enumerate(self.labels):
            f, unit = self.free[k], self.model.units[k]
            if f.prior is not None and not f.prior[1] > 0.0:
                raise InputError(
                    f"{f.name}: the standard deviation of the prior is {f.prior[1]:g}; it must be positive"
                )
            value = self.model.start[k]
            wide = sorted((value / _WIDE, value * _WIDE)) if value else [-np.inf, np.inf]
            low = wide[0] if f.lower is None else f.lower
            high = wide[1] if f.upper is None else f.upper
            if not low < high:
                raise InputError(
                    f"{f.name}: the lower bound {low:g} {unit} is not below the upper one, {high:g} {unit}"
                )
            if not low <= value <= high:
                raise InputError(
                    f"{f.name}: the starting value {value:g} {unit} is outside the bounds {low:g} to {high:g} {unit}; "
                    "give another one"
                )
            lower[entry], upper[entry] = sorted((low / self.scale[entry], high / self.scale[entry]))
        return lower, upper
