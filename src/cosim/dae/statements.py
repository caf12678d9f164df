"""Runs statements on CasADi values: assignments, conditions, loops; the way functions and algorithms are inlined.

What has no value yet is NaN, so that a value that is missing in only some cases is missing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import casadi as ca

from cosim.dae.hybrid import SX, Check
from cosim.dae.symbols import Evaluate
from cosim.dae.texts import text
from cosim.modelica.expressions import Literal, Reference, render
from cosim.modelica.flat import Action, Assertion, Assign, Assigns, Conditional, Loop, Reinit, Return, Terminate, While

State = dict[str, SX]
_MOST_TURNS = 10_000


@dataclass(frozen=True)
class _Step:
    """A statement, and the loop indices around it."""

    action: Action
    indices: Mapping[str, SX]


def missing(value: SX) -> bool:
    """Whether a value, or an element of it, has not been assigned in every case."""
    return any(e.is_constant() and math.isnan(float(e)) for e in ca.vertsplit(ca.vec(value)))


def nothing(*shape: int) -> SX:
    """What a variable has before it is assigned."""
    return SX(ca.DM.nan(*shape))


Effect = Callable[[Action, Evaluate], None]


def run(evaluate: Evaluate, statements: Sequence[Action], state: State, effect: Effect | None = None) -> State:
    """Run statements one after another.

    Args:
        evaluate: evaluates the expressions.
        statements: the actions.
        state: the values of all variables that are assigned, before.
        effect: does what reinit, terminate and assert ask for, with an evaluator that knows what has been assigned so
            far, and its ``path``; without it, reinit and terminate are refused.

    Returns:
        The values of these variables after.

    Raises:
        ModelError: a statement cannot be inlined, by name and place.
    """
    runner = _Run(evaluate, effect)
    runner.tracks = any(missing(value) for value in state.values())
    return runner.run([_Step(action, {}) for action in statements], dict(state), evaluate.path)


class _Run:
    def __init__(self, evaluate: Evaluate, effect: Effect | None) -> None:
        self._evaluate = evaluate
        self._effect = effect
        self._turns = 0
        self.tracks = True
        """Whether anything had no value at the start."""

    def run(self, steps: list[_Step], state: State, path: SX | None) -> State:
        """``path`` is the condition under which control gets here, ``None`` if it always does."""
        pending = list(reversed(steps))
        while pending:
            step = pending.pop()
            match step.action:
                case Assign():
                    self._assign(step, state, path)
                case Assigns(targets=targets):
                    before = dict(state)
                    for target in targets:
                        if target is not None:
                            after = dict(before)
                            self._assign(_Step(target, step.indices), after, path)
                            state |= {name: value for name, value in after.items() if value is not before.get(name)}
                case Conditional() if any(map(_returns, _bodies(step.action))):
                    return self._conditional(step, list(reversed(pending)), state, path)
                case Conditional():
                    state = self._conditional(step, [], state, path)
                case Loop(index=index, domain=domain, body=body):
                    for k in reversed(self._at(step, state, path).indices(domain)):
                        pending += [_Step(a, {**step.indices, index: SX(k)}) for a in reversed(body)]
                case While(body=body):
                    if self._goes_on(step, state, path):
                        pending.append(step)
                        pending += [_Step(action, step.indices) for action in reversed(body)]
                case Return():
                    return state
                case Assertion() | Reinit() | Terminate() if self._effect is not None:
                    self._effect(step.action, self._at(step, state, path))
                case Assertion():
                    self._assert(step, state, path)
                case Reinit(at=at) | Terminate(at=at):
                    raise self._error("reinit() and terminate() have a place only inside when", at)
        return state

    def _at(self, step: _Step, state: State, path: SX | None) -> Evaluate:
        evaluate = self._evaluate
        return evaluate.alike(locals={**evaluate.locals, **state, **step.indices}, path=path)

    def _error(self, message: str, at: int) -> Exception:
        return self._evaluate.error(message, Literal(0, at))

    def _goes_on(self, step: _Step, state: State, path: SX | None) -> bool:
        assert isinstance(step.action, While)
        condition = self._at(step, state, path)(step.action.condition)
        self._turns += 1
        if not condition.is_constant() or self._turns > _MOST_TURNS:
            raise self._error(
                f"while {render(step.action.condition)}: how often a while-loop turns must be known when the model is"
                " compiled; use a for-loop with a fixed range and if inside it",
                step.action.at,
            )
        return float(condition) != 0.0

    def _assign(self, step: _Step, state: State, path: SX | None) -> None:
        action = step.action
        assert isinstance(action, Assign)
        evaluate = self._at(step, state, path)
        components = evaluate.components(action.value) if not action.subscripts else None
        if components is not None:
            for component in components:
                state[f"{action.target}.{component}"] = evaluate.component(action.value, component)
            return
        value = evaluate(action.value)
        before = state.get(action.target)
        if not action.subscripts:
            if before is not None and before.numel() != value.numel():
                message = f"{action.target} has {before.numel()} elements but is assigned {value.numel()}"
                raise self._error(message, action.at)
            # a matrix of one row and a vector have the same elements
            state[action.target] = value if before is None else ca.reshape(value, *before.shape)
            return
        if action.target not in state:
            raise self._error(f"{action.target} is not known here", action.at)
        whole = SX(state[action.target])
        numbers = ca.reshape(SX(ca.DM(list(range(whole.numel())))), *whole.shape)
        node = Reference(action.target, action.subscripts, action.at)
        chosen = evaluate.alike(locals={**evaluate.locals, action.target: numbers})(node)
        if value.numel() not in (1, chosen.numel()):
            message = f"{render(node)} has {chosen.numel()} elements but is assigned {value.numel()}"
            raise self._error(message, action.at)
        for position, number in enumerate(ca.vertsplit(ca.vec(chosen))):
            new = value[position if value.numel() > 1 else 0]
            if number.is_constant():
                whole[int(number)] = new
                continue
            self._check(number >= 0, f"the index in {render(node)} is out of range", True, action.at, path)
            for k in range(whole.numel()):
                whole[k] = ca.if_else(number == k, new, whole[k])
        state[action.target] = whole

    def _conditional(self, step: _Step, rest: list[_Step], state: State, path: SX | None) -> State:
        """Run the branches, each with ``rest`` behind it, and put the outcomes together."""
        action = step.action
        assert isinstance(action, Conditional)
        outcomes: list[tuple[SX, State]] = []
        otherwise = SX(1.0) if path is None else path
        last = action.otherwise
        for expression, body in action.branches:
            condition = self._at(step, state, path)(expression)
            if condition.is_constant() and float(condition) == 0.0:
                continue
            if condition.is_constant():
                last = body
                break
            inside = ca.logic_and(otherwise, condition)
            steps = [_Step(inner, step.indices) for inner in body]
            outcomes.append((condition, self.run([*steps, *rest], dict(state), inside)))
            otherwise = ca.logic_and(otherwise, ca.logic_not(condition))
        steps = [_Step(inner, step.indices) for inner in last]
        result = self.run([*steps, *rest], dict(state), otherwise if outcomes else path)
        for condition, branch in reversed(outcomes):
            result = _merged(condition, branch, result, self.tracks)
        return result

    def _assert(self, step: _Step, state: State, path: SX | None) -> None:
        action = step.action
        assert isinstance(action, Assertion)
        evaluate = self._at(step, state, path)
        condition = evaluate.alike(no_event=True)(action.condition)
        self._check(condition, text(evaluate, action.message), action.is_error, action.at, path)

    def _check(self, condition: SX, message: str, is_error: bool, at: int, path: SX | None) -> None:
        if path is not None:
            condition = ca.logic_or(condition, ca.logic_not(path))
        if condition.is_constant() and float(condition) == 0.0 and is_error:
            raise self._error(f"an assertion is violated: {message}", at)
        checks = self._evaluate.checks if self._evaluate.checks is not None else self._evaluate.symbols.system.checks
        if not condition.is_constant() and not any(
            check.at == at and ca.is_equal(check.condition, condition, 50) for check in checks
        ):
            checks.append(Check(condition, message, is_error, at))


def _returns(actions: Sequence[Action]) -> bool:
    return any(
        isinstance(action, Return)
        or (isinstance(action, Conditional) and any(_returns(body) for body in _bodies(action)))
        or (isinstance(action, Loop | While) and _returns(action.body))
        for action in actions
    )


def _bodies(action: Conditional) -> Iterator[tuple[Action, ...]]:
    yield from (body for _, body in action.branches)
    yield action.otherwise


def _merged(condition: SX, yes: State, no: State, tracks: bool) -> State:
    """What variables have after an if; with ``tracks``, an element that is missing in one case is missing."""
    result: State = {}
    for name in yes:
        if name not in no:
            continue
        a, b = yes[name], no[name]
        if a is b or (a.shape == b.shape and ca.is_equal(a, b, 1)):
            result[name] = a
        elif a.shape != b.shape:
            result[name] = nothing()
        elif tracks and (missing(a) or missing(b)):
            pairs = zip(ca.vertsplit(ca.vec(a)), ca.vertsplit(ca.vec(b)), strict=True)
            elements = [nothing() if missing(x) or missing(y) else ca.if_else(condition, x, y) for x, y in pairs]
            result[name] = ca.reshape(ca.vertcat(*elements), *a.shape)
        else:
            result[name] = ca.if_else(condition, a, b)
    return result
