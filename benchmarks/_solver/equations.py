"""The C of a model's equations, called from Python and timed in C."""

from __future__ import annotations

import re
import subprocess
from ctypes import CDLL, POINTER, c_double, c_int, c_long
from pathlib import Path

import casadi as ca
import numpy as np
from _solver import minimal
from _solver.problems import FLAGS

from cosim.dae import Dae
from cosim.fmu.codegen import generate
from cosim.fmu.layout import lay_out
from cosim.fmu.toolchain import RUNTIME, compiler

HERE = Path(__file__).parent
_ARRAY = POINTER(c_double)


class Equations:
    """model_rhs and model_linearise of a shared library, at fixed inputs, parameters and discrete variables."""

    def __init__(self, library: Path, n: int, **held: np.ndarray) -> None:
        self._dll = CDLL(str(library))
        self._dll.time_rhs.restype = self._dll.time_linearise.restype = c_double
        self._n = n
        self._held = [np.ascontiguousarray(held.get(key, np.zeros(1)), dtype=float) for key in "updc"]

    def rhs(self, v: np.ndarray) -> np.ndarray:
        """The right-hand side at one point."""
        f = np.zeros(self._n)
        self._dll.model_rhs(c_double(0.0), _pointer(v), *map(_pointer, self._held), _pointer(f))
        return f

    def linearise(self, v: np.ndarray) -> np.ndarray:
        """The Jacobian at one point, [row, column]."""
        f, f_t, J = np.zeros(self._n), np.zeros(self._n), np.zeros((self._n, self._n))
        arguments = (c_double(0.0), _pointer(v), *map(_pointer, self._held))
        self._dll.model_linearise(*arguments, _pointer(f), _pointer(J), _pointer(f_t))
        return J.T

    def seconds(self, function: str, points: np.ndarray, evaluations: int) -> float:
        """Seconds for one evaluation of "rhs" or "linearise", the mean over many at points of shape (m, n)."""
        rounds = max(1, evaluations // len(points))
        call = self._dll[f"time_{function}"]
        call.restype = c_double
        total = call(c_long(rounds), c_int(len(points)), _pointer(points), *map(_pointer, self._held))
        return float(total) / (rounds * len(points))


def generated(dae: Dae, folder: Path, u: np.ndarray, d: np.ndarray) -> Equations:
    """What this project's compiler writes for a model."""
    folder.mkdir()
    for name, text in generate(dae, lay_out(dae), "{token}").items():
        (folder / name).write_text(text, encoding="utf-8")
    library = _library([folder / "model.c"], folder)
    p = np.array([dae.parameter_values[p.scalar.name] for p in dae.parameters])
    return Equations(library, len(dae.unknowns), u=u, p=p, d=d, c=np.zeros(max(1, len(dae.relations))))


def derived_by_hand(folder: Path, u: np.ndarray) -> Equations:
    """The equations of minimal.py, written to C by CasADi."""
    folder.mkdir()
    n = len(minimal.UNKNOWNS)
    generator = ca.CodeGenerator("minimal_functions")
    for function in minimal.functions():
        generator.add(function)
    generator.generate(f"{folder}/")
    others = set(re.findall(r"\bMODEL_N[A-Z]+\b", (RUNTIME / "model.h").read_text())) - {"MODEL_NX", "MODEL_NV"}
    sizes = [f"#define MODEL_NX {n}", *(f"#define {name} 0" for name in sorted(others)), ""]
    (folder / "model_sizes.h").write_text("\n".join(sizes))
    return Equations(_library([folder / "minimal_functions.c", HERE / "minimal.c"], folder), n, u=u)


def _library(sources: list[Path], folder: Path) -> Path:
    library = folder / "equations.so"
    includes = [f"-I{folder}", f"-I{RUNTIME}"]
    subprocess.run(
        [*compiler(), *FLAGS, "-shared", *includes, "-o", library, *sources, HERE / "timing.c", "-lm"], check=True
    )
    return library


def _pointer(values: np.ndarray) -> object:
    return values.ctypes.data_as(_ARRAY)
