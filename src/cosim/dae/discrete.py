"""The discrete part: when-clauses and equations of discrete variables become assignments in a computable order."""

from __future__ import annotations

import graphlib

import casadi as ca
import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import maximum_bipartite_matching

from cosim.dae.array_functions import reduce
from cosim.dae.evaluate import Evaluator
from cosim.dae.hybrid import SX, Assignment, Check, Reinit
from cosim.dae.statements import run
from cosim.dae.symbols import Evaluate, Mode, Symbols, declare_held, element_names
from cosim.dae.texts import text
from cosim.errors import ModelError
from cosim.modelica import flat as fm
from cosim.modelica.expressions import Array, Binary, Call, Expression, If, Reference, render, render_equation


def lower_discrete(symbols: Symbols, known: list[Assignment]) -> tuple[list[Assignment], set[fm.Equation]]:
    """Fill ``system.reinits`` and ``terminations``; returns the assignments, in any order, and the equations used up.

    ``known`` are assignments of algorithm sections, which are among those returned.

    Raises:
        ModelError: a discrete variable has no equation or two.
    """
    assignments = list(known)
    for when in symbols.flat.whens:
        assignments += _When(symbols, when).lower()
    assigned = {target for assignment in assignments for target in assignment.targets}
    used, equations = _equations(symbols, assigned)
    return assignments + equations, used


def order_discrete(symbols: Symbols, assignments: list[Assignment]) -> None:
    """Fill ``system.assignments``, the integers that the continuous equations hold with them.

    Raises:
        ModelError: discrete equations need each other's result.
    """
    held = [Assignment((h.name,), h.value, None, f"{h.name} = {h.text}", h.at) for h in symbols.held]
    symbols.system.assignments = _ordered(symbols, assignments + held)


