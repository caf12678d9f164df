"""Reads when-clauses, algorithm sections and functions of rumoca's flat tree."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from cosim.modelica._expressions import ExpressionReader, Tree, place, tag
from cosim.modelica.expressions import Expression, Literal, Output, Reference, UserCall
from cosim.modelica.flat import (
    Action,
    Algorithm,
    Assertion,
    Assign,
    Assigns,
    Conditional,
    Function,
    Local,
    Loop,
    Reinit,
    Return,
    Terminate,
    When,
    While,
    reads,
    targets,
)
from cosim.modelica.source import Source


def separated(source: Source, statements: Sequence[Action | When], at: int) -> tuple[Algorithm, list[When]]:
    """An algorithm section without its when-statements, which act at events, and these.

    Raises:
        ModelError: taking the two apart would change what a statement sees.
    """
    whens = [statement for statement in statements if isinstance(statement, When)]
    actions = tuple(statement for statement in statements if not isinstance(statement, When))
    assigned, at_events = list(targets(actions)), set(targets(tuple(whens)))
    wrong = next(iter(whens), None) if at_events & set(assigned) else None
    used: set[str] = set()
    for statement in statements:
        if not isinstance(statement, When):
            used |= set(reads((statement,)))
        elif used & at_events or any(assigned.count(name) > 1 for name in reads((statement,))):
            wrong = statement
    if wrong is not None:
        raise source.error(
            "this algorithm section assigns a variable inside when and uses it outside, or the other way round; put the"
            " when-statement into an algorithm section of its own",
            wrong.at,
        )
    return Algorithm(actions, at), whens


class StatementReader:
    """Reads what acts, at events or in order; refuses, with the place, what it has no reading for."""

    def __init__(self, source: Source, expression: ExpressionReader) -> None:
        """Places are given in ``source``."""
        self._source = source
        self._expression = expression

    # when-clauses of equation sections

    def when(self, chain: Tree) -> When:
        """A when-clause with its elsewhen branches."""
        branches = [chain["first"], *chain["else_when"]]
        return When(
            tuple((self._expression(b["condition"]), self._actions(b["equations"])) for b in branches),
            sequential=False,
            at=place(chain),
        )

    def assertion(self, node: Tree) -> Assertion:
        """``assert``; rumoca gives the level as the number of AssertionLevel's literal, of which ``warning`` is 1."""
        level = self._expression.optional(node.get("level"))
        warning = (isinstance(level, Reference) and level.name.endswith("warning")) or (
            isinstance(level, Literal) and level.value == 1
        )
        if level is not None and not isinstance(level, Literal | Reference):
            raise self._source.error("the level of assert must be AssertionLevel.error or .warning", place(node))
        message = self._expression(node["message"])
        return Assertion(self._expression(node["condition"]), message, not warning, place(node) or message.at)

    def _actions(self, nodes: list[Tree]) -> tuple[Action, ...]:
        return tuple(self._action(node) for node in nodes)

    def _action(self, node: Tree) -> Action:
        variant, content = tag(node)
        at = place(content)
        match variant:
            case "Assign":
                return Assign(content["target"], (), self._expression(content["value"]), at)
            case "Reinit":
                return Reinit(content["state"], self._expression(content["value"]), at)
            case "Assert":  # its place is that of the whole clause
                assertion = self.assertion(content)
                return replace(assertion, at=assertion.message.at)
            case "Terminate":
                message = self._expression(content["message"])
                return Terminate(message, message.at)
            case "Conditional":
                branches = ((self._expression(c), self._actions(body)) for c, body in content["branches"])
                return Conditional(tuple(branches), self._actions(content.get("else_branch") or []), at)
        raise self._source.error(f"{variant} is not supported inside when", at)

    # algorithm sections and functions

    def algorithm(self, node: Tree) -> tuple[Algorithm, list[When]]:
        """An algorithm section: what it computes at all times, and its when-statements, which act at events.

        Raises:
            ModelError: taking the two apart would change what a statement sees.
        """
        statements = [self._statement(statement) for statement in node["statements"]]
        at = place(node) or (statements[0].at if statements else 0)
        return separated(self._source, statements, at)

    def initial_algorithm(self, node: Tree) -> Algorithm:
        """An initial algorithm section."""
        algorithm, whens = self.algorithm(node)
        if whens:
            raise self._source.error("when has no place in an initial algorithm", whens[0].at)
        return algorithm

    def function(self, node: Tree) -> Function:
        """A function or the constructor of a record.

        Raises:
            ModelError: it is external, or has something that is not supported.
        """
        at = place(node)
        if node.get("external"):
            raise self._source.error(
                f"the function {node['name']} is external; functions in C or Fortran are not supported, only Modelica"
                " algorithms",
                at,
            )
        body = tuple(self._statement(statement) for statement in node["body"])
        function = Function(
            name=node["name"],
            inputs=tuple(self._local(variable) for variable in node["inputs"]),
            outputs=tuple(self._local(variable) for variable in node["outputs"]),
            locals=tuple(self._local(variable) for variable in node["locals"]),
            body=tuple(statement for statement in body if not isinstance(statement, When)),
            is_constructor=bool(node.get("is_constructor")),
            at=at,
        )
        names = [variable.name for variable in (*function.inputs, *function.outputs, *function.locals)]
        for name in names:
            if names.count(name) > 1:
                raise self._source.error(
                    f"in the function {function.name}, {name} stands for a variable and for a record's component;"
                    " rename one",
                    at,
                )
        return function

    def _local(self, node: Tree) -> Local:
        dimensions = tuple(self._expression.subscript(shape) for shape in node.get("shape_expr") or ())
        return Local(
            node["name"], node["type_name"], dimensions, self._expression.optional(node.get("default")), place(node)
        )

    def _statements(self, nodes: list[Tree]) -> tuple[Action, ...]:
        return tuple(action for action in map(self._statement, nodes) if not isinstance(action, When))

    def _statement(self, node: Tree) -> Action | When:
        variant, content = tag(node)
        at = place(content) if isinstance(content, dict) else 0
        expression = self._expression
        match variant:
            case "Assignment":
                target, subscripts = self._target(content["comp"])
                return Assign(target, subscripts, expression(content["value"]), place(content["comp"]))
            case "FunctionCall" if content.get("outputs"):
                return self._assigns(content, at)
            case "If":
                branches = tuple((expression(b["cond"]), self._statements(b["stmts"])) for b in content["cond_blocks"])
                return Conditional(branches, self._statements(content.get("else_block") or []), at)
            case "For":
                body = self._statements(content["equations"])
                for index in reversed(content["indices"]):
                    body = (Loop(index["ident"], expression(index["range"]), body, at),)
                return body[0]
            case "While":
                block = content["block"]
                return While(expression(block["cond"]), self._statements(block["stmts"]), at)
            case "When":
                blocks = tuple((expression(b["cond"]), self._statements(b["stmts"])) for b in content["blocks"])
                return When(blocks, sequential=True, at=at)
            case "Return":
                return Return(at)
            case "Reinit":
                return Reinit(content["state"], expression(content["value"]), at)
            case "Assert":
                return self.assertion(content)
            case "Terminate":
                return Terminate(expression(content["message"]), at)
        raise self._source.error(f"{variant.lower()} is not supported in algorithms", at)

    def _target(self, component: Tree) -> tuple[str, tuple[Expression | None, ...]]:
        parts = component["parts"]
        if any(part["subs"] for part in parts[:-1]):
            raise self._source.error("an assignment to a part of an array of records is not supported",
                                     place(component))  # fmt: skip
        subscripts = tuple(self._expression.subscript(s) for s in parts[-1]["subs"] or ())
        return ".".join(part["ident"] for part in parts), subscripts

    def _assigns(self, content: Tree, at: int) -> Assigns:
        arguments = tuple(self._expression(argument) for argument in content["args"])
        call = UserCall(content["comp"]["name"], arguments, place(content["comp"]) or at)
        found: list[Assign | None] = []
        for position, output in enumerate(content["outputs"]):
            if output is None:
                found.append(None)
            else:
                target, subscripts = self._target(output)
                found.append(Assign(target, subscripts, Output(call, position, at), at))
        return Assigns(tuple(found), at)
