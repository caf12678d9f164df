"""Modelica source text: a file, or a package folder read as one text; from an offset in it back to file and line."""

from __future__ import annotations

import bisect
import re
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path

from cosim.errors import ModelError

_STRING = r'"(?:\\.|[^"\\])*"'
_WITHIN = re.compile(r"^\s*(?:(?://[^\n]*\n|/\*.*?\*/)\s*)*within\b[^;]*;", re.DOTALL)

_CLASS = r"(?:model|block|class|package|record|connector|function|type)"


@dataclass(frozen=True)
class Place:
    """A position in a source file, line and column counted from 1."""

    file: Path
    line: int
    column: int


@dataclass
class Source:
    """One Modelica text and where each piece of it came from.

    A structured package (a folder with ``package.mo``) is put together as if it had been written in one file, in the
    order of ``package.order``, which is what the Modelica specification (13.4) defines it to mean.
    """

    text: str
    files: tuple[Path, ...]
    _pieces: list[tuple[int, Path, int]] = field(repr=False)
    """Offset in bytes, file, offset in that file."""

    @classmethod
    def read(cls, path: Path) -> Source:
        """Read a ``.mo`` file or a package folder; a file inside a package folder stands for the whole package.

        Raises:
            ModelError: the file does not exist, is not Modelica text, or a package folder is incomplete.
        """
        path = Path(path)
        if not path.exists():
            raise ModelError("no such file or folder; give a .mo file or a folder with a package.mo", file=path)
        root = path if path.is_dir() else path.parent
        if path.is_dir() and not (path / "package.mo").is_file():
            raise ModelError("this folder has no package.mo, so it is not a Modelica package", file=path)
        if (root / "package.mo").is_file():
            while (root.parent / "package.mo").is_file():
                root = root.parent
            builder = _Builder()
            builder.package(root)
        else:
            builder = _Builder()
            builder.add(path, 0, _decode(path))
        return builder.source()

    def rearranged(self, chunks: list[tuple[bytes, int]]) -> Source:
        """Another text, put together from chunks; with each goes the offset in this one that it comes from."""
        pieces: list[tuple[int, Path, int]] = []
        length = 0
        for text, origin in chunks:
            # a chunk may run over several files
            first = max(0, bisect.bisect_right(self._pieces, origin, key=lambda piece: piece[0]) - 1)
            for start, file, base in self._pieces[first:]:
                if start >= origin + max(1, len(text)):
                    break
                pieces.append((length + max(0, start - origin), file, base + max(0, origin - start)))
            length += len(text)
        return Source(b"".join(text for text, _ in chunks).decode(), self.files, pieces)

    def place(self, offset: int) -> Place:
        """File, line and column of a byte offset in the text."""
        index = max(0, bisect.bisect_right(self._pieces, offset, key=lambda piece: piece[0]) - 1)
        start, file, base = self._pieces[index]
        before = file.read_bytes()[: base + max(0, offset - start)]
        line_start = before.rfind(b"\n") + 1
        return Place(file, before.count(b"\n") + 1, len(before[line_start:].decode("utf-8", "replace")) + 1)

    def with_line(self, text: str, offset: int) -> str:
        """A piece of a message with the file's name and the line of a byte offset behind it."""
        place = self.place(offset)
        return f"{text} ({place.file.name}:{place.line})"

    def error(self, message: str, offset: int | None = None) -> ModelError:
        """Build the error for something wrong at a byte offset (or in the text as a whole)."""
        if offset is None:
            return ModelError(message, file=self.files[0])
        place = self.place(offset)
        return ModelError(message, file=place.file, line=place.line, column=place.column)

    def find(self, name: str, *, after: int = 0) -> int | None:
        """Byte offset of the first use of an identifier, comments and strings aside."""
        pattern = re.compile(r"//[^\n]*|/\*.*?\*/|\"(?:\\.|[^\"\\])*\"|\b(" + re.escape(name) + r")\b", re.DOTALL)
        encoded_from = self.text.encode()[:after].decode("utf-8", "replace")
        for match in pattern.finditer(self.text, len(encoded_from)):
            if match.group(1):
                return len(self.text[: match.start()].encode())
        return None

    def find_class(self, qualified: str) -> int | None:
        """Byte offset of the declaration of a class, given its full name."""
        offset = 0
        for part in qualified.split("."):
            match = re.compile(rf"\b{_CLASS}\s+({re.escape(part)})\b").search(self.text, offset)
            if match is None:
                return None
            offset = match.start(1)
        return len(self.text[:offset].encode())

    def near_class(self, qualified: str) -> str | None:
        """Full name of a class that is called much like one that is not there, if only one part of it is misspelt."""
        parts = qualified.split(".")
        wrong = next((k for k in range(len(parts)) if self.find_class(".".join(parts[: k + 1])) is None), None)
        if wrong is None:
            return None
        declared = set(re.findall(rf"\b{_CLASS}\s+([A-Za-z_]\w*)", self.text))
        for near in get_close_matches(parts[wrong], declared):
            name = ".".join([*parts[:wrong], near, *parts[wrong + 1 :]])
            if self.find_class(name) is not None:
                return name
        return None


