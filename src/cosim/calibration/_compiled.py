"""The equations as a compiled library: what `native/follow.c` and the generated C make together."""

from __future__ import annotations

import ctypes
import hashlib
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from cosim.calibration._equations import equations
from cosim.calibration._grid import NODES, STAGES, slopes
from cosim.calibration._plant import Plant
from cosim.dae import Dae
from cosim.errors import BuildError
from cosim.fmu.toolchain import compiler, host

Array = NDArray[np.float64]
_NATIVE = Path(__file__).parent / "native" / "follow.c"
_FLAGS = (
    "-std=c11",
    "-O2",
    "-g0",
    "-fPIC",
    "-shared",
    "-fvisibility=hidden",
    "-ffp-contract=off",
    "-fno-math-errno",
    "-fno-tree-slp-vectorize",
)
_TOLERANCE, _MOST = 1e-6, 15
"""Newton's method ends with a step of this size beside the nominal sizes, or after so many."""


@dataclass(frozen=True)
class Track:
    """A motion at the collocation points, as far as it could be followed.

    ``x`` of shape (points + 1, states) begins with the initial state; ``x_q`` (points + 1, states, q) are its
    derivatives by q = [x0; fitted parameters]; ``z`` (points, unknowns). Only the first ``done`` points mean anything.
    """

    x: Array
    z: Array
    x_q: Array
    done: int

    @property
    def whole(self) -> bool:
        """Whether the motion was followed to its end."""
        return self.done == len(self.z)


@dataclass(frozen=True)
class Sums:
    """Sums over residuals r: loss, squares, r dr/dq and (dr/dq)' dr/dq, the last two weighted as the loss says."""

    loss: float
    squares: float
    gradient: Array
    hessian: Array


class Library:
    """The compiled equations of a plant for some fitted parameters."""

    def __init__(self, path: Path, plant: Plant, names: Sequence[str]) -> None:
        """Load it; raises BuildError if it cannot be loaded."""
        try:
            self._library = ctypes.CDLL(str(path))
        except OSError as error:
            raise BuildError(f"the compiled equations cannot be loaded: {error}; delete {path}") from error
        self._plant = plant
        self._q = len(plant.states) + len(names)

    def parameters(self, free: Array) -> Array:
        """Return all parameters from the independent ones."""
        found = np.empty(len(free) + self._plant.dependent)
        _call(self._library.all_parameters, free, found)
        return found

    def relations(self, x: Array, z: Array, u: Array, p: Array) -> Array:
        """Return the indicators of the watched relations at some points, shape (points, relations)."""
        found = np.zeros((len(z), len(self._plant.watched)))
        _call(self._library.held_relations, len(z), x, z, u, p, found)
        return found

    def follow(
        self, h: Array, u: Array, p: Array, x0: Array, guess: tuple[Array, Array], tolerance: float = _TOLERANCE
    ) -> Track:
        """Follow a motion with its derivatives, which are as exact as the guess is near.

        Args:
            h: lengths [s] of the intervals.
            u: inputs at the collocation points, shape (points, inputs).
            p: all parameters.
            x0: the initial state.
            guess: states and unknowns at the points of as many intervals as they are guessed for, at least one.
            tolerance: Newton's method ends with a step of this size beside the nominal sizes.
        """
        count, points, nx, nz = len(h), STAGES * len(h), len(x0), len(self._plant.unknowns)
        x, z = np.zeros((points + 1, nx)), np.zeros((points, nz))
        known = min(len(guess[1]), points)
        x[0], x[1 : known + 1], z[:known] = x0, guess[0][:known], guess[1][:known]
        x_q = np.zeros((points + 1, nx, self._q))
        x_q[0, :, :nx] = np.eye(nx)
        done = _call(self._library.follow, count, known // STAGES, h, u, p, x, z, x_q, tolerance, _MOST)
        return Track(x, z, x_q, done * STAGES)

    def output(self, number: int, track: Track, u: Array, p: Array) -> Array:
        """Return one of the OUTPUTS at the points and, in the other columns, its derivatives by q."""
        points = len(track.z)
        y, y_q = np.zeros(points), np.zeros((points, self._q))
        _call(self._library.measure, number, points, track.x[1:], track.z, u, p, track.x_q[1:], y, y_q)
        return np.column_stack((y, y_q))

    def gather(self, sampling: csr_array, points: Array, measured: Array, turn: float) -> Sums:
        """Return the sums over the residuals of some samples.

        Args:
            sampling: interpolates each sample from four points in a row.
            points: a value at the points and its derivatives by q, shape (points, 1 + q).
            measured: what the value is compared with, shape (samples,).
            turn: from about here on, the loss of a residual is linear (pseudo-Huber); infinite if it never is.
        """
        samples = sampling.shape[0]
        sums = np.zeros(2)
        gradient, hessian = np.zeros(self._q), np.zeros((self._q, self._q))
        first = np.asarray(sampling.indices[::4], dtype=np.int32)
        given = first, sampling.data, points, measured[:samples]
        _call(self._library.gather, samples, *given, turn, sums[:1], sums[1:], gradient, hessian)
        return Sums(float(sums[0]), float(sums[1]), gradient, hessian)


def library(dae: Callable[[], Dae], plant: Plant, names: Sequence[str], folder: Path) -> Library:
    """Return the library for some fitted parameters from a folder, into which it is compiled first if it is missing.

    Args:
        dae: gives the plant's equations if they are needed.
        plant: what else is known of it.
        names: the parameters to fit.
        folder: its name has to tell what the plant is made from.

    Raises:
        InputError: the plant is none of the wiper drive.
        BuildError: there is no C compiler, or it failed.
    """
    from filelock import FileLock

    digest = hashlib.sha256("\n".join([*_FLAGS, *names]).encode()).hexdigest()[:16]
    path = folder / f"fit-{digest}{host().suffix}"
    if not path.is_file():
        folder.mkdir(parents=True, exist_ok=True)
        with FileLock(path.with_suffix(".lock")):
            if not path.is_file():
                _compile(_generated(dae(), plant, names), path)
    return Library(path, plant, names)


def _compile(generated: str, path: Path) -> None:
    """Compile in a folder of its own and rename, so that no other process ever sees half a library."""
    with tempfile.TemporaryDirectory(dir=path.parent) as temporary:
        folder = Path(temporary)
        (folder / "equations.h").write_text(generated, encoding="utf-8")
        libraries = [] if path.suffix == ".dll" else ["-lm"]
        command = [*compiler(), *_FLAGS, f"-I{folder}", "-o", path.name, str(_NATIVE), *libraries]
        done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=folder)
        if done.returncode:
            raise BuildError(f"the C compiler failed on the equations of the fit:\n{done.stderr.strip()[-3000:]}")
        (folder / path.name).replace(path)


