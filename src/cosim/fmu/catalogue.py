"""The FMUs that come with the project: which there are, and building those that are missing or out of date.

What there is stands in ``fmus/catalogue.toml``; no code here knows a model.
"""

from __future__ import annotations

import hashlib
import json
import os
import tomllib
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

from cosim import __version__
from cosim.archive import Archive
from cosim.errors import FmuError, InputError
from cosim.fmu import provenance
from cosim.fmu.versions import FmiChoice, FmiVersion, file_name, versions_of

_PACKAGE = Path(__file__).parents[1]


@dataclass(frozen=True)
class CatalogueEntry:
    """One FMU of the catalogue."""

    name: str
    kind: str
    """"system" or "controller"."""
    model: str
    """Full Modelica name; that of the folder if the FMU is written by hand."""
    source: Path
    """Modelica package folder or file, or the folder of an FMU that is written by hand."""
    description: str
    by_hand: bool = False

    @property
    def fmu_name(self) -> str:
        """Name of the FMU, which is the last part of the model's."""
        return self.model.rpartition(".")[2]


def data_folder() -> Path:
    """The folder that holds modelica/, fmus/ and scenarios/: the checkout, or the package data of a wheel."""
    checkout = _PACKAGE.parents[1]
    if (checkout / "fmus" / "catalogue.toml").is_file():
        return checkout
    return _PACKAGE / "data"


def build_folder() -> Path:
    """Where built FMUs land: ``fmus/`` of a checkout, else a folder in the user's cache."""
    folder = data_folder()
    if folder != _PACKAGE / "data" and os.access(folder / "fmus", os.W_OK):
        return folder / "fmus"
    return _cache_folder() / __version__ / "fmus"


def names() -> dict[str, CatalogueEntry]:
    """All entries by their name in scenario files."""
    folder = data_folder()
    entries = tomllib.loads((folder / "fmus" / "catalogue.toml").read_text(encoding="utf-8"))
    return {
        name: CatalogueEntry(
            name,
            e["kind"],
            e.get("model") or Path(e["source"]).name,
            folder / e["source"],
            e["description"],
            by_hand="model" not in e,
        )
        for name, e in entries.items()
    }


def ensure(name: str, fmi: FmiVersion = "3.0") -> Path:
    """The FMU of this name, built first if it is missing or out of date.

    Raises:
        InputError: there is no such entry.
        ModelError, BuildError: it cannot be built.
    """
    return _build(entry_of(name), build_folder(), fmi)[0]


def build(
    wanted: Iterable[str] | None = None,
    out: Path | None = None,
    fmi: FmiChoice = "3.0",
    platforms: str = "host",
    *,
    with_sources: bool | None = None,
) -> list[Path]:
    """Build the FMUs of these names (all by default) where they are missing or out of date; their paths.

    ``platforms`` as :func:`cosim.fmu.toolchain.chosen` takes it. An FMU for more platforms than asked for will do.

    Raises:
        InputError: there is no such entry.
        ModelError, BuildError: one cannot be built.
    """
    entries = [entry_of(name) for name in (wanted or names())]
    folder = out or build_folder()
    # one more thread than processors, for the one that has a model's equations in hand while others compile C
    with ThreadPoolExecutor((os.cpu_count() or 1) + 1) as threads:
        built = threads.map(lambda entry: _build(entry, folder, fmi, platforms, with_sources), entries)
        return [path for paths in built for path in paths]


def entry_of(name: str) -> CatalogueEntry:
    """The entry with this name, or with an FMU of this name. Raises `InputError` if there is none."""
    known = names()
    for entry in known.values():
        if name in (entry.name, entry.fmu_name):
            return entry
    near = get_close_matches(name, [*known, *(entry.fmu_name for entry in known.values())], n=1)
    hint = f", did you mean '{near[0]}'?" if near else ""
    raise InputError(
        f"no built-in plant or controller '{name}'{hint}; built in are {', '.join(known)}; "
        "an FMU of your own is given by its path, ending in .fmu"
    )


def is_own(path: Path, sha256: str) -> bool:
    """Tell whether a file with this content has been built here, or is one of the catalogue that is up to date."""
    if provenance.is_known(sha256):
        return True
    if not has(path):
        return False
    provenance.note(sha256)
    return True


def scratch(name: str, purpose: str) -> Path:
    """A folder in the user's cache for what is made from an entry; another one as soon as the FMU would be.

    Raises:
        InputError: there is no such entry.
    """
    digest = hashlib.sha256(f"{_hash(entry_of(name))} {purpose}".encode()).hexdigest()
    return _cache_folder() / "scratch" / digest[:32]


