"""Random acausal ladder networks, compiled from Modelica text, against their nodal equations written down directly."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from cosim.dae import Dae
from cosim.fmu import compile_model

pytest.importorskip("rumoca")

SMALL = Path(__file__).parents[1] / "models" / "Small"
CLASSES = {"R": "Resistor", "L": "Inductor", "C": "Capacitor"}


@dataclass(frozen=True)
class Part:
    """One component between two nodes; node 0 is ground, node 1 the source."""

    kind: str
    value: float
    a: int
    b: int


Section = tuple[list[tuple[str, float]], list[tuple[str, float]]]


def network(sections: list[Section]) -> tuple[list[Part], int]:
    """The components of a ladder and the number of nodes; each branch is a chain of components."""
    parts: list[Part] = []
    last, rung = 1, 1

    def chain(branch: list[tuple[str, float]], start: int, end: int | None) -> int:
        nonlocal last
        for position, (kind, value) in enumerate(branch):
            if position == len(branch) - 1 and end is not None:
                stop = end
            else:
                last += 1
                stop = last
            parts.append(Part(kind, value, start, stop))
            start = stop
        return start

    for series, shunt in sections:
        rung = chain(series, rung, None)
        if shunt:
            chain(shunt, rung, 0)
    return parts, last + 1


def modelica(parts: list[Part], nodes: int) -> str:
    lines = [
        "within Small;",
        'model Ladder "Random ladder"',
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
    return "\n".join([*lines, "end Ladder;", ""])


def compile_network(folder: Path, parts: list[Part], nodes: int) -> Dae:
    package = folder / "Small"
    package.mkdir(exist_ok=True)
    for name in ("package.mo", "Parts.mo"):
        shutil.copy(SMALL / name, package / name)
    (package / "Ladder.mo").write_text(modelica(parts, nodes), encoding="utf-8")
    return compile_model(package / "Ladder.mo", "Small.Ladder")


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


component = st.tuples(st.sampled_from("RLC"), st.sampled_from([0.5, 1.0, 2.0, 3.7]))
series = st.lists(component.filter(lambda c: c[0] != "C"), min_size=1, max_size=2)
shunt = st.lists(component, max_size=2)
ladders = st.lists(st.tuples(series, shunt), min_size=1, max_size=4)


@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(ladders)
def test_a_random_ladder_has_the_transfer_functions_of_its_nodal_equations(
    tmp_path: Path, sections: list[Section]
) -> None:
    parts, nodes = network(sections)
    dae = compile_network(tmp_path, parts, nodes)
    A, B, C, D = state_space(dae, [f"v{k}" for k in range(1, nodes)])
    storages = sum(part.kind != "R" for part in parts)
    assert len(dae.states) <= storages
    for s in (0.3 + 0.2j, 1.1 - 2j, 5 + 0.7j):
        ours = (C @ np.linalg.solve(s * np.eye(len(A)) - A, B) + D)[:, 0] if len(A) else D[:, 0]
        assert ours == pytest.approx(by_nodes(parts, nodes, s), rel=1e-8, abs=1e-10)


@settings(max_examples=8, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.tuples(st.floats(0.1, 10), st.floats(0.1, 10)), min_size=1, max_size=6))
def test_an_rc_ladder_steps_as_the_matrix_exponential_says(tmp_path: Path, values: list[tuple[float, float]]) -> None:
    parts, nodes = network([([("R", r)], [("C", c)]) for r, c in values])
    dae = compile_network(tmp_path, parts, nodes)
    n = len(values)
    assert len(dae.states) == n
    A, B, C, D = state_space(dae, [f"v{k}" for k in range(2, nodes)])
    # C_k dv_k/dt = (v_(k-1) - v_k)/R_k - (v_k - v_(k+1))/R_(k+1)
    direct, b = np.zeros((n, n)), np.zeros(n)
    for k, (r, c) in enumerate(values):
        direct[k, k] -= 1 / (r * c)
        if k == 0:
            b[0] = 1 / (r * c)
        else:
            direct[k, k - 1] += 1 / (r * c)
            direct[k - 1, k - 1] -= 1 / (r * values[k - 1][1])
            direct[k - 1, k] += 1 / (r * values[k - 1][1])
    for t in (0.1, 1.0, 10.0):
        expected = np.linalg.solve(direct, (expm(direct * t) - np.eye(n)) @ b)
        ours = C @ np.linalg.solve(A, (expm(A * t) - np.eye(n)) @ B[:, 0]) + D[:, 0]
        assert ours == pytest.approx(expected, rel=1e-8, abs=1e-10)
