"""From a folder with C sources and model descriptions, written by hand, to an .fmu file.

The folder has ``modelDescription.xml`` for FMI 3.0 and ``modelDescription.fmi2.xml`` for FMI 2.0. Files that begin with
``fmi2`` or ``fmi3`` are compiled for that version, all other C files for both. The model identifier is the name of the
folder.
"""

from __future__ import annotations

import json
import tempfile
from pathlib import Path

from cosim import __version__
from cosim.errors import BuildError
from cosim.fmu.exporter import BUILD_RECORD, tool_versions, write_archive
from cosim.fmu.toolchain import Platform, chosen, compile_library, fmi_headers
from cosim.fmu.versions import FmiVersion, file_name


def pack_folder(folder: Path, out: Path, *, fmi: FmiVersion, build_hash: str | None, platforms: str) -> Path:
    """Write the FMU of a folder for the platforms that :func:`toolchain.chosen` takes; see :func:`exporter.export`.

    Raises:
        BuildError: the folder has no description for this version, there is no C compiler, or it failed.
    """
    description = folder / ("modelDescription.xml" if fmi == "3.0" else "modelDescription.fmi2.xml")
    if not description.is_file():
        raise BuildError(f"{folder} has no {description.name}, so there is no FMU for FMI {fmi}; write one")
    files = {
        "modelDescription.xml": description.read_bytes(),
        BUILD_RECORD: json.dumps(
            {"model": folder.name, "hash": build_hash, "cosim": __version__, "tools": tool_versions()},
            indent=1,
            sort_keys=True,
        ).encode(),
    }
    for target in chosen(platforms, fmi):
        files[f"binaries/{target.folder(fmi)}/{folder.name}{target.suffix}"] = _library(folder, fmi, target)
    return write_archive(out, file_name(folder.name, fmi), files)


def sources_of(folder: Path, fmi: FmiVersion) -> list[Path]:
    """The C files of a folder for one FMI version."""
    own = f"fmi{fmi[0]}"
    return [file for file in sorted(folder.glob("*.c")) if file.name.startswith(own) or file.name[:3] != "fmi"]


def _library(folder: Path, fmi: FmiVersion, target: Platform) -> bytes:
    with tempfile.TemporaryDirectory(prefix="cosim-build-") as temporary:
        path = Path(temporary) / f"{folder.name}{target.suffix}"
        compile_library(sources_of(folder, fmi), [folder, fmi_headers()], path, fmi, target)
        return path.read_bytes()
