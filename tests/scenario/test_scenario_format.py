"""Properties of the format: any dialect reads back the same, and garbage is refused, never a crash."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from cosim.errors import InputError
from cosim.scenario import Scenario, read

Cells = list[list[float | None]]


@dataclass(frozen=True)
class Dialect:
    """How a spreadsheet writes: cell separator, decimal mark, line end, byte order mark, quotes, empty cells behind."""

    delimiter: str
    decimal: str
    newline: str
    bom: bool
    quoted: bool
    trailing: int

    def number(self, value: float | None) -> str:
        return "" if value is None else repr(value).replace(".", self.decimal)

    def row(self, cells: list[str]) -> str:
        quoted = [f'"{cell}"' if self.quoted else cell for cell in cells]
        return self.delimiter.join(quoted) + self.delimiter * self.trailing

    def write(self, keys: list[str], header: list[str], rows: Cells) -> bytes:
        lines = [f"# {key}" + self.delimiter * self.trailing for key in keys]
        lines += [self.row(header), *(self.row([self.number(value) for value in row]) for row in rows)]
        return (self.newline.join(lines) + self.newline).encode("utf-8-sig" if self.bom else "utf-8")


dialects = st.builds(
    Dialect,
    *[st.sampled_from([";", "\t"]), st.sampled_from([".", ","])],
    newline=st.sampled_from(["\n", "\r\n", "\r"]),
    bom=st.booleans(),
    quoted=st.booleans(),
    trailing=st.integers(0, 3),
) | st.builds(
    Dialect,
    *[st.just(","), st.just(".")],
    newline=st.sampled_from(["\n", "\r\n", "\r"]),
    bom=st.booleans(),
    quoted=st.booleans(),
    trailing=st.integers(0, 3),
)

finite = st.floats(allow_nan=False, allow_infinity=False)


@st.composite
def tables(draw: st.DrawFn) -> tuple[list[str], Cells]:
    """Names of channels, and rows of a time and cells: times in steps of a millisecond, at most two alike."""
    names = draw(st.lists(st.from_regex(r"[a-z]\w{0,8}(\.\w{1,5})?", fullmatch=True), max_size=4, unique=True))
    names = [name for name in names if name != "time"]
    steps = draw(st.lists(st.tuples(st.integers(1, 10**6), st.booleans()), min_size=1, max_size=8))
    rows: Cells = []
    instant = -1
    for step, twice in steps:
        instant += step
        for _ in range(1 + twice):
            rows.append([instant / 1000, *(draw(st.none() | finite) for _ in names)])
    rows[0][1:] = [draw(finite) for _ in names]
    return names, rows


def read_bytes(data: bytes) -> Scenario:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "x.csv"
        path.write_bytes(data)
        return read(path)


@settings(deadline=None)
@given(tables(), dialects, st.integers(1, 5000))
def test_every_dialect_reads_back(table: tuple[list[str], Cells], dialect: Dialect, sample: int) -> None:
    names, rows = table
    # In a table of one column nothing tells a decimal comma from a separator: it is refused.
    assume(names or dialect.decimal == ".")
    keys = [
        "title: Any title, with a comma",
        "system: linkage",
        "controller: none",
        f"stop: {dialect.number(rows[-1][0] + 1.5)} s",  # type: ignore[operator]
        f"sample_time: {sample} ms",
        f"set: plant.x = {dialect.number(2.5)} N.m",
    ]
    scenario = read_bytes(dialect.write(keys, ["time [s]", *(f"{name} [N.m]" for name in names)], rows))
    assert scenario.title == "Any title, with a comma"
    assert scenario.stop == rows[-1][0] + 1.5  # type: ignore[operator]
    assert scenario.sample_time == sample / 1000
    assert scenario.settings[0].value == "2.5 N.m"
    assert [column.name for column in scenario.columns] == names
    for position, column in enumerate(scenario.columns, start=1):
        written = [(row[0], row[position]) for row in rows if row[position] is not None]
        assert list(zip(column.times, column.values, strict=True)) == written


@settings(deadline=None)
@given(st.binary(max_size=200))
def test_any_bytes_are_refused_as_input(data: bytes) -> None:
    with pytest.raises(InputError):
        read_bytes(data)


lines = st.sampled_from(
    [
        "# system: rig",
        "# controller: none",
        "# stop: 1 s",
        "# stop: 1e400 s",
        "# set: a=b=c",
        "# map: a.b->c.d",
        "# linear: x",
        '"# title: a"""',
        "time [s],x [1]",
        "time [ms];x",
        "0,1",
        "0;1,5",
        '"',
        '0,"1',
        ",",
    ]
) | st.text(alphabet='#:;,.=->" \t0123456789eE+-[]stopmx\x0b\x85', max_size=20)


@settings(deadline=None)
@given(st.lists(lines, max_size=10))
def test_any_lines_are_read_or_refused(text: list[str]) -> None:
    try:
        scenario = read_bytes("\n".join(text).encode())
    except InputError as error:
        assert str(error.file).endswith("x.csv")
    else:
        assert scenario.stop > 0
