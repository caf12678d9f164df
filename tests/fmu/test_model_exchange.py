"""Model Exchange: fmpy's CVode on our FMUs gives what our own solver gives."""

from __future__ import annotations

import contextlib
import itertools
import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal, NamedTuple

import fmpy
import fmpy.validation
import numpy as np
import pytest
from scipy.integrate import quad

from cosim.engine import Channel, Component, Fmu, System, simulate
from cosim.fmu import catalogue, export
from cosim.fmu.versions import FmiVersion

TESTS = Path(__file__).parents[1]
GOLDEN = (5**0.5 - 1) / 2
"""Rows this many tenths of a second apart meet no sample clock."""

BuildOf = Callable[[str, FmiVersion], Path]
Interface = Literal["CoSimulation", "ModelExchange"]


@pytest.fixture(scope="session")
def build_of(tmp_path_factory: pytest.TempPathFactory) -> BuildOf:
    """The FMU of a small model, or of a component that comes with the project, of an FMI version."""
    pytest.importorskip("rumoca")
    folder = tmp_path_factory.mktemp("exchange")
    built: dict[tuple[str, str], Path] = {}

    def build_of(name: str, fmi: FmiVersion) -> Path:
        if name.islower():
            return catalogue.ensure(name, fmi)
        if (name, fmi) not in built:
            package = "Stiff" if name == "VanDerPol" else "Small"
            source = TESTS / "models" / package / f"{name}.mo"
            built[name, fmi] = export(source, f"{package}.{name}", folder, fmi=fmi)
        return built[name, fmi]

    return build_of


class Case(NamedTuple):
    """A model, for how long it runs, its inputs, and how far CVode may be off, in parts of each variable's size."""

    stop: float
    within: float
    inputs: list[tuple[float, ...]] | None = None
    columns: str = ""


DUTY: list[tuple[float, ...]] = [(0, 0.9), (1, 0.9), (1, 0.4), (1.5, 0.4), (1.5, 1.0), (3, 1.0)]


