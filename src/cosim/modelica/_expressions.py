"""Reads the expressions of rumoca's flat tree."""

from __future__ import annotations

from typing import Any

from cosim.modelica.expressions import (
    Array,
    Binary,
    Call,
    Comprehension,
    Expression,
    Field,
    If,
    Literal,
    Range,
    Reference,
    Unary,
    UserCall,
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


def tag(node: Any) -> tuple[str, Any]:  # noqa: ANN401 - JSON
    """The variant and content of a serialised enumeration: ``"Empty"`` or ``{"Variant": content}``."""
    if isinstance(node, str):
        return node, None
    ((name, content),) = node.items()
    return name, content


def place(node: Tree) -> int:
    """Byte offset of a node in the text."""
    return int(node["span"]["start"]) if node.get("span") else 0


class ExpressionReader:
    """Reads expressions; refuses, with the place, what it has no reading for."""

    def __init__(self, source: Source, derivative: str = "") -> None:
        """Places are given in ``source``; ``derivative`` is a function that stands for der() of an expression."""
        self._source = source
        self._derivative = derivative

    def optional(self, node: Tree | None) -> Expression | None:
        """The expression, if there is one."""
        return None if node is None else self(node)

    def subscript(self, node: Tree) -> Expression | None:
        """A subscript; ``None`` is a bare colon."""
        variant, content = tag(node)
        match variant:
            case "Index":
                return Literal(int(content["value"]), 0)
            case "Expr":
                return self(content["expr"])
        return None

    def __call__(self, node: Tree) -> Expression:
        """The expression.

        Raises:
            ModelError: it is of a kind that is not supported.
        """
        variant, content = tag(node)
        at = place(content)
        match variant:
            case "Literal":
                kind, value = tag(content["value"])
                if kind == "Boolean":
                    return Literal(value in (True, "true", "True"), at)
                return Literal(value, at)
            case "VarRef":
                subscripts = tuple(self.subscript(s) for s in content["subscripts"])
                return Reference(content["name"]["name"], subscripts, at)
            case "Index":
                base = self(content["base"])
                if isinstance(base, Reference) and not base.subscripts:
                    return Reference(base.name, tuple(self.subscript(s) for s in content["subscripts"]), at)
                raise self._source.error("only a variable can have a subscript; give this value a name first", at)
            case "FieldAccess":
                return self._field(content, at)
            case "Binary":
                return Binary(_BINARY[content["op"]], self(content["lhs"]), self(content["rhs"]), at)
            case "Unary":
                return Unary(_UNARY[content["op"]], self(content["rhs"]), at)
            case "If":
                branches = tuple((self(c), self(v)) for c, v in content["branches"])
                return If(branches, self(content["else_branch"]), at)
            case "BuiltinCall":
                name = content["function"]
                function = _BUILTIN.get(name, name[0].lower() + name[1:])
                return Call(function, tuple(self(a) for a in content["args"]), at)
            case "FunctionCall":
                function, arguments = content["name"]["name"], tuple(self(a) for a in content["args"])
                if function == self._derivative:
                    return Call("der", arguments, at)
                return UserCall(function, arguments, at)
            case "StringConversion":
                return Call("String", (self(content["value"]),), at)
            case "Array":
                return Array(tuple(self(e) for e in content["elements"]), at)
            case "Range":
                return Range(self(content["start"]), self.optional(content["step"]), self(content["end"]), at)
            case "ArrayComprehension" if len(content["indices"]) == 1 and not content.get("filter"):
                (index,) = content["indices"]
                return Comprehension(self(content["expr"]), index["name"], self(index["range"]), at)
        names = {"Tuple": "a list of values in parentheses", "ArrayComprehension": "more than one index in { ... for }"}
        raise self._source.error(f"{names.get(variant, variant)} is not supported here", at)

    def _field(self, content: Tree, at: int) -> Expression:
        record, name = self(content["base"]), str(content["field"])
        if isinstance(record, Field):
            return Field(record.record, f"{record.name}.{name}", at)
        return Field(record, name, at)
