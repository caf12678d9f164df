"""Tunable parameters: set between steps, they act from there on as an input would; others are refused."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from importer import Importer

from cosim.fmu import compile_model, export
from cosim.fmu.tunable import tunable_parameters

pytest.importorskip("rumoca")

Build = Callable[[str], Path]
SMALL = Path(__file__).parents[1] / "models" / "Small"
OSCILLATOR = """model {name} "A mass on a spring, with an implicit friction and a stop"
  {kind} Real c(start=40){value};
  {kind} Real d(start=0.5){value2};
  parameter Real m = 1;
  parameter Real x_0 = 1;
  output Real x(start=x_0, fixed=true);
  output Real v(start=0, fixed=true);
  output Real F(start=0);
  output Boolean beyond;
equation
  der(x) = v;
  m*der(v) = -c*x - F;
  F + 0.1*sin(F) = d*v;
  beyond = c*x > 10;
end {name};
"""


def test_a_parameter_that_is_tuned_acts_as_an_input(tmp_path: Path) -> None:
    values = {"kind": "parameter", "value": " = 40", "value2": " = 0.5"}
    text = OSCILLATOR.format(name="Tuned", **values), OSCILLATOR.format(name="Fed", kind="input", value="", value2="")
    rows: list[list[list[float]]] = []
    for name, model in zip(("Tuned", "Fed"), text, strict=True):
        (tmp_path / f"{name}.mo").write_text(model)
        with Importer(export(tmp_path / f"{name}.mo", name, tmp_path)) as importer:
            importer.fmu.enterInitializationMode(tolerance=1e-8)
            importer.fmu.exitInitializationMode()
            found = []
            for k in range(60):
                if k in (17, 41):
                    importer.set("c", 90.0 if k == 17 else 20.0)
                    importer.set("d", 2.0)
                importer.step(0.02)
                found.append([importer.get(n) for n in ("x", "v", "F", "beyond")])
            rows.append(found)
    assert rows[0] == rows[1]
    assert np.ptp(np.array(rows[0])[:, 3]) == 1


def test_what_is_declared_tunable_can_be_set_in_step_mode_and_nothing_else(build: Build) -> None:
    with Importer(build("WiperDrive.Systems.LinkagePlant")) as importer:
        parameters = [v for v in importer.variables.values() if v.causality == "parameter"]
        assert {v.variability for v in parameters} == {"fixed", "tunable"}
        importer.set("duty", 0.8)
        importer.start()
        importer.step(0.2)
        for variable in parameters:
            value = importer.get(variable.name)
            if variable.variability == "tunable":
                importer.set(variable.name, value)
            else:
                with pytest.raises(FMICallException):
                    importer.set(variable.name, value)
                assert "before the end of Initialization Mode" in importer.said[-1]
        # what follows from a tunable parameter follows it at once, and is declared so
        derived = importer.variables["motor.emf.k"]
        assert (derived.causality, derived.variability) == ("calculatedParameter", "tunable")
        importer.set("k_emf", 0.03)
        assert importer.get("motor.emf.k") == 0.03
        importer.step(0.2)


def test_setting_parameters_to_what_they_are_changes_nothing(build: Build) -> None:
    results = []
    for tune in (False, True):
        with Importer(build("MotorOnSpring")) as importer:
            importer.set("u", 12.0)
            importer.start()
            for _ in range(20):
                importer.step(0.01)
                if tune:
                    for name in ("R", "J", "spring.c"):
                        importer.set(name, importer.get(name))
            results.append([importer.get("phi"), importer.get("i")])
    assert results[0] == results[1]


@pytest.mark.parametrize(
    ("name", "tunable", "fixed"),
    [
        ("PendulumXY", {"m"}, {"L"}),  # the rod is a constraint that was differentiated
        ("BouncingBall", {"e"}, {"h_0"}),  # the height matters at the start only
        ("SampledPI", {"k", "T", "T_i"}, {"T_s"}),  # the clock is laid out at the start
        ("FourBar", {"J_1", "J_3"}, {"a", "b", "c", "d"}),
    ],
)
def test_tunable_is_what_can_change_physically(name: str, tunable: set[str], fixed: set[str]) -> None:
    dae = compile_model(SMALL / f"{name}.mo", f"Small.{name}")
    found = tunable_parameters(dae)
    independent = {p.scalar.name for p in dae.parameters if p.independent}
    assert (found & independent, independent - found) == (tunable, fixed)


def test_what_lengths_are_counted_from_is_fixed(tmp_path: Path) -> None:
    (tmp_path / "Filter.mo").write_text(
        """model Filter
  parameter Real T = 0.5;
  parameter Integer n = integer(floor(T/0.1));
  parameter Real gain = 2;
  input Real u;
  output Real y;
equation
  y = gain*n*u;
end Filter;
"""
    )
    assert tunable_parameters(compile_model(tmp_path / "Filter.mo", "Filter")) == {"gain"}