def currents() -> list[tuple[float, ...]]:
    """The motor current and park contact of a wiper that meets its park position every 0.7 s, in steps."""
    rows = [(0.05 * k, 2 + np.sin(0.35 * k), float(k // 14 % 2)) for k in range(100)]
    return [rows[0], *itertools.chain.from_iterable(((b[0], *a[1:]), b) for a, b in itertools.pairwise(rows))]


CASES = {
    "linkage": Case(3.0, 1e-4, DUTY, "duty"),
    "rig": Case(3.0, 1e-6, DUTY, "duty"),
    "voltage_profile": Case(4.9, 1e-12, currents(), "i_motor park"),
    "BouncingBall": Case(2.3, 1e-6),
    "RestingBall": Case(4.0, 1e-5),
    "Brake": Case(6.0, 1e-6, [(0, 0.0), (3, 0.0), (3, 3.0), (4, 3.0), (4, -1.0), (6, -1.0)], "tau"),
    "StickSlip": Case(10.0, 1e-4),
    "Rectifier": Case(0.1, 1e-5),
    "SampledPI": Case(5.0, 1e-5),
    "Chopper": Case(0.1, 1e-5),
    "FourBar": Case(1.0, 1e-5),
    "Lights": Case(10.0, 1e-12),
}


QUICK = (("linkage", "2.0"), ("linkage", "3.0"), ("voltage_profile", "3.0"), ("BouncingBall", "2.0"), ("Brake", "3.0"))
ALL = [
    pytest.param(name, fmi, marks=[] if (name, fmi) in QUICK else pytest.mark.slow)
    for name in CASES
    for fmi in ("2.0", "3.0")
]


def run(path: Path, case: Case, interface: Interface) -> Any:  # noqa: ANN401 - a structured array
    description = fmpy.read_model_description(str(path))
    outputs = [v.name for v in description.modelVariables if v.causality == "output"]
    table = None
    if case.inputs is not None:
        types = [("time", float), *((name, bool if name == "park" else float) for name in case.columns.split())]
        table = np.array(case.inputs, dtype=types)
    result = fmpy.simulate_fmu(
        str(path), stop_time=case.stop, output_interval=GOLDEN * case.stop / 60, relative_tolerance=1e-8,
        fmi_type=interface, output=outputs, input=table, record_events=False,
    )  # fmt: skip
    # a row at a step of an input may be before or after it
    instants = {round(row[0], 9) for row in case.inputs or ()}
    first = {round(float(time), 9): k for k, time in enumerate(result["time"]) if round(float(time), 9) not in instants}
    return result[[k for time, k in sorted(first.items()) if time > 0.0]]


@pytest.mark.parametrize(("name", "fmi"), ALL)
def test_cvode_agrees_with_the_solver_of_the_fmu(name: str, fmi: FmiVersion, build_of: BuildOf) -> None:
    path, case = build_of(name, fmi), CASES[name]
    ours, cvode = run(path, case, "CoSimulation"), run(path, case, "ModelExchange")
    rows = np.intersect1d(np.round(ours["time"], 9), np.round(cvode["time"], 9))
    assert len(rows) >= 50
    ours, cvode = (r[np.isin(np.round(r["time"], 9), rows)] for r in (ours, cvode))
    for column in ours.dtype.names[1:]:
        a, b = ours[column].astype(float), cvode[column].astype(float)
        assert np.max(np.abs(a - b)) <= case.within * max(np.max(np.abs(a)), 1e-3), column


OURS = [
    pytest.param(name, marks=[] if name in ("BouncingBall", "Brake") else pytest.mark.slow)
    for name in (*(case for case in CASES if case not in ("linkage", "rig", "voltage_profile")), "VanDerPol")
]


@pytest.mark.parametrize("name", OURS)
def test_our_solver_in_the_engine_agrees_with_that_of_the_fmu(name: str, build_of: BuildOf) -> None:
    """State events, friction, diodes, samples, a model without states, a stiff one: errors are of the tolerance."""
    case = CASES.get(name, Case(2000.0, 1e-4))
    found = {}
    for interface in ("CoSimulation", "ModelExchange"):
        with Fmu.read(build_of(name, "2.0" if name == "BouncingBall" else "3.0"), interface) as fmu:  # type: ignore[arg-type]
            rows = case.inputs or []
            inputs = [Channel(("m", case.columns), [r[0] for r in rows], [r[1] for r in rows])] if rows else []
            system = System([Component("m", fmu)], channels=inputs)
            interval = case.stop / 512.0
            result = simulate(system, stop=case.stop, output_interval=interval, tolerance=1e-8, isolate="never")
            found[interface] = result.columns
    for column, stepped in found["CoSimulation"].items():
        integrated = found["ModelExchange"][column]
        apart = np.abs(stepped.astype(float) - integrated.astype(float)) > case.within * max(
            np.abs(stepped).max(), 1e-3
        )
        # a row may lie between the two instants of one event, which differ by less than the tolerance
        assert apart.sum() <= 0.01 * len(apart), column


@pytest.mark.slow
@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
@pytest.mark.parametrize("name", CASES)
def test_fmpy_finds_nothing(name: str, fmi: FmiVersion, build_of: BuildOf) -> None:
    assert fmpy.validation.validate_fmu(str(build_of(name, fmi))) == []


@pytest.mark.parametrize("fmi", ["2.0", pytest.param("3.0", marks=pytest.mark.slow)])
def test_events_that_accumulate_end_a_simulation_by_the_importer_too(fmi: FmiVersion, build_of: BuildOf) -> None:
    said: list[str] = []
    with pytest.raises(fmpy.fmi1.FMICallException):
        fmpy.simulate_fmu(
            str(build_of("BouncingBall", fmi)), stop_time=3.0, relative_tolerance=1e-8, fmi_type="ModelExchange",
            logger=lambda *arguments: said.append(arguments[-1].decode()),
        )  # fmt: skip
    # h = 1 m, e = 0.7: sqrt(2 h / g) (1 + e) / (1 - e) = 2.5586 s
    assert "At t = 2.55" in said[-1]
    assert "the events of 'h <= 0' accumulate" in said[-1]


PENDULUM = """model M "A pendulum in x and y, with x as the state"
  Real x(start=0.7*sin(2), stateSelect=StateSelect.prefer);
  Real y(start=-0.7*cos(2));
  Real vx(start=0, stateSelect=StateSelect.prefer);
  Real vy(start=0);
  Real F;
equation
  vx = der(x);
  vy = der(y);
  der(vx) = -F*x;
  der(vy) = -F*y - 9.81;
  x^2 + y^2 = 0.7^2;
end M;
"""


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:Exception ignored on calling ctypes callback")
@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
def test_a_choice_of_states_that_becomes_singular_is_named(fmi: FmiVersion, tmp_path: Path) -> None:
    (tmp_path / "M.mo").write_text(PENDULUM)
    path = export(tmp_path / "M.mo", "M", tmp_path, fmi=fmi)
    states = [v.derivative.name for v in fmpy.read_model_description(str(path)).modelVariables if v.derivative]
    assert states == ["x", "vx"]
    said: list[str] = []
    with pytest.raises((fmpy.fmi1.FMICallException, RuntimeError)):  # fmpy's CVode takes no Discard
        fmpy.simulate_fmu(
            str(path), stop_time=3.0, output_interval=5e-3, relative_tolerance=1e-8, fmi_type="ModelExchange",
            logger=lambda *arguments: said.append(arguments[-1].decode()),
        )  # fmt: skip
    found = re.search(
        r"t = (\S+) s the (algebraic equations cannot be solved; the unknown concerned is y|chosen states do not "
        r"determine the other variables: y and vy cannot be computed from x and vx)",
        said[0],
    )
    assert found is not None, said[0]
    # the time of the fall from 2 rad to 90 degrees, by energy, with cos(phi) - cos(2) = s^2
    fall = quad(lambda s: 2 / math.sqrt(1 - (s**2 + math.cos(2)) ** 2), 0, math.sqrt(-math.cos(2)))[0]
    assert float(found[1]) == pytest.approx(fall / math.sqrt(2 * 9.81 / 0.7), abs=0.02)


@pytest.mark.filterwarnings("ignore:Exception ignored on calling ctypes callback")
def test_no_step_turns_back_unnoticed_at_a_singular_choice_of_states(tmp_path: Path) -> None:
    (tmp_path / "M.mo").write_text(PENDULUM)
    path = export(tmp_path / "M.mo", "M", tmp_path)
    for rows in (2e-4, 5e-4, 2e-3, 3e-3, 1e-2, 2e-2):
        said: list[str] = []
        with contextlib.suppress(fmpy.fmi1.FMICallException, RuntimeError):  # sooner or later there is no solution
            fmpy.simulate_fmu(
                str(path), stop_time=3.0, output_interval=rows, relative_tolerance=1e-6, fmi_type="ModelExchange",
                logger=lambda *arguments, said=said: said.append(arguments[-1].decode()),
            )  # fmt: skip
        # it is horizontal after 0.2562 s, by energy
        found = re.search(
            r"t = (\S+) s (may have gone on|the algebraic equations cannot|the chosen states do not)", said[0]
        )
        assert found is not None, said[0]
        assert float(found[1]) == pytest.approx(0.2562, abs=rows + 1e-3)


def test_a_four_bar_linkage_that_turns_is_not_warned_of(tmp_path: Path) -> None:
    small = TESTS / "models" / "Small"
    path = export(small / "FourBar.mo", "Small.FourBar", tmp_path)
    said: list[str] = []
    result = fmpy.simulate_fmu(
        str(path), stop_time=10, output_interval=5e-3, relative_tolerance=1e-6, fmi_type="ModelExchange",
        logger=lambda *arguments: said.append(arguments[-1].decode()),
    )  # fmt: skip
    assert result["phi"][-1] > 9 * 2 * math.pi
    assert not said