class _When:
    """Lowers one when-clause."""

    def __init__(self, symbols: Symbols, when: fm.When) -> None:
        self._symbols = symbols
        self._system = symbols.system
        self._when = when
        self._extra: list[Assignment] = []
        self._checks: list[Check] = []
        """Assertions inside functions that the actions call."""
        self._conditions: dict[str, SX] = {}
        """For targets of ``x = if condition then ... else pre(x)``, the condition."""

    def lower(self) -> list[Assignment]:
        actives: list[SX] = []
        values: list[dict[str, SX]] = []
        for condition, actions in self._when.branches:
            active = self._active(condition)
            for earlier in actives:
                active = ca.logic_and(active, ca.logic_not(earlier))
            actives.append(active)
            self._checks.clear()
            if self._when.sequential:
                values.append(self._sequential(actions, active))
            else:
                values.append(self._equations(actions))
                self._effects(actions, active)
            for check in self._checks:
                self._at_event(check, active)
        return self._extra + self._assignments(actives, values)

    def _assignments(self, actives: list[SX], values: list[dict[str, SX]]) -> list[Assignment]:
        result = []
        targets = dict.fromkeys(target for branch in values for target in branch)
        for target in targets:
            variable = self._symbols.flat.variables[target]
            pre = self._symbols.pre[target]
            guard = SX(0.0)
            value = pre
            for active, branch in reversed(list(zip(actives, values, strict=True))):
                if target in branch:
                    chosen = branch[target]
                    value = chosen if len(actives) == 1 else ca.if_else(active, chosen, value)
                    guard = active if len(actives) == 1 else ca.logic_or(active, guard)
            if target in self._conditions:
                guard = ca.logic_and(guard, self._conditions[target])
            names = tuple(element_names(target, variable.dimensions))
            value = ca.vec(value)
            if value.numel() == 1 and len(names) > 1:
                value = ca.repmat(value, len(names), 1)
            if value.numel() != len(names):
                raise self._symbols.flat.source.error(
                    f"{target} has {len(names)} elements but is assigned {value.numel()}", self._when.at
                )
            result.append(Assignment(names, value, guard, f"when: {target}", self._when.at))
        return result

    def _active(self, condition: Expression) -> SX:
        """True in the pass in which the condition becomes true."""
        if isinstance(condition, Array):
            active = SX(0.0)
            for element in condition.elements:
                active = ca.logic_or(active, self._active(element))
            return active
        value = Evaluator(self._symbols, Mode.DISCRETE)(condition)
        if isinstance(condition, Call) and condition.function in ("sample", "initial", "terminal"):
            return value
        became = [self._became_true(element, render(condition)) for element in ca.vertsplit(ca.vec(value))]
        return reduce(ca.logic_or, became)

    def _became_true(self, value: SX, condition: str) -> SX:
        name = f"$when{sum(n.startswith('$when') for n in self._system.discretes) + 1}"
        declare_held(self._symbols, name, "Boolean")
        self._extra.append(Assignment((name,), value, None, f"{name} = {condition}", self._when.at))
        # during initialisation only initial() makes a when-clause act (Modelica 8.6)
        before = ca.logic_or(self._symbols.pre[name], self._system.initial)
        return ca.logic_and(self._symbols.new[name], ca.logic_not(before))

    def _equations(self, actions: tuple[fm.Action, ...]) -> dict[str, SX]:
        evaluate = self._evaluator()
        values: dict[str, SX] = {}
        for action in actions:
            if isinstance(action, fm.Assign):
                self._once(values, action.target, action.at)
                keeping, chosen = self._lasting(action)
                if keeping is not None:
                    self._conditions[action.target] = evaluate(keeping)
                values[action.target] = evaluate(chosen)
            elif isinstance(action, fm.Conditional):
                branches = [self._unconditionally(body) for _, body in action.branches]
                otherwise = self._unconditionally(action.otherwise)
                conditions = [evaluate(condition) for condition, _ in action.branches]
                for target in dict.fromkeys(t for branch in (*branches, otherwise) for t in branch):
                    self._once(values, target, action.at)
                    value = otherwise.get(target, self._symbols.pre[target])
                    for condition, branch in reversed(list(zip(conditions, branches, strict=True))):
                        value = ca.if_else(condition, branch.get(target, self._symbols.pre[target]), value)
                    values[target] = value
        return values

    def _unconditionally(self, actions: tuple[fm.Action, ...]) -> dict[str, SX]:
        """The values inside an if, where the condition of the if is what keeps the others."""
        inner = _When(self._symbols, self._when)
        inner._checks = self._checks
        values = inner._equations(actions)
        for target, condition in inner._conditions.items():
            values[target] = ca.if_else(condition, values[target], self._symbols.pre[target])
        return values

    def _lasting(self, action: fm.Assign) -> tuple[Expression | None, Expression]:
        """Take ``if c then a else pre(x)``, assigned to x, apart, so that a is computed only where c holds."""
        match action.value:
            case If(
                branches=((condition, value),),
                otherwise=Call(function="pre", arguments=(Reference(name=name, subscripts=()),)),
            ) if name == action.target and len(self._when.branches) == 1:
                return condition, value
        return None, action.value

    def _once(self, values: dict[str, SX], target: str, at: int) -> None:
        variable = self._symbols.flat.variables.get(target)
        if variable is None or target not in self._symbols.new:
            raise self._symbols.flat.source.error(f"{target} is assigned in when but is not a discrete variable", at)
        if target in values:
            raise self._symbols.flat.source.error(f"{target} is assigned twice in one when-clause", at)

    def _evaluator(self) -> Evaluator:
        return Evaluator(self._symbols, Mode.SAMPLED, checks=self._checks)

    def _sequential(self, actions: tuple[fm.Action, ...], active: SX) -> dict[str, SX]:
        """Run the statements of an algorithm; a variable assigned there starts from its pre-value."""
        state: dict[str, SX] = {}
        for target in fm.targets(actions):
            self._once({}, target, self._when.at)
            state[target] = self._symbols.pre[target]

        def effect(action: fm.Action, evaluate: Evaluate) -> None:
            self._effect(action, evaluate, active if evaluate.path is None else ca.logic_and(active, evaluate.path))

        return run(self._evaluator(), actions, state, effect)

    def _effects(self, actions: tuple[fm.Action, ...], active: SX) -> None:
        evaluate = self._evaluator()
        for action in actions:
            if isinstance(action, fm.Conditional):
                rest = active
                for condition, body in action.branches:
                    holds = evaluate(condition)
                    self._effects(body, ca.logic_and(rest, holds))
                    rest = ca.logic_and(rest, ca.logic_not(holds))
                self._effects(action.otherwise, rest)
            else:
                self._effect(action, evaluate, active)

    def _effect(self, action: fm.Action, evaluate: Evaluate, active: SX) -> None:
        """What reinit, assert and terminate ask for; ``active`` is the condition."""
        if isinstance(action, fm.Reinit):
            if action.state not in self._system.unknowns:
                message = f"reinit({action.state}): not a continuous variable"
                raise self._symbols.flat.source.error(message, action.at)
            self._system.reinits.append(Reinit(action.state, evaluate(action.value), active, action.at))
        elif isinstance(action, fm.Assertion):
            check = Check(evaluate(action.condition), text(evaluate, action.message), action.is_error, action.at)
            self._at_event(check, active)
        elif isinstance(action, fm.Terminate):
            self._system.terminations.append((active, text(evaluate, action.message)))

    def _at_event(self, check: Check, active: SX) -> None:
        """An assertion that counts only when ``active``: a Boolean keeps the outcome up to the next time."""
        name = f"$violated{sum(n.startswith('$violated') for n in self._system.discretes) + 1}"
        declare_held(self._symbols, name, "Boolean")
        violated = ca.logic_not(check.condition)
        self._extra.append(Assignment((name,), violated, active, f"{name}: {check.message}", check.at))
        holds = ca.logic_not(self._symbols.values[name])
        self._system.checks.append(Check(holds, check.message, check.is_error, check.at))


