"""Bytes of an FMU changed at random end in a message or in findings, never in a traceback."""

from __future__ import annotations

import io
import warnings
import zipfile
from collections.abc import Callable
from pathlib import Path

import fmpy
import pytest
from fmu_builder import MODELS, description
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cosim.check import check, describe
from cosim.engine import Fmu
from cosim.errors import FmuError

FUZZ = settings(
    max_examples=40, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
CHANGES = st.lists(
    st.tuples(
        st.integers(0, 1 << 20),
        st.sampled_from(["flip", "cut", "repeat", "digit", "swap"]),
        st.integers(1, 255),
    ),
    min_size=1,
    max_size=4,
)
NAMES = ("sampler", "integrator", "mirror", "vector", "parcel", "ball")
SOURCES = b"""<?xml version="1.0"?>
<fmiBuildDescription fmiVersion="3.0"><BuildConfiguration modelIdentifier="m"/></fmiBuildDescription>"""


def packed(xml: bytes, name: str, fmi: int) -> bytes:
    folder = fmpy.platform if fmi == 2 else fmpy.platform_tuple
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", xml)
        archive.writestr("sources/buildDescription.xml", SOURCES)
        archive.writestr(f"binaries/{folder}/{name}{fmpy.sharedLibraryExtension}", b"\x7fELF")
    return stream.getvalue()


def changed(content: bytes, changes: list[tuple[int, str, int]]) -> bytes:
    """Return bytes with bits flipped, pieces cut out or repeated, digits changed, or neighbours swapped."""
    found = bytearray(content)
    for place, how, amount in changes:
        k = place % max(len(found), 1)
        if how == "flip" and found:
            found[k] ^= amount
        elif how == "cut":
            del found[k : k + amount]
        elif how == "repeat":
            found[k:k] = found[k : k + amount]
        elif how == "digit":
            digits = [i for i, byte in enumerate(found) if 48 <= byte <= 57]
            if digits:
                found[digits[place % len(digits)]] = 48 + amount % 10
        elif how == "swap":
            found[k : k + 2 * amount] = found[k + amount : k + 2 * amount] + found[k : k + amount]
    return bytes(found)


def survives(path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for read in (lambda: Fmu.read(path).close(), lambda: describe(path)):
            try:
                read()
            except FmuError as error:
                assert str(error).startswith(f"{path}: ")
        report = check(path, run=False)
    assert all(finding.what for finding in report.findings)


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Callable[[bytes], Path]:
    path = tmp_path_factory.mktemp("fuzz") / "x.fmu"

    def put(content: bytes) -> Path:
        path.write_bytes(content)
        return path

    return put


@FUZZ
@given(name=st.sampled_from(NAMES), fmi=st.sampled_from([2, 3]), changes=CHANGES)
def test_archives(place: Callable[[bytes], Path], name: str, fmi: int, changes: list[tuple[int, str, int]]) -> None:
    xml = description(MODELS[name], fmi).encode()
    survives(place(changed(packed(xml, name, fmi), changes)))


@FUZZ
@given(name=st.sampled_from(NAMES), fmi=st.sampled_from([2, 3]), changes=CHANGES)
def test_descriptions(place: Callable[[bytes], Path], name: str, fmi: int, changes: list[tuple[int, str, int]]) -> None:
    xml = changed(description(MODELS[name], fmi).encode(), changes)
    survives(place(packed(xml, name, fmi)))


@FUZZ
@given(
    name=st.sampled_from(NAMES),
    fmi=st.sampled_from([2, 3]),
    which=st.integers(0, 1 << 20),
    value=st.sampled_from(["", "-1", "0", "99", "4294967296", "1e400", "NaN", "x", "true", "1 2", "\u00b5", " 1"]),
)
def test_attributes(place: Callable[[bytes], Path], name: str, fmi: int, which: int, value: str) -> None:
    """An attribute with a value it should not have; its neighbours are as they were."""
    pieces = description(MODELS[name], fmi).split('"')
    pieces[1 + 2 * (which % (len(pieces) // 2))] = value
    survives(place(packed('"'.join(pieces).encode(), name, fmi)))


@FUZZ
@given(name=st.sampled_from(NAMES), fmi=st.sampled_from([2, 3]), which=st.integers(0, 1 << 20))
def test_attributes_that_are_missing(place: Callable[[bytes], Path], name: str, fmi: int, which: int) -> None:
    text = description(MODELS[name], fmi)
    pieces = text.split('"')
    k = 2 * (which % (len(pieces) // 2))
    left = pieces[k].rpartition(" ")[0]
    survives(place(packed('"'.join([*pieces[:k], left + pieces[k + 2], *pieces[k + 3 :]]).encode(), name, fmi)))
