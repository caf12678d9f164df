"""Random expressions whose units are right by construction pass; one wrong unit in them is found."""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cosim.modelica import Source, check_units, flatten
from cosim.modelica.quantity import declared, write

pytest.importorskip("rumoca")

BASE = ("kg", "m", "s", "A", "rad")
Powers = tuple[int, ...]
"""Exponents of BASE; the last one is free, since an angle is a number."""


def unit(powers: Powers) -> str:
    above = ".".join(f"{base}{p}" for base, p in zip(BASE, powers, strict=True) if p > 0) or "1"
    below = ".".join(f"{base}{-p}" for base, p in zip(BASE, powers, strict=True) if p < 0)
    return f"{above}/({below})" if below else above


@dataclass
class Expressions:
    """Grows an expression of given powers; every variable occurs once."""

    data: st.DataObject
    variables: list[Powers] = field(default_factory=list)

    def draw(self, strategy: st.SearchStrategy[int]) -> int:
        return self.data.draw(strategy)

    def variable(self, powers: Powers) -> str:
        self.variables.append((*powers[:-1], self.draw(st.integers(-1, 1))))
        return f"v{len(self.variables)}"

    def grow(self, powers: Powers, depth: int) -> str:
        if depth == 0:
            return self.variable(powers)
        below = depth - 1
        number = not any(powers[:-1])
        choice = self.draw(st.integers(0, 9 if number else 8))
        match choice:
            case 0 | 1:
                sign = "+-"[self.draw(st.integers(0, 1))]
                return f"({self.grow(powers, below)} {sign} {self.grow(powers, below)})"
            case 2 | 3:
                part = tuple(self.draw(st.integers(-2, 2)) for _ in BASE)
                rest = tuple(p - q for p, q in zip(powers, part, strict=True))
                return f"({self.grow(part, below)}*{self.grow(rest, below)})"
            case 4:
                part = tuple(self.draw(st.integers(-2, 2)) for _ in BASE)
                whole = tuple(p + q for p, q in zip(powers, part, strict=True))
                return f"({self.grow(whole, below)}/{self.grow(part, below)})"
            case 5:
                return f"sqrt({self.grow(tuple(2 * p for p in powers), below)})"
            case 6:
                kind = tuple(self.draw(st.integers(-2, 2)) for _ in BASE)
                condition = f"{self.grow(kind, 0)} > {self.grow(kind, 0)}"
                return f"(if {condition} then {self.grow(powers, below)} else {self.grow(powers, below)})"
            case 7:
                return f"max({self.grow(powers, below)}, abs({self.grow(powers, below)}))"
            case 8:
                kg, m, s, *others = powers
                return f"(der({self.variable((kg, m, s + 1, *others))})*{self.grow((0,) * len(BASE), below)})"
        return f"sin({self.grow(powers, below)})"


def model(equation: str, variables: list[Powers]) -> str:
    declarations = "\n".join(f'  Real v{k}(unit="{unit(powers)}");' for k, powers in enumerate(variables, 1))
    return f"model M\n{declarations}\nequation\n  {equation};\nend M;\n"


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_a_right_expression_passes_and_a_wrong_unit_in_it_is_found(tmp_path: Path, data: st.DataObject) -> None:
    expressions = Expressions(data)
    powers = tuple(data.draw(st.integers(-2, 2)) for _ in BASE)
    equation = f"{expressions.grow(powers, 0)} = {expressions.grow(powers, data.draw(st.integers(1, 4)))}"
    file = tmp_path / "M.mo"

    file.write_text(model(equation, expressions.variables))
    assert [str(m) for m in check_units(flatten(Source.read(file), "M"))] == []

    wrong = data.draw(st.integers(0, len(expressions.variables) - 1))
    kg, *others = expressions.variables[wrong]
    expressions.variables[wrong] = (kg + 1, *others)
    file.write_text(model(equation, expressions.variables))
    assert len(check_units(flatten(Source.read(file), "M"))) >= 1


@given(st.tuples(*(st.fractions(-4, 4, max_denominator=1) for _ in "kg m s A K mol cd".split())))
def test_a_unit_is_written_so_that_it_reads_as_itself(powers: tuple[Fraction, ...]) -> None:
    names = "kg m s A K mol cd".split()
    wanted = tuple(sorted((name, p) for name, p in zip(names, powers, strict=True) if p))
    read = declared(write(wanted))
    assert read is not None
    assert read.powers == wanted
