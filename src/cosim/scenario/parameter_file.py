"""Parameter files: values with their units and where they come from, as ``cosim calibrate`` writes them.

A JSON document::

    {"parameters": [{"name": "plant.d_joint", "value": 0.95, "unit": "N.m.s/rad", "provenance": "fitted to ..."}]}

Every entry needs a name and a value; other members are left alone.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from cosim.errors import InputError
from cosim.scenario._model import Setting


def read_parameters(path: Path) -> list[Setting]:
    """Return what a parameter file sets.

    Raises:
        InputError: it cannot be read, or an entry has no name or no value.
    """
    try:
        document = json.loads(path.read_text(encoding="utf-8-sig"))
    except FileNotFoundError:
        raise InputError("there is no such parameter file", file=path) from None
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", file=path) from error
    except json.JSONDecodeError as error:
        raise InputError(f"is not JSON: {error.msg}", file=path, line=error.lineno, column=error.colno) from None
    except (ValueError, RecursionError):
        raise InputError("is not a JSON document in UTF-8", file=path) from None
    entries = document.get("parameters") if isinstance(document, dict) else None
    if not isinstance(entries, list):
        raise InputError('has no list "parameters"; a file that cosim calibrate wrote is expected', file=path)
    settings: list[Setting] = []
    for number, entry in enumerate(entries, 1):
        setting = _setting(entry, number, path)
        if any(other.name == setting.name for other in settings):
            raise InputError(f"entry {number}: '{setting.name}' is there a second time", file=path)
        settings.append(setting)
    return settings


def write_parameters(path: Path, entries: Sequence[Mapping[str, object]], more: Mapping[str, object]) -> None:
    """Write a parameter file; ``more`` goes beside the entries. Raises `InputError` if it cannot be written."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps({"parameters": [*entries], **more}, indent=2) + "\n", encoding="utf-8")
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror or error}", file=path) from error


def _setting(entry: Any, number: int, path: Path) -> Setting:  # noqa: ANN401 - whatever JSON holds
    name = entry.get("name") if isinstance(entry, dict) else None
    if not isinstance(name, str) or not name:
        raise InputError(f'entry {number} has no "name"', file=path)
    value, unit, provenance = entry.get("value"), entry.get("unit", "1"), entry.get("provenance")
    if not isinstance(unit, str | None):
        raise InputError(f'entry {number}, {name}: "unit" is {unit!r}; a text such as "N.m" is expected', file=path)
    if isinstance(value, bool):
        text = str(int(value))
    elif isinstance(value, int | float) and abs(value) <= sys.float_info.max:
        text = f"{value!r} {unit}" if unit not in ("1", None, "") else repr(value)
    elif isinstance(value, str):
        text = value
    else:
        raise InputError(
            f'entry {number}, {name}: "value" is {value!r}; a finite number or a text is expected', file=path
        )
    return Setting(name, text, path, origin=provenance if isinstance(provenance, str) else f"set by {path}")
