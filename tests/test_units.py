"""Units: the FMI grammar, conversion, and the messages a user reads."""

from __future__ import annotations

import contextlib
import math
import subprocess
import sys

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.errors import InputError
from cosim.units import ACCEPTED, BASE, compatible, convert, parse, quantity

TORQUE = {"kg": 1, "m": 2, "s": -2}


@pytest.mark.parametrize(
    ("text", "factor", "exponents"),
    [
        ("1", 1, {}),
        ("-", 1, {}),
        ("%", 0.01, {}),
        ("kg.m2", 1, {"kg": 1, "m": 2}),
        ("g.mm2", 1e-9, {"kg": 1, "m": 2}),
        ("m/s2", 1, {"m": 1, "s": -2}),
        ("m/s^2", 1, {"m": 1, "s": -2}),
        ("m.s-2", 1, {"m": 1, "s": -2}),
        ("1/s", 1, {"s": -1}),
        ("Hz", 1, {"s": -1}),
        ("N.m", 1, TORQUE),
        ("N m", 1, TORQUE),
        ("N*m", 1, TORQUE),
        ("N·m", 1, TORQUE),
        ("Nm", 1, TORQUE),
        ("kN.m", 1000, TORQUE),
        ("J", 1, TORQUE),
        ("N.m/rad", 1, TORQUE | {"rad": -1}),
        ("N.m.s/rad", 1, {"kg": 1, "m": 2, "s": -1, "rad": -1}),
        ("N.m.s/deg", 180 / math.pi, {"kg": 1, "m": 2, "s": -1, "rad": -1}),
        ("V.s/rad", 1, {"kg": 1, "m": 2, "s": -2, "A": -1, "rad": -1}),
        ("W/(m2.K)", 1, {"kg": 1, "s": -3, "K": -1}),
        ("N.m/(rad/s)", 1, {"kg": 1, "m": 2, "s": -1, "rad": -1}),
        ("(km/h)/(1/(g.s))", 1 / 3600, {"kg": 1, "m": 1}),
        ("kvar", 1e3, {"kg": 1, "m": 2, "s": -3}),
        ("MBq", 1e6, {"s": -1}),
        ("Ohm", 1, {"kg": 1, "m": 2, "s": -3, "A": -2}),
        ("mΩ", 1e-3, {"kg": 1, "m": 2, "s": -3, "A": -2}),
        ("mH", 1e-3, {"kg": 1, "m": 2, "s": -2, "A": -2}),
        ("rad/s", 1, {"s": -1, "rad": 1}),
        ("rpm", math.pi / 30, {"s": -1, "rad": 1}),
        ("rev/min", math.pi / 30, {"s": -1, "rad": 1}),
        ("deg", math.pi / 180, {"rad": 1}),
        ("°", math.pi / 180, {"rad": 1}),
        ("ms", 1e-3, {"s": 1}),
        ("µs", 1e-6, {"s": 1}),
        ("min", 60, {"s": 1}),
        ("m²", 1, {"m": 2}),
        ("W/degC", 1, {"kg": 1, "m": 2, "s": -3, "K": -1}),
        ("inch", 0.0254, {"m": 1}),
        ("psi", 6894.757293168, {"kg": 1, "m": -1, "s": -2}),
        ("turn", 2 * math.pi, {"rad": 1}),
    ],
)
def test_grammar(text: str, factor: float, exponents: dict[str, int]) -> None:
    unit = parse(text)
    assert unit.factor == pytest.approx(factor, rel=1e-12)
    assert unit.exponents == exponents
    assert (unit.text, unit.offset) == (text, 0)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "'' is not a unit; "),
        ("foo", "'foo' is not a unit; "),
        ("m/", "'m/' is not a unit; "),
        ("m..s", "'m..s' is not a unit; "),
        ("1.1", "'1.1' is not a unit; "),
        ("bit", "'bit' is not a unit; "),
        ("dB", "'dB' is not a unit that scales linearly; "),
        ("W/m2.K", "'W/m2.K' is not a unit (a product after '/' is ambiguous: write W/(m2.K)); "),
        ("J/kg/K", "'J/kg/K' is not a unit (more than one '/': write J/(kg.K)); "),
    ],
)
def test_refusals(text: str, complaint: str) -> None:
    with pytest.raises(InputError) as refusal:
        parse(text)
    assert str(refusal.value) == complaint + ACCEPTED


