"""Which FMU files this project has built on this computer: known by their content, so that no other passes for one."""

from __future__ import annotations

import hashlib
from contextlib import suppress
from pathlib import Path


def remember(path: Path) -> None:
    """Note that this project has just built this file."""
    note(hashlib.sha256(path.read_bytes()).hexdigest())


def is_known(sha256: str) -> bool:
    """Tell whether a file with this content has been built here."""
    return (_folder() / sha256).is_file()


def note(sha256: str) -> None:
    """Note that a file with this content is one of this project's."""
    with suppress(OSError):  # one that is not known here is only treated with more care
        _folder().mkdir(parents=True, exist_ok=True)
        (_folder() / sha256).touch()


def _folder() -> Path:
    import platformdirs

    return Path(platformdirs.user_cache_dir("wiper-cosim")) / "built"