class _Builder:
    """Appends pieces of files and remembers where they came from."""

    def __init__(self) -> None:
        self._chunks: list[str] = []
        self._length = 0
        self._pieces: list[tuple[int, Path, int]] = []
        self._files: list[Path] = []

    def add(self, file: Path, base: int, text: str) -> None:
        """Append ``text``, which stands at byte ``base`` of ``file``."""
        if file not in self._files:
            self._files.append(file)
        self._pieces.append((self._length, file, base))
        self._chunks.append(text)
        self._length += len(text.encode())

    def package(self, folder: Path) -> None:
        """Append a package folder: package.mo with the other members put in right after its heading.

        That is the one place where elements may stand whatever follows; a class annotation must come last.
        """
        file = folder / "package.mo"
        text, base = _without_within(_decode(file))
        heading = re.compile(rf"\bpackage\s+{re.escape(folder.name)}\b(\s*{_STRING}(\s*\+\s*{_STRING})*)?").search(text)
        if heading is None:
            raise ModelError(f"expected 'package {folder.name}', named like its folder", file=file)
        self.add(file, base, text[: heading.end()])
        self._gap()
        for name in self._members(folder):
            member = folder / name
            if member.is_dir():
                self.package(member)
            else:
                body, start = _without_within(_decode(member.with_suffix(".mo")))
                self.add(member.with_suffix(".mo"), start, body)
                self._gap()
        self.add(file, base + len(text[: heading.end()].encode()), text[heading.end() :])
        self._gap()

    def source(self) -> Source:
        return Source("".join(self._chunks), tuple(self._files), self._pieces)

    def _gap(self) -> None:
        self._chunks.append("\n")
        self._length += 1

    @staticmethod
    def _members(folder: Path) -> list[str]:
        found = {entry.name for entry in folder.iterdir() if (entry / "package.mo").is_file()}
        found |= {entry.stem for entry in folder.glob("*.mo") if entry.name != "package.mo"}
        order = folder / "package.order"
        listed = order.read_text(encoding="utf-8").split() if order.is_file() else []
        # package.order also names classes and constants declared inside package.mo itself
        return [name for name in listed if name in found] + sorted(found - set(listed))


def _decode(file: Path) -> str:
    try:
        return file.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ModelError(f"Modelica text is UTF-8; byte {error.start} is not", file=file) from None
    except OSError as error:
        raise ModelError(f"cannot be read: {error.strerror}", file=file) from None


def _without_within(text: str) -> tuple[str, int]:
    match = _WITHIN.match(text)
    return (text[match.end() :], len(text[: match.end()].encode())) if match else (text, 0)
