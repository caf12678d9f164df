"""The file of a checkpoint: a zip archive, nothing in it compressed, of one JSON document and of raw numbers.

``docs/checkpoints.md`` describes it. Whatever a file says of sizes and counts is compared with what is there before
anything is made of it; what FMUs have written is for them alone to judge.
"""

from __future__ import annotations

import io
import math
import os
import uuid
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from cosim import __version__
from cosim.engine.checkpoints._snapshot import Progress, Snapshot
from cosim.engine.loop._setup import Past, Setup, UsedFmu
from cosim.engine.system._connection import Connection
from cosim.engine.system._fault import Fault, FaultKind
from cosim.errors import InputError

_VERSION = 1
_DOCUMENT = "checkpoint.json"
_NUMBERS = "<f8"

_Count = Annotated[int, Field(ge=0, lt=2**53)]
_Time = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
_Number = Annotated[float, Field(allow_inf_nan=False)]
_End = tuple[str, str]


class Contents(NamedTuple):
    """What is in a file: the parts of a ``Checkpoint``."""

    setup: Setup
    snapshot: Snapshot
    states: tuple[bytes, ...]
    rows: NDArray[np.float64]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, ser_json_inf_nan="constants")


class _Component(_Strict):
    name: str
    model: str
    fmi_version: str
    interface: str
    sha256: str
    role: Literal["event", "sampled", "continuous"]
    parameters: dict[str, bool | int | float | str]
    time: _Time
    due: _Time | None
    ticks: _Count
    steps: _Count
    events: _Count
    stale: bool
    state_size: _Count


class _Connection(_Strict):
    source: _End
    target: _End
    factor: _Number
    offset: _Number
    table: tuple[tuple[_Number, _Number], ...]


class _Channel(_Strict):
    target: _End
    linear: bool
    entries: _Count


class _Fault(_Strict):
    target: _End
    kind: FaultKind
    amount: _Number
    start: _Time
    stop: _Time | None
    every: _Time | None
    seed: Annotated[int, Field(ge=0)]


class _Memory(_Strict):
    name: str
    size: _Count


class _Text(_Strict):
    slot: _Count
    size: _Count


class _Document(_Strict):
    format: Literal["cosim checkpoint"]
    version: int
    written_by: str
    time: _Time
    horizon: _Time | None
    exchanges: Annotated[int, Field(ge=1, lt=2**53)]
    settings: dict[str, float | str | None]
    rows: _Count
    columns: _Count
    values: _Count
    inputs: _Count
    components: tuple[_Component, ...]
    connections: tuple[_Connection, ...]
    channels: tuple[_Channel, ...]
    faults: tuple[_Fault, ...]
    memory: tuple[_Memory, ...]
    texts: tuple[_Text, ...]

    def members(self) -> Iterator[tuple[str, int]]:
        """Give the names and sizes [bytes] of all files that belong to the document."""
        yield "values", 8 * self.values
        yield "inputs", 8 * self.inputs
        yield "rows", 8 * self.rows * self.columns
        for number, component in enumerate(self.components):
            yield f"states/{number}", component.state_size
        for number, channel in enumerate(self.channels):
            yield f"channels/{number}", 16 * channel.entries
        for number, memory in enumerate(self.memory):
            yield f"memory/{number}", memory.size
        for number, text in enumerate(self.texts):
            yield f"texts/{number}", text.size


def write(checkpoint: Contents, path: Path) -> Path:
    """Write the file beside its place, and move it there; raises InputError if that cannot be."""
    document = _document(checkpoint)
    contents = _contents(checkpoint)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        beside = path.with_name(f"{path.name}.{uuid.uuid4().hex}.part")
        try:
            with beside.open("xb") as file:
                with zipfile.ZipFile(file, "w", zipfile.ZIP_STORED) as archive:
                    for name, content in ((_DOCUMENT, document), *contents):
                        archive.writestr(zipfile.ZipInfo(name), content)
                file.flush()
                os.fsync(file.fileno())
            beside.replace(path)
        except BaseException:
            beside.unlink(missing_ok=True)
            raise
    except OSError as error:
        raise InputError(
            f"the checkpoint cannot be written: {error.strerror}; give another place", file=path
        ) from error
    return path


def _document(checkpoint: Contents) -> bytes:
    setup, snapshot = checkpoint.setup, checkpoint.snapshot
    rows, columns = checkpoint.rows.shape
    document = _Document(
        format="cosim checkpoint",
        version=_VERSION,
        written_by=f"cosim {__version__}",
        time=snapshot.time,
        horizon=_finite(setup.horizon),
        exchanges=snapshot.exchanges,
        settings=setup.settings,
        rows=rows,
        columns=columns,
        values=len(snapshot.values) // 8,
        inputs=len(snapshot.inputs) // 8,
        components=tuple(
            _Component(**vars(used), **(progress._asdict() | {"due": _finite(progress.due)}), state_size=len(state))
            for used, progress, state in zip(setup.components, snapshot.components, checkpoint.states, strict=True)
        ),
        connections=tuple(_Connection(**vars(connection)) for connection in setup.connections),
        channels=tuple(_Channel(target=c.target, linear=c.linear, entries=len(c.times)) for c in setup.channels),
        faults=tuple(_Fault(**(vars(fault) | {"stop": _finite(fault.stop)})) for fault in setup.faults),
        memory=tuple(_Memory(name=name, size=len(content)) for name, content in snapshot.memory.items()),
        texts=tuple(_Text(slot=slot, size=len(content)) for slot, content in snapshot.texts.items()),
    )
    return document.model_dump_json(indent=1).encode()


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _contents(checkpoint: Contents) -> Iterator[tuple[str, bytes]]:
    snapshot = checkpoint.snapshot
    yield "values", snapshot.values
    yield "inputs", snapshot.inputs
    yield "rows", np.ascontiguousarray(checkpoint.rows, _NUMBERS).tobytes()
    for number, state in enumerate(checkpoint.states):
        yield f"states/{number}", state
    for number, channel in enumerate(checkpoint.setup.channels):
        yield f"channels/{number}", np.array([channel.times, channel.values], _NUMBERS).tobytes()
    for number, content in enumerate(snapshot.memory.values()):
        yield f"memory/{number}", content
    for number, text in enumerate(snapshot.texts.values()):
        yield f"texts/{number}", text


