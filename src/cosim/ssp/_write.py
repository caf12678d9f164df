"""Writing of an SSP: the engine's system with its FMUs, in bytes that depend on nothing else."""

from __future__ import annotations

import hashlib
import re
import zipfile
from pathlib import Path

from cosim.engine import System
from cosim.errors import InputError
from cosim.ssp._documents import MAPPING, VALUES, VERSIONS, Documents
from cosim.ssp._package import DEFAULT

_EARLIEST = (1980, 1, 1, 0, 0, 0)
"""The time of all files: the first that a zip archive can give."""


def write_ssp(system: System, path: Path, *, name: str, title: str = "", stop: float, version: str = "1.0") -> None:
    """Write a system as an SSP of a version, ``1.0`` or ``2.0``; ``stop`` [s] goes into its default experiment.

    The SSD connects the components, and connectors of the whole system to what channels drive and to all outputs. The
    SSV has all parameters that are set, and the values at which channels start; their rows are not in it.

    Raises `InputError` if the version is another, an FMU has changed since it was read, or the file cannot be written.
    """
    if version not in VERSIONS:
        raise InputError(f"SSP {version} is not written; accepted are {' and '.join(VERSIONS)}")
    fmus, sources = _fmus(system)
    documents = Documents(system, sources, version)
    files: dict[str, bytes | None] = {
        DEFAULT: documents.structure(name, title, stop),
        VALUES: documents.values(name),
        MAPPING: documents.mapping(),
    }
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        # Stored, not deflated: FMUs are archives already, and no version of a compressor can change the bytes.
        with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED) as archive:
            for file, content in {**files, **fmus}.items():
                if content is not None:
                    entry = zipfile.ZipInfo(file, _EARLIEST)
                    entry.external_attr = 0o644 << 16
                    entry.create_system = 3
                    archive.writestr(entry, content)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}", file=path) from error


def _fmus(system: System) -> tuple[dict[str, bytes], dict[str, str]]:
    """Return the FMUs by their path in the SSP, and the path for each component; one FMU is there once."""
    contents: dict[str, bytes] = {}
    sources: dict[str, str] = {}
    for component in system.components:
        fmu = component.fmu
        try:
            content = fmu.path.read_bytes()
        except OSError as error:
            raise InputError(f"cannot be read: {error.strerror}", file=fmu.path) from error
        if hashlib.sha256(content).hexdigest() != fmu.sha256:
            raise InputError("has changed while it was used; try again", file=fmu.path)
        stem = re.sub(r"[^A-Za-z0-9_.-]+", "_", fmu.path.stem)
        source = f"resources/{stem}.fmu"
        if contents.setdefault(source, content) != content:
            source = f"resources/{re.sub(r'[^A-Za-z0-9_.-]+', '_', component.name)}_{stem}.fmu"
            contents[source] = content
        sources[component.name] = source
    return contents, sources