def _generated(dae: Dae, plant: Plant, names: Sequence[str]) -> str:
    """The text of equations.h."""
    found = equations(dae, names, plant.held, [each.symbol for each in plant.watched])
    code = ca.CodeGenerator("equations.c")
    for function in (found.value, found.point, *found.outputs, found.relations, found.parameters):
        code.add(function)
    sizes = {
        "NX": len(plant.states), "NZ": len(plant.unknowns), "NU": len(plant.inputs),
        "NP": len(names), "NR": len(plant.watched), "STAGES": STAGES,
    }  # fmt: skip
    tables = {
        "NODES": NODES, "L": slopes(), "X_NOMINAL": np.array(plant.state_nominals),
        "Z_NOMINAL": np.array([*plant.unknown_nominals, 1.0]),
    }  # fmt: skip
    return "\n".join([
        # what is generated stays inside the library
        "#define CASADI_SYMBOL_EXPORT static inline",
        code.dump(),
        *(f"#define {name} {value}" for name, value in sizes.items()),
        *(f"static const double {name}{_shape(table)} = {_braces(table)};" for name, table in tables.items()),
        "",
    ])  # fmt: skip


def _shape(table: Array) -> str:
    return "".join(f"[{size}]" for size in table.shape)


def _braces(table: Array) -> str:
    if table.ndim == 0:
        return repr(float(table))
    return "{" + ", ".join(_braces(row) for row in table) + "}"


def _call(function: Callable[..., int], *arguments: NDArray[Any] | float) -> int:
    """Call a C function: arrays become pointers to their numbers, row by row, floats doubles."""
    # an array that had to be copied lives as long as this list
    plain = [np.ascontiguousarray(each) if isinstance(each, np.ndarray) else each for each in arguments]
    return function(*(
        ctypes.c_void_p(each.ctypes.data) if isinstance(each, np.ndarray)
        else ctypes.c_double(each) if isinstance(each, float) else each
        for each in plain
    ))  # fmt: skip
