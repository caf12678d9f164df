"""Where the relative URIs of a system structure lead: into an .ssp, or into the folder of an .ssd."""

from __future__ import annotations

import shutil
import tempfile
import warnings
import weakref
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Protocol
from urllib.parse import unquote, urlsplit

from cosim.archive import Archive
from cosim.engine import Fmu, Interface
from cosim.errors import InputError
from cosim.ssp._xml import Place

DEFAULT = "SystemStructure.ssd"


class Package(Protocol):
    """Files by their path in a package; ``label`` is what a user knows it by."""

    label: str

    def names(self) -> list[str]:
        """Return the files directly in it, of an archive all."""

    def read(self, name: str) -> bytes | None:
        """Return a file's content, None if there is none of this name."""


class ZipPackage:
    """An .ssp file."""

    def __init__(self, path: Path, label: str) -> None:
        """Open it; raises InputError if that is not safe."""
        self._archive = Archive.open(path, "SSP")
        self.label = label

    def names(self) -> list[str]:
        """Return all files."""
        return list(self._archive.sizes)

    def read(self, name: str) -> bytes | None:
        """Return a file's content."""
        return self._archive.read(name) if name in self._archive.sizes else None


class FolderPackage:
    """The folder that an .ssd stands in."""

    def __init__(self, folder: Path) -> None:
        """Take the files of a folder."""
        self._folder = folder
        self.label = str(folder)

    def names(self) -> list[str]:
        """Return the files directly in it."""
        return sorted(path.name for path in self._folder.iterdir() if path.is_file())

    def read(self, name: str) -> bytes | None:
        """Return a file's content."""
        path = self._folder / name
        try:
            return path.read_bytes() if path.is_file() else None
        except OSError as error:
            raise InputError(f"cannot be read: {error.strerror}", file=path) from error


@dataclass(frozen=True)
class Location:
    """A file in a package; relative URIs in it start from its folder."""

    package: Package
    name: str

    @property
    def label(self) -> str:
        """What a user knows the file by."""
        return str(PurePosixPath(self.package.label, self.name))

    def content(self, place: Place | None = None) -> bytes:
        """Return its content; raises InputError, at the place that asks for it, if there is no such file."""
        content = self.package.read(self.name)
        if content is None:
            listed = [name for name in self.package.names() if name.endswith(PurePosixPath(self.name).suffix)]
            known = f"; there is {', '.join(sorted(listed)[:8])}" if listed else ""
            message = f"there is no '{self.name}' in {self.package.label}{known}"
            raise place.fail(message) if place else InputError(message)
        return content

    def at(self, uri: str, place: Place) -> tuple[Location, str]:
        """Return where a URI in this file leads, and its fragment; raises InputError if that is out of the package."""
        try:
            parts = urlsplit(uri)
        except ValueError:
            raise place.fail(f"'{uri}' is not a URI; give a path such as resources/Plant.fmu") from None
        path = PurePosixPath(unquote(parts.path))
        if parts.scheme or parts.netloc or path.is_absolute() or "\\" in uri or "\0" in str(path):
            raise place.fail(
                f"'{uri}' leads out of {self.package.label}; put the file into it and give a path such as "
                "resources/Plant.fmu"
            )
        steps: list[str] = [*PurePosixPath(self.name).parent.parts]
        for step in path.parts:
            if step != "..":
                steps.append(step)
            elif steps:
                steps.pop()
            else:
                raise place.fail(f"'{uri}' leads out of {self.package.label}; put the file into it")
        return Location(self.package, "/".join(steps)), unquote(parts.fragment)

    def inside(self, place: Place, name: str = "") -> Location:
        """Return a file in this one, which is an archive; raises InputError, at the place, if it cannot be opened."""
        path, folder = self.on_disk(place)
        try:
            return Location(ZipPackage(path, self.label), name)
        except InputError as error:
            raise place.fail(str(error).replace(str(path), self.label)) from error
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    def on_disk(self, place: Place) -> tuple[Path, str]:
        """Copy the file into a new temporary folder; return its path, and the folder, which the caller removes."""
        content = self.content(place)
        folder = tempfile.mkdtemp(prefix="cosim-ssp-")
        path = Path(folder, PurePosixPath(self.package.label).name, self.name)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
        return path, folder


def open_package(path: Path) -> Location:
    """Return the default system structure of an .ssp, the one after a ``#``, or an .ssd itself.

    Raises InputError if there is no such file, or if it is not safe to open.
    """
    file, fragment = split_fragment(path)
    if not file.is_file():
        raise InputError(f"there is no file '{file}'")
    if file.suffix.lower() == ".ssd":
        return Location(FolderPackage(file.parent), file.name)
    return Location(ZipPackage(file, str(file)), fragment or DEFAULT)


def split_fragment(path: Path) -> tuple[Path, str]:
    """Split ``x.ssp#Variant.ssd``; a file that has a number sign in its name is meant as a whole."""
    head, mark, fragment = path.name.partition("#")
    return (path, "") if path.is_file() or not mark else (path.with_name(head), fragment)


def read_fmu(location: Location, place: Place, interface: Interface | None = None) -> Fmu:
    """Read an FMU of a package; it keeps its own copy of the file for as long as it lives."""
    path, folder = location.on_disk(place)
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            fmu = Fmu.read(path, interface)
    except InputError as error:
        shutil.rmtree(folder, ignore_errors=True)
        where = f"{path}: "
        raise InputError(str(error).removeprefix(where), file=location.label) from error
    for warning in caught:
        text = str(warning.message).replace(str(path), location.label)
        warnings.warn(text, warning.category, stacklevel=2)
    weakref.finalize(fmu, shutil.rmtree, folder, ignore_errors=True)
    return fmu
