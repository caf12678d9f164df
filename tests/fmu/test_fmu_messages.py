"""What a model says while it runs, and what it lets an importer set."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import fmpy
import pytest
from fmpy.fmi1 import FMICallException

from cosim.fmu import compile_model, export
from cosim.fmu.description import describe
from cosim.fmu.description2 import describe2
from cosim.fmu.layout import lay_out

pytest.importorskip("rumoca")

TALKING = """
model Talking "Says what happens to x, which falls by 1 in a second"
  parameter String who = "tank" "Name in messages";
  parameter Real low(unit="1") = -1 "Where an error is";
  Real x(unit="1", start=1, fixed=true) "Level";
  parameter Real least(unit="1") = -1 "Where an error of a function is";
  parameter Real rate(unit="1/s") = 1 "Rate";
  Integer n(start=0, fixed=true) "Times below a half";
  function checked "Warns and errs"
    input Real u(unit="1") "Argument";
    input Real low(unit="1") "Limit";
    output Real y(unit="1") "The same";
  algorithm
    assert(u > low, "the function's argument is too low");
    y := u;
  end checked;
equation
  der(x) = -rate;
  assert(x > 0.75, who + ": x = " + String(x) + " is low", AssertionLevel.warning);
  assert(x > low, who + " is empty");
  when x < 0.5 then
    n = pre(n) + 1;
    assert(n < 1, "below a half", level=AssertionLevel.warning);
  end when;
  when x < 0.25 then
    terminate(who + " is done");
  end when;
  when checked(x, least) < 0.1 then
    reinit(x, 1);
  end when;
end Talking;
"""


@pytest.fixture(scope="module")
def talking(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("talking")
    (folder / "Talking.mo").write_text(TALKING)
    return export(folder / "Talking.mo", "Talking", folder)


def said(text: str) -> list[str]:
    return [line for line in text.splitlines() if line.startswith("[")]


def test_warnings_are_logged_once_and_an_end_with_its_message(talking: Path, capfd: pytest.CaptureFixture[str]) -> None:
    fmpy.simulate_fmu(str(talking), stop_time=2, output_interval=0.05)
    assert said(capfd.readouterr().out) == [
        "[WARNING] At t = 0.25 s: tank: x = <x> is low",
        "[WARNING] At t = 0.5 s: below a half",
        "[WARNING] At t = 0.75 s the model ends the simulation: tank is done",
    ]


@pytest.mark.parametrize(
    ("parameter", "message"),
    [("low", "tank is empty"), ("least", "the function's argument is too low")],
)
def test_an_error_ends_the_run(talking: Path, parameter: str, message: str, capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(FMICallException):
        fmpy.simulate_fmu(str(talking), stop_time=2, output_interval=0.05, start_values={parameter: 0.6})
    expected = f"[ERROR] At t = 0.4 s an assertion of the model is violated: {message}"
    assert said(capfd.readouterr().out)[-1] == expected


def attributes(tmp_path: Path, text: str, model: str = "M") -> dict[str, dict[str, str]]:
    """The attributes of each variable in the description."""
    (tmp_path / "M.mo").write_text(text)
    dae = compile_model(tmp_path / "M.mo", model)
    root = ET.fromstring(describe(dae, lay_out(dae), "M", "token"))
    variables = root.find("ModelVariables")
    assert variables is not None
    return {str(variable.get("name")): dict(variable.attrib) for variable in variables}


def test_parameters_that_have_decided_the_structure_cannot_be_set(tmp_path: Path) -> None:
    found = attributes(
        tmp_path,
        """model M
             model Part parameter Real k = 1; output Real y = k*time; end Part;
             parameter Integer half = 1;
             parameter Integer n = 2*half "Size";
             parameter Boolean with = true "Decides a component";
             parameter Boolean steady = false "Decides an initial equation";
             parameter Integer kind = 2 "Decides an equation";
             parameter Integer m = 3 "Range of a sum";
             parameter Integer pick = 1 "An index";
             parameter Boolean free = true "Decides nothing but a value";
             Real x[n];
             Part part if with;
             output Real s;
             output Real y;
             output Real z = sum(i*time for i in 1:m) + x[pick] + (if free then 1 else 2);
           initial equation
             if steady then der(s) = 0; else s = 1; end if;
           equation
             for i in 1:n loop x[i] = i*time; end for;
             der(s) = 2 - s;
             if kind == 1 then y = 1; elseif kind == 2 then y = time; else y = 3; end if;
           end M;""",
    )
    fixed = {name for name, a in found.items() if a["causality"] == "calculatedParameter"}
    assert fixed == {"half", "n", "with", "steady", "kind", "m"}
    assert {name for name, a in found.items() if a["causality"] == "parameter"} == {"pick", "free", "part.k"}


def test_enumerations_whose_literals_run_together_have_names_of_their_own(tmp_path: Path) -> None:
    (tmp_path / "M.mo").write_text(
        """model M
             type E = enumeration(a, b_c); type F = enumeration(a_b, c);
             parameter E e = E.b_c; parameter F f = F.c; parameter E g = E.a;
             output Real Enumeration_a_b_c_2 = time;
           end M;"""
    )
    dae = compile_model(tmp_path / "M.mo", "M")
    for write, tag, attribute in ((describe, "Enumeration", "name"), (describe2, "ScalarVariable", "name")):
        root = ET.fromstring(write(dae, lay_out(dae), "M", "token"))
        types = {}
        for variable in root.iter(tag):
            inner = variable if variable.get("declaredType") else variable.find("Enumeration")
            if inner is not None and inner.get("declaredType"):
                types[variable.get(attribute)] = inner.get("declaredType")
        assert types == {"e": "Enumeration_a_b_c", "f": "Enumeration_a_b_c_3", "g": "Enumeration_a_b_c"}
        definitions = root.find("TypeDefinitions")
        assert definitions is not None
        literals = {kind.get("name"): [item.get("name") for item in kind.iter("Item")] for kind in definitions}
        assert literals == {"Enumeration_a_b_c": ["a", "b_c"], "Enumeration_a_b_c_3": ["a_b", "c"]}
