"""A look at Modelica text without its meaning: which statements stand where, and what decides how many there are.

The front end leaves some statements out without a word, and does not say of every parameter that it has decided
something with its value. This finds what it should have given.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

_TOKEN = re.compile(
    rb"//[^\n]*|/\*.*?\*/|(?P<string>\"(?:\\.|[^\"\\])*\")|(?P<name>[A-Za-z_]\w*|'(?:\\.|[^'\\])+')"
    rb"|(?P<number>\d+(?:\.\d*)?(?:[eE][-+]?\d+)?)|(?P<mark>:=|==|<>|<=|>=|[^\s\w])",
    re.DOTALL,
)
CLASSES = frozenset("model block class package record connector function type operator".split())
_SECTIONS = frozenset("equation algorithm public protected".split())
_WATCHED = frozenset("when if for assert terminate reinit connect while break".split())
_WORDS = frozenset("and or not if then else elseif true false in loop end time".split())


@dataclass(frozen=True)
class Statement:
    """A statement of an equation or algorithm section; offsets are in bytes."""

    kind: str
    at: int
    end: int
    inside: tuple[str, ...]
    """The statements around it, the outermost first."""
    section: str
    class_kind: str
    class_at: int
    """Where the class begins in which it stands."""


@dataclass
class _Class:
    kind: str
    at: int
    end: int = 0
    section: str = "public"
    open: list[tuple[str, int]] = field(default_factory=list)
    """Statements that have begun, and where."""


@dataclass
class Scan:
    """What was found in a text."""

    statements: list[Statement] = field(default_factory=list)
    deciding: set[str] = field(default_factory=set)
    """Names in conditions of if-equations, ranges of loops and sizes of arrays."""
    conditional: set[str] = field(default_factory=set)
    """Names in conditions of components."""
    classes: list[tuple[int, int]] = field(default_factory=list)
    """Where each class begins and ends."""
    names: dict[int, str] = field(default_factory=dict)
    """The name of each class by where it begins."""

    def class_of(self, at: int) -> int | None:
        """Where the innermost class begins that has this place."""
        return max((begin for begin, end in self.classes if begin <= at < end), default=None)


def scan(text: str) -> Scan:
    """Look through a text that is valid Modelica."""
    return _Scanner(text.encode()).result


def derivatives_of_expressions(text: bytes) -> list[int]:
    """Where ``der`` stands before something else than a variable or an element of one."""
    tokens = list(_tokens(text))
    found = []
    for position, token in enumerate(tokens[:-1]):
        if token.text != "der" or tokens[position + 1].text != "(":
            continue
        depth, plain = 1, True
        for after in tokens[position + 2 :]:
            depth += (after.text in ("(", "[", "{")) - (after.text in (")", "]", "}"))
            if depth == 0:
                break
            plain = plain and (depth > 1 or after.text in (".", "]") or after.is_name) and after.text not in ("(", "{")
        if not plain:
            found.append(token.at)
    return found


@dataclass(frozen=True)
class Token:
    """A name, number or mark; texts and comments are none."""

    text: str
    is_name: bool
    at: int
    end: int


def tokens_of(text: bytes) -> list[Token]:
    """The tokens of a text; offsets are in bytes."""
    return list(_tokens(text))


def _tokens(text: bytes) -> Iterator[Token]:
    for match in _TOKEN.finditer(text):
        if match.lastgroup in ("name", "mark", "number"):
            yield Token(match.group().decode("utf-8", "replace"), match.lastgroup == "name", match.start(), match.end())


class _Scanner:
    def __init__(self, text: bytes) -> None:
        self.result = Scan()
        self._classes: list[_Class] = []
        self._statement: list[Token] = []
        """Tokens since the statement or declaration began."""
        self._depth = 0
        tokens = list(_tokens(text))
        position = 0
        while position < len(tokens):
            position = self._next(tokens, position)

    def _next(self, tokens: list[Token], position: int) -> int:
        token = tokens[position]
        following = tokens[position + 1].text if position + 1 < len(tokens) else ""
        if token.text in "([{":
            self._depth += 1
        elif token.text in ")]}":
            self._depth -= 1
        elif token.text == ";" and self._depth <= 0:
            self._end_statement(token)
            return position + 1
        elif token.is_name and self._depth == 0:
            if token.text == "end" and not self._in_expression():
                return self._end(tokens, position)
            if token.text in CLASSES and following not in ("", ";") and not self._in_code():
                return self._begin_class(tokens, position)
            if token.text in _SECTIONS and self._classes and not self._in_expression():
                self._classes[-1].section = token.text
                if token.text == "algorithm":
                    self._found("initial algorithm" if self._statement else "algorithm", token.at, token.end)
                self._statement.clear()
                return position + 1
            if token.text in ("then", "loop", "else") and self._in_code() and self._opens(token):
                return position + 1
        self._statement.append(token)
        return position + 1

    def _in_code(self) -> bool:
        return bool(self._classes) and self._classes[-1].section in ("equation", "algorithm")

    def _in_expression(self) -> bool:
        return bool(self._statement) and [t.text for t in self._statement] not in (["initial"], ["encapsulated"])

    def _begin_class(self, tokens: list[Token], position: int) -> int:
        start = position
        while position + 1 < len(tokens) and tokens[position + 1].text in (*CLASSES, "pure", "impure"):
            position += 1
        kind = tokens[position].text
        if tokens[position + 1].text == "extends":
            position += 1
        after = tokens[position + 2].text if position + 2 < len(tokens) else ""
        self._statement.clear()
        self.result.names[tokens[start].at] = tokens[min(position + 1, len(tokens) - 1)].text
        if after == "=":  # a short definition has no end
            end = next((t.end for t in tokens[position:] if t.text == ";"), tokens[-1].end)
            self.result.classes.append((tokens[start].at, end))
            self._statement += tokens[start : position + 2]
            return position + 2
        self._classes.append(_Class(kind, tokens[start].at))
        return position + 2

    def _end(self, tokens: list[Token], position: int) -> int:
        word = tokens[position + 1] if position + 1 < len(tokens) else tokens[position]
        if not self._classes:
            return position + 1
        current = self._classes[-1]
        if word.text in ("if", "for", "when", "while"):
            if current.open:
                kind, at = current.open.pop()
                self._found(kind, at, word.end)
        else:
            self._classes.pop()
            self.result.classes.append((current.at, word.end))
        self._statement.clear()
        return position + 2

    def _opens(self, token: Token) -> bool:
        """Take ``then``, ``loop`` and ``else`` as part of a statement where they do not belong to an expression."""
        words = [t.text for t in self._statement]
        current = self._classes[-1]
        if token.text == "else":
            if words:
                return False
            return bool(current.open)
        if not words or words[0] not in ("if", "elseif", "when", "elsewhen", "for", "while"):
            return False
        if token.text == "then" and words.count("if") - (words[0] == "if") > words.count("then"):
            return False  # of an if-expression in the condition
        if words[0] in ("if", "elseif", "for"):
            self.result.deciding |= _names(self._statement)
        if words[0] in ("if", "when", "for", "while"):
            current.open.append((words[0], self._statement[0].at))
        self._statement.clear()
        return True

    def _end_statement(self, token: Token) -> None:
        first = self._statement[0] if self._statement else token
        if self._in_code():
            if first.text in _WATCHED:
                self._found(first.text, first.at, token.end)
        elif self._classes:
            self._declaration()
        self._statement.clear()
        self._depth = 0

    def _declaration(self) -> None:
        depth, brackets = 0, 0
        bound = False
        for index, token in enumerate(self._statement):
            depth += (token.text in "([{") - (token.text in ")]}")
            brackets += (token.text == "[") - (token.text == "]")
            bound = bound or (depth == 0 and token.text in ("=", ":="))
            if brackets > 0 and token.is_name:
                self.result.deciding.add(token.text)
            if token.text == "annotation" and depth == 0:
                return
            if token.text == "if" and depth == 0 and not bound:
                words = [t.text for t in self._statement]
                last = words.index("annotation", index) if "annotation" in words[index:] else len(words)
                self.result.conditional |= _names(self._statement[index:last])
                return

    def _found(self, kind: str, at: int, end: int) -> None:
        current = self._classes[-1]
        inside = tuple(kind for kind, _ in current.open)
        if kind in _WATCHED or kind.endswith("algorithm"):
            self.result.statements.append(Statement(kind, at, end, inside, current.section, current.kind, current.at))


def _names(tokens: list[Token]) -> set[str]:
    return {t.text for t in tokens if t.is_name} - _WORDS
