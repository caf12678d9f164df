"""Random circuits, with loops of capacitors and cutsets of coils, and random gear trains, against direct equations."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from networks import Part, by_nodes, compile_beside_parts, compile_network, state_space
from scipy.linalg import expm

from cosim.errors import ModelError

pytest.importorskip("rumoca")

same_every_time = settings(
    max_examples=30, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


class Groups:
    """Union-find: which nodes are joined."""

    def __init__(self, nodes: int) -> None:
        self._root = list(range(nodes))

    def find(self, node: int) -> int:
        while self._root[node] != node:
            node = self._root[node]
        return node

    def join(self, a: int, b: int) -> bool:
        """Join two nodes; false if they are joined already."""
        a, b = self.find(a), self.find(b)
        self._root[a] = b
        return a != b

    def count(self) -> int:
        return sum(self._root[node] == node for node in range(len(self._root)))


def joined(parts: list[Part], kinds: str, nodes: int) -> tuple[Groups, int]:
    """The nodes joined by components of these kinds, and how many of these close a loop."""
    groups = Groups(nodes)
    loops = sum(not groups.join(part.a, part.b) for part in parts if part.kind in kinds)
    return groups, loops


@st.composite
def circuits(draw: st.DrawFn) -> tuple[list[Part], int]:
    """A random tree that spans the nodes, and links; node 0 is ground, node 1 the source."""
    nodes = draw(st.integers(2, 6))
    component = st.tuples(st.sampled_from("RLCLC"), st.sampled_from([0.5, 1.0, 2.0, 3.7]))
    parts = [Part(*draw(component), draw(st.integers(0, node - 1)), node) for node in range(1, nodes)]
    for _ in range(draw(st.integers(0, 5))):
        a, b = draw(st.tuples(st.integers(0, nodes - 1), st.integers(0, nodes - 1)))
        if a != b:
            parts.append(Part(*draw(component), a, b))
    return parts, nodes


@same_every_time
@given(circuits())
def test_a_random_circuit_has_its_order_and_its_transfer_functions(
    tmp_path: Path, circuit: tuple[list[Part], int]
) -> None:
    parts, nodes = circuit
    by_capacitors, loops = joined(parts, "C", nodes)
    if by_capacitors.find(0) == by_capacitors.find(1):
        # the source prescribes the charge of capacitors: the current would be the derivative of the input
        with pytest.raises(ModelError, match="derivative"):
            compile_network(tmp_path, parts, nodes)
        return
    dae = compile_network(tmp_path, parts, nodes)
    # N. Balabanian, T. Bickart, Electrical Network Theory (1969), 4.5: the order of complexity
    without_coils, _ = joined([*parts, Part("V", 0, 0, 1)], "RCV", nodes)
    storages = sum(part.kind in "LC" for part in parts)
    assert len(dae.states) == storages - loops - (without_coils.count() - 1)
    A, B, C, D = state_space(dae, [f"v{k}" for k in range(1, nodes)])
    for s in (0.3 + 0.2j, 1.1 - 2j, 5 + 0.7j):
        ours = (C @ np.linalg.solve(s * np.eye(len(A)) - A, B) + D)[:, 0] if len(A) else D[:, 0]
        assert ours == pytest.approx(by_nodes(parts, nodes, s), rel=1e-8, abs=1e-10)


@dataclass(frozen=True)
class Train:
    """Shafts in groups that gears make rigid, and springs with dampers between any; shaft -1 is the wall."""

    inertias: list[tuple[int, float]]
    gears: list[tuple[int, int, float]]
    springs: list[tuple[int, int, float, float]]
    shafts: int


@st.composite
def trains(draw: st.DrawFn) -> Train:
    shafts = draw(st.integers(1, 6))
    size = st.sampled_from([0.1, 0.5, 1.0, 2.5])
    inertias = [(draw(st.integers(0, shafts - 1)), draw(size)) for _ in range(draw(st.integers(1, 7)))]
    gears = []
    for shaft in range(1, shafts):
        if draw(st.booleans()):
            gears.append((draw(st.integers(0, shaft - 1)), shaft, draw(st.sampled_from([-3.0, -1.0, 0.5, 2.0, 4.0]))))
    springs = []
    for _ in range(draw(st.integers(0, 5))):
        a, b = draw(st.tuples(st.integers(-1, shafts - 1), st.integers(0, shafts - 1)))
        if a != b:
            springs.append((a, b, draw(st.sampled_from([0.0, 1.0, 20.0])), draw(st.sampled_from([0.0, 0.2, 3.0]))))
    train = Train(inertias, gears, springs, shafts)
    groups, _ = reduced(train)
    assume({groups[shaft] for shaft, _ in inertias} == set(groups))  # no group without inertia
    return train


def reduced(train: Train) -> tuple[list[int], np.ndarray]:
    """For each shaft the group it is in, and its angle for one radian of the group."""
    group, angle = list(range(train.shafts)), np.ones(train.shafts)
    for a, b, ratio in train.gears:  # angle of a = ratio * angle of b; each shaft is geared to an earlier one at most
        group[b], angle[b] = group[a], angle[a] / ratio
    return group, angle


def in_minimal_coordinates(train: Train) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[int], np.ndarray]:
    """(A, B, C): one angle and one speed for each group, a torque on shaft 0, the angles of all shafts."""
    group, angle = reduced(train)
    names = sorted(set(group))
    T = np.zeros((train.shafts, len(names)))
    for shaft in range(train.shafts):
        T[shaft, names.index(group[shaft])] = angle[shaft]
    J = np.zeros(train.shafts)
    for shaft, inertia in train.inertias:
        J[shaft] += inertia
    K, D = np.zeros((train.shafts, train.shafts)), np.zeros((train.shafts, train.shafts))
    for a, b, c, d in train.springs:
        e = np.zeros(train.shafts)
        e[b] = 1
        if a >= 0:
            e[a] = -1
        K += c * np.outer(e, e)
        D += d * np.outer(e, e)
    M = T.T @ np.diag(J) @ T
    n = len(names)
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, T.T @ K @ T), -np.linalg.solve(M, T.T @ D @ T)]])
    B = np.concatenate([np.zeros(n), np.linalg.solve(M, T[0])])
    return A, B, np.hstack([T, np.zeros_like(T)]), names, T


def modelica(train: Train) -> str:
    lines = [
        "within Small;",
        'model Train "Random gear train"',
        '  input Parts.Torque tau(start=0) "Torque";',
        '  Parts.TorqueSource source(tau=tau) "Torque";',
        '  Parts.Fixed wall "Wall";',
    ]
    ends: dict[int, list[str]] = {k: [] for k in range(-1, train.shafts)}
    ends[-1].append("wall.flange")
    ends[0].append("source.flange")
    for k, (shaft, J) in enumerate(train.inertias):
        lines.append(f'  Parts.Inertia rotor{k}(J={J!r}) "Rotor {k}";')
        ends[shaft].append(f"rotor{k}.{'ab'[k % 2]}")
    for k, (a, b, ratio) in enumerate(train.gears):
        lines.append(f'  Parts.Gear gear{k}(ratio={ratio!r}) "Gear {k}";')
        ends[a].append(f"gear{k}.a")
        ends[b].append(f"gear{k}.b")
    for k, (a, b, c, d) in enumerate(train.springs):
        lines.append(f'  Parts.SpringDamper spring{k}(c={c!r}, d={d!r}) "Spring {k}";')
        ends[a].append(f"spring{k}.a")
        ends[b].append(f"spring{k}.b")
    lines += [f'  output Parts.Angle phi{k} "Angle of shaft {k}";' for k in range(train.shafts)]
    lines.append("equation")
    for flanges in ends.values():
        lines += [f"  connect({flanges[0]}, {flange});" for flange in flanges[1:]]
    lines += [f"  phi{k} = {ends[k][0]}.phi;" for k in range(train.shafts)]
    return "\n".join([*lines, "end Train;", ""])


def step_response(A: np.ndarray, B: np.ndarray, C: np.ndarray, t: float) -> np.ndarray:
    """Outputs at t after a step of the input, from rest."""
    n = len(A)
    whole = np.zeros((n + 1, n + 1))
    whole[:n, :n], whole[:n, n] = A, B
    return C @ expm(whole * t)[:n, n]


@pytest.mark.slow
@same_every_time
@given(trains())
def test_a_random_gear_train_moves_as_its_minimal_coordinates_say(tmp_path: Path, train: Train) -> None:
    dae = compile_beside_parts(tmp_path, "Train", modelica(train))
    A, B, C, names, _ = in_minimal_coordinates(train)
    assert len(dae.states) == 2 * len(names)
    ours = state_space(dae, [f"phi{k}" for k in range(train.shafts)])
    assert not ours[3].any()
    for t in (0.1, 1.0, 4.0):
        expected = step_response(A, B, C, t)
        scale = max(1.0, np.abs(expected).max())
        assert step_response(ours[0], ours[1][:, 0], ours[2], t) == pytest.approx(expected, abs=1e-8 * scale)
