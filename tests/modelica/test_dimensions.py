"""The units of every equation: what passes, what is found, and the words a user reads."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from cosim.cli._app import app
from cosim.errors import ModelError, ModelWarning
from cosim.fmu import catalogue, compile_model
from cosim.modelica import Source, UnitMismatch, check_units, flatten

pytest.importorskip("rumoca")

ROOT = Path(__file__).parents[2]
LIBRARY = ROOT / "modelica" / "WiperDrive"
MODELS = ROOT / "tests" / "models"
COMPLETE = re.compile(r"^(?:model|block) (\w+)", re.M)


def complete_models(package: Path) -> list[str]:
    files = (file for file in sorted(package.rglob("*.mo")) if COMPLETE.search(file.read_text()))
    parts = [file.relative_to(package.parent).with_suffix("").parts for file in files]
    return [".".join(names) for names in parts]


def mismatches(tmp_path: Path, text: str, model: str = "M") -> list[UnitMismatch]:
    file = tmp_path / "M.mo"
    file.write_text(text)
    return check_units(flatten(Source.read(file), model))


def model(*lines: str) -> str:
    """A model around an equation; what is declared has units that a reader knows."""
    return "\n".join(
        (
            "model M",
            '  parameter Real R(unit="Ohm") = 2;',
            '  parameter Real L(unit="H") = 1;',
            '  parameter Real J(unit="kg.m2") = 3;',
            '  parameter Real k(unit="N.m/A") = 0.1;',
            '  parameter Real r(unit="m") = 0.5;',
            '  parameter Real T(unit="s") = 2;',
            '  Real v(unit="V"); Real i(unit="A"); Real phi(unit="rad"); Real w(unit="rad/s"); Real tau(unit="N.m");',
            '  Real x(unit="m"); Real s(unit="m/s"); Real ratio(unit="1"); Real q;',
            *lines,
            "end M;",
        )
    )


def of_the_library() -> list[object]:
    """Its complete models; those that hold the linkage plant once more take their time."""
    names = [name for part in ("Systems", "Controllers", "Tests") for name in complete_models(LIBRARY / part)]
    again = re.compile(r"ClosedLoop|Tests\.Linkage|RigEnergy")
    return [pytest.param(name, marks=[pytest.mark.slow] if again.search(name) else []) for name in names]


@pytest.mark.parametrize("name", of_the_library())
def test_the_library_passes(name: str) -> None:
    assert check_units(flatten(Source.read(LIBRARY), f"WiperDrive.{name}")) == []


@pytest.mark.parametrize("package", ["Small", "Stiff", "Split", "Loops"])
def test_the_models_of_the_tests_pass(tmp_path: Path, package: str) -> None:
    # all as components of one model, which is flattened once
    parts = "".join(f"  {name} part_{k};\n" for k, name in enumerate(complete_models(MODELS / package)))
    text = f"{Source.read(MODELS / package).text}\nmodel All\n{parts}end All;\n"
    assert mismatches(tmp_path, text, "All") == []


@pytest.mark.parametrize("name", ["Language", "Algorithmic"])
def test_a_model_without_units_has_no_mismatch(name: str) -> None:
    assert check_units(flatten(Source.read(MODELS / f"{name}.mo"), name)) == []


@pytest.mark.parametrize(
    "equation",
    [
        "s = r*w",  # rad is no dimension
        "tau = k*i - J*der(w)",
        "v = k*w",
        "v*i = tau*w",
        "der(phi) = w",
        "phi = x/r",
        "x = r*sin(phi) + r*cos(2*phi + 0.1)",
        "x = 3",  # a literal fits any unit,
        "v = 24*sin(314*time) + 1",  # also with plain numbers and time,
        "tau = 3*ratio",
        "v = if time > 0.5 then 2 else v*1.5",
        "tau*w = J*w^2/T/2",  # and is a number where it is a factor
        "ratio = exp(-time/T)*tanh(w*T)",
        "x = sqrt(x^2 + r^2)",
        "w = sqrt(9.81*r)/r*1.0 + w",  # 9.81 hides a unit, but w would too
        "phi = atan2(x, r)",
        "ratio = min(1, max({ratio, 0.2, x/r}))",
        "i = if initial() then i else abs(i)*sign(v)",
        "v = q*i",  # a variable without unit fits
        "x^1.5 = r*sqrt(x)",
        "mod(phi, 2*3.14159) = ratio",
        "x = smooth(1, noEvent(if x > r then x else r))",
        "x = homotopy(s*T, r)",
    ],
)
def test_what_is_right_passes(tmp_path: Path, equation: str) -> None:
    found = mismatches(tmp_path, model("equation", f"  {equation};"))
    wanted = ["w = sqrt(9.81 * r) / r * 1 + w: sqrt(9.81 * r) / r * 1 is in 1/m^(1/2), but w is in rad/s"]
    assert [str(m).partition(": ")[2] for m in found] == (wanted if "9.81" in equation else [])


WRONG = {
    "v = R*i*w": "12:7: v = R * i * w: v is in V, but R * i * w is in V/s",
    "v = R*i + L*i": "12:13: v = R * i + L * i: R * i is in V, but L * i is in Wb",
    "tau = J*w": "12:9: tau = J * w: tau is in N.m, but J * w is in N.m.s",
    "x = r*sin(x)": "12:13: x = r * sin(x): the argument x of sin() is in m, but must be a number without unit",
    "ratio = exp(-T*3*w*T)": "12:15: ratio = exp(-T * 3 * w * T): the argument -T * 3 * w * T of exp() is in s, "
    "but must be a number without unit",
    "x = r*ratio^T": "12:15: x = r * ratio ^ T: the exponent T is in s, but must be a number without unit",
    "v = if x > T then v else R*i": "12:14: v = if x > T then v else R * i: x is in m, but T is in s",
    "v = if x > r then i else R*i": "12:21: v = if x > r then i else R * i: v is in V, but i is in A",
    "i = max({i, v/R, v})": "12:20: i = max({i, v / R, v}): i is in A, but v is in V",
    "phi = atan2(x, T)": "12:18: phi = atan2(x, T): x is in m, but T is in s",
    "der(x) = r": "12:12: der(x) = r: der(x) is in m/s, but r is in m",
    "der(x) = -2*x": "12:12: der(x) = -2 * x: der(x) is in m/s, but -2 * x is in m",
    "x = sqrt(r)": "12:7: x = sqrt(r): x is in m, but sqrt(r) is in m^(1/2)",
    "0 = v + i": "12:11: 0 = v + i: v is in V, but i is in A",
    "x = mod(r, T)": "12:14: x = mod(r, T): r is in m, but T is in s",
    "v = sample_rate": "12:7: v = sample_rate: v is in V, but sample_rate is in Hz",
    "w = sample_rate": "12:7: w = sample_rate: w is in rad/s, but sample_rate is in Hz: a factor of 2*pi is missing",
    "x = mm": "12:7: x = mm: x is in m, but mm is in mm: a factor of 1000 is missing",
    "phi = x/mm*ratio": "12:9: phi = x / mm * ratio: phi is in rad, but x / mm * ratio is in multiples of 1000: "
    "a factor of 1000 is missing",
    "ratio = sin(degrees)": "12:15: ratio = sin(degrees): the argument degrees of sin() is in deg, "
    "but must be a plain number or an angle in rad",
    "kelvin = celsius": "12:12: kelvin = celsius: kelvin is in K, but celsius is in degC: "
    "their zeros differ by 273.15 K",
}


@pytest.mark.parametrize("equation", WRONG)
def test_what_is_wrong_is_found(tmp_path: Path, equation: str) -> None:
    others = (
        '  Real sample_rate(unit="Hz"); Real mm(unit="mm"); Real degrees(unit="deg"); Real kelvin(unit="K");'
        ' Real celsius(unit="degC");'
    )
    (found,) = mismatches(tmp_path, model(others, "equation", f"  {equation};"))
    assert str(found) == f"{tmp_path / 'M.mo'}:{WRONG[equation]}"


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        (('  parameter Real P(unit="W") = R*k;',), "10:32: P = R * k: P is in W, but R * k is in kg2.m4/(s5.A3)"),
        (
            ("  Real z = x;", '  Real y(unit="s") = z;'),
            "11:22: y = z: y is in s, but z is in m; z has no unit, m follows from line 10: z = x",
        ),
        (('  Real y(unit="m", start=T);',), "10:26: y(start = T): y is in m, but T is in s"),
        (('  Real y(unit="m", min=-r, max=T);',), "10:32: y(max = T): y is in m, but T is in s"),
        (('  Real y(unit="m", nominal=T);',), "10:28: y(nominal = T): y is in m, but T is in s"),
        (("initial equation", "  x = v;"), "11:7: x = v: x is in m, but v is in V"),
        (("equation", "  when x > T then", "    q = 1;", "  end when;"), "11:12: when x > T: x is in m, but T is in s"),
        (
            ('  discrete Real d(unit="m");', "equation", "  when x > r then", "    d = pre(d) + T;", "  end when;"),
            "13:18: d = pre(d) + T: pre(d) is in m, but T is in s",
        ),
        (
            ("equation", "  der(x) = s;", "  when x > r then", "    reinit(x, -s);", "  end when;"),
            "13:15: reinit(x, -s): x is in m, but -s is in m/s",
        ),
        (("equation", '  assert(x < T, "too far");'), "11:14: assert(x < T): x is in m, but T is in s"),
        (
            ('  Real d(unit="m", start=0);', "algorithm", "  when sample(0, r) then", "    d := T;", "  end when;"),
            "12:18: when sample(0, r): time is in s, but r is in m|13:10: d = T: d is in m, but T is in s",
        ),
        (
            ('  Real a[2](each unit="m");', "equation", "  a = {x, T};"),
            "12:11: a = {x, T}: a is in m, but T is in s",
        ),
        (
            ('  Real a[3](each unit="m");', "equation", "  for j in 1:3 loop", "    a[j] = j*T;", "  end for;"),
            "13:12: a[1] = 1 * T: a[1] is in m, but 1 * T is in s (in 3 instances)",
        ),
    ],
)  # fmt: skip
def test_it_is_found_wherever_it_stands(tmp_path: Path, lines: tuple[str, ...], message: str) -> None:
    found = mismatches(tmp_path, model(*lines))
    assert [str(m) for m in found] == [f"{tmp_path / 'M.mo'}:{one}" for one in message.split("|")]


PACKAGE = """package P
  type Force = Real(unit="N") "Force";
  constant Real g(unit="m/s2") = 9.81;
  constant Force weight = 3;
  constant Real two = 2;
  connector Pin
    Real e(unit="V");
    flow Real f(unit="A");
  end Pin;
  connector Pipe
    Real e(unit="Pa");
    flow Real f(unit="m3/s");
  end Pipe;
  model Spring
    parameter Real c(unit="N/m") = 5;
    Real x(unit="m");
    Force F;
  equation
    F = c*x^2;
  end Spring;
  model M
    Spring a; Spring b; Spring d(c = P.weight);
    parameter Real m(unit="kg") = 2;
    parameter Real h(unit="m") = m*P.g;
    parameter Real E(unit="J") = P.two*P.g*m*h;
    Pin pin; Pipe pipe; Pin last;
    Real power(unit="W") = pin.e*pin.f;
  equation
    connect(pin, pipe);
    connect(pin, last);
  end M;
