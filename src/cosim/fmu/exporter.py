"""From a Modelica file to an .fmu file: compile, generate, describe, link, pack."""

from __future__ import annotations

import gc
import hashlib
import json
import os
import re
import tempfile
import warnings
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from threading import Lock

from cosim import __version__
from cosim.dae import Dae, compile_dae
from cosim.errors import ModelWarning
from cosim.fmu.binaries import build_binaries
from cosim.fmu.codegen import generate
from cosim.fmu.description import describe
from cosim.fmu.description2 import describe2
from cosim.fmu.documentation import document_model
from cosim.fmu.layout import lay_out
from cosim.fmu.provenance import remember
from cosim.fmu.sources import build_description, compiled, source_files
from cosim.fmu.terminals import icon, terminals_and_icons
from cosim.fmu.toolchain import RUNTIME, Platform, chosen
from cosim.fmu.versions import FmiChoice, FmiVersion, file_name, versions_of
from cosim.modelica import Source, check_units, flatten, refuse_mismatches

BUILD_RECORD = "extra/io.github.wiper-cosim/build.json"
_TOKEN = "{token}"
"""Stands for the instantiation token until the content it is made from is known."""
_EPOCH = (1980, 1, 1, 0, 0, 0)
_EXPRESSIONS = Lock()


def compile_model(file: Path, model: str, *, strict_units: bool = False) -> Dae:
    """Compile one class of a Modelica file or package to a :class:`Dae`.

    Units that do not fit are a `ModelWarning` each, or all together an error if ``strict_units``.

    Raises:
        ModelError: the model is wrong or uses something unsupported; the message says what and where.
    """
    flat = flatten(Source.read(file), model)
    mismatches = check_units(flat)
    if strict_units:
        refuse_mismatches(flat, mismatches)
    for mismatch in mismatches:
        warnings.warn(str(mismatch), ModelWarning, stacklevel=2)
    return compile_dae(flat)


def export(
    file: Path,
    model: str,
    out: Path,
    *,
    fmi: FmiVersion = "3.0",
    build_hash: str | None = None,
    platforms: str = "host",
    with_sources: bool | None = None,
    fixed_step: float | None = None,
) -> Path:
    """Compile one class of a Modelica file or package to an FMU in the folder ``out``.

    ``platforms`` is "host", "all", or names separated by commas, as :func:`cosim.fmu.toolchain.chosen` takes them.
    The C from which the binaries are built goes along if ``with_sources``, by default if there is one binary only. With
    ``fixed_step`` [s] the solver takes steps of this length, and the work in each is bounded; see docs/fixed_step.md.

    The FMI 3.0 file is ``<last part of the model's name>.fmu``, the FMI 2.0 one ends in ``.fmi2.fmu``. It is written
    beside its place and moved there, so that it is never seen half done.

    Raises:
        ModelError: the model is wrong or uses something unsupported.
        BuildError: there is no C compiler, or it failed.
    """
    return pack(
        compile_model(file, model),
        out,
        fmi=fmi,
        build_hash=build_hash,
        platforms=platforms,
        with_sources=with_sources,
        fixed_step=fixed_step,
    )


def export_all(
    file: Path,
    model: str,
    out: Path,
    *,
    fmi: FmiChoice = "both",
    build_hash: str | None = None,
    strict_units: bool = False,
    platforms: str = "host",
    with_sources: bool | None = None,
) -> list[Path]:
    """Compile one class once and write it as an FMU of each chosen FMI version; see :func:`export`.

    Several threads may do this at a time.
    """
    with _alone():
        # the model's expressions go before others begin
        prepared = _prepare(
            compile_model(file, model, strict_units=strict_units), fmi, build_hash, platforms, with_sources
        )
    return _write(prepared, out)


def pack_all(
    dae: Dae,
    out: Path,
    *,
    fmi: FmiChoice = "both",
    build_hash: str | None = None,
    platforms: str = "host",
    with_sources: bool | None = None,
    fixed_step: float | None = None,
) -> list[Path]:
    """Write a compiled model as an FMU of each chosen FMI version; see :func:`export`."""
    return _write(_prepare(dae, fmi, build_hash, platforms, with_sources, fixed_step), out)


def pack(
    dae: Dae,
    out: Path,
    *,
    fmi: FmiVersion = "3.0",
    build_hash: str | None = None,
    platforms: str = "host",
    with_sources: bool | None = None,
    fixed_step: float | None = None,
) -> Path:
    """Write a compiled model as an FMU for the platforms that :func:`toolchain.chosen` takes; see :func:`export`."""
    return _write(_prepare(dae, fmi, build_hash, platforms, with_sources, fixed_step), out)[0]


@contextmanager
def _alone() -> Iterator[None]:
    """One thread at a time works with expressions, and what is left of them is collected before the next one does.

    CasADi lets other threads run meanwhile, but counts the users of its expressions without locks.
    """
    with _EXPRESSIONS:
        collecting = gc.isenabled()
        gc.disable()
        try:
            yield
            gc.collect()
        finally:
            if collecting:
                gc.enable()


