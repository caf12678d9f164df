"""Initialisation of algebraic loops against their closed forms, its messages, and what it costs."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from algebraic_loops import Blocks, initialized, wired
from both_loops import simulate
from fmu_builder import INTEGRATOR, MODELS, build, build_first, edited
from scipy.optimize import brentq

from cosim.engine import Channel, Fault, FaultKind, Fmu, PartialResultError, Role, System, explain_timing
from cosim.engine import simulate as simulate_once
from cosim.engine.algebra._algebraic import Network
from cosim.engine.algebra._port import Port
from cosim.engine.exchange._instances import instantiate
from cosim.engine.fmu._calls import Site
from cosim.engine.fmu._instance import CallError
from cosim.engine.loop._initialize import initialize
from cosim.engine.loop._plan import make_plan
from cosim.engine.system._graph import Phase, declared
from cosim.engine.system._parameters import parameters_of
from cosim.errors import FmuWarning

pytest.importorskip("rumoca")

EXACT = {"rel": 1e-12, "abs": 1e-15}


@pytest.fixture(scope="module")
def blocks(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Blocks]:
    made = Blocks(tmp_path_factory.mktemp("loops"))
    yield made
    made.close()


def two(a: Fmu, b: Fmu, back: str = "b.affine a.u", /, *, output: str = "affine", **parameters: float) -> System:
    return wired({"a": (a, parameters), "b": (b, {})}, f"a.{output} b.u", back)


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("bare", [False, True])
@pytest.mark.parametrize("gain", [-0.5, 0.5, 3.0, -40.0, 0.0])
def test_a_linear_loop_whatever_its_gain(blocks: Blocks, version: int, bare: bool, gain: float) -> None:
    block = blocks.bare(version) if bare else blocks.plain(version)
    found = initialized(two(block, block, k=gain, b=1.0))
    assert found.values["a.affine"] == pytest.approx(1.0 / (1.0 - gain), **EXACT)
    assert found.values["b.affine"] == pytest.approx(1.0 / (1.0 - gain), **EXACT)
    assert found.remarks == []


@pytest.mark.parametrize("bare", [False, True])
def test_a_conversion_of_units_is_part_of_the_loop(blocks: Blocks, bare: bool) -> None:
    block = blocks.bare() if bare else blocks.plain()
    found = initialized(two(block, block, "b.affine a.u 1000 -273.15", k=2.0, b=1.0))
    a = (1.0 - 2.0 * 273.15) / (1.0 - 2.0 * 1000.0)
    assert found.values["a.affine"] == pytest.approx(a, **EXACT)
    assert found.values["b.affine"] == pytest.approx(a, **EXACT)


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("bare", [False, True])
def test_nonlinear_loops(blocks: Blocks, version: int, bare: bool) -> None:
    block = blocks.bare(version) if bare else blocks.plain(version)
    cosine = initialized(two(block, block, output="cosine"))
    assert cosine.values["a.cosine"] == pytest.approx(0.73908513321516064, **EXACT)  # x = cos x: Dottie's number
    system = wired({"a": (block, {}), "b": (block, {"k": -2.0, "b": 1.0})}, "a.implicit b.u", "b.affine a.u")
    implicit = initialized(system)
    expected = brentq(lambda y: y + 0.5 * math.sin(y) + 2.0 * y - 1.0, 0.0, 1.0, xtol=1e-16, rtol=1e-15)
    assert implicit.values["a.implicit"] == pytest.approx(expected, **EXACT)


@pytest.mark.parametrize(("start", "sign"), [(0.5, -1.0), (5.0, 1.0)])
def test_of_two_solutions_the_one_near_the_start_value_is_taken(blocks: Blocks, start: float, sign: float) -> None:
    """x = x^2/4 + 1/2; repeated evaluation could find the smaller solution only."""
    block = blocks.start(start)
    found = initialized(two(block, block, output="square", c=0.25, b=0.5))
    assert found.values["a.square"] == pytest.approx(2.0 + sign * math.sqrt(2.0), **EXACT)


def test_a_start_value_from_which_no_step_can_be_taken(blocks: Blocks) -> None:
    """x = 2 x^2 - 0.1 has a slope of 1 at 0.25."""
    block = blocks.start(0.25)
    found = initialized(two(block, block, output="square", c=2.0, b=-0.1))
    x = found.values["a.square"]
    assert x == pytest.approx(2.0 * x**2 - 0.1, **EXACT)
    assert found.remarks == []


@pytest.mark.parametrize("seed", range(40))
def test_random_wiring_against_one_matrix(blocks: Blocks, seed: int) -> None:
    """Any number of loops within and after each other, between FMUs of all kinds: x = k u + m v + b for each."""
    random = np.random.default_rng(seed)
    kinds = [blocks.plain(3), blocks.plain(2), blocks.bare(3), blocks.bare(2)]
    n = int(random.integers(2, 9))
    k, m, b = random.normal(scale=2.0, size=(3, n))
    matrix, right = np.eye(n), b + 0.5 * k  # u starts at 0.5, v at 0
    connections = []
    for i in range(n):
        for name, gain, start in (("u", k[i], 0.5), ("v", m[i], 0.0)):
            if random.random() < 0.8:
                j = int(random.integers(n))
                factor, offset = random.normal(size=2)
                connections.append(f"c{j}.affine c{i}.{name} {factor} {offset}")
                matrix[i, j] -= gain * factor
                right[i] += gain * (offset - start)
    system = wired(
        {f"c{i}": (kinds[random.integers(4)], {"k": k[i], "m": m[i], "b": b[i]}) for i in range(n)}, *connections
    )
    found = initialized(system)
    expected = np.linalg.solve(matrix, right)
    error = np.max(np.abs(expected - [found.values[f"c{i}.affine"] for i in range(n)])) / np.max(np.abs(expected))
    assert error <= 1e-13 * np.linalg.cond(matrix)


def test_a_chain_of_three_in_a_loop(blocks: Blocks) -> None:
    block = blocks.plain()
    system = wired(
        {"a": (block, {"k": 3.0, "b": 1.0}), "b": (block, {"k": 0.1}), "c": (block, {})},
        *("a.affine b.u", "b.affine c.u", "c.square a.u"),
    )
    # a = 3 (a/10)^2 + 1
    expected = (1.0 - math.sqrt(1.0 - 0.12)) / 0.06
    assert initialized(system).values["a.affine"] == pytest.approx(expected, **EXACT)


def test_the_result_begins_with_the_solution_in_every_algorithm(blocks: Blocks) -> None:
    block = blocks.plain()
    system = two(block, block, k=3.0, b=1.0)
    for arguments in ({}, {"algorithm": "jacobi", "step": 0.1}):
        result = simulate(system, stop=0.1, output_interval=0.1, tolerance=1e-6, **arguments)  # type: ignore[arg-type]
        assert result.columns["a.affine"][0] == pytest.approx(-0.5, **EXACT)
    explain_timing(system, stop=0.1, output_interval=0.1)


def test_model_exchange_takes_part(blocks: Blocks) -> None:
    found = initialized(two(blocks.exchange(), blocks.plain(), k=3.0, b=1.0))
    assert found.values["a.affine"] == pytest.approx(-0.5, **EXACT)
    assert found.calls["a"]["GetDirectionalDerivative"] == 1


def test_fmi_1_takes_part(blocks: Blocks, tmp_path: Path) -> None:
    """It says nothing of its dependencies, so that this looks like a loop, but is none."""
    with Fmu.read(build_first(tmp_path)) as first:
        system = wired({"a": (first, {"x0": 2.0}), "b": (blocks.plain(), {"k": 3.0})}, "a.x b.u", "b.affine a.u")
        found = initialized(system)
        assert found.values["a.x"] == 2.0
        assert found.values["b.affine"] == 6.0
        assert found.calls["b"]["Get"] <= 2 + 4
        result = simulate(system, stop=0.1, output_interval=0.1, tolerance=1e-6)
        assert result.columns["b.affine"][0] == 6.0


def test_booleans_are_tried_until_they_stay(blocks: Blocks) -> None:
    """The switch is closed first, which opens the way to another solution of the loop around it."""
    block = blocks.plain()
    system = wired(
        {"a": (block, {"k": -0.5, "low": 1.9, "high": 2.5}), "b": (block, {})},
        *("a.switched b.u", "b.affine a.u", "b.above a.on"),
    )
    found = initialized(system)
    assert found.values["a.switched"] == pytest.approx(2.5 / 1.5, **EXACT)
    assert found.values["b.above"] == 1.0
    inverters = initialized(wired({"a": (block, {}), "b": (block, {})}, "a.not_on b.on", "b.not_on a.on"))
    assert inverters.values["a.not_on"] != inverters.values["b.not_on"]


def test_booleans_that_never_stay(blocks: Blocks) -> None:
    block = blocks.plain()
    system = wired({name: (block, {}) for name in "abc"}, "a.not_on b.on", "b.not_on c.on", "c.not_on a.on")
    with pytest.raises(CallError) as caught:
        initialized(system)
    assert str(caught.value) == (
        "the algebraic loop a.not_on -> b.on -> b.not_on -> c.on -> c.not_on -> a.on does not come to rest: a.not_on "
        "true -> false -> true, b.not_on false -> true -> false, c.not_on true -> false -> true, and so on; change "
        "start values of its inputs, or break it: by a sample or a delay in one of its components"
    )


@pytest.mark.parametrize("bare", [False, True])
def test_a_gain_of_1_without_a_solution(blocks: Blocks, bare: bool) -> None:
    block = blocks.bare() if bare else blocks.plain()
    with pytest.raises(PartialResultError) as caught:
        simulate(two(block, block, b=1.0), stop=0.1, output_interval=0.1, tolerance=1e-6)
    assert str(caught.value) == (
        "the simulation failed during initialisation: the algebraic loop a.affine -> b.u -> b.affine -> a.u has no "
        "solution, or none close by: around it a change comes back unchanged (a gain of 1); closest: a.affine = 0.5 V "
        "comes back as 1.5 V (residual 1 V), with b.u = 0.5 V, b.affine = 0.5 V, a.u = 0.5 V; change a gain or an "
        "offset in it, or break it: by a state, a sample or a delay in one of its components"
    )


def test_a_parabola_that_misses(blocks: Blocks) -> None:
    """x = x^2 + 5 comes closest to a solution at x = 1/2."""
    with pytest.raises(CallError) as caught:
        initialized(two(blocks.start(2.0), blocks.plain(), output="square", b=5.0))
    assert "the algebraic loop a.square -> b.u -> b.affine -> a.u has no solution" in str(caught.value)
    assert "(residual 4.75 V)" in str(caught.value)


@pytest.mark.parametrize("bare", [False, True])
def test_a_gain_of_1_with_any_number_of_solutions(blocks: Blocks, bare: bool) -> None:
    block = blocks.bare() if bare else blocks.plain()
    with pytest.warns(FmuWarning) as caught:
        result = simulate(two(block, block), stop=0.1, output_interval=0.1, tolerance=1e-6)
    assert str(caught[0].message) == (
        "the algebraic loop a.affine -> b.u -> b.affine -> a.u does not determine its variables at initialisation: "
        "around it a change comes back unchanged; of all solutions this one, close to the start values, was taken: "
        "a.affine = 0.5 V, b.u = 0.5 V, b.affine = 0.5 V, a.u = 0.5 V; give the inputs other start values for "
        "another one"
    )
    assert result.columns["a.affine"][0] == 0.5


def test_a_wrong_statement_on_dependencies_is_noticed(blocks: Blocks) -> None:
    liar = blocks.liar()
    chain = wired(
        {name: (liar, {"k": 3.0, "b": 1.0}) for name in "cba"}, "a.affine b.u", "b.affine c.u", "c.affine a.u"
    )
    expected = (1.0 + 3.0 + 9.0) / (1.0 - 27.0)
    assert initialized(chain).values["c.affine"] == pytest.approx(expected, **EXACT)


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("lie", ["", "WRONG_DERIVATIVE", "OPPOSITE_DERIVATIVE"])
def test_wrong_derivatives(
    blocks: Blocks, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, version: int, lie: str
) -> None:
    """y = 2 u1 + u1 u2 with u1 = 1/2, and u2 = 6 y + 1: directional derivatives are a help, not a condition."""
    monkeypatch.setenv("CHECKED_LIE", lie)
    path = build(MODELS["checked"], version, tmp_path, defines=("CHECKED",))
    claim = f'<CoSimulation providesDirectionalDerivative{"s" * (version - 2)}="true" '
    copy = edited(path, tmp_path / "claiming.fmu", lambda text: text.replace("<CoSimulation ", claim))
    with Fmu.read(copy) as checked:
        system = wired({"a": (checked, {}), "b": (blocks.plain(), {"k": 6.0, "b": 1.0})}, "a.y b.u", "b.affine a.u2")
        found = initialized(system)
    assert found.values["a.y"] == pytest.approx(-0.75, **EXACT)
    assert found.calls["a"]["GetDirectionalDerivative"] > 0


def test_derivatives_that_are_claimed_but_not_given(tmp_path: Path) -> None:
    path = build(INTEGRATOR, 2, tmp_path)
    claim = '<CoSimulation providesDirectionalDerivative="true" '
    copy = edited(path, tmp_path / "claiming.fmu", lambda text: text.replace("<CoSimulation ", claim))
    with Fmu.read(copy) as claiming:
        found = initialized(wired({"a": (claiming, {"offset": 1.0}), "b": (claiming, {})}, "a.y b.u", "b.y a.u 3"))
    assert found.values["a.y"] == pytest.approx(-0.5, **EXACT)
    assert found.calls["a"]["GetDirectionalDerivative"] == 1


@pytest.mark.parametrize("gain", [0.3, 3.3])
def test_single_precision_is_solved_as_far_as_it_goes(tmp_path: Path, gain: float) -> None:
    """a = u + 1, b = a, and u = gain b."""
    variables = tuple(replace(v, type="Float32") if v.name in ("u", "y") else v for v in INTEGRATOR.variables)
    with Fmu.read(build(replace(INTEGRATOR, variables=variables), 3, tmp_path)) as single:
        found = initialized(wired({"a": (single, {"offset": 1.0}), "b": (single, {})}, "a.y b.u", f"b.y a.u {gain}"))
    assert found.values["a.y"] == pytest.approx(1.0 / (1.0 - gain), rel=1e-6)


def test_a_loop_in_event_mode(blocks: Blocks) -> None:
    """After initialisation with v = 0 the loop is solved again, from where it is, with another v."""
    block = blocks.plain()
    system = two(block, block, k=3.0, b=1.0, m=1.0)
    system.channels = [Channel(("a", "v"), [0.0], [0.0])]
    sites = [Site(number=number) for number in range(2)]
    instances = {
        c.name: instantiate(c.name, c.fmu, True, site) for c, site in zip(system.components, sites, strict=True)
    }
    try:
        for component in system.components:
            instances[component.name].set_values(parameters_of(component))
        plan = make_plan(system, dict.fromkeys("ab", Role.EVENT), instances, 0.1, 1.0)
        initialize(plan, system, 1e-6, 1.0)
        slots = {name: {v: slot for (owner, v), slot in plan.signals.items() if owner == name} for name in "ab"}
        ports = {p.instance.name: Port(p, slots[p.instance.name]) for p in plan.discrete}
        for v in (0.0, 4.0):
            plan.values[plan.signals["a", "v"]] = v
            network = Network.of(plan, system, ports, declared(system.components, Phase.TIME), 1e-6)
            network.settle()
            assert plan.values[plan.signals["a", "affine"]] == pytest.approx((1.0 + v) / (1.0 - 3.0), **EXACT)
    finally:
        for instance in instances.values():
            instance.free()


@pytest.mark.parametrize("version", [2, 3])
def test_an_fmu_that_gives_nothing_before_its_inputs_are_set(blocks: Blocks, tmp_path: Path, version: int) -> None:
    """It fails while u is 0, even for the state x, which does not depend on u; in a loop a first value is tried."""
    path = build(INTEGRATOR, version, tmp_path, defines=("READING(m)=((m)->v[1]==0.0?3:0)",))
    block = blocks.plain()
    with Fmu.read(path) as shy:
        parts = {"a": (shy, {"x0": 2.0}), "b": (block, {"b": 1.0}), "c": (block, {"b": 4.0})}
        found = initialized(wired(parts, "a.x b.u", "c.affine a.u"))
        assert found.values["a.y"] == 4.5
        assert found.values["b.affine"] == 3.0
        looped = initialized(wired(parts, "a.x b.u", "b.affine a.u"))
        assert looped.values["a.y"] == 3.0
        assert looped.values["b.affine"] == 3.0
        with pytest.raises(CallError, match=r"a \(integrator\): fmi.Get(Real|Float64)\(?.* returned Error"):
            initialized(wired(parts, "a.x b.u"))


@pytest.mark.parametrize(
    ("kind", "amount", "expected"),
    # a = 3 u + 1, b = a, and u is b as the fault leaves it
    [("bias", 0.5, -1.25), ("scale", 2.0, -0.2), ("override", 2.0, 7.0)],
)
def test_a_fault_in_a_loop(blocks: Blocks, kind: FaultKind, amount: float, expected: float) -> None:
    block = blocks.plain()
    system = replace(two(block, block, k=3.0, b=1.0), faults=[Fault(("a", "u"), kind, amount)])
    assert initialized(system).values["a.affine"] == pytest.approx(expected, **EXACT)


def test_a_run_in_a_process_of_its_own_hands_on_what_there_is_to_say(blocks: Blocks) -> None:
    system = two(blocks.plain(), blocks.plain())
    with pytest.warns(FmuWarning, match="does not determine its variables at initialisation"):
        simulate_once(system, stop=0.1, output_interval=0.1, tolerance=1e-6, isolate="always")


def test_what_initialisation_costs(blocks: Blocks) -> None:
    """Each input is set once and each output read for it; all are read once more, and once in Step Mode."""
    block = blocks.plain()
    chain = initialized(wired({n: (block, {"k": 2.0}) for n in "cba"}, "a.affine b.u", "b.affine c.u")).calls
    assert {name: calls["Set"] for name, calls in chain.items()} == {"a": 0, "b": 1, "c": 1}
    assert {name: calls["Get"] for name, calls in chain.items()} == {"a": 1 + 4, "b": 1 + 4, "c": 4}  # two types
    linear = initialized(two(block, block, k=3.0, b=1.0)).calls
    for calls in linear.values():
        assert calls["Set"] <= 2 + 1
        assert calls["Get"] <= 2 + 4
        assert calls["GetDirectionalDerivative"] == 1
    differences = initialized(two(blocks.bare(), blocks.bare(), k=3.0, b=1.0)).calls
    for calls in differences.values():
        assert calls["Set"] <= 6
        assert calls["Get"] <= 6 + 4
