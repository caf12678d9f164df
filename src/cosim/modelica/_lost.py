"""Modifiers that the front end loses without a word, so that a model would be compiled with other values.

rumoca 0.10 takes ``redeclare model M = B`` from ``H h(redeclare model M = B(k=7))``, and forgets ``k=7``; it forgets
the modifiers after ``constrainedby`` of a class; it keeps ``A c`` in ``extends E(redeclare B c)`` if E has inherited
its ``replaceable A c``; and constants of a package that one component redeclares are those of
all components.
"""

from __future__ import annotations

from cosim.modelica._scan import CLASSES, Scan, Token, tokens_of
from cosim.modelica.source import Source


def refuse_lost_modifiers(source: Source, found: Scan, model_at: int | None) -> None:
    """Refuse a model that may use a class in which modifiers are lost.

    Args:
        source: the text.
        found: what was found in it.
        model_at: where the model's own class is; its class and all whose names it mentions, and so on, may be used.

    Raises:
        ModelError: modifiers would be lost; where, and how to write them instead.
    """
    if not any(word in source.text for word in ("redeclare", "constrainedby")):
        return
    tokens = tokens_of(source.text.encode())
    lost = [*_lost(tokens), *_inherited(tokens, found)]
    if lost:
        used = _reachable(tokens, found, model_at)
        for at, message in lost:
            if used is None or any(begin <= at < end for begin, end in used):
                raise source.error(message, at)


def _lost(tokens: list[Token]) -> list[tuple[int, str]]:
    found = []
    depth, start = 0, 0
    for position, token in enumerate(tokens):
        depth += (token.text in ("(", "[", "{")) - (token.text in (")", "]", "}"))
        if token.text == ";" and depth <= 0:
            start = position + 1
        if token.text == "redeclare":
            kind = position + 1
            while tokens[kind].text in ("each", "final", "replaceable"):
                kind += 1
            name = tokens[kind + 1].text
            if tokens[kind].text == "package":
                found.append((token.at, "redeclared packages are not supported: the front end mixes up their constants;"
                              " give the constants as parameters"))  # fmt: skip
            elif depth > 0 and tokens[kind].text in CLASSES - {"function"} and _is_modified(tokens, kind + 3):
                found.append((token.at, f"the front end loses the modifiers in redeclare {tokens[kind].text} {name} ="
                              f" ...(...); declare a class with them, such as model T = ...(...), and write"
                              f" redeclare {tokens[kind].text} {name} = T"))  # fmt: skip
        elif token.text == "constrainedby" and _is_modified(tokens, position + 1):
            words = [t.text for t in tokens[start:position]]
            if "replaceable" in words and any(w in CLASSES for w in words[words.index("replaceable") + 1 :][:1]):
                found.append((token.at, "the front end loses the modifiers after constrainedby of a class; give them"
                              " where the class is used"))  # fmt: skip
    return found


def _inherited(tokens: list[Token], found: Scan) -> list[tuple[int, str]]:
    """Components that an extends-clause redeclares although the class it extends has only inherited them."""
    lost = []
    start = 0
    for position, token in enumerate(tokens):
        if token.text in (";", "equation", "algorithm", "public", "protected") or token.text.startswith('"'):
            start = position + 1
        if token.text != "redeclare":
            continue
        begins = next((k for k in range(start, position) if tokens[k].text == "extends"), None)
        if begins is None:
            continue
        before = [t.text for t in tokens[begins:position]]
        kind = position + 1
        while tokens[kind].text in ("each", "final", "replaceable"):
            kind += 1
        if before.count("(") - before.count(")") != 1 or tokens[kind].text in CLASSES:
            continue
        base = before[before.index("(") - 1]
        named = kind
        while tokens[named + 1].text == ".":
            named += 2
        name = tokens[named + 1].text
        texts = [[t.text for t in tokens if b <= t.at < e] for b, e in found.classes if found.names.get(b) == base]
        if texts and not any("replaceable" in text and name in text for text in texts):
            message = (
                f"the front end loses the redeclaration of {name}, which {base} has inherited; extend the class that"
                f" declares {name}, or redeclare it where {base} is a component"
            )
            lost.append((token.at, message))
    return lost


def _is_modified(tokens: list[Token], position: int) -> bool:
    """Whether a class name that begins here has modifiers behind it."""
    while tokens[position].is_name or tokens[position].text == ".":
        position += 1
    return tokens[position].text == "("


def _reachable(tokens: list[Token], found: Scan, model_at: int | None) -> list[tuple[int, int]] | None:
    """Begin and end of the classes that a model may use: those named in its text, in theirs, and so on."""
    begin = None if model_at is None else found.class_of(model_at)
    first = next(((b, e) for b, e in found.classes if b == begin), None)
    if first is None:
        return None
    ranges: dict[str, list[tuple[int, int]]] = {}
    for b, e in found.classes:
        ranges.setdefault(found.names.get(b, ""), []).append((b, e))
    used, waiting = [first], [first]
    while waiting:
        begin, end = waiting.pop()
        for name in {t.text for t in tokens if t.is_name and begin <= t.at < end}:
            new = [place for place in ranges.get(name, ()) if place not in used]
            used += new
            waiting += new
    return used
