"""Parameter files: what they may hold, and what is said of those that cannot be used."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cosim.errors import InputError
from cosim.scenario import read_parameters, write_parameters


def test_what_is_written_is_read(tmp_path: Path) -> None:
    path = tmp_path / "there" / "p.json"
    fitted = {"name": "plant.d_joint", "value": 0.95, "unit": "N.m.s/rad", "provenance": "fitted to x.xlsx"}
    others = [{"name": "plant.naive_load", "value": True}, {"name": "plant.n", "value": "3", "unit": "1"}]
    write_parameters(path, [fitted, *others], {"model": "M"})
    found = read_parameters(path)
    assert [(s.name, s.value) for s in found] == [
        ("plant.d_joint", "0.95 N.m.s/rad"), ("plant.naive_load", "1"), ("plant.n", "3"),
    ]  # fmt: skip
    assert [s.origin for s in found] == ["fitted to x.xlsx", f"set by {path}", f"set by {path}"]


def test_a_byte_order_mark_does_no_harm(tmp_path: Path) -> None:
    path = tmp_path / "p.json"
    path.write_text('{"parameters": [{"name": "a.b", "value": 1}]}', encoding="utf-8-sig")
    assert [s.value for s in read_parameters(path)] == ["1"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", ":1:2: is not JSON: Expecting property name enclosed in double quotes"),
        ("[1]", ': has no list "parameters"; a file that cosim calibrate wrote is expected'),
        ('{"parameters": [1]}', ': entry 1 has no "name"'),
        ('{"parameters": [{"name": "a.b"}]}', ': entry 1, a.b: "value" is None; a finite number or a text is expected'),
        (
            '{"parameters": [{"name": "a.b", "value": NaN}]}',
            ': entry 1, a.b: "value" is nan; a finite number or a text is expected',
        ),
        (
            '{"parameters": [{"name": "a.b", "value": 1, "unit": 5}]}',
            ': entry 1, a.b: "unit" is 5; a text such as "N.m" is expected',
        ),
        (
            '{"parameters": [{"name": "a.b", "value": 1}, {"name": "a.b", "value": 2}]}',
            ": entry 2: 'a.b' is there a second time",
        ),
    ],
)
def test_what_cannot_be_used(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "p.json"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        read_parameters(path)
    assert str(caught.value) == f"{path}{message}"


def test_numbers_without_end_and_files_that_are_not_there(tmp_path: Path) -> None:
    path = tmp_path / "p.json"
    path.write_text('{"parameters": [{"name": "a.b", "value": 1' + 400 * "0" + "}]}")
    with pytest.raises(InputError, match="a finite number or a text is expected"):
        read_parameters(path)
    with pytest.raises(InputError, match=r"none.json: there is no such parameter file"):
        read_parameters(tmp_path / "none.json")
    with pytest.raises(InputError, match="cannot be read: Is a directory"):
        read_parameters(tmp_path)


VALUES = st.one_of(st.none(), st.booleans(), st.floats(), st.integers(), st.text(max_size=5), st.lists(st.none()))


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.dictionaries(st.sampled_from(["name", "value", "unit", "provenance"]), VALUES)), st.binary())
def test_no_file_ends_in_a_traceback(tmp_path: Path, entries: list[dict[str, object]], noise: bytes) -> None:
    for data in (json.dumps({"parameters": entries}).encode(), noise):
        (tmp_path / "p.json").write_bytes(data)
        try:
            found = read_parameters(tmp_path / "p.json")
        except InputError as error:
            assert str(error).startswith(str(tmp_path / "p.json"))
        else:
            assert len(found) == len(entries)