def test_the_refusal_lists_what_is_accepted() -> None:
    assert ACCEPTED == (
        "accepted are SI symbols with prefixes and bare exponents, joined by '.' and '/', such as "
        "N.m, kg.m2, rad/s, V.s/rad, m/s2, Ohm, ms, deg, rpm, degC, % or 1 for a plain number"
    )


@pytest.mark.parametrize(
    ("value", "source", "target", "expected"),
    [
        (35, "ms", "s", 0.035),
        (20, "ms", "s", 0.02),
        (0.3, "s", "ms", 300),
        (180, "deg", "rad", math.pi),
        (60, "rpm", "rad/s", 2 * math.pi),
        (20, "degC", "K", 293.15),
        (300, "K", "degC", 26.85),
        (212, "degF", "degC", 100),
        (1.5e-2, "N.m.s/deg", "N.m.s/rad", 0.8594366926962349),
        (35, "%", "1", 0.35),
    ],
)
def test_conversion(value: float, source: str, target: str, expected: float) -> None:
    assert convert(value, parse(source), parse(target)) == pytest.approx(expected, rel=1e-14)


def test_decimal_times_stay_decimal() -> None:
    second, millisecond = parse("s"), parse("ms")
    assert [convert(n, millisecond, second) for n in range(1000)] == [n / 1000 for n in range(1000)]


@pytest.mark.parametrize(
    ("source", "target", "message"),
    [
        ("A", "V", "cannot convert A to V: A against kg.m2.s-3.A-1"),
        ("Hz", "rad/s", "cannot convert Hz to rad/s: s-1 against s-1.rad, they differ in rad only"),
        ("1", "N.m", "cannot convert 1 to N.m: 1 against kg.m2.s-2"),
    ],
)
def test_incompatible_units(source: str, target: str, message: str) -> None:
    assert not compatible(parse(source), parse(target))
    with pytest.raises(InputError) as refusal:
        convert(1.0, parse(source), parse(target))
    assert str(refusal.value) == message


@pytest.mark.parametrize(
    ("text", "value", "unit"),
    [("20 ms", 20, "ms"), ("-3.5e-2 N.m", -0.035, "N.m"), ("4", 4, "1"), (".5A", 0.5, "A"), (" 5 % ", 5, "%")],
)
def test_quantity(text: str, value: float, unit: str) -> None:
    number, read = quantity(text)
    assert (number, read) == (value, parse(unit))


@pytest.mark.parametrize("text", ["", "ms", "nan s", "inf", "1,5 s", "1.2.3 s", "1_000 s", "1e999 s"])
def test_not_a_quantity(text: str) -> None:
    with pytest.raises(InputError) as refusal:
        quantity(text)
    assert str(refusal.value) == f"'{text}' is not a number with a unit; write it like 20 ms or 4.5 N.m"


@settings(deadline=None)
@given(st.dictionaries(st.sampled_from(BASE), st.integers(-9, 9).filter(bool), min_size=1))
def test_a_product_of_powers_reads_back(powers: dict[str, int]) -> None:
    text = ".".join(f"{base}{power}" for base, power in powers.items())
    assert parse(text).exponents == powers


@settings(deadline=None)
@given(st.text(alphabet="kgmsAKradN./()^-0123456789 %°", max_size=12))
def test_any_text_is_a_unit_or_refused(text: str) -> None:
    with contextlib.suppress(InputError):
        assert parse(text).factor > 0


def test_pint_is_imported_only_for_names_not_known_here() -> None:
    code = "import sys, cosim.units as u; u.parse('kN.m/rad'); assert 'pint' not in sys.modules; u.parse('inch')"
    subprocess.run([sys.executable, "-c", code + "; assert 'pint' in sys.modules"], check=True)