@dataclass(frozen=True)
class _Prepared:
    """All of a model's FMUs but their binaries."""

    identifier: str
    generated: dict[str, str]
    """The generated C, with a placeholder for the token."""
    tokens: dict[FmiVersion, str]
    targets: dict[FmiVersion, tuple[Platform, ...]]
    files: dict[FmiVersion, dict[str, bytes]]


def _prepare(
    dae: Dae,
    choice: FmiChoice,
    build_hash: str | None,
    platforms: str,
    with_sources: bool | None,
    fixed_step: float | None = None,
) -> _Prepared:
    """Generate and describe; expressions are needed for this alone."""
    identifier = re.sub(r"\W", "_", dae.name.rpartition(".")[2])
    targets = {fmi: chosen(platforms, fmi) for fmi in versions_of(choice)}
    layout = lay_out(dae)
    prepared = _Prepared(identifier, generate(dae, layout, _TOKEN, fixed_step), {}, targets, {})
    shared = {
        BUILD_RECORD: _record(dae, build_hash),
        "documentation/licenses/LICENSE.txt": (RUNTIME / "LICENSE").read_bytes(),
        "documentation/index.html": document_model(dae, layout, tool_versions(), fixed_step),
    }
    for fmi, platforms_of in targets.items():
        sourced = len(platforms_of) == 1 if with_sources is None else with_sources
        listed = compiled(source_files(prepared.generated, fmi)) if sourced else []
        if fmi == "3.0":
            description = describe(dae, layout, identifier, _TOKEN, fixed_step)
        else:
            description = describe2(dae, layout, identifier, _TOKEN, listed, fixed_step)
        token = prepared.tokens[fmi] = _token(prepared.generated, description)
        files = shared | {"modelDescription.xml": description.replace(_TOKEN.encode(), token.encode())}
        if fmi == "3.0":
            files["terminalsAndIcons/terminalsAndIcons.xml"] = terminals_and_icons(layout)
            files["terminalsAndIcons/icon.png"] = icon(layout)
        else:
            files["model.png"] = icon(layout)
        if sourced:
            sources = source_files(_with_token(prepared.generated, token), fmi)
            if fmi == "3.0":
                sources["buildDescription.xml"] = build_description(sources, identifier)
            files |= {f"sources/{name}": content for name, content in sources.items()}
        prepared.files[fmi] = files
    return prepared


def _write(prepared: _Prepared, out: Path) -> list[Path]:
    """Compile, link and pack."""
    identifier = prepared.identifier
    shells = {fmi: _with_token(prepared.generated, token) for fmi, token in prepared.tokens.items()}
    libraries = build_binaries(identifier, prepared.generated, shells, prepared.targets)
    paths = []
    for fmi, files in prepared.files.items():
        binaries = {
            f"binaries/{target.folder(fmi)}/{identifier}{target.suffix}": content
            for target, content in libraries[fmi].items()
        }
        paths.append(write_archive(out, file_name(identifier, fmi), files | binaries))
    return paths


def _with_token(generated: dict[str, str], token: str) -> dict[str, str]:
    return {name: text.replace(_TOKEN, token) for name, text in generated.items()}


def write_archive(out: Path, name: str, files: dict[str, bytes]) -> Path:
    """Write an .fmu file of this name beside its place and move it there; its path."""
    out.mkdir(parents=True, exist_ok=True)
    handle, part = tempfile.mkstemp(prefix=f".{name}-", suffix=".part", dir=out)
    with os.fdopen(handle, "wb") as stream:
        _zip(stream, files)
    path = out / name
    Path(part).chmod(0o644)
    Path(part).replace(path)
    remember(path)
    return path


def _token(sources: dict[str, str], description: bytes) -> str:
    """A name for this very FMU: another model, or another compiler or runtime, gives another one."""
    digest = hashlib.sha256(description)
    for text in sources.values():
        digest.update(text.encode())
    for file in sorted(RUNTIME.glob("*.[ch]")):
        digest.update(file.read_bytes())
    h = digest.hexdigest()
    return f"{{{h[:8]}-{h[8:12]}-{h[12:16]}-{h[16:20]}-{h[20:32]}}}"


def _record(dae: Dae, build_hash: str | None) -> bytes:
    record = {"model": dae.name, "hash": build_hash, "cosim": __version__, "tools": tool_versions()}
    return json.dumps(record, indent=1, sort_keys=True).encode() + b"\n"


def tool_versions() -> dict[str, str | None]:
    """Versions of what an FMU's content depends on."""

    def installed(package: str) -> str | None:
        try:
            return version(package)
        except PackageNotFoundError:
            return None

    return {package: installed(package) for package in ("rumoca", "casadi", "ziglang", "fmpy")}


def _zip(stream: object, files: dict[str, bytes]) -> None:
    """Pack with fixed dates and order, so that the same content gives the same bytes."""
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:  # type: ignore[call-overload]
        for name in sorted(files):
            entry = zipfile.ZipInfo(name, _EPOCH)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o755 if name.startswith("binaries/") else 0o644) << 16
            archive.writestr(entry, files[name], compresslevel=9)
