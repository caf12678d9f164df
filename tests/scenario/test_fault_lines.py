"""The ``fault`` lines of a scenario: what is read, and what is refused in which words."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from test_scenario_assemble import FMUS, locate

from cosim.engine import FAULT_KINDS, RANDOM_FAULTS, Fault, FaultKind, Fmu, Variable, described
from cosim.errors import InputError
from cosim.scenario import assemble, read
from cosim.scenario._faults import _amount, fault_line, parse_fault
from cosim.scenario._values import difference

HEAD = "# system: plant\n# controller: control\n# stop: 2 s\n"
Faults = Callable[..., list[Fault]]


@pytest.fixture
def faults(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Faults:
    """Return the faults of a scenario with these lines; its FMUs are lists of variables."""
    monkeypatch.setattr(Fmu, "read", staticmethod(lambda path: FMUS[Path(path).stem]))

    def assembled(*lines: str, options: tuple[str, ...] = ()) -> list[Fault]:
        path = tmp_path / "x.csv"
        path.write_text(HEAD + "".join(f"# fault: {line}\n" for line in lines) + "time [s]\n", encoding="utf-8")
        return assemble(read(path, faults=options), locate).faults

    return assembled


CURRENT = ("controller", "i_motor")
PARK = ("controller", "park")


@pytest.mark.parametrize(
    ("line", "fault"),
    [
        ("controller.i_motor bias 0.5 A from 2 s to 5 s", Fault(CURRENT, "bias", 500.0, 2.0, 5.0)),
        ("i_motor bias -0.5 A", Fault(CURRENT, "bias", -500.0)),
        ("i_motor override 0 A to 300 ms", Fault(CURRENT, "override", 0.0, 0.0, 0.3)),
        ("i_motor scale 90 %", Fault(CURRENT, "scale", 0.9)),
        ("i_motor scale -1", Fault(CURRENT, "scale", -1.0)),
        ("i_motor freeze from 0.02 min", Fault(CURRENT, "freeze", 0.0, 1.2)),
        ("i_motor delay 5 ms", Fault(CURRENT, "delay", 0.005)),
        ("i_motor drop 30 % seed 3 from 1 s to 4 s", Fault(CURRENT, "drop", 0.3, 1.0, 4.0, None, 3)),
        ("i_motor drop 0.3 from 1 s seed 3 every 2 ms", Fault(CURRENT, "drop", 0.3, 1.0, math.inf, 0.002, 3)),
        ("i_motor quantise 10 mA", Fault(CURRENT, "quantise", 10.0)),
        ("i_motor noise 0.2 A seed 7 every 1 ms", Fault(CURRENT, "noise", 200.0, 0.0, math.inf, 0.001, 7)),
        ("i_motor noise 0.2 A", Fault(CURRENT, "noise", 200.0, seed=1)),
        ("controller.park override 1 from 1 s", Fault(PARK, "override", 1.0, 1.0)),
        ("controller.park override false", Fault(PARK, "override", 0.0)),
        ("plant.gear override HIGH", Fault(("plant", "gear"), "override", 2.0)),
        ("duty   override  0.3", Fault(("plant", "duty"), "override", 0.3)),
    ],
)
def test_what_a_line_means(faults: Faults, line: str, fault: Fault) -> None:
    assert faults(line) == [fault]


def test_options_follow_the_lines_of_the_file(faults: Faults) -> None:
    found = faults("i_motor bias 1 mA", "park freeze", options=("i_motor scale 2", "i_motor bias 2 mA"))
    assert [(fault.kind, fault.amount) for fault in found] == [("bias", 1), ("freeze", 0), ("scale", 2), ("bias", 2)]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (
            "",
            "'fault' has no value; write 'fault: INPUT KIND AMOUNT from TIME to TIME', for example 'fault: "
            "controller.i_motor bias 0.5 A from 2 s to 5 s'",
        ),
        (
            "i_motor",
            "'i_motor' has no kind; write 'fault: INPUT KIND AMOUNT from TIME to TIME', for example 'fault: "
            "controller.i_motor bias 0.5 A from 2 s to 5 s'",
        ),
        (
            "bias 1 A",
            "'bias 1 A' names no input; write 'fault: INPUT KIND AMOUNT from TIME to TIME', for example "
            "'fault: controller.i_motor bias 0.5 A from 2 s to 5 s'",
        ),
        (
            "i_motor quantize 1 A",
            "'i_motor quantize 1 A' has no kind that is known, did you mean 'quantise'?; kinds "
            "are override, bias, scale, freeze, delay, drop, quantise, noise",
        ),
        ("i_motor bias", "'bias' needs what it adds, such as 'bias 0.5 A'"),
        ("i_motor bias from 1 s", "'bias' needs what it adds, such as 'bias 0.5 A'"),
        ("i_motor freeze 1 A", "'freeze' takes no amount, found '1 A'; the input keeps the value that it has"),
        ("i_motor bias 1 A from", "'from' has no value; write for example 'from 2 s'"),
        ("i_motor bias 1 A from 1", "'from' is a time, '1' is not; write 1 s or 1 ms"),
        ("i_motor bias 1 A to 1 V", "'to' is a time, '1 V' is not; write for example 'to 2 s'"),
        ("i_motor bias 1 A from -1 s", "'from' is -1 s; a simulation starts at 0 s"),
        ("i_motor bias 1 A from 1 s to 1 s", "it ends at 1 s, but begins at 1 s; 'to' must be after 'from'"),
        ("i_motor bias 1 A from 1 s from 2 s", "'from' is given a second time; it can be given once"),
        ("i_motor bias 1 A seed 3", "'bias' takes no 'seed'; only drop and noise do"),
        ("i_motor noise 1 A seed -3", "'seed' is '-3'; it must be a whole number from 0 on, such as 'seed 1'"),
        (
            "i_motor bias 1 A from 3 s",
            "the fault of 'i_motor' begins at 3 s, after 'stop', 2 s; let it begin earlier, or remove it",
        ),
        ("i_motor bias 1", "'1' is in 1, 'controller.i_motor' is in mA; write for example 1 mA"),
        ("i_motor bias 1 V", "'1 V' is in V, 'controller.i_motor' is in mA; write for example 1 mA"),
        ("i_motor scale 2 A", "'scale' takes a factor, such as 'scale 1.1' or 'scale 90 %', not '2 A'"),
        ("i_motor delay 2 A", "'delay' is a time, '2 A' is not; write for example 'delay 5 ms'"),
        ("i_motor delay 0 s", "fault controller.i_motor delay: the delay is 0 s; it must be above 2e-09 s"),
        ("i_motor drop 130 %", "fault controller.i_motor drop: the probability is 1.3; it must be from 0 to 1"),
        ("park bias 1", "'bias' needs a Real, 'controller.park' is a Boolean; it takes override, freeze, delay, drop"),
        ("park override 2", "'controller.park' is a Boolean, '2' is not; write 0 or 1"),
        ("duty override 3", "plant.duty = 3 is above its maximum 1.1"),
        (
            "plant.park override 1",
            "'plant.park' is an output; a fault is done to an input, such as controller.park, which it drives",
        ),
        (
            "tau_crank freeze",
            "'plant.tau_crank' is an output, not an input; inputs are plant.duty, plant.v_supply, "
            "plant.lights, plant.gear, plant.free, plant.odd, controller.i_motor, controller.park, "
            "controller.enable, controller.torque",
        ),
        (
            "i_moter freeze",
            "unknown input 'i_moter', did you mean 'controller.i_motor'?; inputs are plant.duty, "
            "plant.v_supply, plant.lights, plant.gear, plant.free, plant.odd, controller.i_motor, "
            "controller.park, controller.enable, controller.torque",
        ),
    ],
)
def test_what_is_refused(faults: Faults, tmp_path: Path, line: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        faults(line)
    assert str(caught.value) == f"{tmp_path / 'x.csv'}:4: {message}"


def test_an_option_is_refused_by_its_name(faults: Faults) -> None:
    with pytest.raises(InputError) as caught:
        faults(options=("i_motor wobble 1 A",))
    assert str(caught.value).startswith("--fault: 'i_motor wobble 1 A' has no kind that is known; kinds are override")


def test_a_decimal_comma_is_read_where_the_table_has_semicolons(tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    path.write_text(HEAD + "# fault: i_motor bias 0,5 A from 0,25 s\ntime [s];duty\n0;0,3\n", encoding="utf-8")
    (fault,) = read(path).faults
    assert (fault.amount, fault.start) == ("0.5 A", 0.25)


def test_the_bias_of_a_temperature_is_a_difference() -> None:
    kelvin = Variable("T", "Real", "input", "continuous", "K", None, None, 0, None)
    assert difference("5 degC", "T", kelvin) == 5.0
    assert difference("9 degF", "T", kelvin) == pytest.approx(5.0, rel=1e-15)


NUMBERS = st.floats(allow_nan=False, allow_infinity=False)
TIMES = st.floats(0.0, 1e6)
VARIABLES = st.sampled_from(
    [
        Variable(name, kind, "input", "continuous", unit, None, None, 0, literals)
        for name, kind, unit, literals in [
            ("u", "Real", "A", None),
            ("a.b[1,2]", "Real", None, None),
            ("from to", "Real", "N.m", None),
            ("on", "Boolean", None, None),
            ("gear", "Enumeration", None, ("LOW", "HIGH")),
            ("n", "Integer", None, None),
        ]
    ]
)


@st.composite
def any_fault(draw: st.DrawFn) -> tuple[Fault, Variable]:
    variable = draw(VARIABLES)
    kinds = FAULT_KINDS if variable.type == "Real" else ("override", "freeze", "delay", "drop")
    kind: FaultKind = draw(st.sampled_from(kinds))
    amounts: dict[str, st.SearchStrategy[float]] = {
        "freeze": st.just(0.0),
        "delay": st.floats(1e-6, 1e3),
        "drop": st.floats(0.0, 1.0),
        "quantise": st.floats(1e-9, 1e9),
        "noise": st.floats(0.0, 1e9),
    }
    amount = draw(amounts.get(kind, NUMBERS if variable.type == "Real" else st.sampled_from([1.0])))
    start = draw(TIMES)
    stop = draw(st.just(math.inf) | st.floats(start + 1e-3, start + 1e6))
    drawn = kind in RANDOM_FAULTS
    every = draw(st.none() | st.floats(1e-6, 1e3)) if drawn else None
    return Fault(
        ("c", variable.name), kind, amount, start, stop, every, draw(st.integers(0, 9)) if drawn else 1
    ), variable


UNKNOWN = Variable("u", "Real", "input", "continuous", "wiggles", None, None, 0, None)


@settings(deadline=None)
@example((Fault(("c", "u"), "noise", 0.1, 0.3, 0.7, 1e-3, 0), UNKNOWN))
@given(any_fault())
def test_a_fault_is_read_as_it_was_written(pair: tuple[Fault, Variable]) -> None:
    """In the units of the FMU, to the bit; and what a report says of it can be read, too."""
    fault, variable = pair
    fault.check(variable)
    line = parse_fault(fault_line(fault, variable), "x.csv", 1)
    assert (line.name, line.kind) == (".".join(fault.target), fault.kind)
    seed = Fault.seed if line.seed is None else line.seed
    amount = _amount(line, fault.target, variable)
    assert Fault(fault.target, line.kind, amount, line.start, line.stop, line.every, seed) == fault
    words = parse_fault(f"c.{variable.name} {described(fault, 'A')}", "x.csv", 1)
    assert (words.kind, words.start) == (fault.kind, pytest.approx(fault.start, rel=1e-8))


WORDS = st.sampled_from(
    [
        *FAULT_KINDS,
        "from",
        "to",
        "seed",
        "every",
        "i_motor",
        "park",
        "plant.duty",
        "1",
        "-2",
        "0.5",
        "A",
        "mA",
        "s",
        "ms",
        "%",
        "1e999",
        "nan",
        "inf",
        "=",
        "->",
        "",
        "°C",
        "٣",
    ]
)


@settings(deadline=None)
@given(st.lists(WORDS, max_size=10).map(" ".join) | st.text(max_size=40))
@example("i_motor noise 1 A seed 99999999999999999999")
@example("i_motor delay 1e300 s")
def test_any_text_is_a_fault_or_is_refused(text: str) -> None:
    """Never anything but a line of faults or an `InputError` with its place."""
    try:
        line = parse_fault(text, "--fault", None)
    except InputError as error:
        assert str(error).startswith("--fault: ")
        return
    assert line.kind in FAULT_KINDS
    assert 0.0 <= line.start < line.stop
    assert bool(line.amount) == (line.kind != "freeze")
