"""Archives that must not be unpacked: each is refused with the message here, and leaves nothing behind."""

from __future__ import annotations

import io
import re
import stat
import struct
import tempfile
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path

import pytest

from cosim.archive import MOST_MEMBERS, Archive
from cosim.engine import Fmu
from cosim.errors import FmuError
from cosim.foreign import read_description

XML = b'<?xml version="1.0" encoding="UTF-8"?><fmiModelDescription fmiVersion="2.0" modelName="x" guid="x"/>'


def packed(*members: tuple[str | zipfile.ZipInfo, bytes], method: int = zipfile.ZIP_DEFLATED) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", method) as archive:
        archive.writestr("modelDescription.xml", XML)
        for name, content in members:
            if isinstance(name, str):
                info = zipfile.ZipInfo("x")
                info.filename = info.orig_filename = name  # ZipInfo itself would mend some names
                info.compress_type = method
                archive.writestr(info, content)
            else:
                archive.writestr(name, content)
    return stream.getvalue()


def special(mode: int) -> zipfile.ZipInfo:
    info = zipfile.ZipInfo("resources/passwords")
    info.create_system = 3
    info.external_attr = (mode | 0o777) << 16
    return info


def encrypted() -> bytes:
    """Set the bit that says so in both headers, as the module cannot write encrypted archives."""
    content = bytearray(packed(("resources/secret", b"secret")))
    for mark, at in ((b"PK\3\4", 6), (b"PK\1\2", 8)):
        content[content.rindex(mark) + at] |= 1
    return bytes(content)


def claiming(size: int, *names: str) -> bytes:
    """Return an archive whose directory claims that each of these files has ``size`` bytes."""
    content = bytearray(packed(*((name, bytes(1000)) for name in names)))
    for name in names:
        entry = content.rindex(name.encode()) - 46
        content[entry + 24 : entry + 28] = struct.pack("<I", size)
    return bytes(content)


def overlapping() -> bytes:
    """A second entry of the directory for the same bytes, as in bombs that need no nesting."""
    content = packed(("resources/a", b"a"))
    end = content.rindex(b"PK\5\6")
    start = struct.unpack("<I", content[end + 16 : end + 20])[0]
    entry = content[content.rindex(b"PK\1\2") : end]
    directory = content[start:end] + entry.replace(b"resources/a", b"resources/b")
    tail = struct.pack("<4s4H2IH", b"PK\5\6", 0, 0, 3, 3, len(directory), start, 0)
    return content[:start] + directory + tail


def many() -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for k in range(101):
            archive.writestr(f"{k}", b"")
    return stream.getvalue()


def twice() -> bytes:
    with pytest.warns(UserWarning, match="Duplicate name"):
        return packed(("resources/a", b"1"), ("resources/a", b"2"))