end P;
"""


def test_all_of_a_model_are_reported_at_once_and_those_of_a_class_once(tmp_path: Path) -> None:
    found = [str(m).partition("M.mo:")[2] for m in mismatches(tmp_path, PACKAGE, "P.M")]
    assert found == [
        "19:9: a.F = a.c * a.x ^ 2: a.F is in N, but a.c * a.x ^ 2 is in N.m (in 3 instances)",
        "22:38: d.c = 3: d.c is in N/m, but 3 is in N",
        "24:34: h = m * 9.81: h is in m, but m * 9.81 is in N",
        "29:5: 0 = -pin.f + (-pipe.f) + (-last.f): -pin.f is in A, but -pipe.f is in m3/s",
        "29:5: pin.e = pipe.e: pin.e is in V, but pipe.e is in Pa",
        "29:5: pipe.e = last.e: pipe.e is in Pa, but last.e is in V",
    ]


FUNCTIONS = """package P
  type Length = Real(unit="m");
  function force "Hooke's law, with mistakes inside"
    input P.Length x "Stretch";
    input Real c(unit="N/m") = 3;
    input Real share;
    output Real F(unit="N");
  protected
    Real z(unit="J");
    Real p[2](each unit="m"), q(unit="s") = 1;
  algorithm
    z := c*x;
    for i in 1:2 loop
      p[i] := i*x;
    end for;
    if q > x then
      q := p[1];
    end if;
    F := share*c*x;
  end force;
  model M
    parameter Real T(unit="s") = 3;
    P.Length x(start=1, fixed=true);
    Real F(unit="N");
    Real v(unit="m/s");
    Real G(unit="s");
  equation
    der(x) = v;
    v = P.force(v, share=1);
    F = P.force(x, 2, x) + P.force(c=3, x=x, share=T);
  algorithm
    if v > x then
      G := 2;
    else
      G := 3*x;
    end if;
  end M;
