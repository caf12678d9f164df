"""Models whose linear systems are known."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from cosim.linear import Linearizer

pytest.importorskip("rumoca")

MOTOR = """model Motor "A DC motor that turns an inertia"
  parameter Real R(unit="Ohm") = 2 "Resistance";
  parameter Real L(unit="H") = 0.01 "Inductance";
  parameter Real k(unit="N.m/A") = 0.1 "Motor constant";
  parameter Real J(unit="kg.m2") = 1e-3 "Inertia";
  parameter Real d(unit="N.m.s/rad") = 1e-4 "Friction";
  input Real v(unit="V", start=12) "Voltage";
  input Real tau(unit="N.m") "Load";
  input Boolean lamp(start=true) "Not of interest";
  output Real i(unit="A", start=0, fixed=true) "Current";
  output Real w(unit="rad/s", start=0, fixed=true) "Speed";
  output Real P(unit="W") "Electric power";
  Real phi(unit="rad", start=0.5, fixed=true) "Angle";
equation
  L*der(i) = v - R*i - k*w;
  J*der(w) = k*i - d*w - tau;
  der(phi) = w;
  P = v*i;
end Motor;
"""


IMPLICIT = """model Valve "A tank whose outflow is given implicitly"
  parameter Real c(unit="1") = 0.3;
  parameter Real h_0(unit="m") = 1;
  input Real u(unit="m/s", start=2);
  output Real h(unit="m", start=h_0, fixed=true);
  output Real q(unit="m/s", start=1);
  output Real slope(unit="m/s");
  constant Real T(unit="s") = 1;
  constant Real s(unit="m/s") = 1;
equation
  slope = u - q;
  der(h) = slope;
  q/s + c*sin(q/s) + (q/s)^3 = h/(s*T);
end Valve;
"""

SWITCHED = """model Switched "Two slopes"
  parameter Real a = 1;
  parameter Real b = 1;
  parameter Real c = 0;
  parameter Real d = 2;
  output Real x(start=0, fixed=true);
equation
  der(x) = if x < 0.5 then a - b*x - c*x^2 else d - x;
end Switched;
"""


@pytest.fixture(scope="session")
def models(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("models")
    for name, text in {"Motor": MOTOR, "Valve": IMPLICIT, "Switched": SWITCHED}.items():
        (folder / f"{name}.mo").write_text(text)
    return folder


@pytest.fixture(scope="session")
def motor(models: Path) -> Iterator[Linearizer]:
    with Linearizer(models / "Motor.mo", "Motor") as linearizer:
        yield linearizer


@pytest.fixture(scope="session")
def valve(models: Path) -> Iterator[Linearizer]:
    with Linearizer(models / "Valve.mo", "Valve") as linearizer:
        yield linearizer


@pytest.fixture(scope="session")
def switched(models: Path) -> Iterator[Linearizer]:
    with Linearizer(models / "Switched.mo", "Switched") as linearizer:
        yield linearizer
