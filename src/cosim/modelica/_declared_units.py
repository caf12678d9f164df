"""Finds in the text what the flat model has lost: units of package constants, which it replaces by their values, and of
functions' variables, and the place of a connection.
"""

from __future__ import annotations

import re
from collections.abc import Collection

from cosim.modelica.expressions import Binary, Expression, Literal, Reference, Unary, children
from cosim.modelica.flat import Local
from cosim.modelica.quantity import NUMBER, UNKNOWN, Quantity, declared
from cosim.modelica.source import Source

_NAME = re.compile(rb"[A-Za-z_][\w.]*")
_CONNECT = re.compile(rb"\bconnect\s*\(\s*([\w.]+)\s*,\s*([\w.]+)\s*\)")
_UNIT = re.compile(r'\bunit\s*=\s*"([^"]*)"')


class DeclaredUnits:
    """Looks up declarations in one source text."""

    def __init__(self, source: Source) -> None:
        """Take the text; nothing is looked up yet."""
        self._text = source.text
        self._bytes = source.text.encode()
        self._constants: dict[str, Quantity] = {}
        self._connects = [
            (match.group(1).decode(), match.group(2).decode(), match.start())
            for match in _CONNECT.finditer(self._bytes)
        ]

    def constant(self, node: Expression) -> Quantity | None:
        """The quantity of the constant that a literal expression stands for; None if it is none.

        The front end puts the value in and keeps the place, where the text then has a name instead of a number. Its
        declaration is looked up by its last name; if several of that name have different units, nothing is known.
        """
        if node.at <= 0 or not _stands_for_a_name(node):
            return None
        match = _NAME.match(self._bytes, node.at)
        if match is None:
            return None
        last = match.group().decode().rpartition(".")[2]
        if last not in self._constants:
            self._constants[last] = _declared(self._text, last)
        return self._constants[last]

    def connection(self, names: Collection[str], variables: Collection[str]) -> int | None:
        """Place of the first ``connect`` that joins connectors with these names of variables to each other.

        Of a set of several connectors not each pair is connected directly; then it is the first that joins one of them
        to any other of the model's ``variables``. None if there is none.
        """
        joined = _connectors(names)
        return self._connect(joined, joined) or self._connect(joined, _connectors(variables))

    def _connect(self, these: set[str], those: set[str]) -> int | None:
        for left, right, at in self._connects:
            for own, other in ((left, right), (right, left)):
                # both paths begin in the component that holds the connect
                inside = (name[: -len(own)] for name in these if name == own or name.endswith(f".{own}"))
                if any(component + other in those for component in inside):
                    return at
        return None

    def local(self, variable: Local) -> Quantity:
        """The quantity of a function's variable, whose place is that of its type's name in the declaration."""
        if variable.type == "Integer":
            return NUMBER
        if variable.type != "Real":
            return UNKNOWN
        end = self._bytes.find(b";", variable.at)
        declaration = self._bytes[variable.at : end].decode("utf-8", "replace")
        match = re.match(rf"([\w.]+)\b[^;]*?\b{re.escape(variable.name)}\b\s*(\[[^\]]*\]\s*)?(\([^)]*\))?", declaration)
        if match is None:
            return UNKNOWN
        unit = _UNIT.search(match.group(3) or "")
        text = unit.group(1) if unit else _unit_of_type(self._text, match.group(1).rpartition(".")[2])
        return UNKNOWN if text is None else declared(text) or UNKNOWN


def _connectors(variables: Collection[str]) -> set[str]:
    """The variables themselves, since a signal connector is one, and what they are in."""
    return {*variables, *(name.rpartition(".")[0] for name in variables)}


def _stands_for_a_name(node: Expression) -> bool:
    """Whether an expression may be a constant's value: a number, or an operation that has not its operand's place."""
    match node:
        case Literal(value=value):
            return not isinstance(value, (bool, str))
        case Binary(left=operand) | Unary(operand=operand):
            return operand.at != node.at and not _refers(node)
    return False


def _refers(node: Expression) -> bool:
    return isinstance(node, Reference) or any(_refers(child) for child in children(node))


def _declared(text: str, name: str) -> Quantity:
    found = set[str | None]()
    for match in re.finditer(rf"\bconstant\s+([\w.]+)\s+{re.escape(name)}\b\s*(\([^)]*\))?", text):
        unit = _UNIT.search(match.group(2) or "")
        found.add(unit.group(1) if unit else _unit_of_type(text, match.group(1).rpartition(".")[2]))
    if not found:
        return NUMBER  # the index of a loop
    if len(found) > 1:
        return UNKNOWN
    (only,) = found
    return NUMBER if only is None else declared(only) or UNKNOWN


def _unit_of_type(text: str, name: str) -> str | None:
    match = re.search(rf"\btype\s+{re.escape(name)}\s*=\s*[\w.]+\s*(\([^)]*\))?", text)
    unit = _UNIT.search((match and match.group(1)) or "")
    return unit.group(1) if unit else None
