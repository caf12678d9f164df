"""Copies of FMUs with something changed."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from pathlib import Path

Edit = Callable[[str, bytes], tuple[str, bytes] | None]


def repack(source: Path, target: Path, edit: Edit) -> Path:
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(target, "w") as new:
        for name in old.namelist():
            entry = edit(name, old.read(name))
            if entry is not None:
                new.writestr(*entry)
    return target


def replacing(old: str, new: str, count: int = -1) -> Edit:
    def edit(name: str, content: bytes) -> tuple[str, bytes]:
        if name != "modelDescription.xml":
            return name, content
        assert old.encode() in content
        return name, content.replace(old.encode(), new.encode(), count)

    return edit
