"""What is to be found: the parameters with what is known of them beforehand, and the measurements that tell of them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from cosim.calibration._data import Data
from cosim.calibration._grid import STAGES, intervals, points_of, sampling
from cosim.calibration._model import Model
from cosim.errors import InputError

Array = NDArray[np.float64]
HUBER = 3.0
"""Residuals beyond this many standard deviations count linearly if the loss is robust."""
REST = 0.05
"""Speed [rad/s] that a crank may have reached between the instant of switching on and the first sample after it."""
LOOSE = 0.3
"""What the data do not tell stays near its start: known to a third, far too weak to move what they tell."""
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
    """A measurement inside the problem, and which entries of theta it uses.

    ``borders`` [s] of the intervals, ``points`` [s] of collocation, ``u`` the inputs there, shape (points, inputs);
    ``sampling`` (samples, points) takes what is there to the instants of the data.
    """

    data: Data
    borders: Array
    points: Array
    u: Array
    sampling: csr_array
    entries: list[int]
    held_out: bool

    @property
    def h(self) -> Array:
        """Lengths [s] of the intervals."""
        return np.diff(self.borders)

    @property
    def is_cut(self) -> bool:
        """Whether this is the beginning of a measurement only."""
        return int(self.sampling.shape[0]) < len(self.data.time)

    @property
    def samples(self) -> int:
        """How many residuals there are."""
        return int(self.sampling.shape[0]) * len(self.data.measured)

    def first(self, length: float) -> Part:
        """Return the first so many seconds of it; all, if there are not as many."""
        count = int(np.searchsorted(self.borders, self.borders[0] + length))
        if count >= len(self.borders) - 1:
            return self
        points = STAGES * count
        samples = int(np.searchsorted(self.data.time, self.borders[count]))
        part = self.sampling[:samples]
        # the last samples may be interpolated from points that are left out
        samples = int(np.searchsorted(np.maximum.reduceat(part.indices, part.indptr[:-1]), points))
        return replace(
            self,
            borders=self.borders[: count + 1],
            points=self.points[:points],
            u=self.u[:points],
            sampling=self.sampling[:samples, :points],
        )


@dataclass(frozen=True)
class Solution:
    """Parameters over their scales, an initial state (scaled) for each fitted measurement, and how the search ended.

    ``limit`` is what kept it from a minimum, None if it is at one.
    """

    theta: Array
    states: tuple[Array, ...]
    limit: str | None
    iterations: int


class Problem:
    """All measurements, and one vector theta of the parameters over their scales.

    ``labels`` tell for each entry which of the free parameters it is, and of which measurement if it is local.
    """

    def __init__(self, model: Model, free: Sequence[Free], data: Sequence[Data], held_out: Sequence[Data] = ()) -> None:
        """Set it up; raises InputError if bounds or priors contradict each other or the starting values."""
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

    def initial(self, part: Part) -> Array:
        """Return a guess of a measurement's initial state, scaled."""
        return np.asarray(part.data.initial(self.model) / self.model.scales[0])

    def priors(self) -> Iterator[tuple[int, float, float]]:
        """Give entries of theta with the mean and the standard deviation that are known of them beforehand, scaled."""
        for entry, (k, _) in enumerate(self.labels):
            prior = self.free[k].prior
            if prior is not None:
                yield entry, prior[0] / self.scale[entry], prior[1] / abs(self.scale[entry])

    def _part(self, number: int, data: Data, held_out: bool) -> Part:
        entries = [self.labels.index((k, number if f.local else None)) for k, f in enumerate(self.free)]
        borders = intervals(data.time[0], data.time[-1], data.from_rest)
        points = points_of(borders)
        u = self.model.inputs(data.supply_at(points))
        return Part(data, borders, points, u, sampling(points, data.time), entries, held_out)

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
