"""ModelStructure: what is not listed has no influence, and factors vary with nothing that their kind leaves out."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import casadi as ca
import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.model_description import Unknown
from fmpy.validation import validate_fmu
from importer import Importer

from cosim.dae import Dae
from cosim.fmu import compile_model, export
from cosim.fmu.dependencies import Dependencies, Kind
from cosim.fmu.layout import lay_out

pytest.importorskip("rumoca")

Build = Callable[[str], Path]


def declared(path: Path, unknowns: str) -> dict[str, dict[str, str]]:
    """For each unknown of a list of ModelStructure, the kind of its dependency on each known."""
    found: list[Unknown] = getattr(fmpy.read_model_description(str(path)), unknowns)
    return {
        u.variable.name: dict(zip([v.name for v in u.dependencies], u.dependenciesKind or [], strict=True))
        for u in found
    }


def dependencies_of(text: str, folder: Path) -> tuple[Dae, dict[str, dict[str, Kind]]]:
    """The Dae of a model M, and for each output the kind of its dependency on inputs, states and time."""
    file = folder / "M.mo"
    file.write_text(text)
    dae = compile_model(file, "M")
    layout = lay_out(dae)
    found = Dependencies(dae, layout)
    return dae, {
        slot.name: {layout.slots[d.reference].name: d.kind for d in found.of(reference)}
        for reference, slot in enumerate(layout.slots)
        if slot.causality == "output"
    }


def test_the_kind_of_each_dependency_is_what_its_factor_varies_with(tmp_path: Path) -> None:
    _, found = dependencies_of(
        """model M
  parameter Real k = 2;
  parameter Real k2 = 3*k;
  input Real u, w;
  Real x(start=1, fixed=true);
  discrete Real held(start=1, fixed=true);
  output Real plain, scaled, switched, jumping, squared, stepped, chosen, product, clock, mode, own;
equation
  der(x) = u - x;
  when sample(0, 0.1) then
    held = w;
  end when;
  plain = 3*x + u;
  scaled = k2*x - u/k;
  switched = held*x;
  jumping = if u > 0.5 then x + 1 else x;
  squared = x^2 + u;
  stepped = noEvent(if u > 0.5 then x else 2*x);
  chosen = x + time;
  product = u*w;
  clock = k*time;
  mode = held;
  own = u - u + w;
end M;
""",
        tmp_path,
    )
    constant, tunable, discrete, dependent = Kind.CONSTANT, Kind.TUNABLE, Kind.DISCRETE, Kind.DEPENDENT
    assert found == {
        "plain": {"x": constant, "u": constant},
        "scaled": {"x": tunable, "u": tunable},
        "switched": {"x": discrete, "time": dependent, "w": dependent},
        "jumping": {"x": discrete, "u": dependent},
        "squared": {"x": dependent, "u": constant},
        "stepped": {"x": dependent, "u": dependent},
        "chosen": {"x": constant, "time": constant},
        "product": {"u": dependent, "w": dependent},
        "clock": {"time": tunable},
        "mode": {"time": dependent, "w": dependent},
        "own": {"w": constant},
    }


def test_dependencies_go_through_the_blocks_of_torn_unknowns_that_lie_before(tmp_path: Path) -> None:
    _, found = dependencies_of(
        """model M
  input Real u, w;
  output Real a(start=1), b(start=1), c, d;
equation
  a + 0.1*sin(a) = u;
  b + 0.1*a*sin(b) = w;
  c = 2*a;
  d = a + b;
