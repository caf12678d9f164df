"""Reads rumoca's flat tree into a :class:`FlatModel`; refuses, with the place, what it has no reading for."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from cosim.modelica.expressions import (
    Array,
    Binary,
    Call,
    Comprehension,
    Expression,
    If,
    Literal,
    Range,
    Reference,
    Unary,
    put_in,
)
from cosim.modelica.flat import (
    Action,
    Assertion,
    Assign,
    Causality,
    Conditional,
    Equation,
    FlatModel,
    Reinit,
    StateSelect,
    Terminate,
    Type,
    Variability,
    Variable,
    When,
)
from cosim.modelica.source import Source

Tree = dict[str, Any]

_BINARY = {
    "Add": "+", "Sub": "-", "Mul": "*", "Div": "/", "Exp": "^",
    "AddElem": ".+", "SubElem": ".-", "MulElem": ".*", "DivElem": "./", "ExpElem": ".^",
    "Gt": ">", "Ge": ">=", "Lt": "<", "Le": "<=", "Eq": "==", "Neq": "<>", "And": "and", "Or": "or",
}  # fmt: skip
_UNARY = {"Minus": "-", "DotMinus": "-", "Plus": "+", "DotPlus": "+", "Not": "not"}
_BUILTIN = {"NoEvent": "noEvent", "OuterProduct": "outerProduct"}


def read(tree: Tree, model: str, source: Source) -> FlatModel:
    """Read the tree that ``to_dict("flat")`` of rumoca 0.10 gives.

    Raises:
        ModelError: something in the model is outside what is supported, by name and place.
    """
    return _Reader(tree, source).model(model)


def _tag(node: Any) -> tuple[str, Any]:  # noqa: ANN401 - JSON
    """The variant and content of a serialised enumeration: ``"Empty"`` or ``{"Variant": content}``."""
    if isinstance(node, str):
        return node, None
    ((tag, content),) = node.items()
    return tag, content


def _targets(actions: tuple[Action, ...]) -> Iterator[str]:
    for action in actions:
        if isinstance(action, Assign):
            yield action.target
        elif isinstance(action, Conditional):
            for body in (*(body for _, body in action.branches), action.otherwise):
                yield from _targets(body)


def _enumerations(ordinals: dict[str, int]) -> dict[str, tuple[str, ...]]:
    """The literals of each enumeration by its full name.

    The flat tree lists each literal by its full name, then, with what comes last of the type's name, once more in a
    short form, which is not unique, and both again in quotes.
    """
    found: dict[str, tuple[str, ...]] = {}
    last = ""
    for key in ordinals:
        if "'" in key or key == ".".join(last.split(".")[-2:]):
            continue
        last = key
        name, _, literal = key.rpartition(".")
        found[name] = (*found.get(name, ()), literal)
    return found


class _Reader:
    def __init__(self, tree: Tree, source: Source) -> None:
        self._tree = tree
        self._source = source
        types = _enumerations(tree["enum_literal_ordinals"])
        self._ordinals = {f"{name}.{literal}": k for name, type_ in types.items() for k, literal in enumerate(type_, 1)}
        self._enumerations = dict(zip(sorted(tree["enumeration_type_roots"]), types.values(), strict=True))
        """Literals by rumoca's number of the type; numbers and names are both in the order of declaration."""

    def model(self, name: str) -> FlatModel:
        tree = self._tree
        for key, what in (
            ("initial_structured_equations", "for-loops in initial equations"),
            ("initial_assert_equations", "assert in initial equations"),
            ("initial_algorithms", "initial algorithm"),
        ):
            if tree.get(key):
                raise self._source.error(f"{what} are not supported yet", self._source.find_class(name))
        whens = [self._when(chain) for chain in tree["when_chains"]]
        for algorithm in tree["algorithms"]:
            whens += self._algorithm(algorithm)
        variables = {key: self._variable(value) for key, value in tree["variables"].items()}
        for target in {target for when in whens for _, actions in when.branches for target in _targets(actions)}:
            # a Real that is assigned in a when-clause is discrete, declared so or not (Modelica 4.5.1)
            variables[target] = replace(variables[target], variability="discrete")
        return FlatModel(
            name=name,
            source=self._source,
            description=tree["model_description"],
            variables=variables,
            equations=(*self._bindings(variables), *self._equations()),
            initial_equations=tuple(self._equation(node) for node in tree["initial_equations"]),
            whens=tuple(whens),
            assertions=tuple(self._assertion(node) for node in tree["assert_equations"]),
            enumeration_values=self._ordinals,
        )

    @staticmethod
    def _bindings(variables: dict[str, Variable]) -> list[Equation]:
        """Declaration equations, which the flat tree keeps with the variables: ``Real x = a`` and ``S s(u = a)``."""
        return [
            Equation(Binary("-", Reference(v.name, (), v.at), v.binding, v.at), "Declaration", v.at)
            for v in variables.values()
            if v.binding is not None and v.variability not in ("parameter", "constant") and v.causality != "input"
        ]

    @staticmethod
    def _at(node: Tree) -> int:
        return int(node["span"]["start"]) if node.get("span") else 0

    def _variable(self, node: Tree) -> Variable:
        name: str = node["name"]
        at = int(node["source_span"]["start"])
        type_name: str = self._tree["variable_type_names"].get(name, "Real")
        kind, literals = self._type(node, type_name)
        tag, _ = _tag(node["variability"])
        variability: Variability = "continuous"
        if tag in ("Parameter", "Constant"):
            variability = "parameter" if tag == "Parameter" else "constant"
        elif tag == "Discrete" or kind != "Real":
            variability = "discrete"
        causality: Causality = "local"
        tag, _ = _tag(node["causality"])
        if "." not in name and tag in ("Input", "Output"):
            causality = "input" if tag == "Input" else "output"
        select: StateSelect = str(node["state_select"]).lower()  # type: ignore[assignment]
        fixed = node["fixed"]
        if isinstance(fixed, list):
            fixed = all(fixed)
        return Variable(
            name=name,
            type=kind,
            variability=variability,
            causality=causality,
            dimensions=tuple(node["dims"]),
            start=self._start(node),
            fixed=fixed,
            binding=self._optional(node["binding"]),
            minimum=self._optional(node["min"]),
            maximum=self._optional(node["max"]),
            nominal=self._optional(node["nominal"]),
            unit=node["unit"],
            display_unit=node["display_unit"],
            quantity=node["quantity"],
            description=node["description"],
            state_select=select,
            final=bool(self._tree["variable_final_flags"].get(name, False)),
            protected=bool(node["is_protected"]),
            literals=literals,
            at=at,
        )

    def _type(self, node: Tree, type_name: str) -> tuple[Type, tuple[str, ...]]:
        effective = self._tree["effective_types"][str(node["type_id"])]
        builtin = {number: name for name, number in self._tree["predefined_types"].items()}
        base = builtin.get(effective["canonical_type"])
        if base in ("real", "integer", "boolean", "string"):
            return base.capitalize(), ()
        literals = self._enumerations.get(effective["canonical_type"])
        if literals is None:
            raise self._source.error(f"{node['name']}: variables of type {type_name} are not supported", self._at(node))
        return "Enumeration", literals

    def _start(self, node: Tree) -> Expression | None:
        """The start value that the model gives; where it gives none, rumoca has zero, placed at the declaration."""
        start = node["start"]
        if start is not None and "Literal" in start and start["Literal"].get("span") == node["source_span"]:
            return None
        return self._optional(start)

    def _optional(self, node: Tree | None) -> Expression | None:
        return None if node is None else self.expression(node)

    def _equations(self) -> list[Equation]:
        """The equations, with those that the flat tree gives only as the template of a for-loop put in their places."""
        equations = [self._equation(node) for node in self._tree["equations"]]
        for family in self._tree["structured_equations"]:
            if family["interiors_materialized"]:
                continue
            body = [self.expression(residual) for residual in family["template"]["body"]]
            binders = family["domain"]["binders"]
            ranges = [range(b["lower"], b["upper"] + (1 if b["step"] > 0 else -1), b["step"]) for b in binders]
            position = int(family["first_equation_index"])
            for point in itertools.product(*ranges):
                indices = {b["display_name"]: Literal(k, self._at(family)) for b, k in zip(binders, point, strict=True)}
                for residual in body:
                    equations[position] = replace(equations[position], residual=put_in(residual, indices))
                    position += 1
        return equations

    def _equation(self, node: Tree) -> Equation:
        tag, content = _tag(node["origin"])
        origin = str(content.get("component", "")) if isinstance(content, dict) else ""
        return Equation(self.expression(node["residual"]), f"{tag}:{origin}", self._at(node))

    def _assertion(self, node: Tree) -> Assertion:
        level = self._optional(node.get("level"))
        message = self.expression(node["message"])
        if not (isinstance(message, Literal) and isinstance(message.value, str)):
            raise self._source.error("the message of assert must be a plain string", self._at(node))
        is_error = not (isinstance(level, Reference) and level.name.endswith("warning"))
        return Assertion(self.expression(node["condition"]), message.value, is_error, self._at(node))

    def _when(self, chain: Tree) -> When:
        branches = [chain["first"], *chain["else_when"]]
        return When(
            tuple((self.expression(b["condition"]), self._actions(b["equations"])) for b in branches),
            sequential=False,
            at=self._at(chain),
        )

    def _action(self, node: Tree) -> Action:
        tag, content = _tag(node)
        at = self._at(content)
        match tag:
            case "Assign":
                return Assign(content["target"], (), self.expression(content["value"]), at)
            case "Reinit":
                return Reinit(content["state"], self.expression(content["value"]), at)
            case "Assert":
                return self._assertion(content)
            case "Terminate":
                message = self.expression(content["message"])
                return Terminate(str(message.value) if isinstance(message, Literal) else "terminate", at)
            case "Conditional":
                branches = ((self.expression(c), self._actions(body)) for c, body in content["branches"])
                return Conditional(tuple(branches), self._actions(content.get("else_branch") or []), at)
        raise self._source.error(f"{tag} is not supported inside when", at)

    def _actions(self, nodes: list[Tree]) -> tuple[Action, ...]:
        return tuple(self._action(node) for node in nodes)

    def _algorithm(self, node: Tree) -> list[When]:
        whens = []
        for statement in node["statements"]:
            tag, content = _tag(statement)
            if tag != "When":
                raise self._source.error(
                    "algorithm sections may hold only when-statements so far; write this as an equation",
                    self._at(content) if isinstance(content, dict) else self._at(node),
                )
            whens.append(
                When(
                    tuple((self.expression(b["cond"]), self._statements(b["stmts"])) for b in content["blocks"]),
                    sequential=True,
                    at=self._at(content) or self._at(node),
                )
            )
        return whens

    def _statements(self, nodes: list[Tree]) -> tuple[Action, ...]:
        return tuple(self._statement(node) for node in nodes)

    def _statement(self, node: Tree) -> Action:
        tag, content = _tag(node)
        at = self._at(content) if isinstance(content, dict) else 0
        match tag:
            case "Assignment":
                parts = content["comp"]["parts"]
                name = ".".join(part["ident"] for part in parts)
                subscripts = tuple(self._subscript(s) for s in parts[-1]["subs"] or ())
                return Assign(name, subscripts, self.expression(content["value"]), self._at(content["comp"]))
            case "If":
                return Conditional(
                    tuple((self.expression(b["cond"]), self._statements(b["stmts"])) for b in content["cond_blocks"]),
                    self._statements(content.get("else_block") or []),
                    at,
                )
            case "Reinit":
                return Reinit(content["state"], self.expression(content["value"]), at)
        raise self._source.error(f"{tag.lower()} is not supported inside when-statements", at)

    def _subscript(self, node: Tree) -> Expression | None:
        tag, content = _tag(node)
        match tag:
            case "Index":
                return Literal(int(content["value"]), 0)
            case "Expr":
                return self.expression(content["expr"])
        return None

    def expression(self, node: Tree) -> Expression:
        tag, content = _tag(node)
        at = self._at(content)
        match tag:
            case "Literal":
                kind, value = _tag(content["value"])
                if kind == "Boolean":
                    return Literal(value in (True, "true", "True"), at)
                return Literal(value, at)
            case "VarRef":
                subscripts = tuple(self._subscript(s) for s in content["subscripts"])
                return Reference(content["name"]["name"], subscripts, at)
            case "Binary":
                left, right = self.expression(content["lhs"]), self.expression(content["rhs"])
                return Binary(_BINARY[content["op"]], left, right, at)
            case "Unary":
                return Unary(_UNARY[content["op"]], self.expression(content["rhs"]), at)
            case "If":
                return If(
                    tuple((self.expression(c), self.expression(v)) for c, v in content["branches"]),
                    self.expression(content["else_branch"]),
                    at,
                )
            case "BuiltinCall":
                name = content["function"]
                function = _BUILTIN.get(name, name[0].lower() + name[1:])
                return Call(function, tuple(self.expression(a) for a in content["args"]), at)
            case "Array":
                return Array(tuple(self.expression(e) for e in content["elements"]), at)
            case "Range":
                step = self._optional(content["step"])
                return Range(self.expression(content["start"]), step, self.expression(content["end"]), at)
            case "ArrayComprehension" if len(content["indices"]) == 1 and not content.get("filter"):
                (index,) = content["indices"]
                domain = self.expression(index["range"])
                return Comprehension(self.expression(content["expr"]), index["name"], domain, at)
            case "FunctionCall":
                name = content["name"]["name"]
                raise self._source.error(f"calls of the function {name} are not supported yet", at)
        raise self._source.error(f"{tag} expressions are not supported", at)
