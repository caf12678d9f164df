"""Strings on connections."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from both_loops import simulate

from cosim.engine import Algorithm, Channel, Component, Connection, Fmu, Result, System
from cosim.errors import FmuError, InputError

Get = Callable[..., Fmu]


def pair(fmu: Get, first: int = 3, second: int = 3, **parameters: str) -> System:
    label = {"name": "step", **parameters}
    return System(
        [Component("a", fmu("label", first), dict(label)), Component("b", fmu("label", second), dict(label))],
        [Connection(("a", "y"), ("b", "u")), Connection(("b", "y"), ("a", "u"))],
    )


def run(system: System, algorithm: Algorithm = "gauss-seidel") -> Result:
    if algorithm == "jacobi":
        return simulate(system, stop=2.0, output_interval=0.1, tolerance=1e-6, algorithm=algorithm, step=0.1)
    return simulate(system, stop=2.0, output_interval=0.1, tolerance=1e-6)


@pytest.mark.parametrize(("first", "second"), [(2, 2), (2, 3), (3, 2), (3, 3)])
def test_a_text_arrives_when_a_number_would(fmu: Get, first: int, second: int) -> None:
    """a puts "step " and k // 2 plusses out in step k. b is stepped after a and hears it at once, a hears b later."""
    result = run(pair(fmu, first, second))
    assert list(result.columns) == ["a.heard", "a.set", "b.heard", "b.set"]
    assert result.columns["b.heard"].tolist() == [0.0] + [5.0 + k // 2 for k in range(1, 21)]
    assert result.columns["a.heard"].tolist() == [0.0, 0.0] + [5.0 + k // 2 for k in range(1, 20)]


def test_a_text_is_set_when_it_has_changed(fmu: Get) -> None:
    """Once in initialisation, once in the first step, and in every second step from then on."""
    result = run(pair(fmu))
    sets = result.columns["b.set"] - result.columns["b.set"][0]
    assert sets.tolist() == [0] + [1 + k // 2 for k in range(1, 21)]


def test_jacobi_hands_texts_on_one_step_later(fmu: Get) -> None:
    result = run(pair(fmu), "jacobi")
    for name in ("a.heard", "b.heard"):
        assert result.columns[name].tolist() == [0.0, 0.0] + [5.0 + k // 2 for k in range(1, 20)]


def test_letters_beyond_ascii(fmu: Get) -> None:
    result = run(pair(fmu, name="Übergröße"))
    assert result.columns["b.heard"][-1] == len("Übergröße ".encode()) + 10


def test_what_is_no_text(fmu: Get) -> None:
    system = pair(fmu)
    system.connections[0] = Connection(("a", "heard"), ("b", "u"))
    with pytest.raises(InputError, match=r"^a.heard -> b.u: a Real cannot drive a String; it takes String$"):
        run(system)
    system.connections[0] = Connection(("a", "y"), ("b", "u"), factor=2.0)
    with pytest.raises(InputError, match=r"factor and offset need a Real target, but it is a String"):
        run(system)
    system = System([Component("a", fmu("label"))], channels=[Channel(("a", "u"), [0.0], [1.0])])
    with pytest.raises(FmuError, match=r"^channel a.u: is a String; a channel has numbers only$"):
        run(system)


def test_arrays_of_texts(fmu: Get) -> None:
    """Each element goes its own way: b hears what a has put out in the same step, a what b did in the step before."""
    words = fmu("words")
    parts = [Component("a", words, {"name[2]": "a longer word"}), Component("b", words)]
    links = [Connection((s, f"y[{i}]"), (t, f"u[{i}]")) for s, t in ("ab", "ba") for i in (1, 2)]
    result = run(System(parts, links))
    b, heard = ["", ""], {"a": [0.0], "b": [0.0]}
    for _ in range(20):
        heard["a"].append(len(b[0]) + 100 * len(b[1]))
        a = [f"word {b[1][:30]}", f"a longer word {b[0][:30]}"]
        heard["b"].append(len(a[0]) + 100 * len(a[1]))
        b = [f"word {a[1][:30]}", f"word {a[0][:30]}"]
    assert result.columns["a.heard"].tolist() == heard["a"]
    assert result.columns["b.heard"].tolist() == heard["b"]
    assert words.variables["name[1]"].start == "word"
