"""The binaries of a model: compiled once for each platform, linked once for each FMI version.

All of the runtime but its shells is one translation unit, and so is each shell: a compiler's start and FMI's headers
cost more than the code in a file.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from cosim.fmu.toolchain import (
    RUNTIME,
    Platform,
    compile_object,
    fmi_headers,
    link_library,
    runtime_sources,
    shell_sources,
)
from cosim.fmu.versions import FmiVersion


def build_binaries(
    identifier: str,
    generated: Mapping[str, str],
    shells: Mapping[FmiVersion, Mapping[str, str]],
    targets: Mapping[FmiVersion, Sequence[Platform]],
) -> dict[FmiVersion, dict[Platform, bytes]]:
    """Compile a model and link it with the shell of each FMI version.

    Args:
        identifier: the libraries' name.
        generated: the generated files by name, without an instantiation token.
        shells: the same with the token for each version; only what the shell is compiled with may differ.
        targets: the platforms for each version.

    Raises:
        BuildError: there is no C compiler, it failed, or a library does not export the FMI functions.
    """
    with tempfile.TemporaryDirectory(prefix="cosim-build-") as temporary:
        folder = Path(temporary)
        common = _written(folder / "common", generated)
        units = {
            "model": (common / "model.c", common),
            "runtime": (_unit(folder / "runtime.c", runtime_sources(None)), common),
        }
        for fmi in targets:
            unit = _unit(folder / f"shell{fmi[0]}.c", shell_sources(fmi))
            units[f"shell{fmi[0]}"] = unit, _written(folder / f"fmi{fmi[0]}", shells[fmi])
        platforms = list(dict.fromkeys(target for chosen in targets.values() for target in chosen))
        libraries = [(fmi, target) for fmi, chosen in targets.items() for target in chosen]
        for target in platforms:
            (folder / target.fmi3).mkdir()

        def compiled(job: tuple[Platform, str]) -> None:
            target, name = job
            source, sizes = units[name]
            compile_object(source, [sizes, RUNTIME, fmi_headers()], folder / target.fmi3 / f"{name}.o", target)

        def linked(job: tuple[FmiVersion, Platform]) -> bytes:
            fmi, target = job
            # a folder each, since the linker puts other files beside a library for Windows
            path = folder / target.fmi3 / fmi / f"{identifier}{target.suffix}"
            path.parent.mkdir()
            objects = [folder / target.fmi3 / f"{name}.o" for name in ("model", "runtime", f"shell{fmi[0]}")]
            link_library(objects, path, fmi, target)
            return path.read_bytes()

        with ThreadPoolExecutor(os.cpu_count()) as threads:
            wanted = [
                (target, name)
                for target in platforms
                for name in units
                if name[:5] != "shell" or any(name == f"shell{fmi[0]}" and target in targets[fmi] for fmi in targets)
            ]
            list(threads.map(compiled, wanted))
            contents = list(threads.map(linked, libraries))
    return {
        fmi: {target: content for (of, target), content in zip(libraries, contents, strict=True) if of == fmi}
        for fmi in targets
    }


def _written(folder: Path, files: Mapping[str, str]) -> Path:
    folder.mkdir()
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder


def _unit(path: Path, sources: Sequence[Path]) -> Path:
    """One translation unit of several files of the runtime."""
    path.write_text("".join(f'#include "{source.name}"\n' for source in sources), encoding="utf-8")
    return path
