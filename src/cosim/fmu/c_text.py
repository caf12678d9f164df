"""C text: functions, tables, comments and strings, in lines of a length that people read."""

from __future__ import annotations

import json
import re
import textwrap
from collections.abc import Sequence

WIDTH = 120
"""The longest line, where it can be broken."""


def function(head: str, body: Sequence[str]) -> list[str]:
    """A function definition."""
    return [head, "{", *(part for line in body for part in _wrapped(f"    {line}")), "}", ""]


def scope(body: Sequence[str]) -> list[str]:
    """Lines in braces, so that their names are their own; nothing for nothing."""
    return ["{", *(f"    {line}" for line in body), "}"] if body else []


def table(kind: str, name: str, size: str, values: Sequence[str]) -> list[str]:
    """The definition of a constant array of ``MODEL_ROOM(size)`` elements."""
    content = list(values) or ["0" if "char *" not in kind else '""']
    head, line = f"const {kind} {name}[MODEL_ROOM({size})] = {{", ", ".join(content)
    if len(head + line) + 2 <= WIDTH:
        return [f"{head}{line}}};", ""]
    lines = [""]
    for value in content:
        if len(lines[-1]) + len(value) + 2 > WIDTH:
            lines.append("")
        lines[-1] += f"{' ' if lines[-1] else '    '}{value},"
    return [head, *lines[:-1], lines[-1].removesuffix(","), "};", ""]


def remark(text: str, indent: str = "") -> list[str]:
    """A comment of a text that :func:`comment` has made harmless, long ones on several lines."""
    # it may be indented once more
    return textwrap.wrap(f"/* {text} */", WIDTH - 4, initial_indent=indent, subsequent_indent=f"{indent} * ")


def comment(text: str) -> str:
    """A text that neither ends a comment nor begins another."""
    return text.replace("*/", "* /").replace("/*", "/ *")


def string(text: str) -> str:
    """A C string literal."""
    escaped = json.dumps(text, ensure_ascii=True)
    # JSON and C agree on these escapes but for \u, which C does not allow for ASCII; models are named in ASCII
    return escaped.replace("\\u", "?u").replace("??", "?\\?")


def _wrapped(line: str) -> list[str]:
    """A line of code in lines of at most :data:`WIDTH` characters; a remark that does not fit comes first."""
    if len(line) <= WIDTH or line.lstrip().startswith(("/*", "*")):
        return [line]
    indent = line[: len(line) - len(line.lstrip())]
    code, _, about = line.partition(" /* ")
    if about:
        return [*remark(about.removesuffix(" */"), indent), *_wrapped(code)]
    lines: list[str] = []
    while len(code) > WIDTH:
        # an operator begins the next line
        ends = [match.start() for match in re.finditer(r" (?:[-+*/?:]|&&|\|\|) |(?<=,) ", code[: WIDTH + 1])]
        end = max((end for end in ends if end > len(indent) + 8), default=None)
        if end is None:
            break
        lines.append(code[:end])
        code = f"{indent}    {code[end + 1 :]}"
    return [*lines, code]
