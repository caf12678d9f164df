"""Algorithm sections in a form that the front end lets through, where it refuses them as they stand.

rumoca flattens any expression, but refuses most algorithm sections afterwards. So their statements are put into
assertions that say nothing, whose message names the statement: ``y := 2*x`` becomes ``assert(size({y}, 1) > 0, ...)``
and ``assert(size({2*x}, 1) > 0, ...)``. Conditions go the same way, loops and when stay what they are. From the
assertions of the flat model, with every name worked out, ``_recover`` makes the statements again.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field

from cosim.modelica._scan import scan, tokens_of
from cosim.modelica.source import Source

MARK = "cosim-statement:"
"""What the message of such an assertion begins with; then come the number of the statement and what of it this is."""
_ENDS = frozenset("equation algorithm initial public protected end annotation external else elseif elsewhen".split())


@dataclass
class Step:
    """A statement: its kind, and the statements inside it."""

    kind: str
    """assign, call, if, for, when, reinit, assert or terminate; or section, for the whole."""
    number: int
    at: int
    """Byte offset in the text as it was."""
    bodies: list[list[Step]] = field(default_factory=list)
    """Of an if or when, one for each branch, with that of else last; of a loop or section, one."""
    outputs: list[bool] = field(default_factory=list)
    """Of a call with several outputs, which are kept."""
    is_warning: bool = False
    in_algorithm: bool = True
    """Whether a when-clause is one of an algorithm section, where the order of its statements counts."""


class NotCarriedError(Exception):
    """A statement has no such form."""


def carry(source: Source) -> tuple[Source, dict[int, Step]] | None:
    """The text with its algorithm sections in that form, and the statements by their numbers; ``None`` if none has it.

    Also when-equations that assign elements of arrays, which the front end refuses, too.
    """
    rewriter = _Rewriter(source)
    try:
        rewriter.run()
    except NotCarriedError:
        return None
    return rewriter.result() if rewriter.steps else None


class _Rewriter:
    def __init__(self, source: Source) -> None:
        self._source = source
        self._text = source.text.encode()
        self._tokens = tokens_of(self._text)
        self._index = {token.at: position for position, token in enumerate(self._tokens)}
        self._chunks: list[tuple[bytes, int]] = []
        """Pieces of the new text, and where in the old one each comes from."""
        self._copied = 0
        self.steps: dict[int, Step] = {}

    def run(self) -> None:
        """Rewrite every section and clause that needs it."""
        for statement in sorted(scan(self._source.text).statements, key=lambda s: s.at):
            if statement.class_kind == "function" or statement.at < self._copied or "if" in statement.inside:
                continue
            if statement.kind == "algorithm":
                self._section(statement.at, self._index[statement.at] + 1)
            elif statement.kind == "when" and statement.section == "equation" and self._has_parts(statement.at):
                self._copy(statement.at)
                step, position = self._when(self._index[statement.at])
                step.in_algorithm = False
                self._copied = self._tokens[position].at

    def result(self) -> tuple[Source, dict[int, Step]]:
        """The new text, with places in the old files."""
        self._copy(len(self._text))
        return self._source.rearranged(self._chunks), self.steps

    # writing

    def _copy(self, end: int) -> None:
        self._chunks.append((self._text[self._copied : end], self._copied))
        self._copied = end

    def _write(self, text: str, at: int) -> None:
        self._chunks.append((text.encode(), at))

    def _carrier(self, step: Step, part: str, begin: int, end: int) -> None:
        self._write("assert(size({", begin)
        self._chunks.append((self._text[begin:end], begin))
        self._write(f'}}, 1) > 0, "{MARK}{step.number}:{part}"); ', begin)

    def _mark(self, step: Step, part: str, text: tuple[int, int] | None = None) -> None:
        """An assertion without expression; its message is perhaps a part of the text."""
        self._write(f'assert(size({{time}}, 1) > 0, "{MARK}{step.number}:{part}:"', step.at)
        if text is not None:
            self._write(" + (", text[0])
            self._chunks.append((self._text[text[0] : text[1]], text[0]))
            self._write(")", text[1])
        self._write("); ", step.at)

    # statements; each takes the position of its first token and gives the one after it

    def _step(self, kind: str, position: int) -> Step:
        step = Step(kind, len(self.steps) + 1, self._tokens[position].at)
        self.steps[step.number] = step
        return step

    def _section(self, at: int, position: int) -> None:
        self._copy(at)
        step = self._step("section", position - 1)
        self._write("equation ", at)
        self._mark(step, "begin")
        body, position = self._statements(position, [])
        step.bodies.append(body)
        self._copied = self._tokens[position].at

    def _statements(self, position: int, loops: list[str]) -> tuple[list[Step], int]:
        found = []
        while self._tokens[position].text not in _ENDS:
            step, position = self._statement(position, loops)
            found.append(step)
        return found, position

    def _statement(self, position: int, loops: list[str]) -> tuple[Step, int]:
        match self._tokens[position].text:
            case "if":
                return self._if(position, loops)
            case "for":
                return self._for(position, loops)
            case "when":
                return self._when(position)
            case "while" | "break" | "return":
                raise NotCarriedError
        end = self._until(position, ";")
        return self._simple(position, end), end + 1

    def _simple(self, position: int, end: int) -> Step:
        first, last = self._tokens[position], self._tokens[end - 1]
        if first.text in ("reinit", "assert", "terminate") and self._tokens[position + 1].text == "(":
            return self._act(position, end)
        becomes = next((k for k in range(position, end) if self._tokens[k].text in (":=", "=")), None)
        if becomes is None:
            raise NotCarriedError
        sign = self._tokens[becomes]
        if first.text != "(":
            step = self._step("assign", position)
            self._carrier(step, "left", first.at, self._tokens[becomes - 1].end)
            self._carrier(step, "right", self._tokens[becomes + 1].at, last.end)
            return step
        step = self._step("call", position)
        for begin, stop in self._arguments(position, becomes - 1):
            step.outputs.append(begin < stop)
            if begin < stop:
                self._carrier(step, f"left{len(step.outputs) - 1}", begin, stop)
        self._carrier(step, "right", sign.end, last.end)
        return step

    def _act(self, position: int, end: int) -> Step:
        step = self._step(self._tokens[position].text, position)
        arguments = self._arguments(position + 1, end - 1)
        texts = [self._text[begin:stop].decode() for begin, stop in arguments]
        if step.kind == "reinit":
            self._carrier(step, "left", *arguments[0])
            self._carrier(step, "right", *arguments[1])
        elif step.kind == "assert":
            step.is_warning = any("warning" in text for text in texts[2:])
            self._carrier(step, "right", *arguments[0])
            self._mark(step, "message", arguments[1])
        else:
            self._mark(step, "message", arguments[0])
        return step

    def _if(self, position: int, loops: list[str]) -> tuple[Step, int]:
        step = self._step("if", position)
        while self._tokens[position].text in ("if", "elseif"):
            then = self._until(position + 1, "then")
            self._carrier(step, f"condition{len(step.bodies)}", self._tokens[position + 1].at, self._tokens[then].at)
            body, position = self._statements(then + 1, loops)
            step.bodies.append(body)
        otherwise: list[Step] = []
        if self._tokens[position].text == "else":
            otherwise, position = self._statements(position + 1, loops)
        step.bodies.append(otherwise)
        return step, position + 3

    def _for(self, position: int, loops: list[str]) -> tuple[Step, int]:
        step = self._step("for", position)
        loop = self._until(position, "loop")
        header = self._tokens[position + 1 : loop]
        indices = [a.text for a, b in itertools.pairwise(header) if b.text == "in"]
        if any(b.text == "in" and a.text in loops for a, b in itertools.pairwise(header)):
            raise NotCarriedError
        begin = self._tokens[position].at
        self._chunks.append((self._text[begin : self._tokens[loop].end] + b" ", begin))
        inside = [*loops, *indices]
        for name in inside:
            self._write(f'assert(size({{{name}}}, 1) > 0, "{MARK}{step.number}:{name}"); ', begin)
        step.outputs = [True] * len(inside)
        body, position = self._statements(loop + 1, inside)
        step.bodies.append(body)
        self._write("end for; ", self._tokens[position].at)
        return step, position + 3

    def _when(self, position: int) -> tuple[Step, int]:
        step = self._step("when", position)
        while self._tokens[position].text in ("when", "elsewhen"):
            then = self._until(position + 1, "then")
            begin = self._tokens[position].at
            self._chunks.append((self._text[begin : self._tokens[then].end] + b" ", begin))
            self._mark(step, f"branch{len(step.bodies)}")
            body, position = self._statements(then + 1, [])
            step.bodies.append(body)
        self._write("end when; ", self._tokens[position].at)
        return step, position + 3

    # finding

    def _until(self, position: int, word: str) -> int:
        """The position of a word outside parentheses; ``then`` belongs to the last ``if`` before it."""
        depth, expressions = 0, 0
        while position < len(self._tokens):
            text = self._tokens[position].text
            depth += (text in ("(", "[", "{")) - (text in (")", "]", "}"))
            if depth == 0 and text == word and not (word == "then" and expressions):
                return position
            expressions += (text == "if") - (text == "then" and expressions > 0)
            position += 1
        raise NotCarriedError

    def _arguments(self, opening: int, closing: int) -> list[tuple[int, int]]:
        """Begin and end of each argument between two parentheses."""
        found = []
        depth, begin = 0, self._tokens[opening].end
        for token in self._tokens[opening + 1 : closing]:
            depth += (token.text in ("(", "[", "{")) - (token.text in (")", "]", "}"))
            if depth == 0 and token.text == ",":
                found.append((begin, token.at))
                begin = token.end
        found.append((begin, self._tokens[closing].at))
        return [(a, b) if self._text[a:b].strip() else (a, a) for a, b in found]

    def _has_parts(self, at: int) -> bool:
        """Whether a when-equation has a loop, or assigns elements or several outputs."""
        tokens = self._tokens
        position = self._until(self._index[at], "then")
        start = position + 1
        while tokens[position].text != "end" or tokens[position + 1].text != "when":
            position += 1
            text = tokens[position].text
            if position == start and text in ("for", "("):
                return True
            if position == start and tokens[position + 1].text == "[":
                return True
            if text in (";", "then", "else", "loop"):
                start = position + 1
        return False
