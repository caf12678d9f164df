"""Flattening by rumoca: Modelica text in, a flat model in our own terms out.

Everything that depends on rumoca's (alpha) data layout is in this file and in ``_reader.py``.
"""

from __future__ import annotations

import contextlib
import os
import re
import sys
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from cosim.errors import BuildError, ModelError
from cosim.modelica import _reader
from cosim.modelica.flat import FlatModel
from cosim.modelica.source import Source

_FINAL = re.compile(r"//[^\n]*|/\*.*?\*/|\"(?:\\.|[^\"\\])*\"|\b(final)\b", re.DOTALL)
_QUOTED = re.compile(r"[`']([A-Za-z_][\w.]*)(?:\[[^\]]*\])?[`']")
_AT = re.compile(r"\s*\[[^\]\s]*:(\d+):(\d+)\]")
_BALANCE = re.compile(r"unbalanced model: .*\(balance = (-?\d+)\)")
_PANIC = re.compile(r'detail: "(.*?)", span: .*?start: BytePos\((\d+)\)', re.DOTALL)
_PROBE = "CosimBalanceProbe"


def flatten(source: Source, model: str) -> FlatModel:
    """Flatten ``model`` (its full name) of ``source``.

    A model with too few or too many equations is flattened as it stands, for the structural analysis to say which.

    Raises:
        ModelError: the text is not valid Modelica, the class is missing or cannot be flattened, or it uses something
            this version does not support; the message says what and where.
        BuildError: rumoca is not installed.
    """
    try:
        import rumoca
    except ImportError:
        raise BuildError("compiling Modelica needs rumoca; install it with: pip install 'wiper-cosim[build]'") from None
    if source.find_class(model) is None:
        raise ModelError(f"there is no class {model!r} in this text; give its full name, package and all",
                         file=source.files[0])  # fmt: skip
    _check_syntax(source, rumoca)
    try:
        tree = _tree(rumoca, source, source.text, model)
    except rumoca.RumocaError as error:
        unbalanced = _flatten_unbalanced(rumoca, source, model, str(error))
        if unbalanced is None:
            raise _explain(source, model, str(error)) from None
        return unbalanced
    if tree["is_partial"]:
        raise source.error(
            f"{model} is partial, a basis for other models; compile one that extends it", source.find_class(model)
        )
    return _reader.read(tree, model, source)


def _tree(rumoca: Any, source: Source, text: str, model: str) -> dict[str, Any]:  # noqa: ANN401 - a module
    """rumoca's flat tree of a class of ``text``, which starts with that of ``source``.

    rumoca takes a ``final`` parameter for a constant and decides asserts and ifs with its default value, although it
    may follow from parameters that an importer sets. So it gets to see the equations without the keyword, and a second
    time with it, for the flags alone.
    """
    plain = _FINAL.sub(lambda match: " " * len("final") if match.group(1) else match.group(), text)
    tree = _load(rumoca, source, plain, model)
    if plain != text:
        tree["variable_final_flags"] = _load(rumoca, source, text, model)["variable_final_flags"]
    return tree


def _load(rumoca: Any, source: Source, text: str, model: str) -> dict[str, Any]:  # noqa: ANN401 - a module
    try:
        with _silenced_stderr():
            compiled = rumoca.Session().loads(text, model=model, filename=source.files[0].name)
            tree: dict[str, Any] = compiled.to_dict("flat")
            return tree
    except rumoca.RumocaError:
        raise
    except BaseException as error:
        # a panic of the front end arrives as a BaseException of its own; anything else is not ours to handle
        if type(error).__name__ != "PanicException":
            raise
        detail = _PANIC.search(str(error))
        if detail is not None:
            raise source.error(f"{model}: {detail.group(1)}", int(detail.group(2))) from None
        raise source.error(f"the Modelica front end failed on {model}: {error}", source.find_class(model)) from None


def _flatten_unbalanced(rumoca: Any, source: Source, model: str, message: str) -> FlatModel | None:  # noqa: ANN401
    """The flat model that rumoca refuses because it has too few or too many equations.

    rumoca only says how many. A class that adds as many empty equations or free variables passes, and without these
    it is the model that was asked for.
    """
    balance = _BALANCE.search(message)
    if balance is None:
        return None
    surplus = int(balance.group(1))
    added = " ".join(f"Real {_PROBE}{k};" for k in range(surplus)) + " equation " + "0 = time; " * -surplus
    text = f"{source.text}\nmodel {_PROBE} extends {model}; {added} end {_PROBE};"
    try:
        flat = _reader.read(_tree(rumoca, source, text, _PROBE), model, source)
    except (rumoca.RumocaError, ModelError):
        return None
    end = len(source.text.encode())
    return replace(
        flat,
        variables={name: v for name, v in flat.variables.items() if v.at < end},
        equations=tuple(equation for equation in flat.equations if equation.at < end),
    )


