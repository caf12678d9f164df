"""Rules on the zip archive; an FMU that breaks one with severity error is not read any further."""

from __future__ import annotations

from collections.abc import Iterator

from cosim.archive import Archive
from cosim.check._rules import Found, Rules, Severity, shortened

ARCHIVE_RULES: Rules[Archive] = Rules()
_PACK_AGAIN = "pack the FMU again with a zip tool that follows ISO/IEC 21320-1"


def _dangers(archive: Archive, *kinds: str) -> Iterator[Found]:
    for danger in archive.dangers:
        if danger.id in kinds:
            yield Found(danger.text, danger.member, _PACK_AGAIN)


@ARCHIVE_RULES("archive.path", Severity.ERROR)
def path(archive: Archive) -> Iterator[Found]:
    """Every path in the archive is relative, stays in its folder, and has no control characters."""
    yield from _dangers(archive, "name", "absolute", "drive", "traversal")


@ARCHIVE_RULES("archive.duplicate", Severity.ERROR)
def duplicate(archive: Archive) -> Iterator[Found]:
    """No file is in the archive twice, or is a folder, too."""
    yield from _dangers(archive, "duplicate")


@ARCHIVE_RULES("archive.link", Severity.ERROR)
def link(archive: Archive) -> Iterator[Found]:
    """There are no symbolic links, devices or pipes in the archive."""
    yield from _dangers(archive, "link")


@ARCHIVE_RULES("archive.method", Severity.ERROR)
def method(archive: Archive) -> Iterator[Found]:
    """Files are stored or deflated, and not encrypted."""
    yield from _dangers(archive, "encrypted", "method")


@ARCHIVE_RULES("archive.bomb", Severity.ERROR)
def bomb(archive: Archive) -> Iterator[Found]:
    """The archive unpacks to no more than 4 GiB, 100 times its size and 50,000 files, none of which overlap."""
    yield from _dangers(archive, "count", "size", "ratio", "overlap")


@ARCHIVE_RULES("archive.case", Severity.WARNING)
def case(archive: Archive) -> Iterator[Found]:
    """No two names differ in capital and small letters only; on Windows and macOS one would overwrite the other."""
    by_folded: dict[str, list[str]] = {}
    for name in archive.sizes:
        by_folded.setdefault(name.casefold(), []).append(name)
    for names in by_folded.values():
        if len(names) > 1:
            yield Found("differ in capital and small letters only", shortened(names), "rename all but one of them")
