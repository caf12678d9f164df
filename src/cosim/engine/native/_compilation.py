"""How the native loop is compiled: here on first use, and beforehand for the wheels.

The build hook of the wheels (``hatch_build.py``) loads this file by its path, where nothing else is installed: it uses
the standard library only.
"""

from __future__ import annotations

import hashlib
import subprocess
from collections.abc import Sequence
from pathlib import Path

SOURCES = Path(__file__).parent
SHARED = Path(__file__).parents[2] / "fmu" / "runtime"
"""Where the sources lie that the FMUs' own solver has, too."""

_SHARED = ("cubic.h", "lu.h", "rodas_table.h", "step_control.c", "step_control.h")
FLAGS = (
    "-std=c11",
    "-O2",
    "-g0",
    "-fPIC",
    "-shared",
    "-fvisibility=hidden",
    "-ffp-contract=off",
    "-s",
    "-Wall",
    "-Wextra",
)
"""Of the compiler; nothing here may change what floating point gives."""

SUFFIXES = {"windows": ".dll", "darwin": ".dylib"}
"""How a library ends by operating system; ".so" elsewhere."""


def file_name(platform: str) -> str:
    """Return the name of the library for a platform ("x86_64-linux"): it contains a digest of what it is made from."""
    digest = hashlib.sha256(" ".join(FLAGS).encode())
    for path in [*sorted(SOURCES.glob("*.[ch]")), *(SHARED / name for name in _SHARED)]:
        digest.update(path.read_bytes().replace(b"\r\n", b"\n"))
    suffix = SUFFIXES.get(platform.rpartition("-")[2], ".so")
    return f"engine-{platform}-{digest.hexdigest()[:16]}{suffix}"


def units() -> list[Path]:
    """Return the files that are compiled; the others are included by them."""
    return [SOURCES.resolve() / name for name in ("engine.c", "watched.c", "plain.c")]


def includes() -> list[str]:
    """Return what tells the compiler where it finds the sources that are shared."""
    return [f"-I{SHARED.resolve()}"]


def compile_library(compiler: Sequence[str], output: Path) -> str:
    """Compile with this command; return what the compiler says if it fails, an empty text if it does not."""
    libraries = [] if output.suffix == ".dll" else ["-lm"]
    # in the folder of the output, since a library for macOS holds its own name as it was given
    command = [*compiler, *FLAGS, *includes(), "-o", output.name, *map(str, units()), *libraries]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=output.parent)
    return (done.stderr.strip() or f"exit code {done.returncode}") if done.returncode else ""
