"""Flattening by rumoca: Modelica text in, a flat model in our own terms out.

Everything that depends on rumoca's (alpha) data layout is in this file and in ``_reader.py``.
"""

from __future__ import annotations

import contextlib
import os
import re
import sys
from collections.abc import Iterator
from typing import Any

from cosim.errors import BuildError, ModelError
from cosim.modelica import _reader
from cosim.modelica.flat import FlatModel
from cosim.modelica.source import Source

_QUOTED = re.compile(r"[`']([A-Za-z_][\w.]*)(?:\[[^\]]*\])?[`']")
_AT = re.compile(r"\[[^\]\s]*:(\d+):(\d+)\]")


def flatten(source: Source, model: str) -> FlatModel:
    """Flatten ``model`` (its full name) of ``source``.

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
        with _silenced_stderr():
            compiled = rumoca.Session().loads(source.text, model=model, filename=source.files[0].name)
            tree: dict[str, Any] = compiled.to_dict("flat")
    except rumoca.RumocaError as error:
        raise _explain(source, model, str(error)) from None
    except BaseException as error:
        # a panic of the front end arrives as a BaseException of its own; anything else is not ours to handle
        if type(error).__name__ != "PanicException":
            raise
        raise source.error(f"the Modelica front end failed on {model}: {error}", source.find_class(model)) from None
    return _reader.read(tree, model, source)


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


def _explain(source: Source, model: str, text: str) -> ModelError:
    """Put the place that rumoca's message leaves out in front of it, from the names it quotes."""
    message = text.split("\nRelated failures", maxsplit=1)[0].strip()
    message = re.sub(r"^todae failed: \S+ failed in ToDae: ", "", message)
    message = re.sub(rf"^{re.escape(model)} could not be compiled: ", "", message)
    declared = source.find_class(model)
    offset = declared
    for name in _QUOTED.findall(message):
        found = source.find(name.rpartition(".")[2], after=declared or 0)
        if found is None:
            found = source.find(name.rpartition(".")[2])
        if found is not None:
            offset = found
            break
    if "unbalanced model" in message:
        message += "; a model needs as many equations as unknowns: add what is missing or remove what is too many"
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
