"""Finds what the front end has left out without a word, and which parameters have decided something."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from cosim.modelica._carry import MARK
from cosim.modelica._lost import refuse_lost_modifiers
from cosim.modelica._scan import Scan, Statement, scan
from cosim.modelica.expressions import Expression, children, references
from cosim.modelica.flat import Action, Conditional, FlatModel, Loop, When, While, reads


def completed(flat: FlatModel, flagged: frozenset[str], model_at: int | None) -> FlatModel:
    """The model, with the parameters named whose value has decided which equations, components or elements there are.

    Args:
        flat: the model as read.
        flagged: parameters that the front end takes for structural; that is too many.
        model_at: where the model's own class is in the text.

    Raises:
        ModelError: a when-clause or an assertion of the text is not in the model.
    """
    found = scan(flat.source.text)
    refuse_lost_modifiers(flat.source, found, model_at)
    _check_statements(flat, found, model_at)
    used = _used(flat)
    structural = {
        name
        for name, variable in flat.variables.items()
        if variable.variability == "parameter"
        and (
            (name in flagged and (name not in used or _last(name) in found.deciding))
            or (variable.type != "Real" and _last(name) in found.conditional)
        )
    }
    return replace(flat, structural=frozenset(structural))


def _last(name: str) -> str:
    return name.rpartition(".")[2]


def _used(flat: FlatModel) -> set[str]:
    expressions: list[Expression] = [equation.residual for equation in (*flat.equations, *flat.initial_equations)]
    for variable in flat.variables.values():
        expressions += [e for e in (variable.binding, variable.start) if e is not None]
    expressions += [assertion.condition for assertion in flat.assertions]
    names = {name for expression in expressions for name in references(expression)}
    for algorithm in (*flat.algorithms, *flat.initial_algorithms):
        names |= set(reads(algorithm.statements))
    return names | set(reads(flat.whens))


def _check_statements(flat: FlatModel, found: Scan, model_at: int | None) -> None:
    places = sorted(_places(flat))
    text = flat.source.text.encode()
    classes = {found.class_of(variable.at) for variable in flat.variables.values()}
    if model_at is not None:
        classes.add(found.class_of(model_at))
    for statement in found.statements:
        if statement.kind == "connect" and "if" in statement.inside and statement.class_at in classes:
            raise flat.source.error(
                "connect inside an if-equation is not supported; make one of the components conditional instead,"
                " as in: Component c if condition",
                statement.at,
            )
        if statement.kind not in ("when", "assert", "terminate") or statement.class_at not in classes:
            continue
        if statement.kind != "when" and MARK.encode() in text[statement.at : statement.end]:
            continue
        if statement.class_kind == "function" or any(statement.at <= place < statement.end for place in places):
            continue
        raise flat.source.error(_left_out(statement), statement.at)


def _left_out(statement: Statement) -> str:
    if "if" in statement.inside:
        what = "when c and condition then" if statement.kind == "when" else "assert(condition or not c, ...)"
        return (
            f"{statement.kind} inside an if-equation is not supported; put the condition c of the if into it,"
            f" as {what}, and take it out"
        )
    return f"the Modelica front end has left this {statement.kind} out; write it in another way"


def _places(flat: FlatModel) -> Iterator[int]:
    yield from (assertion.at for assertion in flat.assertions)
    for when in flat.whens:
        yield when.at
        for condition, actions in when.branches:
            yield from _expression_places(condition)
            yield from _action_places(actions)
    for algorithm in (*flat.algorithms, *flat.initial_algorithms):
        yield from _action_places(algorithm.statements)


def _expression_places(expression: Expression) -> Iterator[int]:
    yield expression.at
    for child in children(expression):
        yield from _expression_places(child)


def _action_places(actions: tuple[Action | When, ...]) -> Iterator[int]:
    for action in actions:
        yield action.at
        if isinstance(action, Conditional):
            for body in (*(body for _, body in action.branches), action.otherwise):
                yield from _action_places(body)
        elif isinstance(action, Loop | While):
            yield from _action_places(action.body)
