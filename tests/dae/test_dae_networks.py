"""Random acausal ladder networks, compiled from Modelica text, against their nodal equations written down directly."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from networks import Part, by_nodes, compile_network, state_space
from scipy.linalg import expm

pytest.importorskip("rumoca")

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
