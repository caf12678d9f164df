"""Puts the native loop, compiled for all platforms, into the wheel, so that its users need no compiler.

Runs if HATCH_BUILD_HOOKS_ENABLE is set, as for a release (see CONTRIBUTING.md). The same sources and compiler give the
same bytes.
"""

from __future__ import annotations

import runpy
import sys
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

SOURCE = Path(__file__).parent / "src"


class NativeLoops(BuildHookInterface):  # type: ignore[type-arg]
    """Compiles the libraries into a temporary folder, from which the wheel is filled."""

    PLUGIN_NAME = "custom"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile, unless the installation is an editable one."""
        if version == "editable":
            return
        self._folder = tempfile.TemporaryDirectory()
        for path in compile_all(Path(self._folder.name)):
            build_data["force_include"][str(path)] = f"cosim/engine/native/prebuilt/{path.name}"

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Remove the folder."""
        if version != "editable":
            self._folder.cleanup()


def compile_all(folder: Path) -> list[Path]:
    """Compile for each platform; return the libraries. Ends with the compiler's message if one fails."""
    sys.path.insert(0, str(SOURCE))
    try:
        from cosim.fmu.toolchain import PLATFORMS
    finally:
        sys.path.remove(str(SOURCE))
    compilation = runpy.run_path(str(SOURCE / "cosim" / "engine" / "native" / "_compilation.py"))
    libraries = []
    for name, platform in PLATFORMS.items():
        inner = folder / name  # the compiler puts other files beside a library for Windows
        inner.mkdir()
        library = inner / compilation["file_name"](name)
        compiler = [sys.executable, "-m", "ziglang", "cc", "-target", platform.zig]
        said = compilation["compile_library"](compiler, library)
        if said:
            raise SystemExit(f"the native loop cannot be compiled for {name}:\n{said}")
        libraries.append(library)
    return libraries
