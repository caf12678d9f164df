"""Files of checkpoints: what is in them, and that damaged and forged ones end with a message."""

from __future__ import annotations

import json
import math
import os
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from saving_fmus import RUN, feedback

from cosim.engine import (
    Channel,
    Checkpoint,
    Component,
    Fmu,
    System,
    simulate,
)
from cosim.errors import CosimError, FmuError, InputError
from cosim.fmu import catalogue

Get = Callable[..., Fmu]


@pytest.fixture(scope="module")
def some(saving: Get, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A file of a run with a channel and events, at 0.05 s."""
    folder = tmp_path_factory.mktemp("some")
    return simulate(eventful(saving), checkpoint_at=[0.05], **RUN).checkpoints[0].save(folder / "some.cosim")


def eventful(saving: Get) -> System:
    system = feedback(saving)
    system.channels = [Channel(("c", "enable"), [0.0, 0.045, 0.07], [1.0, 0.0, 1.0])]
    return system


def test_no_file_and_other_files(tmp_path: Path) -> None:
    def of(content: bytes | None) -> str:
        path = tmp_path / "x.cosim"
        path.unlink(missing_ok=True)
        if content is not None:
            path.write_bytes(content)
        with pytest.raises(InputError) as caught:
            Checkpoint.load(path)
        return str(caught.value).removeprefix(f"{path}: ")

    assert of(None) == "the checkpoint cannot be read: No such file or directory; give the path of a .cosim file"
    told = "; write it again with --checkpoint, or Checkpoint.save"
    assert of(b"") == of(b"time,x\n0,1\n") == f"is not a checkpoint{told}"
    assert of(b"PK\3\4") == f"is cut off or damaged{told}"
    with zipfile.ZipFile(tmp_path / "other.zip", "w") as archive:
        archive.writestr("modelDescription.xml", "<fmi/>")
    assert of((tmp_path / "other.zip").read_bytes()).startswith("is not a checkpoint: it has no checkpoint.json")


def repacked(some: Path, path: Path, edit: Callable[[dict[str, bytes]], None], kind: int = zipfile.ZIP_STORED) -> Path:
    with zipfile.ZipFile(some) as old:
        contents = {name: old.read(name) for name in old.namelist()}
    edit(contents)
    with zipfile.ZipFile(path, "w", kind) as new:
        for name, content in contents.items():
            new.writestr(name, content)
    return path


def with_document(**changes: object) -> Callable[[dict[str, bytes]], None]:
    def edit(contents: dict[str, bytes]) -> None:
        document = json.loads(contents["checkpoint.json"]) | changes
        contents["checkpoint.json"] = json.dumps(document).encode()

    return edit


def test_what_does_not_agree_within_a_file(some: Path, tmp_path: Path, saving: Get) -> None:
    def of(edit: Callable[[dict[str, bytes]], None], kind: int = zipfile.ZIP_STORED) -> str:
        path = repacked(some, tmp_path / "x.cosim", edit, kind)
        with pytest.raises(InputError) as caught:
            simulate(eventful(saving), resume=Checkpoint.load(path), **RUN)
        return str(caught.value)

    def cut(contents: dict[str, bytes]) -> None:
        contents["values"] = contents["values"][:-8]

    assert "is damaged: what is in it is not what checkpoint.json says: values" in of(cut)
    assert "its directory is not as cosim writes it" in of(lambda _: None, zipfile.ZIP_DEFLATED)
    assert "says: extra" in of(lambda contents: contents.update(extra=b""))
    assert "is a checkpoint of format 2, and this version of cosim reads 1" in of(with_document(version=2, new=1))
    assert "is damaged: checkpoint.json: rows: Input should be a valid integer" in of(with_document(rows="many"))
    assert "is damaged: checkpoint.json: time: " in of(with_document(time=math.nan))
    assert "what is in it is not what checkpoint.json says: rows" in of(with_document(rows=10**15))
    assert "does not fit this system: it is damaged" in of(with_document(time=0.0499))
    assert "cannot go on from the checkpoint" in of(with_document(settings={}))

    def garbled(contents: dict[str, bytes]) -> None:
        contents["states/0"] = contents["states/0"][:8]
        with_document(
            components=[c | {"state_size": 8} for c in _components(contents)[:1]] + _components(contents)[1:]
        )(contents)

    assert "plant (integrator) refuses its state in the checkpoint: fmi3DeserializeFMUState returned Error" in of(
        garbled
    )


@pytest.mark.parametrize("version", ["3.0", "2.0"])
def test_our_own_fmus_find_damage_in_their_states(version: str, tmp_path: Path) -> None:
    with Fmu.read(catalogue.ensure("VoltageProfile", fmi=version)) as controller:
        system = System([Component("controller", controller)])
        path = simulate(system, checkpoint_at=[0.05], **RUN).checkpoints[0].save(tmp_path / "x.cosim")

        def turn(contents: dict[str, bytes]) -> None:
            state = bytearray(contents["states/0"])
            state[len(state) // 2] ^= 1
            contents["states/0"] = bytes(state)

        with pytest.raises(FmuError) as caught:
            simulate(system, resume=Checkpoint.load(repacked(path, tmp_path / "y.cosim", turn)), **RUN)
    assert "controller (VoltageProfile) refuses its state in the checkpoint: " in str(caught.value)
    assert "the state is damaged (its checksum is wrong)" in str(caught.value)


def _components(contents: dict[str, bytes]) -> list[dict[str, object]]:
    found: list[dict[str, object]] = json.loads(contents["checkpoint.json"])["components"]
    return found


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_damaged_files_are_refused(some: Path, tmp_path: Path, data: st.DataObject) -> None:
    """One changed byte, or the loss of a part, is noticed by the archive's checksums, or changes nothing."""
    content = bytearray(some.read_bytes())
    if data.draw(st.booleans()):
        content[data.draw(st.integers(0, len(content) - 1))] ^= data.draw(st.integers(1, 255))
    else:
        first = data.draw(st.integers(0, len(content)))
        del content[first : first + data.draw(st.integers(1, len(content)))]
    (tmp_path / "x.cosim").write_bytes(content)
    try:
        found = Checkpoint.load(tmp_path / "x.cosim")
    except InputError:
        return
    expected = Checkpoint.load(some)
    assert (found.setup, found.snapshot, found.states) == (expected.setup, expected.snapshot, expected.states)
    assert found.rows.tobytes() == expected.rows.tobytes()


NUMBERS = st.none() | st.booleans() | st.integers(-(2**70), 2**70) | st.floats() | st.text(max_size=5) | st.just([])


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_forged_documents_end_with_a_message_or_run(
    some: Path, saving: Get, tmp_path: Path, data: st.DataObject
) -> None:
    """Whatever the document says in the place of one of its values: no crash, no traceback, an end."""

    def edit(contents: dict[str, bytes]) -> None:
        document = json.loads(contents["checkpoint.json"])
        place: object = document
        while isinstance(place, dict | list) and place:
            keys = list(place) if isinstance(place, dict) else range(len(place))
            key = data.draw(st.sampled_from(keys))
            inner = place[key]  # type: ignore[index]
            if not isinstance(inner, dict | list) or not inner or data.draw(st.booleans()):
                place[key] = data.draw(NUMBERS)  # type: ignore[index]
                break
            place = inner
        contents["checkpoint.json"] = json.dumps(document).encode()

    path = repacked(some, tmp_path / "x.cosim", edit)
    try:
        checkpoint = Checkpoint.load(path)
        simulate(eventful(saving), resume=checkpoint, **RUN)
    except CosimError:
        pass


def test_saving_replaces_the_file_at_once(some: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    checkpoint = Checkpoint.load(some)
    path = checkpoint.save(tmp_path / "x.cosim")
    before = path.read_bytes()

    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(InputError, match="No space left on device; give another place"):
        checkpoint.save(path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]
