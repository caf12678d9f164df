"""Options of ``cosim run`` for the process that the simulation gets of its own."""

from __future__ import annotations

import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from cosim.cli._times import time_of
from cosim.errors import InputError

if TYPE_CHECKING:
    from cosim.engine import Isolate

_BYTES = {"B": 1.0, "kB": 1e3, "MB": 1e6, "GB": 1e9, "TB": 1e12, "KiB": 2.0**10, "MiB": 2.0**20, "GiB": 2.0**30}
_FOREIGN = re.compile(rb"\.(fmu|ssp|ssd)\b", re.IGNORECASE)


@dataclass(frozen=True)
class Isolation:
    """Whether runs are isolated, how long one call of an FMU may take [s], how much memory the process may have."""

    isolate: Isolate = "auto"
    call_timeout: float = 60.0
    memory_limit: float | None = None


def isolation(isolate: str, call_timeout: str, memory_limit: str | None) -> Isolation:
    """Read the options; raises `InputError` for what cannot be meant."""
    choices: dict[str, Isolate] = {"auto": "auto", "always": "always", "never": "never"}
    if isolate not in choices:
        raise InputError(f"--isolate {isolate}: accepted are {', '.join(choices)}")
    return Isolation(
        choices[isolate], time_of("--call-timeout", call_timeout), None if memory_limit is None else _size(memory_limit)
    )


def prepare(files: Sequence[Path], chosen: Isolation, settings: Sequence[str] = ()) -> None:
    """Let a worker begin to load its modules if these scenarios are likely to need one."""
    if chosen.isolate == "always" or (chosen.isolate == "auto" and _mention_fmus(files, settings)):
        from cosim.worker import prestart

        prestart()


def _mention_fmus(files: Sequence[Path], settings: Sequence[str]) -> bool:
    texts = [text.encode() for text in settings]
    for file in files:
        with suppress(OSError):  # is reported when it is read
            texts.append(file.read_bytes())
    return any(map(_FOREIGN.search, texts))


def _size(text: str) -> float:
    found = re.fullmatch(r"\s*([\d.eE+]+)\s*([A-Za-z]+)\s*", text)
    try:
        size = float(found[1]) * _BYTES[found[2]] if found else -1.0
    except (KeyError, ValueError):
        size = -1.0
    if not 1e8 <= size < float("inf"):
        raise InputError(f"--memory-limit {text}: write a size of 100 MB or more, such as '4 GB'")
    return size
