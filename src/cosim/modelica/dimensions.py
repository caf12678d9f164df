"""Checks that both sides of every equation, and all terms of every sum, have the same unit.

The rule is written down in docs/units.md; the algebra of units is in ``quantity.py``.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from cosim.errors import ModelError
from cosim.modelica._terms import Finding, Terms
from cosim.modelica.expressions import Binary, Expression, Reference, references, render, render_equation
from cosim.modelica.flat import (
    Action,
    Assertion,
    Assign,
    Assigns,
    Conditional,
    FlatModel,
    Function,
    Loop,
    Reinit,
    Variable,
    When,
    While,
)
from cosim.modelica.quantity import NUMBER, Quantity

Scope = Mapping[str, Quantity]
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
    for text, at, visit, joined in _Everything(flat, terms):
        terms.findings.clear()
        visit()
        for finding in dict.fromkeys(terms.findings):
            # a connection's own place is that of the variable in the connector's class
            connect = None if joined is None else terms.units.connection(joined, flat.variables)
            key = connect or finding.at or at, finding.units
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

    def __init__(self, terms: Terms, scope: Scope, pairs: Sequence[tuple[Expression, Expression] | Expression]) -> None:
        self._terms = terms
        self._scope = scope
        self._pairs = pairs

    def __call__(self) -> None:
        self._terms.scope = self._scope
        for pair in self._pairs:
            if isinstance(pair, tuple):
                self._terms.same(*pair)
            else:
                self._terms.quantity(pair)
        self._terms.scope = {}


_Item = tuple[str, int, _Visit, frozenset[str] | None]
"""Text, place, check, and what it joins if it follows from a connection."""


class _Everything:
    """Everything in a model that has units: text, place and check of each."""

    def __init__(self, flat: FlatModel, terms: Terms) -> None:
        self._flat = flat
        self._terms = terms
        self._scope: Scope = {}

    def __iter__(self) -> Iterator[_Item]:
        flat = self._flat
        for variable in flat.variables.values():
            yield from self._declaration(variable)
        for equation in (*flat.equations, *flat.initial_equations):
            text, at, visit, _ = self._item(render_equation(equation.residual), equation.at, _sides(equation.residual))
            connected = equation.origin.startswith(("Connection", "FlowSum"))
            yield text, at, visit, frozenset(references(equation.residual)) if connected else None
        yield from self._actions((*flat.whens, *flat.assertions))
        for algorithm in (*flat.algorithms, *flat.initial_algorithms):
            yield from self._actions(algorithm.statements)
        # a function is there under each name by which it is called
        for function in {function.at: function for function in flat.functions.values()}.values():
            yield from self._function(function)

    def _item(self, text: str, at: int, *pairs: tuple[Expression, Expression] | Expression) -> _Item:
        return text, at, _Visit(self._terms, self._scope, pairs), None

    def _declaration(self, variable: Variable) -> Iterator[_Item]:
        name = Reference(variable.name, (), variable.at)
        known = variable.variability in ("parameter", "constant")
        if known and variable.binding is not None:
            yield self._item(f"{variable.name} = {render(variable.binding)}", variable.at, (name, variable.binding))
        # the front end repeats a parameter's value as its start
        start = None if known and variable.binding is not None else variable.start
        for attribute, value in (
            ("start", start),
            ("min", variable.minimum),
            ("max", variable.maximum),
            ("nominal", variable.nominal),
        ):
            if value is not None:
                yield self._item(f"{variable.name}({attribute} = {render(value)})", variable.at, (name, value))

    def _function(self, function: Function) -> Iterator[_Item]:
        if function.is_constructor:
            return
        self._scope = self._terms.own(function)
        for variable in (*function.inputs, *function.outputs, *function.locals):
            if variable.value is not None:
                name = Reference(variable.name, (), variable.at)
                yield self._item(f"{variable.name} = {render(variable.value)}", variable.at, (name, variable.value))
        yield from self._actions(function.body)
        self._scope = {}

    def _actions(self, actions: Sequence[Action | When]) -> Iterator[_Item]:
        for action in actions:
            yield from self._action(action)

    def _action(self, action: Action | When) -> Iterator[_Item]:
        match action:
            case Assign(target=target, subscripts=subscripts, value=value, at=at):
                name = Reference(target, subscripts, at)
                yield self._item(f"{render(name)} = {render(value)}", at, (name, value))
            case Assigns(targets=targets):
                yield from self._actions([target for target in targets if target is not None])
            case Reinit(state=state, value=value, at=at):
                yield self._item(f"reinit({state}, {render(value)})", at, (Reference(state, (), at), value))
            case Assertion(condition=condition, at=at):
                yield self._item(f"assert({render(condition)})", at, condition)
            case When(branches=branches, at=at):
                for condition, body in branches:
                    yield self._item(f"when {render(condition)}", at, condition)
                    yield from self._actions(body)
            case Conditional(branches=branches, otherwise=otherwise, at=at):
                for condition, body in branches:
                    yield self._item(f"if {render(condition)}", at, condition)
                    yield from self._actions(body)
                yield from self._actions(otherwise)
            case While(condition=condition, body=body, at=at):
                yield self._item(f"while {render(condition)}", at, condition)
                yield from self._actions(body)
            case Loop(index=index, body=body):
                outside, self._scope = self._scope, {**self._scope, index: NUMBER}
                yield from self._actions(body)
                self._scope = outside


def _sides(residual: Expression) -> tuple[Expression, Expression] | Expression:
    return (residual.left, residual.right) if isinstance(residual, Binary) and residual.operator == "-" else residual


def _infer(flat: FlatModel, terms: Terms) -> None:
    """Find units of variables that have none, where an equation leaves no choice: ``v = R*i`` with two units known.

    The first equation in the order of the model decides; one that contradicts it is then reported as a mismatch.
    """
    if not terms.open:
        return
    visits = list(_Everything(flat, terms))
    found = True
    while found and terms.open:
        found = False
        for text, at, visit, _ in visits:
            terms.solved.clear()
            visit()
            for name, powers in terms.solved.items():
                if name in terms.open:
                    line = flat.source.place(at).line
                    terms.settle(name, powers, f"line {line}: {text}")
                    found = True
    terms.findings.clear()
