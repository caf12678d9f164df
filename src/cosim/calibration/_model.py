"""A plant with some parameters free: what a fit asks of it."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cached_property, lru_cache
from pathlib import Path

import casadi as ca
import numpy as np
from filelock import FileLock
from numpy.typing import NDArray

from cosim.calibration._compiled import Library, Track, library
from cosim.calibration._equations import SUPPLY, equations
from cosim.calibration._grid import STAGES, intervals, points_of
from cosim.calibration._plant import Plant, plant_of
from cosim.dae import Dae
from cosim.errors import InputError, SimulationError
from cosim.fmu import catalogue
from cosim.fmu.exporter import compile_model

Array = NDArray[np.float64]

_PLANT = "linkage"
_SOURCES = ("_compiled.py", "_equations.py", "_grid.py", "_plant.py", "native/follow.c")
"""What the files in the cache depend on beside the plant."""
_SETTLED, _LONGEST = 1.0, 12.0
"""The nominal run is looked at from the former time [s] on; it lasts at most the latter."""


@dataclass(frozen=True)
class Nominal:
    """The current [A] over the crank angle [rad], from 0 to 2 pi, in steady running; both of shape (n,)."""

    angle: Array
    current: Array


class Model:
    """Equations of a plant with some parameters free.

    theta are the fitted parameters over ``scale``, which are their starting values where these are not zero.
    """

    def __init__(
        self, plant: Plant, dae: Callable[[], Dae], names: Sequence[str], given: Mapping[str, float], folder: Path
    ) -> None:
        """Take the equations from a folder, or compile them into it.

        Args:
            plant: what is known of the plant.
            dae: gives its equations if they are needed.
            names: the parameters to fit.
            given: values of other parameters, and starting values of those to fit, in the model's units.
            folder: its name has to tell what the plant is made from.

        Raises:
            InputError: there is no such parameter, or it cannot be fitted.
            BuildError: there is no C compiler, or it failed.
        """
        independent = {p.name: p for p in plant.parameters}
        for name in (*names, *given):
            if name not in independent:
                near = get_close_matches(name, list(independent), n=3)
                hint = f"; did you mean {' or '.join(near)}?" if near else ""
                raise InputError(f"{plant.name} has no parameter '{name}'{hint}")
        for name in names:
            if independent[name].type != "Real":
                raise InputError(f"{name} is a {independent[name].type}; only Reals can be fitted")
        self.plant = plant
        self.names = tuple(names)
        self.units = tuple(independent[name].unit for name in names)
        self.values = {name: given.get(name, p.value) for name, p in independent.items()}
        self.start = np.array([self.values[name] for name in names])
        self.scale = np.where(self.start == 0.0, 1.0, self.start)
        self.scales = np.array(plant.state_nominals), np.array(plant.unknown_nominals)
        self._free = np.array(list(self.values.values()))
        self._fitted = [list(self.values).index(name) for name in names]
        self._dae = dae
        self.library: Library = library(dae, plant, names, folder)

    @property
    def sizes(self) -> tuple[int, int]:
        """How many states and torn unknowns there are."""
        return len(self.plant.states), len(self.plant.unknowns)

    @cached_property
    def rhs(self) -> ca.Function:
        """CasADi's function of (x, z, u, theta) that gives dx/dt, the residuals 0 = r and the OUTPUTS."""
        found = equations(self._dae(), self.names, self.plant.held, [])
        nx, nz = self.sizes
        arguments = [
            ca.SX.sym(name, size)
            for name, size in {"x": nx, "z": nz, "u": len(self.plant.inputs), "theta": len(self.names)}.items()
        ]
        free = ca.SX(self._free)
        for k, place in enumerate(self._fitted):
            free[place] = arguments[3][k] * self.scale[k]
        return ca.Function("rhs", arguments, found.rhs.call([*arguments[:3], found.parameters(free)]))

    def state(self, name: str) -> int:
        """Return the position of a state."""
        return self.plant.states.index(name)

    def inputs(self, supply: Array) -> Array:
        """Return the inputs for these supply voltages [V], shape (n, inputs): full duty, no disturbance."""
        columns = {"duty": np.ones(len(supply)), SUPPLY: supply}
        return np.array([columns.get(name, np.zeros(len(supply))) for name in self.plant.inputs]).T

    def unknowns(self, angle: Array) -> Array:
        """Return a guess of the torn unknowns at these crank angles [rad], shape (n, unknowns): as in a nominal run."""
        rows = np.array(self.plant.unknowns_over_angle)
        # what turns with the crank counts from its value modulo one turn
        turns = np.round((rows[-1] - rows[0]) / (2.0 * np.pi))
        rows = rows - 2.0 * np.pi * np.round(rows[0] / (2.0 * np.pi)) * (turns != 0.0)
        inside = np.mod(angle, 2.0 * np.pi)
        found = np.array([np.interp(inside, self.plant.angle, column) for column in rows.T]).T
        return np.asarray(found + np.outer(angle - inside, turns))

    def follow(self, h: Array, u: Array, q: Array, guess: tuple[Array, Array] | None = None, **options: float) -> Track:
        """Follow a motion; its derivatives are by q.

        Args:
            h: lengths [s] of the intervals.
            u: inputs at the collocation points, shape (points, inputs).
            q: the initial state, then the fitted parameters, none of them scaled.
            guess: states and unknowns at the points of the first intervals.
            options: the tolerance of :meth:`Library.follow`.
        """
        x0 = q[: self.sizes[0]]
        if guess is None:
            angle = x0[[self.state("phi_crank")]]
            z = np.array([self.plant.at_rest]) if not x0[self.state("w_crank")] else self.unknowns(angle)
            guess = np.repeat(x0[None, :], STAGES, axis=0), np.repeat(z, STAGES, axis=0)
        return self.library.follow(h, u, self._parameters(q), x0, guess, **options)

    def output(self, number: int, track: Track, u: Array, q: Array) -> Array:
        """Return one of the OUTPUTS at the points, then its derivatives by q; shape (points, 1 + q)."""
        return self.library.output(number, track, u, self._parameters(q))

    def first_change(self, track: Track, u: Array, q: Array) -> tuple[int, str] | None:
        """Return the first point at which a relation is not as it is held, and its text; None if there is none."""
        held = self.plant.watched
        if not held:
            return None
        there = slice(0, track.done)
        values = self.library.relations(track.x[1:][there], track.z[there], u[there], self._parameters(q))
        strict = np.array([each.strict for each in held])
        changed = np.where(strict, values > 0.0, values >= 0.0) != np.array([each.value for each in held])
        if not changed.any():
            return None
        point = int(np.argmax(changed.any(axis=1)))
        return point, held[int(np.argmax(changed[point]))].text

    @cached_property
    def nominal(self) -> Nominal:
        """A run from rest with the starting values at full duty; raises InputError if the crank does not turn."""
        borders = intervals(0.0, _LONGEST, from_rest=True)
        points = points_of(borders)
        u = self.inputs(np.full(len(points), self.plant.supply))
        q = np.concatenate((np.zeros(self.sizes[0]), self.start))
        track = self.follow(np.diff(borders), u, q)
        angle = track.x[1:, self.state("phi_crank")]
        begin = float(np.interp(_SETTLED, points, angle))
        turn = (angle >= begin) & (angle <= begin + 2.0 * np.pi)
        if not track.whole or angle[-1] < begin + 2.0 * np.pi:
            raise InputError(
                f"with the starting values the crank turns only {(angle[-1] - begin) / (2.0 * np.pi):.2f} times in "
                f"{_LONGEST - _SETTLED:g} s; start from values with which the motor runs"
            )
        order = np.argsort(np.mod(angle[turn], 2.0 * np.pi))
        inside, current = np.mod(angle[turn], 2.0 * np.pi)[order], self.output(0, track, u, q)[turn, 0][order]
        grid = np.linspace(0.0, 2.0 * np.pi, 360)
        return Nominal(grid, np.interp(grid, inside, current, period=2.0 * np.pi))

    def _parameters(self, q: Array) -> Array:
        free = self._free.copy()
        free[self._fitted] = q[self.sizes[0] :]
        found = self.library.parameters(free)
        if not np.isfinite(found).all():
            raise SimulationError("the parameters give no finite equations; start from others, or give bounds")
        return found


