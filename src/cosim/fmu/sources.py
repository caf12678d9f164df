"""The sources of an FMU, from which any C11 compiler builds its binary: ``sources/`` and what describes it."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping

from cosim.fmu._description_parts import document
from cosim.fmu.toolchain import PORTABLE_FLAGS, RUNTIME, fmi_headers, runtime_sources
from cosim.fmu.versions import FmiVersion


def source_files(generated: Mapping[str, str], fmi: FmiVersion) -> dict[str, bytes]:
    """The files below ``sources/`` by name: the generated ones, the runtime, and FMI's own headers.

    The headers are there so that nothing else is needed; an importer that has its own may use these.
    """
    files = {name: text.encode() for name, text in generated.items()}
    runtime = [*runtime_sources(fmi), *RUNTIME.glob("*.h")]
    headers = fmi_headers().glob(f"fmi{fmi[0]}*.h")
    return files | {path.name: path.read_bytes() for path in (*runtime, *headers)}


def compiled(files: Mapping[str, bytes]) -> list[str]:
    """The names of the files to compile, in a fixed order."""
    return sorted(name for name in files if name.endswith(".c"))


def build_description(files: Mapping[str, bytes], identifier: str) -> bytes:
    """``buildDescription.xml`` of FMI 3.0."""
    root = ET.Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = ET.SubElement(
        root,
        "BuildConfiguration",
        modelIdentifier=identifier,
        description="A shared library; needs the C standard library and nothing else",
    )
    sources = ET.SubElement(configuration, "SourceFileSet", language="C11", compilerOptions=" ".join(PORTABLE_FLAGS))
    for name in compiled(files):
        ET.SubElement(sources, "SourceFile", name=name)
    ET.SubElement(sources, "IncludeDirectory", name=".")
    ET.SubElement(configuration, "Library", name="m", external="true", description="The C library's mathematics")
    return document(root)
