"""The native loop's library: found in the package, found in the user's cache, or compiled into it.

Its name contains a digest of what it is made from, so that one made from another source is never taken.
"""

from __future__ import annotations

import ctypes
import functools
import os
import tempfile
from contextlib import suppress
from ctypes import POINTER, c_bool, c_char_p, c_double, c_int, c_int64, c_size_t
from pathlib import Path

from cosim.engine.native import _compilation
from cosim.engine.native._structures import SIZES, Engine, Fault
from cosim.errors import BuildError, InputError
from cosim.fmu.toolchain import host_name

CHOICE = "COSIM_ENGINE"
"""Environment variable: "native", "python", or "auto", which takes the Python loop if the native one cannot be had."""


def native_library(choice: str | None = None) -> ctypes.CDLL | None:
    """Return the library of the native loop, or None if the Python loop is to be used: as COSIM_ENGINE chooses.

    Raises InputError if COSIM_ENGINE is none of its three values, BuildError if it is "native" and there is neither a
    library nor a compiler.
    """
    choice = os.environ.get(CHOICE, "auto") if choice is None else choice
    if choice not in ("auto", "native", "python"):
        raise InputError(f"{CHOICE} is {choice!r}; it can be auto, native or python")
    if choice == "python":
        return None
    library = _load()
    if isinstance(library, BuildError):
        if choice == "native":
            raise library
        return None
    return library


def preload() -> None:
    """Load the library if there is one, and nothing needs to be compiled."""
    name = _compilation.file_name(host_name())
    if any((folder / name).is_file() for folder in (_compilation.SOURCES / "prebuilt", cache_folder())):
        _load()


@functools.cache
def _load() -> ctypes.CDLL | BuildError:
    """Load or build the library, once per process; a failure is remembered, too."""
    name = _compilation.file_name(host_name())
    prebuilt, cached = _compilation.SOURCES / "prebuilt" / name, cache_folder() / name
    if prebuilt.is_file():
        with suppress(OSError, BuildError):  # it may be for another C library than this system has
            return _opened(prebuilt)
    try:
        return _opened(cached if cached.is_file() else _built(cached))
    except (BuildError, OSError) as error:
        return error if isinstance(error, BuildError) else BuildError(f"the native loop cannot be loaded: {error}")


def cache_folder() -> Path:
    """Return the folder in the user's cache for libraries that were compiled on first use."""
    import platformdirs

    return Path(platformdirs.user_cache_dir("wiper-cosim")) / "engine"


def compile_to(output: Path) -> None:
    """Compile the library with the project's compiler; raises BuildError if there is none or it fails."""
    from cosim.fmu.toolchain import compiler

    said = _compilation.compile_library(compiler(), output)
    if said:
        raise BuildError(f"the C compiler failed on the native loop:\n{said[-3000:]}")


def _built(path: Path) -> Path:
    """Compile into a folder of its own and rename, so that no other process ever sees half a library."""
    from filelock import FileLock

    path.parent.mkdir(parents=True, exist_ok=True)
    with FileLock(path.with_suffix(".lock")):
        if not path.is_file():
            with tempfile.TemporaryDirectory(dir=path.parent) as folder:
                compile_to(Path(folder) / path.name)
                (Path(folder) / path.name).replace(path)
    return path


def _opened(path: Path) -> ctypes.CDLL:
    library = ctypes.CDLL(str(path))
    for run in (library.cosim_run, library.cosim_run_watched, library.cosim_run_plain):
        run.argtypes = [POINTER(Engine), c_double]
        run.restype = c_int
    library.cosim_set_text.argtypes = [POINTER(Engine), c_int64, c_char_p, c_size_t]
    library.cosim_set_text.restype = c_bool
    library.cosim_free_texts.argtypes = [POINTER(Engine)]
    library.cosim_free_texts.restype = None
    library.cosim_note_faults.argtypes = [POINTER(Fault)]
    library.cosim_note_faults.restype = None
    sizes = (c_int64 * len(SIZES))()
    library.cosim_sizes(sizes)
    if tuple(sizes) != SIZES:
        raise BuildError(f"{path}: its tables have the sizes {tuple(sizes)}, but {SIZES} are expected; delete it")
    return library