def read(path: Path) -> Contents:
    """Read a file; raises InputError if it is none, from another version, or damaged."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError(
            f"the checkpoint cannot be read: {error.strerror}; give the path of a .cosim file", file=path
        ) from error
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            return _checkpoint(archive, path, len(content))
    except InputError:
        raise
    except Exception as error:  # a damaged archive ends in many kinds of exceptions
        what = "is cut off or damaged" if content.startswith(b"PK\3\4") else "is not a checkpoint"
        raise InputError(f"{what}; write it again with --checkpoint, or Checkpoint.save", file=path) from error


def _checkpoint(archive: zipfile.ZipFile, path: Path, length: int) -> Contents:
    members = archive.infolist()
    sizes = {member.filename: member.file_size for member in members}
    if _DOCUMENT not in sizes:
        raise InputError(f"is not a checkpoint: it has no {_DOCUMENT}; give the path of a .cosim file", file=path)
    if len(sizes) != len(members) or any(member.compress_type for member in members) or sum(sizes.values()) > length:
        raise _damaged(path, "its directory is not as cosim writes it")
    document = _parsed(archive.read(_DOCUMENT), path)
    expected = dict(document.members())
    if expected != {name: size for name, size in sizes.items() if name != _DOCUMENT}:
        wrong = sorted(name for name in {*expected, *sizes} - {_DOCUMENT} if expected.get(name) != sizes.get(name))
        raise _damaged(path, f"what is in it is not what {_DOCUMENT} says: {wrong[0]}")
    contents = {name: archive.read(name) for name in expected}
    return _assembled(document, contents, path)


def _parsed(text: bytes, path: Path) -> _Document:
    try:
        document = _Document.model_validate_json(text)
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"])
        if place == "version" or _version(text) != _VERSION:
            raise _other_version(path, _version(text)) from error
        raise _damaged(path, f"{_DOCUMENT}: {place or 'it'}: {first['msg']}") from error
    if document.version != _VERSION:
        raise _other_version(path, document.version)
    return document


def _version(text: bytes) -> object:
    import json

    try:
        document = json.loads(text)
        return document.get("version", _VERSION) if isinstance(document, dict) else _VERSION
    except (ValueError, RecursionError):
        return _VERSION


def _other_version(path: Path, version: object) -> InputError:
    return InputError(
        f"is a checkpoint of format {version!s:.20}, and this version of cosim reads {_VERSION}; write it "
        "again with this one",
        file=path,
    )


def _damaged(path: Path, what: str) -> InputError:
    return InputError(f"is damaged: {what}; write it again with --checkpoint, or Checkpoint.save", file=path)


def _assembled(document: _Document, contents: dict[str, bytes], path: Path) -> Contents:
    slots = [text.slot for text in document.texts]
    names = [memory.name for memory in document.memory]
    if len(set(slots)) < len(slots) or len(set(names)) < len(names):
        raise _damaged(path, f"{_DOCUMENT} names something twice")
    channels = []
    for number, channel in enumerate(document.channels):
        times, values = np.frombuffer(contents[f"channels/{number}"], _NUMBERS).reshape(2, -1).tolist()
        channels.append(Past(channel.target, channel.linear, tuple(times), tuple(values)))
    setup = Setup(
        components=tuple(
            UsedFmu(c.name, c.model, c.fmi_version, c.interface, c.sha256, c.role, c.parameters)
            for c in document.components
        ),
        connections=tuple(Connection(c.source, c.target, c.factor, c.offset, c.table) for c in document.connections),
        channels=tuple(channels),
        faults=tuple(
            Fault(f.target, f.kind, f.amount, f.start, _or_infinite(f.stop), f.every, f.seed) for f in document.faults
        ),
        settings=document.settings,
        horizon=_or_infinite(document.horizon),
    )
    snapshot = Snapshot(
        time=document.time,
        exchanges=document.exchanges,
        values=contents["values"],
        inputs=contents["inputs"],
        memory={name: contents[f"memory/{number}"] for number, name in enumerate(names)},
        texts={slot: contents[f"texts/{number}"] for number, slot in enumerate(slots)},
        components=tuple(
            Progress(c.time, _or_infinite(c.due), c.ticks, c.steps, c.events, c.stale) for c in document.components
        ),
    )
    states = tuple(contents[f"states/{number}"] for number in range(len(document.components)))
    rows = np.frombuffer(contents["rows"], _NUMBERS).reshape(document.rows, document.columns)
    return Contents(setup, snapshot, states, rows)


def _or_infinite(value: float | None) -> float:
    return math.inf if value is None else value