end M;
""",
        tmp_path,
    )
    dependent = Kind.DEPENDENT
    assert found == {
        "a": {"u": dependent},
        "b": {"u": dependent, "w": dependent},
        "c": {"u": dependent},
        "d": {"u": dependent, "w": dependent},
    }


def random_model(seed: int) -> str:
    """Random sparse equations, some of them nonlinear, for n unknowns of which a few are states."""
    random = np.random.default_rng(seed)
    n, states, inputs = 8, 3, 3
    names = [f"y{k}" for k in range(n)]
    known = [*(f"x{k}" for k in range(states)), *(f"u{k}" for k in range(inputs))]
    lines = ["model M", *(f"  input Real u{k};" for k in range(inputs))]
    lines += [f"  parameter Real p{k} = {random.uniform(0.5, 1.5):.3f};" for k in range(2)]
    lines += [f"  output Real x{k}(start=0.1, fixed=true);" for k in range(states)]
    lines += [f"  output Real {name};" for name in names]
    lines.append("equation")
    lines += [f"  der(x{k}) = -x{k} + {random.choice(names)};" for k in range(states)]
    for k, name in enumerate(names):
        terms = [f"{random.uniform(3, 4):.3f}*{name}"]
        others = random.choice([other for other in names if other != name], size=random.integers(0, 3), replace=False)
        terms += [f"({random.uniform(-1, 1):.3f})*{other}" for other in others]
        for other in random.choice(known, size=2, replace=False):
            factor = random.choice([f"{random.uniform(1, 2):.3f}", "p0", f"sin({other})", "p1"])
            terms.append(f"{factor}*{other}")
        if k % 3 == 0:
            terms.append(f"0.3*sin({name})")
        lines.append(f"  {' + '.join(terms)} = ({random.uniform(-1, 1):.3f});")
    return "\n".join([*lines, "end M;", ""])


def sensitivities(dae: Dae, wanted: list[str]) -> list[dict[tuple[str, str], float]]:
    """The derivatives of outputs by knowns at two points, parameters as they are, by the implicit function theorem."""
    random = np.random.default_rng(1)
    values = {p.scalar.name: p.value for p in dae.published}
    outputs = ca.vertcat(*(values[name] for name in wanted))
    known = ca.vertcat(*(u.symbol for u in dae.states), *(s.symbol for s in dae.inputs))
    names = [values[n].name() for n in (u.symbol.name() for u in dae.states)] + [s.name for s in dae.inputs]
    parameters = ca.vertcat(*(p.scalar.symbol for p in dae.parameters))
    numbers = [dae.parameter_values[p.scalar.name] for p in dae.parameters]
    z = dae.z
    total = ca.jacobian(outputs, known)
    if dae.torn:
        r = dae.residuals
        total -= ca.jacobian(outputs, z) @ ca.solve(ca.jacobian(r, z), ca.densify(ca.jacobian(r, known)))
    function = ca.Function("f", [known, z, parameters], [ca.densify(total)])
    result = []
    for _ in range(2):
        # everywhere, not only where the equations hold: a factor that is constant is so there too
        matrix = function(random.uniform(-1, 1, known.numel()), random.uniform(-1, 1, z.numel()), numbers).full()
        result.append({(wanted[i], names[j]): matrix[i, j] for i in range(len(wanted)) for j in range(len(names))})
    return result


@pytest.mark.parametrize("seed", range(12))
def test_of_a_random_model_exactly_what_has_influence_is_listed(tmp_path: Path, seed: int) -> None:
    dae, found = dependencies_of(random_model(seed), tmp_path)
    here, there = sensitivities(dae, list(found))
    influence = {pair for pair, value in here.items() if abs(value) > 1e-12}
    assert {(output, known) for output, kinds in found.items() for known in kinds} == influence
    for output, known in influence:
        if found[output][known] < Kind.DEPENDENT:
            assert there[output, known] == pytest.approx(here[output, known], rel=1e-9)


MODELS = ["Rectifier", "SteadyStart", "FourBar", "Lights", "BouncingBall"]


def settled(path: Path, changes: dict[str, float], unknowns: list[str]) -> dict[str, float] | None:
    """The values of variables at the end of Initialization Mode; ``None`` if the equations have no solution then."""
    with Importer(path) as importer:
        importer.fmu.enterInitializationMode()
        for name, value in changes.items():
            importer.set(name, value)
        try:
            return {name: importer.get(name) for name in unknowns}
        except FMICallException:
            return None


@pytest.mark.parametrize("name", MODELS)
def test_initial_unknowns_change_with_nothing_but_what_is_listed(build: Build, name: str) -> None:
    path = build(name)
    listed = declared(path, "initialUnknowns")
    with Importer(path) as importer:
        knowns = {
            v.name: float({"true": 1, "false": 0}.get(v.start, v.start))
            for v in importer.variables.values()
            if v.causality in ("input", "parameter")
        }
        types = {v.name: v.type for v in importer.variables.values()}
    before = settled(path, {}, list(listed))
    assert before is not None
    looked = 0
    for known, start in knowns.items():
        if types[known] == "Float64":
            changes = [start * 1.01 + 1e-3, start * 0.5 + 0.1]
        else:
            changes = [1 - start] if types[known] == "Boolean" else [start + 1]
        for changed in changes:
            after = settled(path, {known: changed}, list(listed))
            if after is None:
                continue
            looked += 1
            # a search that starts elsewhere, or takes other steps, ends at the same solution to rounding errors
            moved = {n for n in listed if after[n] != pytest.approx(before[n], rel=1e-9, abs=1e-9)}
            assert {n for n in moved if known not in listed[n]} == set()
    assert looked >= len(knowns)


@pytest.mark.slow
def test_outputs_follow_an_input_at_once_only_if_it_is_listed(build: Build) -> None:
    path = build("WiperDrive.Systems.LinkagePlant")
    listed = declared(path, "outputs")
    with Importer(path) as importer:
        inputs = {v.name for v in importer.variables.values() if v.causality == "input"}
        importer.set("duty", 0.7)
        importer.start()
        importer.step(0.4)
        followed: dict[str, set[str]] = {name: set() for name in listed}
        for known in sorted(inputs):
            before = {name: importer.get(name) for name in listed}
            kept = importer.get(known)
            importer.set(known, kept * 0.9 + 0.05)
            for name in listed:
                if importer.get(name) != pytest.approx(before[name], rel=1e-9, abs=1e-9):
                    followed[name].add(known)
            importer.set(known, kept)
    assert {name: set(kinds) & inputs for name, kinds in listed.items()} == followed
    assert followed["v_motor"] == {"duty", "v_supply"}
    assert followed["tau_crank"] == {"tau_disturbance"}


def test_both_versions_list_the_same_dependencies(build: Build, tmp_path: Path) -> None:
    path = export(Path(__file__).parents[1] / "models" / "Small" / "FourBar.mo", "Small.FourBar", tmp_path, fmi="2.0")
    for unknowns in ("outputs", "initialUnknowns"):
        assert declared(path, unknowns) == declared(build("FourBar"), unknowns)
    assert validate_fmu(str(path)) == []