def _check_syntax(source: Source, rumoca: Any) -> None:  # noqa: ANN401 - a module
    for diagnostic in rumoca.validate_source(source.text):
        if diagnostic.level != "error":
            continue
        text = str(diagnostic.message)
        at = _AT.search(text)
        found = re.search(r"×\s*(.+)", text)
        expected = re.search(r"help:\s*(.+?)(?:\n\n|\Z)", text, re.DOTALL)
        message = found.group(1).strip() if found else text.strip()
        if expected:
            message += "; " + re.sub(r"\s+", " ", expected.group(1)).strip()
        offset = _offset(source, int(at.group(1)), int(at.group(2))) if at else None
        raise source.error(message, offset)


def _offset(source: Source, line: int, column: int) -> int:
    lines = source.text.split("\n")
    return len("\n".join(lines[: line - 1]).encode()) + (line > 1) + len(lines[line - 1][: column - 1].encode())


_PLAINER = (
    (r"^todae failed: ", ""),
    (r"\S+ failed in \w+: ", ""),
    (r"typecheck failed: ", ""),
    (r"^could not be compiled: ", ""),
    (r"unsupported Flat semantic owner `derivative expression`: .*",
     "der() takes one plain variable here: declare a variable for the expression and differentiate that"),
    (r"unbalanced model: (\d+) equations, (\d+) unknowns.*",
     r"the model has \1 equation(s) for \2 unknown(s); add what is missing or remove what is too many"),
    (r"invalid Appendix B discrete solved form: (`.*?`) participates in an? (internal )?current-value dependency cycle",
     r"\1 needs its own new value to be computed; use pre() to break the ring"),
    (r"invalid Appendix B discrete solved form: (`.*?`) has more than one semantic definition owner",
     r"\1 is defined more than once"),
    (r"unsupported Flat semantic owner `pre expression`: pre\((`.*?`)\) .*",
     r"pre() of \1: a continuous variable has a value before the event only inside when"),
    (r"canonical DAE construction rejected an invalid operation: expected a numeric expression, found (\w+)",
     r"a value of type \1 stands where a number is expected"),
    (r"canonical DAE construction rejected an invalid operation: expression shape mismatch",
     "the two sides of an equation do not fit: arrays of different shapes, or a Real for an Integer"),
    (r"reinit\(\) can only be applied to state variables: (\S+) is not a state",
     r"reinit() of `\1`, which is not a state: only what stands in der() can be reinitialised"),
    (r"(cyclic dependency in parameter binding for '.*?').*", r"\1: parameters depend on each other in a ring"),
)  # fmt: skip
"""What rumoca says in its own terms, and what it means."""


def _explain(source: Source, model: str, text: str) -> ModelError:
    """Put the place that rumoca's message leaves out in front of it, from the names it quotes."""
    message = text.partition("\nRelated failures")[0].strip().removeprefix(f"{model} ")
    for pattern, plainer in _PLAINER:
        message = re.sub(pattern, plainer, message)
    at = _AT.search(message)
    if at is not None:
        offset: int | None = _offset(source, int(at.group(1)), int(at.group(2)))
        return source.error(f"{model}: {_AT.sub('', message)}", offset)
    declared = source.find_class(model)
    offset = declared
    for name in _QUOTED.findall(message):
        found = source.find(name.rpartition(".")[2], after=declared or 0)
        if found is None:
            found = source.find(name.rpartition(".")[2])
        if found is not None:
            offset = found
            break
    return source.error(f"{model}: {message}", offset)


@contextlib.contextmanager
def _silenced_stderr() -> Iterator[None]:
    """Keep the front end's panic traces off the user's terminal; they go to file descriptor 2 directly."""
    sys.stderr.flush()
    saved = os.dup(2)
    null = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(null, 2)
        yield
    finally:
        os.dup2(saved, 2)
        os.close(saved)
        os.close(null)
