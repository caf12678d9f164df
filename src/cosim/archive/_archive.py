"""A zip archive in memory: what was checked is what is unpacked."""

from __future__ import annotations

import hashlib
import io
import shutil
import zipfile
from pathlib import Path

from cosim.archive._dangers import Danger, cleaned, dangers, is_folder
from cosim.errors import FmuError

_SHOWN = 3


class Archive:
    """An archive that was read whole, so that nobody can change it between the check and the unpacking.

    ``path`` is the file, ``sha256`` its hash, ``size`` its length [bytes], ``sizes`` the unpacked sizes [bytes] of its
    files by name, ``dangers`` why it must not be unpacked, ``dotted`` whether names begin with "./",
    ``backslashed`` whether they have backslashes.
    """

    def __init__(self, path: Path, content: bytes, kind: str) -> None:
        """Read the directory; users call ``open``, or ``inspect`` to see what is dangerous."""
        self.path = path
        self.size = len(content)
        self.sha256 = hashlib.sha256(content).hexdigest()
        try:
            self._zip = zipfile.ZipFile(io.BytesIO(content))
        except Exception as error:  # a damaged directory ends in many kinds of exceptions
            raise FmuError(_unreadable(content, kind), file=path) from error
        self._kind = kind
        members = self._zip.infolist()
        self.dangers: list[Danger] = dangers(members, len(content))
        names = [member.orig_filename for member in members]
        self.dotted = any(name.startswith("./") for name in names)
        self.backslashed = any("\\" in name for name in names)
        self._members = {cleaned(member.filename): member for member in members if not is_folder(member)}
        self.sizes = {name: member.file_size for name, member in self._members.items()}

    @classmethod
    def inspect(cls, path: Path | str, kind: str = "FMU") -> Archive:
        """Read an archive, dangerous or not; nothing of a dangerous one can be read or unpacked.

        Raises FmuError if the file cannot be read or is no zip archive; ``kind`` says what it should have been.
        """
        path = Path(path)
        try:
            return cls(path, path.read_bytes(), kind)
        except OSError as error:
            ending = ".fmu" if kind == "FMU" else f".{kind.lower()}"
            article = "an" if kind[0] in "FS" else "a"
            raise FmuError(
                f"cannot be read: {error.strerror}; give the path of {article} {ending} file", file=path
            ) from error

    @classmethod
    def open(cls, path: Path | str, kind: str = "FMU") -> Archive:
        """Read an archive that is safe to unpack; raises FmuError as ``inspect``, and for whatever is dangerous."""
        archive = cls.inspect(path, kind)
        archive._refuse_dangers()
        return archive

    def __contains__(self, name: object) -> bool:
        """Tell whether there is a file of this name."""
        return name in self._members

    def read(self, name: str) -> bytes:
        """Return a file's content; raises KeyError if there is none, FmuError if it is damaged."""
        self._refuse_dangers()
        try:
            return self._zip.read(self._members[name])
        except KeyError:
            raise
        except Exception as error:
            raise FmuError(f"is damaged: {name} cannot be unpacked; copy or export it again", file=self.path) from error

    def extract(self, folder: Path | str, wanted: tuple[str, ...] = ("",)) -> None:
        """Unpack the files whose names begin with one of ``wanted``; raises FmuError if one is damaged."""
        self._refuse_dangers()
        for name, member in self._members.items():
            if not name.startswith(wanted):
                continue
            target = Path(folder, name)
            try:
                target.parent.mkdir(parents=True, exist_ok=True)
                with self._zip.open(member) as source, target.open("wb") as unpacked:
                    shutil.copyfileobj(source, unpacked)
            except Exception as error:
                raise FmuError(
                    f"cannot be unpacked: {name}: {error}; copy or export it again", file=self.path
                ) from error

    def _refuse_dangers(self) -> None:
        if self.dangers:
            told = [f"{one.member} {one.text}".strip() for one in self.dangers[:_SHOWN]]
            more = len(self.dangers) - _SHOWN
            rest = f"; and {more} more" if more > 0 else ""
            raise FmuError(f"is refused, nothing was unpacked: {'; '.join(told)}{rest}", file=self.path)


def _unreadable(content: bytes, kind: str) -> str:
    """Tell a file that was cut off from one that never was a zip archive."""
    article = "an" if kind[0] in "FS" else "a"
    if content.startswith(b"PK\3\4"):
        return f"is not {article} {kind}: the zip archive is cut off or damaged; copy it again"
    return f"is not {article} {kind}: it is not a zip archive; export the model again"