def has(path: Path) -> bool:
    """Whether this file is the FMU of an entry, where such are built, and up to date."""
    if path.resolve().parent != build_folder().resolve():
        return False
    return any(
        path.name == file_name(entry.fmu_name, fmi) and _up_to_date(path, _hash(entry), set())
        for entry in names().values()
        for fmi in versions_of("both")
    )


def _build(
    entry: CatalogueEntry, out: Path, choice: FmiChoice, platforms: str = "host", with_sources: bool | None = None
) -> list[Path]:
    versions = versions_of(choice)
    paths = {fmi: out / file_name(entry.fmu_name, fmi) for fmi in versions}
    wanted = _hash(entry)

    def outdated() -> list[FmiVersion]:
        return [
            fmi
            for fmi in versions
            if not _up_to_date(paths[fmi], wanted, _folders(platforms, fmi) | ({"sources/"} if with_sources else set()))
        ]

    if outdated():
        from filelock import FileLock

        out.mkdir(parents=True, exist_ok=True)
        with FileLock(_lock(out / entry.fmu_name)):
            missing = outdated()  # another process may have built some meanwhile
            if missing and entry.by_hand:
                from cosim.fmu.handwritten import pack_folder

                for version in missing:
                    pack_folder(entry.source, out, fmi=version, build_hash=wanted, platforms=platforms)
            elif missing:
                from cosim.fmu.exporter import export_all

                export_all(
                    entry.source,
                    entry.model,
                    out,
                    fmi="both" if len(missing) > 1 else missing[0],
                    build_hash=wanted,
                    platforms=platforms,
                    with_sources=with_sources,
                )
    return list(paths.values())


def _lock(target: Path) -> Path:
    """The file that locks a target, in the user's cache: a folder of the user's is for what was asked for alone."""
    name = hashlib.sha256(os.path.normcase(target.resolve()).encode()).hexdigest()[:32]
    path = _cache_folder() / "locks" / f"{name}.lock"
    path.parent.mkdir(parents=True, exist_ok=True)
    return path


def _cache_folder() -> Path:
    import platformdirs

    return Path(platformdirs.user_cache_dir("wiper-cosim"))


def _folders(platforms: str, fmi: FmiVersion) -> set[str]:
    from cosim.fmu.toolchain import chosen

    return {f"binaries/{target.folder(fmi)}/" for target in chosen(platforms, fmi)}


def _up_to_date(path: Path, wanted: str, folders: set[str]) -> bool:
    """Whether there is an FMU with this hash, and with files in each of these folders."""
    try:
        archive = Archive.open(path)
        record = json.loads(archive.read("extra/io.github.wiper-cosim/build.json"))
    except (FmuError, KeyError, ValueError):
        return False
    present = {name[: name.rindex("/") + 1] for name in archive.sizes if "/" in name}
    return bool(record.get("hash") == wanted and folders <= present)


def _hash(entry: CatalogueEntry) -> str:
    """Digest of everything the FMU is made from: the model's text, the compiler, the runtime, the tools' versions."""
    digest = hashlib.sha256(entry.model.encode())
    if entry.by_hand:
        files = [path for path in sorted(entry.source.iterdir()) if path.suffix in (".c", ".h", ".xml")]
        files += [_PACKAGE / "fmu" / name for name in ("handwritten.py", "toolchain.py")]
        return _digest(digest, files)
    files = sorted(entry.source.rglob("*.mo")) + sorted(entry.source.rglob("package.order"))
    files += sorted((_PACKAGE / "fmu" / "runtime").glob("*.[ch]"))
    for folder in ("modelica", "dae", "fmu"):
        files += sorted((_PACKAGE / folder).glob("*.py"))
    return _digest(digest, files)


def _digest(digest: hashlib._Hash, files: Iterable[Path]) -> str:
    """Add the files and the tools' versions to a digest; return it."""
    for file in files:
        digest.update(file.name.encode() + b"\0" + file.read_bytes() + b"\0")
    digest.update(json.dumps(_tool_versions(), sort_keys=True).encode())
    return digest.hexdigest()


def _tool_versions() -> dict[str, str | None]:
    from importlib.metadata import PackageNotFoundError, version

    found: dict[str, str | None] = {}
    for package in ("rumoca", "casadi", "ziglang", "fmpy"):
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = None
    return found