NOTHING = "is refused, nothing was unpacked: "
HOSTILE: dict[str, tuple[Callable[[], bytes], str]] = {
    "traversal": (
        lambda: packed(("../../evil", b"")),
        f"{NOTHING}../../evil leads out of the folder it is unpacked to",
    ),
    "traversal inside": (
        lambda: packed(("resources/../../evil", b"")),
        f"{NOTHING}resources/../../evil leads out of the folder it is unpacked to",
    ),
    "absolute": (lambda: packed(("/etc/passwd", b"")), f"{NOTHING}/etc/passwd has an absolute path"),
    "drive": (lambda: packed(("C:/evil.dll", b"")), f"{NOTHING}C:/evil.dll has a drive letter in its path"),
    "share": (lambda: packed(("//server/share/x", b"")), f"{NOTHING}//server/share/x has an absolute path"),
    "traversal with backslashes": (
        lambda: packed(("resources\\..\\..\\evil", b"")),
        rf"{NOTHING}resources\\..\\..\\evil leads out of the folder it is unpacked to",
    ),
    "share with backslashes": (
        lambda: packed(("\\\\server\\share\\x", b"")),
        rf"{NOTHING}\\\\server\\share\\x has an absolute path",
    ),
    "one file by two names": (
        lambda: packed(("resources/x.txt", b""), ("resources\\x.txt", b"")),
        rf"{NOTHING}resources\\x.txt is in it twice",
    ),
    "control": (
        lambda: packed(("resources/x\n.txt", b"")),
        rf"{NOTHING}resources/x\n.txt has no name, or control characters in it",
    ),
    "link": (
        lambda: packed((special(stat.S_IFLNK), b"/etc/passwd")),
        f"{NOTHING}resources/passwords is a symbolic link; pack the file that it leads to",
    ),
    "pipe": (
        lambda: packed((special(stat.S_IFIFO), b"")),
        f"{NOTHING}resources/passwords is a device, a pipe or a socket",
    ),
    "duplicate": (twice, f"{NOTHING}resources/a is in it twice"),
    "file and folder": (
        lambda: packed(("resources", b""), ("resources/a", b"")),
        f"{NOTHING}resources is both a file and a folder",
    ),
    "encrypted": (encrypted, f"{NOTHING}resources/secret is encrypted; pack it without a password"),
    "method": (
        lambda: packed(method=zipfile.ZIP_LZMA),
        f"{NOTHING}modelDescription.xml is packed by another method than deflate; pack it again",
    ),
    "size": (
        lambda: claiming(3 << 30, "resources/a", "resources/b"),
        f"{NOTHING}has 6144 MiB in it; 4096 MiB are accepted",
    ),
    "count": (many, f"{NOTHING}has 101 files; 100 are accepted"),
    "overlap": (overlapping, f"{NOTHING}resources/b lies in the archive where another file lies"),
    "no zip": (lambda: b"MZ" + bytes(100), "is not an FMU: it is not a zip archive; export the model again"),
    "empty": (lambda: b"", "is not an FMU: it is not a zip archive; export the model again"),
    "cut off": (lambda: packed()[:-30], "is not an FMU: the zip archive is cut off or damaged; copy it again"),
}


def refusal(path: Path) -> str:
    with pytest.raises(FmuError) as caught:
        Fmu.read(path)
    return str(caught.value).removeprefix(f"{path}: ")


@pytest.mark.parametrize("kind", list(HOSTILE))
def test_what_is_refused(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    make, message = HOSTILE[kind]
    path = tmp_path / "hostile" / "x.fmu"
    path.parent.mkdir()
    path.write_bytes(make())
    unpacked = tmp_path / "unpacked"
    unpacked.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(unpacked))
    if kind == "count":
        assert MOST_MEMBERS == 50_000
        monkeypatch.setattr("cosim.archive._dangers.MOST_MEMBERS", 100)
    said = refusal(path)
    assert said == message
    assert list(unpacked.iterdir()) == []
    assert list(path.parent.iterdir()) == [path]
    assert sorted(p.name for p in tmp_path.iterdir()) == ["hostile", "unpacked"]


def test_a_real_bomb_is_refused(tmp_path: Path) -> None:
    """A hundred and one MiB of zeros deflate to 100 kB, about as well as it can pack anything."""
    (tmp_path / "x.fmu").write_bytes(packed(("resources/zeros", bytes(101 << 20))))
    assert re.fullmatch(
        f"{NOTHING}unpacks to 101 MiB, 10[0-9]{{2}} times its size; 100 are accepted", refusal(tmp_path / "x.fmu")
    )


def test_all_dangers_are_known_to_the_check(tmp_path: Path) -> None:
    path = tmp_path / "x.fmu"
    path.write_bytes(packed(("../a", b""), ("/b", b""), ("C:/c", b""), ("d/e", b""), ("d\\e", b""), ("../f", b"")))
    assert [danger.id for danger in Archive.inspect(path).dangers] == [
        "traversal",
        "absolute",
        "drive",
        "duplicate",
        "traversal",
    ]
    assert refusal(path).endswith("C:/c has a drive letter in its path; and 2 more")
    with pytest.raises(FmuError, match="is refused, nothing was unpacked"):
        Archive.inspect(path).read("modelDescription.xml")
    with pytest.raises(FmuError, match="is refused, nothing was unpacked"):
        Archive.inspect(path).extract(tmp_path / "there")


def test_a_damaged_member(tmp_path: Path) -> None:
    content = bytearray(packed(method=zipfile.ZIP_STORED))
    content[content.index(b"modelName")] ^= 1
    (tmp_path / "x.fmu").write_bytes(content)
    assert refusal(tmp_path / "x.fmu") == "is damaged: modelDescription.xml cannot be unpacked; copy or export it again"