end P;
"""


def test_functions_and_algorithms(tmp_path: Path) -> None:
    found = [str(m).partition("M.mo:")[2] for m in mismatches(tmp_path, FUNCTIONS, "P.M")]
    assert found == [
        "12:10: z = c * x: z is in J, but c * x is in N",
        "16:12: if q > x: q is in s, but x is in m",
        "17:12: q = p[1]: q is in s, but p[1] is in m",
        "29:9: v = P.force(v, 3, 1): v is in m/s, but P.force(v, 3, 1) is in N",
        "29:17: v = P.force(v, 3, 1): the argument v of P.force() is in m/s, but the input x is in m",
        "32:12: if v > x: v is in m/s, but x is in m",
        "35:12: G = 3 * x: G is in s, but 3 * x is in m",
    ]


def test_strict_units_refuse_all_of_them_together(tmp_path: Path) -> None:
    file = tmp_path / "M.mo"
    file.write_text(model("equation", "  v = i;", "  x = T;"))
    with pytest.raises(ModelError) as caught:
        compile_model(file, "M", strict_units=True)
    assert str(caught.value) == (
        "M: 2 unit mismatches, refused because of --strict-units:\n"
        f"  {file}:11:7: v = i: v is in V, but i is in A\n"
        f"  {file}:12:7: x = T: x is in m, but T is in s\n"
        "A literal fits any unit; give a factor that has one a name and a unit, "
        'such as constant Real g(unit="m/s2") = 9.81.'
    )
    done = CliRunner().invoke(app, ["export", str(file), "M", "--out", str(tmp_path), "--strict-units"])
    assert (done.exit_code, done.stderr) == (2, f"error: {caught.value}\n")
    assert list(tmp_path.iterdir()) == [file]


def test_without_it_each_is_a_warning(tmp_path: Path) -> None:
    file = tmp_path / "M.mo"
    file.write_text('model M\n  output Real v(unit="V");\n  Real x(unit="m");\nequation\n  x = 2;\n  v = x;\nend M;\n')
    with pytest.warns(ModelWarning) as caught:
        compile_model(file, "M")
    assert [str(w.message) for w in caught] == [f"{file}:6:7: v = x: v is in V, but x is in m"]


def test_building_what_comes_along_looks_at_its_units_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "M.mo"
    file.write_text(model("equation", "  v = i;"))
    entry = catalogue.CatalogueEntry("mine", "system", "M", file, "Mine")
    monkeypatch.setattr(catalogue, "names", lambda: {"mine": entry})
    done = CliRunner().invoke(app, ["build", "mine", "--strict-units", "--out", str(tmp_path)])
    assert (done.exit_code, "v is in V, but i is in A" in done.stderr) == (2, True)


def test_the_example_of_the_documentation(tmp_path: Path) -> None:
    text = (ROOT / "docs" / "units.md").read_text(encoding="utf-8")
    example, shown = re.findall(r"```(?:modelica|text)\n(.*?)```", text, re.DOTALL)
    found = mismatches(tmp_path, example, "Slider")
    assert [f"warning: {m}".replace(str(tmp_path / "M.mo"), "slider.mo") for m in found] == shown.splitlines()
