"""Models as every solver needs them: an FMU, and the same equations as CasADi functions scaled to nominal values."""

from __future__ import annotations

import subprocess
import tomllib
from dataclasses import dataclass
from pathlib import Path

import casadi as ca
import numpy as np

from cosim.dae import Dae
from cosim.fmu import compile_model
from cosim.fmu.exporter import pack
from cosim.fmu.toolchain import compiler

ROOT = Path(__file__).parents[2]
STIFF = ROOT / "tests" / "models" / "Stiff"
# as the FMUs are compiled
FLAGS = ("-std=c11", "-O2", "-fPIC", "-ffp-contract=off", "-fno-math-errno")


@dataclass(frozen=True)
class Problem:
    """One stiff problem without inputs or events.

    Its unknowns are [x; z], each divided by its nominal value, so that one absolute tolerance for all of them means
    what the FMU means by it.
    """

    name: str
    stop: float
    fmu: Path
    n_x: int
    start: np.ndarray
    """Consistent unknowns at t = 0, shape (n_x + n_z,)."""
    symbolic: ca.Function
    """(t, v) to [dx/dt; residuals]."""
    f: ca.Function
    """The same in machine code."""
    jacobian: ca.Function
    """(t, v) to df/dv."""
    outputs: ca.Function
    """(t, v) to the components of which the solution is published, unscaled."""
    components: list[str]
    expected: np.ndarray
    nominal: np.ndarray
    """Of the components."""

    @property
    def is_ode(self) -> bool:
        """Whether there are no algebraic equations."""
        return self.n_x == len(self.start)

    def error(self, values: np.ndarray) -> float:
        """The largest error in units of each component's size plus its nominal value."""
        return float(np.max(np.abs(values - self.expected) / (np.abs(self.expected) + self.nominal)))


def problem(name: str, folder: Path) -> Problem:
    """Compile one of the stiff problems; what is built goes into ``folder``."""
    published = tomllib.loads((STIFF / "reference.toml").read_text(encoding="utf-8"))[name]
    dae = compile_model(STIFF / f"{name}.mo", f"Stiff.{name}")
    scalars = {p.scalar.name: p for p in dae.published}
    components = list(published["values"])
    outputs = ca.vertcat(*(scalars[c].value for c in components))
    t, v, (f, y) = unknowns_only(dae, [dae.f, outputs])
    scale = ca.DM([u.nominal for u in dae.unknowns])
    n_x = len(dae.states)
    f = ca.substitute(f, v, v * scale)
    f[:n_x] /= scale[:n_x]
    start = ca.vertcat(*unknowns_only(dae, [ca.vertcat(*(u.start for u in dae.unknowns))])[2])
    return Problem(
        name=name,
        stop=published["stop"],
        fmu=pack(dae, folder),
        n_x=n_x,
        start=_consistent(t, v, f, n_x, np.array(ca.evalf(start)).ravel() / np.array(scale).ravel()),
        symbolic=(symbolic := ca.Function(f"f_{name}", [t, v], [ca.cse(ca.densify(f))])),
        f=compiled(symbolic, folder),
        jacobian=compiled(ca.Function(f"jacobian_{name}", [t, v], [ca.cse(ca.densify(ca.jacobian(f, v)))]), folder),
        outputs=ca.Function("outputs", [t, v], [ca.substitute(y, v, v * scale)]),
        components=components,
        expected=np.array([published["values"][c] for c in components]),
        nominal=np.array([scalars[c].scalar.nominal for c in components]),
    )


def unknowns_only(dae: Dae, expressions: list[ca.SX]) -> tuple[ca.SX, ca.SX, list[ca.SX]]:
    """Time, the unknowns, and the expressions with the default values of the parameters put in."""
    parameters = ca.vertcat(ca.SX(0, 1), *(p.scalar.symbol for p in dae.parameters))
    values = ca.DM([dae.parameter_values[p.scalar.name] for p in dae.parameters])
    return dae.time, dae.v, [ca.substitute(e, parameters, values) for e in expressions]


def _consistent(t: ca.SX, v: ca.SX, f: ca.SX, n_x: int, start: np.ndarray) -> np.ndarray:
    """Algebraic unknowns that satisfy their equations at t = 0."""
    if n_x == len(start):
        return start
    residual = ca.Function("residual", [v[n_x:], v[:n_x], t], [f[n_x:]])
    z = ca.rootfinder("z", "newton", residual)(start[n_x:], start[:n_x], 0.0)
    return np.concatenate([start[:n_x], np.array(z).ravel()])


def compiled(function: ca.Function, folder: Path) -> ca.Function:
    """The same function as machine code."""
    name = function.name()
    generator = ca.CodeGenerator(name)
    generator.add(function)
    generator.generate(f"{folder}/")
    library = folder / f"{name}.so"
    subprocess.run([*compiler(), *FLAGS, "-shared", "-o", library, folder / f"{name}.c", "-lm"], check=True)
    return ca.external(name, str(library))
