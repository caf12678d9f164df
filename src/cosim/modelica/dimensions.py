"""Checks that both sides of every equation, and all terms of every sum, have the same unit.

The rule is written down in docs/units.md; the algebra of units is in ``quantity.py``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from cosim.errors import ModelError
from cosim.modelica._terms import Finding, Terms
from cosim.modelica.expressions import Binary, Expression, Reference, render, render_equation
from cosim.modelica.flat import Action, Assertion, Assign, Conditional, FlatModel, Reinit, Variable, When

_LONGEST = 160
"""Characters of an equation that a message shows."""


@dataclass(frozen=True)
class UnitMismatch:
    """Two units that should be one, or an argument with a unit where a number belongs."""

    equation: str
    """Modelica text of the equation, declaration or clause."""
    problem: str
    """Which subexpressions have which units, and which unit follows from where."""
    at: int
    """Byte offset in the source."""
    times: int
    """How many instances of the class have it."""
    place: str
    """``file:line:column``."""

    def __str__(self) -> str:
        """The message a user reads."""
        more = f" (in {self.times} instances)" if self.times > 1 else ""
        return f"{self.place}: {self.equation}: {self.problem}{more}"


def check_units(flat: FlatModel) -> list[UnitMismatch]:
    """All mismatches of units of a flat model, in the order of the source text.

    Looked at are equations, initial equations, connections, declarations with their start, min, max and nominal
    values, when-clauses and assertions. A mistake in a class that is instantiated many times is reported once.
    """
    terms = Terms(flat)
    _infer(flat, terms)
    findings: dict[tuple[int, str], list[tuple[str, Finding]]] = {}
    for text, at, visit in _everything(flat, terms):
        terms.findings.clear()
        visit()
        for finding in dict.fromkeys(terms.findings):
            key = finding.at or at, finding.units
            findings.setdefault(key, []).append((text, finding))
    mismatches = []
    for (at, _), found in sorted(findings.items(), key=lambda item: item[0][0]):
        text, finding = found[0]
        place = flat.source.place(at)
        shown = text if len(text) <= _LONGEST else text[: _LONGEST - 4] + " ..."
        mismatches.append(
            UnitMismatch(shown, finding.problem, at, len(found), f"{place.file}:{place.line}:{place.column}")
        )
    return mismatches


def refuse_mismatches(flat: FlatModel, mismatches: list[UnitMismatch]) -> None:
    """Raise `ModelError` with all of them, if there are any."""
    if not mismatches:
        return
    count = f"{len(mismatches)} unit mismatch{'es' if len(mismatches) > 1 else ''}"
    lines = "".join(f"\n  {mismatch}" for mismatch in mismatches)
    raise ModelError(f"{flat.name}: {count}, refused because of --strict-units:{lines}\n{REMEDY}")


REMEDY = (
    "A literal fits any unit; give a factor that has one a name and a unit, "
    'such as constant Real g(unit="m/s2") = 9.81.'
)


class _Visit:
    """One equation or clause, to be looked at once or, while units are inferred, several times."""

    def __init__(self, terms: Terms, *pairs: tuple[Expression, Expression] | Expression) -> None:
        self._terms = terms
        self._pairs = pairs

    def __call__(self) -> None:
        for pair in self._pairs:
            if isinstance(pair, tuple):
                self._terms.same(*pair)
            else:
                self._terms.quantity(pair)


def _everything(flat: FlatModel, terms: Terms) -> Iterator[tuple[str, int, _Visit]]:
    """Text, place and check of everything in the model that has units."""
    for variable in flat.variables.values():
        yield from _declaration(terms, variable)
    for equation in (*flat.equations, *flat.initial_equations):
        yield render_equation(equation.residual), equation.at, _Visit(terms, _sides(equation.residual))
    for when in flat.whens:
        yield from _when(terms, when)
    for assertion in flat.assertions:
        yield from _action(terms, assertion)


def _sides(residual: Expression) -> tuple[Expression, Expression] | Expression:
    return (residual.left, residual.right) if isinstance(residual, Binary) and residual.operator == "-" else residual


def _declaration(terms: Terms, variable: Variable) -> Iterator[tuple[str, int, _Visit]]:
    name = Reference(variable.name, (), variable.at)
    known = variable.variability in ("parameter", "constant")
    if known and variable.binding is not None:
        text = f"{variable.name} = {render(variable.binding)}"
        yield text, variable.at, _Visit(terms, (name, variable.binding))
    # the front end repeats a parameter's value as its start
    start = None if known and variable.binding is not None else variable.start
    for attribute, value in (
        ("start", start),
        ("min", variable.minimum),
        ("max", variable.maximum),
        ("nominal", variable.nominal),
    ):
        if value is not None:
            yield f"{variable.name}({attribute} = {render(value)})", variable.at, _Visit(terms, (name, value))


def _when(terms: Terms, when: When) -> Iterator[tuple[str, int, _Visit]]:
    for condition, actions in when.branches:
        yield f"when {render(condition)}", when.at, _Visit(terms, condition)
        for action in actions:
            yield from _action(terms, action)


def _action(terms: Terms, action: Action) -> Iterator[tuple[str, int, _Visit]]:
    match action:
        case Assign(target=target, subscripts=subscripts, value=value, at=at):
            name = Reference(target, subscripts, at)
            yield f"{render(name)} = {render(value)}", at, _Visit(terms, (name, value))
        case Reinit(state=state, value=value, at=at):
            yield f"reinit({state}, {render(value)})", at, _Visit(terms, (Reference(state, (), at), value))
        case Assertion(condition=condition, at=at):
            yield f"assert({render(condition)})", at, _Visit(terms, condition)
        case Conditional(branches=branches, otherwise=otherwise, at=at):
            for condition, body in branches:
                yield f"if {render(condition)}", at, _Visit(terms, condition)
                for inner in body:
                    yield from _action(terms, inner)
            for inner in otherwise:
                yield from _action(terms, inner)


def _infer(flat: FlatModel, terms: Terms) -> None:
    """Find units of variables that have none, where an equation leaves no choice: ``v = R*i`` with two units known.

    The first equation in the order of the model decides; one that contradicts it is then reported as a mismatch.
    """
    if not terms.open:
        return
    visits = list(_everything(flat, terms))
    found = True
    while found and terms.open:
        found = False
        for text, at, visit in visits:
            terms.solved.clear()
            visit()
            for name, powers in terms.solved.items():
                if name in terms.open:
                    line = flat.source.place(at).line
                    terms.settle(name, powers, f"line {line}: {text}")
                    found = True
    terms.findings.clear()