def test_a_member_that_is_longer_than_its_directory_says(tmp_path: Path) -> None:
    """Lies about sizes do not help a bomb: no more is unpacked than the directory, which was checked, tells."""
    content = bytearray(packed(("resources/zeros", bytes(10 << 20))))
    entry = content.rindex(b"PK\1\2")
    content[entry + 24 : entry + 28] = struct.pack("<I", 10)
    content[entry + 16 : entry + 20] = struct.pack("<I", zlib.crc32(bytes(10)))
    (tmp_path / "x.fmu").write_bytes(content)
    Archive.open(tmp_path / "x.fmu").extract(tmp_path / "there")
    assert (tmp_path / "there" / "resources" / "zeros").read_bytes() == bytes(10)


def test_names_with_a_dot_in_front_are_harmless(tmp_path: Path) -> None:
    (tmp_path / "x.fmu").write_bytes(packed(("./resources/a.txt", b"a")))
    archive = Archive.open(tmp_path / "x.fmu")
    assert archive.dotted
    assert archive.read("resources/a.txt") == b"a"
    archive.extract(tmp_path / "there", ("resources/",))
    assert [p.name for p in (tmp_path / "there").rglob("*")] == ["resources", "a.txt"]


def test_names_with_backslashes_are_harmless(tmp_path: Path) -> None:
    (tmp_path / "x.fmu").write_bytes(packed(("resources\\deep\\a.txt", b"a"), ("resources\\empty\\", b"")))
    archive = Archive.open(tmp_path / "x.fmu")
    assert archive.backslashed
    assert archive.read("resources/deep/a.txt") == b"a"
    archive.extract(tmp_path / "there", ("resources/",))
    assert [p.name for p in (tmp_path / "there").rglob("*")] == ["resources", "deep", "a.txt"]
    assert "its files are packed with backslashes in their names" in [a.text for a in read_description(archive).amiss]


def test_a_packed_folder_instead_of_its_content(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "x.fmu", "w") as archive:
        archive.writestr("Model/modelDescription.xml", XML)
    assert refusal(tmp_path / "x.fmu") == (
        "is not an FMU: it has no modelDescription.xml at the top, but Model/modelDescription.xml: pack what is in "
        "that folder; export the model again"
    )


LAUGHS = b"""<?xml version="1.0"?><!DOCTYPE lol [<!ENTITY a "ha"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>
<fmiModelDescription fmiVersion="2.0" modelName="&b;" guid="x"/>"""
OUTSIDE = b"""<?xml version="1.0"?><!DOCTYPE x [<!ENTITY a SYSTEM "file:///etc/passwd">]>
<fmiModelDescription fmiVersion="2.0" modelName="&a;" guid="x"/>"""
DOCTYPE = "has a document type (<!DOCTYPE ...>), which can define entities; take it out of the file"


@pytest.mark.parametrize(
    "xml",
    [LAUGHS, OUTSIDE, b"\n" + LAUGHS, b"\xef\xbb\xbf" + LAUGHS, LAUGHS.decode().encode("utf-16")],
    ids=["nested", "external", "after a blank", "after a mark", "in another encoding"],
)
@pytest.mark.parametrize("name", ["modelDescription.xml", "sources/buildDescription.xml"])
def test_entities_are_refused(tmp_path: Path, xml: bytes, name: str) -> None:
    with zipfile.ZipFile(tmp_path / "x.fmu", "w") as archive:
        for member in {"modelDescription.xml", name}:
            archive.writestr(member, xml if member == name else XML)
    assert refusal(tmp_path / "x.fmu") == f"its {name} {DOCTYPE}"


@pytest.mark.parametrize(
    ("xml", "message"),
    [
        (b"<a><b></a>", "its modelDescription.xml is not well-formed XML: line 1: mismatched tag; export it again"),
        (b"", "its modelDescription.xml is not well-formed XML: line 1: no element found; export it again"),
        (
            b'<?xml version="1.0" encoding="UTF-7"?><a/>',
            "its modelDescription.xml is in the encoding UTF-7; UTF-8 is needed",
        ),
        (
            b'<?xml version="1.0" encoding="nonsense"?><a/>',
            "its modelDescription.xml is in the encoding nonsense; UTF-8 is needed",
        ),
    ],
)
def test_xml_that_cannot_be_read(tmp_path: Path, xml: bytes, message: str) -> None:
    with zipfile.ZipFile(tmp_path / "x.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", xml)
    assert refusal(tmp_path / "x.fmu") == message
