"""The graph of variables: its strong components against the definition, its loops, and what cuts them."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
import pytest

from cosim.engine import Component, Connection, Fmu, System
from cosim.engine.loop._plan import roles_of
from cosim.engine.system._graph import (
    Arrows,
    End,
    Loop,
    Phase,
    arrows_between,
    loops,
    loops_among,
    strong_components,
)

Get = Callable[..., Fmu]


def everything(output: End, name: str) -> bool:
    return True


def wired(*pairs: str) -> list[Connection]:
    """ "a.y b.u" is a connection."""

    def end(text: str) -> End:
        component, variable = text.split(".")
        return component, variable

    return [Connection(end(source), end(target)) for source, target in map(str.split, pairs)]


def reachable(arrows: Arrows) -> dict[End, set[End]]:
    """Warshall's closure."""
    found = {node: set(targets) for node, targets in arrows.items()}
    for middle, node in itertools.product(arrows, arrows):
        if middle in found[node]:
            found[node] |= found[middle]
    return found


@pytest.mark.parametrize("seed", range(30))
def test_strong_components_are_what_reaches_each_other_and_come_in_order(seed: int) -> None:
    random = np.random.default_rng(seed)
    nodes = [("c", str(i)) for i in range(1 + seed)]
    arrows = {node: [t for t in nodes if random.random() < 1.3 / len(nodes)] for node in nodes}
    found = strong_components(arrows)
    closure = reachable(arrows)
    assert sorted(itertools.chain.from_iterable(found)) == sorted(nodes)
    for i, group in enumerate(found):
        for node in group:
            together = {other for other in nodes if other in closure[node] and node in closure[other]} | {node}
            assert together == set(group)
            assert not any(earlier in closure[node] for before in found[:i] for earlier in before)


@pytest.mark.parametrize("seed", range(30))
@pytest.mark.parametrize("size", [4, 60])
def test_without_the_torn_outputs_nothing_leads_round(seed: int, size: int) -> None:
    random = np.random.default_rng(seed)
    ends = random.integers(0, 1 + size // 4, (size, 2))
    connections = [Connection((f"c{a}", f"y{i % 3}"), (f"c{b}", f"u{i}")) for i, (a, b) in enumerate(ends)]
    arrows = arrows_between(connections, everything)
    closure = reachable(arrows)
    inside = {node for node in arrows if node in closure[node]}
    found = loops_among(connections, everything)
    assert {node for loop in found for node in (*loop.torn, *loop.others)} == inside
    for loop in found:
        kept = [c for c in loop.connections if c.source not in loop.torn]
        assert loops_among(kept, everything) == []
        order = {node: i for i, node in enumerate(loop.others)}
        for source, targets in arrows.items():
            assert all(order[source] < order[t] for t in targets if source in order and t in order)
        assert loop.shortest[0].source == loop.torn[0]
        assert all(a.target[0] == b.source[0] for a, b in itertools.pairwise([*loop.shortest, loop.shortest[0]]))


def test_one_output_that_drives_two_inputs_is_torn_once() -> None:
    (loop,) = loops_among(wired("b.y a.u", "c.y a.v", "a.y b.u", "a.y c.u"), everything)
    assert loop.torn == (("a", "y"),)
    assert str(loop) == "a.y -> b.u -> b.y -> a.u"


def test_two_loops_that_touch_are_one_and_two_apart_come_in_the_order_of_the_way() -> None:
    first = wired("a.y b.u", "b.y a.u")
    second = wired("c.y d.u", "d.y c.u")
    apart = loops_among([*second, *first, *wired("b.y c.v")], everything)
    assert [str(loop) for loop in apart] == ["a.y -> b.u -> b.y -> a.u", "c.y -> d.u -> d.y -> c.u"]
    (one,) = loops_among([*first, *second, *wired("b.y c.v", "d.y a.v")], everything)
    assert len(one.torn) == 2


def test_a_component_on_itself_is_a_loop() -> None:
    (loop,) = loops_among(wired("a.y a.u"), everything)
    assert str(loop) == "a.y -> a.u"


def test_what_does_not_depend_on_its_input_makes_no_loop(fmu: Get, undescribed_integrator: Fmu) -> None:
    """The integrator's y feeds its input through, its x does not."""

    def found(output: str, one: Fmu) -> list[Loop]:
        system = System(
            [Component("a", one), Component("b", fmu("integrator"))],
            [Connection(("a", output), ("b", "u")), Connection(("b", "y"), ("a", "u"))],
        )
        roles = roles_of(system)
        in_time = loops(system, roles, Phase.TIME)
        assert in_time == loops(system, roles, Phase.INITIALIZATION)
        return in_time

    assert [str(loop) for loop in found("y", fmu("integrator"))] == ["a.y -> b.u -> b.y -> a.u"]
    assert found("x", fmu("integrator")) == []
    assert [str(loop) for loop in found("x", undescribed_integrator)] == ["a.x -> b.u -> b.y -> a.u"]


def test_in_time_discrete_components_make_no_loop_with_continuous_ones(fmu: Get) -> None:
    system = System(
        [Component("plant", fmu("integrator")), Component("c", fmu("sampler"))],
        [Connection(("plant", "y"), ("c", "u")), Connection(("c", "y"), ("plant", "u"))],
    )
    assert loops(system, roles_of(system), Phase.TIME) == []
    assert len(loops(system, roles_of(system), Phase.INITIALIZATION)) == 1
