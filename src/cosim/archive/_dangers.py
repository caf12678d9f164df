"""What makes a zip archive dangerous to unpack, told from its directory alone.

An FMU is a zip archive as ISO/IEC 21320-1 restricts it (FMI 3.0, section 2.5): stored or deflated members, not
encrypted, on one volume; and names are relative, with forward slashes (PKWARE's APPNOTE, 4.4.17). Some tools write
backslashes (modelica/fmi-cross-check issue 43); they are read as what they mean.
"""

from __future__ import annotations

import re
import stat
import zipfile
from collections.abc import Iterator, Sequence
from typing import NamedTuple

MOST_MEMBERS = 50_000
"""More files than this are refused; the largest FMUs that carry a Python environment have about 20,000."""

MOST_BYTES = 4 << 30
"""More than this [bytes] is not unpacked."""

MOST_RATIO = 100
"""Unpacked size over packed size, looked at from ``_SMALL`` on; libraries and tables pack to a third or a tenth."""

_SMALL = 100 << 20
_LOCAL_HEADER = 30
_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
_ENCRYPTED = 0x1 | 0x40 | 0x2000
_CONTROL = re.compile(r"[\x00-\x1f\x7f]")
_DRIVE = re.compile(r"(^|/)[A-Za-z]:")


class Danger(NamedTuple):
    """Why an archive is refused: a rule's ``id``, the ``member`` (empty: the whole archive), and what is wrong."""

    id: str
    member: str
    text: str


def dangers(members: Sequence[zipfile.ZipInfo], packed: int) -> list[Danger]:
    """Return all that makes it dangerous to unpack an archive with these members, ``packed`` bytes long."""
    return [*_of_names(members), *_of_members(members), *_of_sizes(members, packed)]


def cleaned(name: str) -> str:
    """Return a member's name with forward slashes, and without the "./" that some tools put in front.

    Both faults are harmless once they are mended: all rules look at the name as it is then, and so it is unpacked.
    """
    name = name.replace("\\", "/")
    while name.startswith("./"):
        name = name[2:]
    return name


def is_folder(member: zipfile.ZipInfo) -> bool:
    """Tell whether a member is a folder; zipfile's own function fails if the name is empty."""
    return cleaned(member.filename).endswith("/")


def _of_names(members: Sequence[zipfile.ZipInfo]) -> Iterator[Danger]:
    files: set[str] = set()
    folders: set[str] = set()
    for member in members:
        name = member.orig_filename
        shown = ascii(name)[1:-1]
        plain = cleaned(name)
        parts = plain.split("/")
        if not plain or _CONTROL.search(plain):
            yield Danger("name", shown, "has no name, or control characters in it")
        elif plain.startswith("/"):
            yield Danger("absolute", shown, "has an absolute path")
        elif _DRIVE.search(plain):
            yield Danger("drive", shown, "has a drive letter in its path")
        elif ".." in parts:
            yield Danger("traversal", shown, "leads out of the folder it is unpacked to")
        clean = "/".join(part for part in parts if part not in ("", "."))
        if is_folder(member):
            folders.add(clean)
            continue
        if clean in files:
            yield Danger("duplicate", shown, "is in it twice")
        files.add(clean)
        folders.update(clean[:k] for k, character in enumerate(clean) if character == "/")
    for name in sorted(files & folders):
        yield Danger("duplicate", name, "is both a file and a folder")


def _of_members(members: Sequence[zipfile.ZipInfo]) -> Iterator[Danger]:
    for member in members:
        shown = ascii(member.orig_filename)[1:-1]
        kind = stat.S_IFMT(member.external_attr >> 16)
        if kind == stat.S_IFLNK:
            yield Danger("link", shown, "is a symbolic link; pack the file that it leads to")
        elif kind not in (0, stat.S_IFREG, stat.S_IFDIR):
            yield Danger("link", shown, "is a device, a pipe or a socket")
        if member.flag_bits & _ENCRYPTED:
            yield Danger("encrypted", shown, "is encrypted; pack it without a password")
        elif member.compress_type not in _METHODS:
            yield Danger("method", shown, "is packed by another method than deflate; pack it again")


def _of_sizes(members: Sequence[zipfile.ZipInfo], packed: int) -> Iterator[Danger]:
    if len(members) > MOST_MEMBERS:
        yield Danger("count", "", f"has {len(members)} files; {MOST_MEMBERS} are accepted")
    size = sum(member.file_size for member in members)
    if size > MOST_BYTES:
        yield Danger("size", "", f"has {_mebibytes(size)} in it; {_mebibytes(MOST_BYTES)} are accepted")
    elif size > _SMALL and size > MOST_RATIO * packed:
        ratio = size // max(packed, 1)
        yield Danger("ratio", "", f"unpacks to {_mebibytes(size)}, {ratio} times its size; {MOST_RATIO} are accepted")
    end = 0
    for member in sorted(members, key=lambda one: one.header_offset):
        if member.header_offset < end:
            yield Danger("overlap", ascii(member.orig_filename)[1:-1], "lies in the archive where another file lies")
        end = member.header_offset + _LOCAL_HEADER + len(member.orig_filename) + member.compress_size


def _mebibytes(size: int) -> str:
    return f"{size >> 20} MiB"
