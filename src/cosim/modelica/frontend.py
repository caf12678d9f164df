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
from cosim.modelica._carry import carry
from cosim.modelica._explain import AT, explain, offset
from cosim.modelica._recover import recover
from cosim.modelica._scan import derivatives_of_expressions
from cosim.modelica.flat import FlatModel
from cosim.modelica.source import Source

_FINAL = re.compile(r"//[^\n]*|/\*.*?\*/|\"(?:\\.|[^\"\\])*\"|\b(final)\b", re.DOTALL)
_DERIVATIVE = re.compile(r"\bder\s*\((?![\w\s.,:\[\]]*\))")
"""``der`` of more than a variable, perhaps in a comment."""
_BALANCE = re.compile(r"unbalanced model: .*\(balance = (-?\d+)\)")
_PANIC = re.compile(r'detail: "(.*?)", span: .*?start: BytePos\((\d+)\)', re.DOTALL)
_STATEMENTS = re.compile(r"model algorithm|when assignment|when function-call|when-equation LHS")
"""In what rumoca says when it refuses statements that it can flatten."""
_NOWHERE = "cosim-has-no-such-folder/model.mo"
"""A file that does not exist: next to one that does, rumoca would read all others."""
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
        near = source.near_class(model)
        hint = f", did you mean '{near}'?" if near else ""
        raise ModelError(
            f"there is no class {model!r} in this text{hint}; give its full name, package and all", file=source.files[0]
        )
    _check_syntax(source, rumoca)
    try:
        tree = _tree(rumoca, source, source.text, model)
    except rumoca.RumocaError as error:
        flat = _flatten_unbalanced(rumoca, source, model, str(error))
        if flat is None and _STATEMENTS.search(str(error)):
            flat = _flatten_carried(rumoca, source, model)
        if flat is None:
            raise explain(source, model, str(error)) from None
        return flat
    if tree["is_partial"]:
        raise source.error(
            f"{model} is partial, a basis for other models; compile one that extends it", source.find_class(model)
        )
    return _reader.read(tree, model, source)


def _tree(rumoca: Any, source: Source, text: str, model: str) -> dict[str, Any]:  # noqa: ANN401 - a module
    """rumoca's flat tree of a class of ``text``, which starts with that of ``source``.

    rumoca takes a ``final`` parameter for a constant and decides asserts and ifs with its default value, although it
    may follow from parameters that an importer sets. So it gets to see the equations without the keyword, and a second
    time with it, for the flags alone. And it takes ``der`` of variables only; where it has an expression, a function
    takes its place.
    """
    named, marker = _derivatives_marked(text)
    plain = _FINAL.sub(lambda match: " " * len("final") if match.group(1) else match.group(), named)
    tree = _load(rumoca, source, plain, model)
    tree["derivative_marker"] = marker
    if plain != named:
        tree["variable_final_flags"] = _load(rumoca, source, named, model)["variable_final_flags"]
    return tree


def _derivatives_marked(text: str) -> tuple[str, str]:
    """The text with a function of the same length in place of ``der`` of expressions, and the function's name."""
    encoded = text.encode()
    places = derivatives_of_expressions(encoded) if _DERIVATIVE.search(text) else []
    if not places:
        return text, ""
    marker = next(name for name in ("Der", "dEr", "deR", "DEr", "DeR", "dER", "DER") if name not in text)
    for at in places:
        encoded = encoded[:at] + marker.encode() + encoded[at + len(marker) :]
    return f"{encoded.decode()}\nfunction {marker} input Real u; output Real y; algorithm y := u; end {marker};", marker


def _load(rumoca: Any, source: Source, text: str, model: str) -> dict[str, Any]:  # noqa: ANN401 - a module
    try:
        with _silenced_stderr():
            compiled = rumoca.Session().loads(text, model=model, filename=_NOWHERE)
            tree: dict[str, Any] = compiled.to_dict("flat")
            parameters = compiled.parameters
            tree["structural_parameters"] = [n for n in parameters.names if parameters[n].kind == "structural"]
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
    except rumoca.RumocaError:
        return None
    end = len(source.text.encode())
    return replace(
        flat,
        variables={name: v for name, v in flat.variables.items() if v.at < end},
        equations=tuple(equation for equation in flat.equations if equation.at < end),
    )


def _flatten_carried(rumoca: Any, source: Source, model: str) -> FlatModel | None:  # noqa: ANN401 - a module
    """The flat model where rumoca refuses algorithm sections; ``None`` if this is not the way."""
    carried = carry(source)
    if carried is None:
        return None
    text, steps = carried
    try:
        flat: FlatModel | None = _reader.read(_tree(rumoca, text, text.text, model), model, text)
    except rumoca.RumocaError as error:
        flat = _flatten_unbalanced(rumoca, text, model, str(error))
    return None if flat is None else recover(flat, steps)


def _check_syntax(source: Source, rumoca: Any) -> None:  # noqa: ANN401 - a module
    for diagnostic in rumoca.validate_source(source.text):
        if diagnostic.level != "error":
            continue
        text = str(diagnostic.message)
        at = AT.search(text)
        found = re.search(r"×\s*(.+)", text)
        expected = re.search(r"help:\s*(.+?)(?:\n\n|\Z)", text, re.DOTALL)
        message = found.group(1).strip() if found else text.strip()
        if expected:
            message += "; " + re.sub(r"\s+", " ", expected.group(1)).strip()
        raise source.error(message, offset(source, int(at.group(1)), int(at.group(2))) if at else None)


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
