"""Which FMUs count as built here: by their bytes, or as one of the catalogue that is up to date."""

from __future__ import annotations

import hashlib
import json
import zipfile
from pathlib import Path

import pytest

from cosim.fmu import catalogue, provenance


@pytest.fixture(autouse=True)
def empty_notes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(provenance, "_folder", lambda: tmp_path / "built")
    return tmp_path / "built"


def digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def fake(path: Path, build_hash: str) -> Path:
    """Write what looks like an FMU of the catalogue from outside."""
    path.parent.mkdir(exist_ok=True)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("extra/io.github.wiper-cosim/build.json", json.dumps({"hash": build_hash}))
    return path


def test_a_file_is_known_by_its_bytes_wherever_it_lies(tmp_path: Path) -> None:
    built, moved, changed = (tmp_path / name for name in ("a.fmu", "b.fmu", "c.fmu"))
    built.write_bytes(b"content")
    moved.write_bytes(b"content")
    changed.write_bytes(b"contenT")
    assert not catalogue.is_own(built, digest(built))
    provenance.remember(built)
    assert catalogue.is_own(built, digest(built))
    assert catalogue.is_own(moved, digest(moved))
    assert not catalogue.is_own(changed, digest(changed))


def test_one_of_the_catalogue_is_known_if_it_is_up_to_date_and_where_such_are_built(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, empty_notes: Path
) -> None:
    monkeypatch.setattr(catalogue, "build_folder", lambda: tmp_path / "fmus")
    entry = catalogue.entry_of("linkage")
    current = catalogue._hash(entry)
    for folder, name, build_hash, known in (
        ("fmus", "LinkagePlant.fmu", "another", False),
        ("fmus", "Other.fmu", current, False),
        ("elsewhere", "LinkagePlant.fmu", current, False),
        ("fmus", "LinkagePlant.fmu", current, True),
    ):
        path = fake(tmp_path / folder / name, build_hash)
        assert catalogue.is_own(path, digest(path)) is known
    assert [note.name for note in empty_notes.iterdir()] == [digest(tmp_path / "fmus" / "LinkagePlant.fmu")]


def test_where_nothing_can_be_noted_files_are_foreign(tmp_path: Path, empty_notes: Path) -> None:
    empty_notes.write_text("a file where the folder should be")
    path = tmp_path / "a.fmu"
    path.write_bytes(b"content")
    provenance.remember(path)
    assert not catalogue.is_own(path, digest(path))
