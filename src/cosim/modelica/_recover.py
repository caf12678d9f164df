"""Makes statements again from the assertions that carried them through the front end; see ``_carry``."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import replace

from cosim.modelica._carry import MARK, Step
from cosim.modelica._kinds import check_assignment
from cosim.modelica._statements import separated
from cosim.modelica.expressions import (
    Array,
    Binary,
    Call,
    Expression,
    Literal,
    Output,
    Reference,
    Unary,
    UserCall,
    calls,
    children,
)
from cosim.modelica.flat import (
    Action,
    Algorithm,
    Assertion,
    Assign,
    Assigns,
    Conditional,
    FlatModel,
    Reinit,
    Terminate,
    When,
    reads,
    targets,
)

_Queues = dict[tuple[int, str], deque[Assertion]]


def recover(flat: FlatModel, steps: dict[int, Step]) -> FlatModel:
    """The flat model with its statements in place of the assertions that carried them.

    Raises:
        ModelError: a when-clause of an equation section uses a new value that it assigns itself.
    """
    recovery = _Recovery(flat, steps)
    whens = [recovery.when(when) for when in flat.whens]
    algorithms = [recovery.section(list(section)) for section in _sections(flat.assertions, steps)]
    variables = dict(flat.variables)
    for target in targets(tuple(whens)):
        if target in variables:
            variables[target] = replace(variables[target], variability="discrete")
    return replace(
        flat,
        variables=variables,
        whens=tuple(whens),
        algorithms=(*flat.algorithms, *(a for a in algorithms if a.statements)),
        assertions=tuple(a for a in flat.assertions if _mark(a) is None),
    )


def _mark(assertion: Assertion) -> tuple[int, str] | None:
    """Number of the statement that an assertion carries, and which part of it."""
    message = assertion.message
    while isinstance(message, Binary):
        message = message.left
    if not (isinstance(message, Literal) and isinstance(message.value, str) and message.value.startswith(MARK)):
        return None
    number, part = message.value.removeprefix(MARK).split(":")[:2]
    return int(number), part


def _sections(assertions: Iterable[Assertion], steps: dict[int, Step]) -> Iterator[list[Assertion]]:
    """The assertions of each algorithm section of each component."""
    current: list[Assertion] = []
    for assertion in assertions:
        mark = _mark(assertion)
        if mark is None:
            continue
        if mark[1] == "begin" and steps[mark[0]].kind == "section":
            if current:
                yield current
            current = []
        current.append(assertion)
    if current:
        yield current


def _carried(assertion: Assertion) -> Expression:
    size = next(calls(assertion.condition, "size"))
    array = size.arguments[0]
    assert isinstance(array, Array)
    return array.elements[0]


class _Recovery:
    def __init__(self, flat: FlatModel, steps: dict[int, Step]) -> None:
        self._flat = flat
        self._steps = steps
        self._queues: _Queues = {}
        self._whens: dict[int, deque[When]] = {}

    def _fill(self, assertions: Iterable[Assertion]) -> None:
        self._queues = {}
        for assertion in assertions:
            mark = _mark(assertion)
            if mark is not None:
                self._queues.setdefault(mark, deque()).append(assertion)

    def section(self, assertions: list[Assertion]) -> Algorithm:
        """An algorithm section; its when-statements are among the when-clauses already."""
        self._fill(assertions)
        mark = _mark(assertions[0])
        assert mark is not None
        statements: list[Action | When] = []
        for step in self._steps[mark[0]].bodies[0]:
            if step.kind == "when":
                statements.append(self._whens[step.number].popleft())
            else:
                statements += self._statement(step, {})
        return separated(self._flat.source, statements, assertions[0].message.at)[0]

    def when(self, when: When) -> When:
        """A when-clause with its statements."""
        branches, step = [], None
        for condition, actions in when.branches:
            carriers = [action for action in actions if isinstance(action, Assertion) and _mark(action)]
            mark = _mark(carriers[0]) if carriers else None
            if mark is None:
                branches.append((condition, actions))
                continue
            self._fill(carriers)
            step = self._steps[mark[0]]
            body = step.bodies[int(mark[1].removeprefix("branch"))]
            branches.append((condition, self._statements(body, {})))
        if step is None:
            return when
        result = When(tuple(branches), sequential=True, at=when.at)
        if step.in_algorithm:
            self._whens.setdefault(step.number, deque()).append(result)
        else:
            self._check_order(result)
        return result

    def _check_order(self, when: When) -> None:
        """In an equation section the order must not matter; what the equations assign is not to be used in them."""
        for _, actions in when.branches:
            assigned = set(targets(actions))
            for action in actions:
                used = sorted(assigned & set(_current(action)))
                if used:
                    raise self._flat.source.error(
                        f"{used[0]} is assigned in this when-clause, and its new value used; where elements of arrays"
                        " are assigned, too, write an algorithm section, in which the order counts",
                        action.at,
                    )

    def _statements(self, steps: list[Step], indices: dict[str, float]) -> tuple[Action, ...]:
        found: list[Action] = []
        for step in steps:
            found += self._statement(step, indices)
        return tuple(found)

    def _take(self, step: Step, part: str) -> Assertion:
        return self._queues[step.number, part].popleft()

    def _value(self, step: Step, part: str) -> Expression:
        return _carried(self._take(step, part))

    def _statement(self, step: Step, indices: dict[str, float]) -> list[Action]:
        match step.kind:
            case "assign":
                left = self._reference(step, "left")
                assign = Assign(left.name, left.subscripts, self._value(step, "right"), left.at)
                check_assignment(self._flat, assign)
                return [assign]
            case "call":
                return [self._call(step)]
            case "if":
                conditions = [self._value(step, f"condition{k}") for k in range(len(step.bodies) - 1)]
                bodies = [self._statements(body, indices) for body in step.bodies]
                branches = tuple(zip(conditions, bodies[:-1], strict=True))
                return [Conditional(branches, bodies[-1], conditions[0].at)]
            case "for":
                return self._loop(step, indices)
            case "reinit":
                left = self._reference(step, "left")
                return [Reinit(left.name, self._value(step, "right"), left.at)]
            case "assert":
                condition, message = self._value(step, "right"), self._message(step)
                return [Assertion(condition, message, not step.is_warning, message.at)]
            case "terminate":
                message = self._message(step)
                return [Terminate(message, message.at)]
        return []

    def _reference(self, step: Step, part: str) -> Reference:
        assertion = self._take(step, part)
        left = _carried(assertion)
        if not isinstance(left, Reference):
            raise self._flat.source.error("only a variable can be assigned", assertion.message.at)
        return left

    def _call(self, step: Step) -> Assigns:
        right = self._value(step, "right")
        if not isinstance(right, UserCall):
            raise self._flat.source.error("only a function can give several values", right.at)
        found: list[Assign | None] = []
        for position, kept in enumerate(step.outputs):
            if not kept:
                found.append(None)
                continue
            left = self._reference(step, f"left{position}")
            assign = Assign(left.name, left.subscripts, Output(right, position, right.at), left.at)
            check_assignment(self._flat, assign)
            found.append(assign)
        return Assigns(tuple(found), right.at)

    def _message(self, step: Step) -> Expression:
        message = self._take(step, "message").message
        assert isinstance(message, Binary)
        return _without_mark(message)

    def _loop(self, step: Step, indices: dict[str, float]) -> list[Action]:
        """All turns one after another; each has told the values of the indices."""
        found: list[Action] = []
        names = [part for number, part in self._queues if number == step.number]
        while self._queues.get((step.number, names[0]) if names else (0, "")):
            values = {name: self._queues[step.number, name][0] for name in names}
            numbers = {name: _number(_carried(assertion)) for name, assertion in values.items()}
            if any(numbers.get(name) != value for name, value in indices.items()):
                break
            for name in names:
                self._queues[step.number, name].popleft()
            found += self._statements(step.bodies[0], numbers)
        return found


def _without_mark(message: Binary) -> Expression:
    if isinstance(message.left, Literal):
        return message.right
    assert isinstance(message.left, Binary)
    return replace(message, left=_without_mark(message.left))


def _number(value: Expression) -> float:
    if isinstance(value, Unary):
        return -_number(value.operand)
    assert isinstance(value, Literal) and not isinstance(value.value, str)
    return float(value.value)


def _current(action: Action) -> Iterator[str]:
    """The names that an action uses, but for those inside pre()."""
    match action:
        case Assign(subscripts=subscripts, value=value):
            for expression in (value, *subscripts):
                if expression is not None:
                    yield from _outside_pre(expression)
        case Assigns(targets=assigned):
            for target in assigned:
                if target is not None:
                    yield from _current(target)
        case Conditional(branches=branches, otherwise=otherwise):
            for condition, body in branches:
                yield from _outside_pre(condition)
                for inner in body:
                    yield from _current(inner)
            for inner in otherwise:
                yield from _current(inner)
        case _:
            yield from reads((action,))


def _outside_pre(expression: Expression) -> Iterator[str]:
    if isinstance(expression, Call) and expression.function == "pre":
        return
    if isinstance(expression, Reference):
        yield expression.name
    for child in children(expression):
        yield from _outside_pre(child)