def _equations(symbols: Symbols, assigned: set[str]) -> tuple[set[fm.Equation], list[Assignment]]:
    """Equations outside when that define a discrete variable: ``b = expression`` either way round."""
    flat = symbols.flat
    open_names = [name for name in flat.variables if name in symbols.new and not name.startswith("$")]
    open_names = [n for n in open_names if not set(element_names(n, flat.variables[n].dimensions)) & assigned]
    candidates: list[tuple[fm.Equation, list[str]]] = []
    for equation in flat.equations:
        sides = _sides(equation)
        names = [s.name for s in sides if isinstance(s, Reference) and not s.subscripts and s.name in symbols.new]
        names = [name for name in names if name in open_names]
        if names:
            candidates.append((equation, names))
    rows, columns = [], []
    for row, (_, names) in enumerate(candidates):
        for name in names:
            rows.append(row)
            columns.append(open_names.index(name))
    matrix = csr_matrix((np.ones(len(rows)), (rows, columns)), shape=(len(candidates), max(1, len(open_names))))
    match = maximum_bipartite_matching(matrix, perm_type="column") if candidates else np.array([], int)
    result = []
    for (equation, _), column in zip(candidates, match, strict=True):
        if column < 0:
            raise flat.source.error(
                f"{render_equation(equation.residual)}: every discrete variable in it is defined elsewhere", equation.at
            )
        name = open_names[column]
        left, right = _sides(equation)
        value_side = right if isinstance(left, Reference) and left.name == name else left
        value = ca.vec(Evaluator(symbols, Mode.DISCRETE)(value_side))
        names_of = tuple(element_names(name, flat.variables[name].dimensions))
        text = render_equation(equation.residual)
        result.append(Assignment(names_of, value, None, text, equation.at))
    defined = {name for assignment in result for name in assignment.targets}
    for name in open_names:
        if not set(element_names(name, flat.variables[name].dimensions)) & defined:
            raise flat.source.error(f"{name} is discrete, but no equation or when-clause gives it a value",
                                    flat.variables[name].at)  # fmt: skip
    return {equation for equation, _ in candidates}, result


def _sides(equation: fm.Equation) -> tuple[Expression, ...]:
    residual = equation.residual
    return (residual.left, residual.right) if isinstance(residual, Binary) and residual.operator == "-" else (residual,)


def _ordered(symbols: Symbols, assignments: list[Assignment]) -> list[Assignment]:
    """Sort so that each assignment uses only new values that are there already; equal guards stay together."""
    writer = {target: index for index, a in enumerate(assignments) for target in a.targets}
    needs: dict[int, set[int]] = {}
    for index, assignment in enumerate(assignments):
        read = {s.name() for s in ca.symvar(assignment.values)}
        if assignment.guard is not None:
            read |= {s.name() for s in ca.symvar(assignment.guard)}
        names = {name[4:-1] for name in read if name.startswith("new(")}
        needs[index] = {writer[name] for name in names if name in writer}
        for name in names:
            if name not in writer:
                raise _no_value(symbols, name)
    sorter = graphlib.TopologicalSorter(needs)
    try:
        sorter.prepare()
    except graphlib.CycleError as error:
        ring = [assignments[i] for i in dict.fromkeys(error.args[1])]
        texts = "; ".join(a.text for a in ring)
        raise symbols.flat.source.error(
            f"these discrete equations need each other's result: {texts}; use pre() to break the ring", ring[0].at
        ) from None
    ready: list[int] = []
    result: list[Assignment] = []
    while sorter.is_active():
        ready = sorted([*ready, *sorter.get_ready()])
        current = result[-1].guard if result else None
        pick = next((i for i in ready if result and _same(assignments[i].guard, current)), ready[0])
        ready.remove(pick)
        result.append(assignments[pick])
        sorter.done(pick)
    return result


def _same(a: SX | None, b: SX | None) -> bool:
    return (a is None and b is None) or (a is not None and b is not None and ca.is_equal(a, b, 20))


def _no_value(symbols: Symbols, name: str) -> ModelError:
    return symbols.flat.source.error(f"{name} is discrete, but no equation or when-clause gives it a value",
                                     symbols.scalars[name].declaration.at)  # fmt: skip