def linkage_equations() -> Dae:
    """Return the equations of the built-in plant with the linkage. Raises ModelError if they cannot be compiled."""
    entry = catalogue.entry_of(_PLANT)
    return compile_model(entry.source, entry.model)


def linkage_plant(dae: Dae | None = None) -> Plant:
    """Return what is known of the built-in plant with the linkage, from the user's cache once it has been there.

    ``dae`` are its equations, if they are at hand. Raises ModelError or BuildError if they cannot be compiled.
    """
    return _plant(dae, _folder())


def linkage_model(names: Sequence[str], given: Mapping[str, float] | None = None, dae: Dae | None = None) -> Model:
    """Return the built-in plant with the linkage, with some parameters free; arguments and errors as of Model.

    ``dae`` are its equations, if they are at hand. Once compiled for these names, it comes from the user's cache.
    """
    folder = _folder()
    return Model(_plant(dae, folder), lambda: dae or linkage_equations(), names, given or {}, folder)


def _plant(dae: Dae | None, folder: Path) -> Plant:
    path = folder / "plant.json"
    if not path.is_file():
        folder.mkdir(parents=True, exist_ok=True)
        with FileLock(path.with_suffix(".lock")):
            if not path.is_file():
                found = plant_of(dae or linkage_equations(), catalogue.scratch(_PLANT, "observed"))
                found.write(path.with_suffix(".part"))
                path.with_suffix(".part").replace(path)
    return Plant.read(path)


def _folder() -> Path:
    """The folder in the user's cache; another one as soon as its content would be."""
    package = Path(__file__).parents[1]
    roots = [catalogue.entry_of(_PLANT).source, *(package / name for name in ("modelica", "dae", "fmu", "calibration"))]
    return _folder_of(tuple(stamp for root in roots for stamp in _stamps(root)))


@lru_cache(maxsize=1)
def _folder_of(_stamps: tuple[tuple[str, int, int], ...]) -> Path:
    """Read and digest all sources: once, until one of them has another stamp."""
    digest = hashlib.sha256()
    for name in _SOURCES:
        digest.update((Path(__file__).parent / name).read_bytes())
    return catalogue.scratch(_PLANT, f"calibration {digest.hexdigest()}")


def _stamps(folder: Path) -> list[tuple[str, int, int]]:
    """Names of the files below a folder, with their sizes and when they were written."""
    found = []
    for place, _, names in os.walk(folder):
        for name in names:
            stat = os.stat(os.path.join(place, name))  # noqa: PTH116, PTH118 - Path takes as long as reading
            found.append((name, stat.st_size, stat.st_mtime_ns))
    return found
