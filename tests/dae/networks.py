"""Random networks as Modelica text, their linear systems as compiled, and the equations to compare these with."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

import casadi as ca
import numpy as np

from cosim.dae import Dae
from cosim.fmu import compile_model

SMALL = Path(__file__).parents[1] / "models" / "Small"
CLASSES = {"R": "Resistor", "L": "Inductor", "C": "Capacitor"}


@dataclass(frozen=True)
class Part:
    """One component between two nodes; node 0 is ground, node 1 the source."""

    kind: str
    value: float
    a: int
    b: int


def modelica(parts: list[Part], nodes: int) -> str:
    lines = [
        "within Small;",
        'model Network "Random network"',
        '  input Parts.Voltage u(start=0) "Supply";',
        '  Parts.VoltageSource source(u=u) "Supply";',
        '  Parts.Ground ground "Chassis";',
    ]
    ends: dict[int, list[str]] = {k: [] for k in range(nodes)}
    ends[0] += ["ground.p", "source.n"]
    ends[1] += ["source.p"]
    for k, part in enumerate(parts):
        lines.append(f'  Parts.{CLASSES[part.kind]} p{k}({part.kind}={part.value!r}) "Part {k}";')
        ends[part.a].append(f"p{k}.p")
        ends[part.b].append(f"p{k}.n")
    lines += [f'  output Parts.Voltage v{k} "Potential of node {k}";' for k in range(1, nodes)]
    lines.append("equation")
    for pins in ends.values():
        lines += [f"  connect({pins[0]}, {pin});" for pin in pins[1:]]
    lines += [f"  v{k} = {ends[k][0]}.v;" for k in range(1, nodes)]
    return "\n".join([*lines, "end Network;", ""])


def compile_network(folder: Path, parts: list[Part], nodes: int) -> Dae:
    return compile_beside_parts(folder, "Network", modelica(parts, nodes))


def compile_beside_parts(folder: Path, name: str, text: str) -> Dae:
    """Compile a class of the package Small that stands beside its Parts."""
    package = folder / "Small"
    package.mkdir(exist_ok=True)
    for file in ("package.mo", "Parts.mo"):
        shutil.copy(SMALL / file, package / file)
    (package / f"{name}.mo").write_text(text, encoding="utf-8")
    return compile_model(package / f"{name}.mo", f"Small.{name}")


def state_space(dae: Dae, outputs: list[str]) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """(A, B, C, D) of a linear Dae with one input, the torn unknowns eliminated."""
    published = {p.scalar.name: p.value for p in dae.published}
    y = ca.vertcat(*(published[name] for name in outputs))
    x = ca.vertcat(ca.SX(0, 1), *(s.symbol for s in dae.states))
    z = ca.vertcat(ca.SX(0, 1), *(s.symbol for s in dae.torn))
    u = dae.inputs[0].symbol
    p = ca.vertcat(*(q.scalar.symbol for q in dae.parameters))
    whole = ca.vertcat(dae.derivatives, dae.residuals, y)
    jacobian = ca.Function("J", [p, x, z, u], [ca.jacobian(whole, ca.vertcat(x, u, z))])
    values = ca.DM([dae.parameter_values[q.scalar.name] for q in dae.parameters])
    M = np.array(ca.densify(jacobian(values, 0, 0, 0)))
    n, m = len(dae.states), len(dae.torn)
    kept = np.r_[0:n, n + m : len(M)]
    reduced = M[kept][:, : n + 1]
    if m:
        reduced = reduced - M[kept][:, n + 1 :] @ np.linalg.solve(M[n : n + m, n + 1 :], M[n : n + m, : n + 1])
    return reduced[:n, :n], reduced[:n, n:], reduced[n:, :n], reduced[n:, n:]


def by_nodes(parts: list[Part], nodes: int, s: complex) -> np.ndarray:
    """Potentials of nodes 1.. for one volt of e^(st) at node 1: nodal equations with every branch's admittance."""
    admittance = {"R": lambda v: 1 / v, "L": lambda v: 1 / (s * v), "C": lambda v: s * v}
    Y = np.zeros((nodes, nodes), complex)
    for part in parts:
        g = admittance[part.kind](part.value)
        Y[part.a, part.a] += g
        Y[part.b, part.b] += g
        Y[part.a, part.b] -= g
        Y[part.b, part.a] -= g
    inner = list(range(2, nodes))
    result = np.ones(nodes, complex)
    result[0] = 0
    result[2:] = np.linalg.solve(Y[np.ix_(inner, inner)], -Y[np.ix_(inner, [1])])[:, 0]
    return result[1:]
