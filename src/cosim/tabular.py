"""CSV text cut into key lines, header and rows, whatever spreadsheet wrote it."""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from pathlib import Path

from cosim.errors import InputError

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_COMMA_IN_NUMBER = re.compile(r"(?<=\d),(?=\d)")


@dataclass
class Table:
    """Cells as text with the lines (from 1) at which they stand.

    ``keys`` are the leading ``#`` lines without the ``#`` and without a spreadsheet's trailing separators. Rows are as
    long as the header. ``decimal`` is the mark that numbers in cells use, found with the first number that has one;
    ``empty`` says what an empty cell means.
    """

    path: Path
    delimiter: str
    keys: list[tuple[int, str]]
    header_line: int
    header: list[str]
    rows: list[tuple[int, list[str]]]
    empty: str
    decimal: str | None = None

    def number(self, text: str, line: int, position: int) -> float:
        """Read the number in a cell; `InputError` for text, NaN, infinity and a mixture of decimal marks."""
        plain = text
        mark = "," if "," in text and "." not in text else "." if "." in text and "," not in text else None
        if mark == "," and self.delimiter != ",":
            plain = text.replace(",", ".")
        if _NUMBER.fullmatch(plain) is None or (value := float(plain)) in (float("inf"), float("-inf")):
            raise self.error(
                f"'{text}' in column '{self.header[position - 1]}' is not a number; "
                f"accepted are finite numbers such as 12, -0.5 or 3e-2, and an empty cell for '{self.empty}'",
                line,
                position,
            )
        if mark is not None:
            if self.decimal not in (None, mark):
                raise self.error(
                    f"'{text}' has the decimal mark '{mark}', earlier numbers have '{self.decimal}'; "
                    "use one of them in the whole file",
                    line,
                    position,
                )
            self.decimal = mark
        return value

    def plain_decimal(self, text: str) -> str:
        """Return the value of a key with a decimal point, where a comma cannot mean anything else."""
        return text if self.delimiter == "," and len(self.header) > 1 else _COMMA_IN_NUMBER.sub(".", text)

    def error(self, message: str, line: int | None = None, position: int | None = None) -> InputError:
        """Make the error for a place in this file; ``position`` is the cell's number in its row."""
        return InputError(message, file=self.path, line=line, column=position)


def load(path: Path, what: str = "scenario file", empty: str = "unchanged", example: str = "duty [1]") -> Table:
    """Read a file's lines and cells. Raises `InputError` if it is no such table.

    Args:
        path: the file.
        what: what the file is, for the message if it is missing.
        empty: what an empty cell means, for messages.
        example: a column that such a file may have beside the time, for messages.
    """
    lines = re.split(r"\r\n|\n|\r", _text(path, what))
    keys: list[tuple[int, str]] = []
    body: list[tuple[int, str]] = []
    for number, line in enumerate(lines, start=1):
        bare = line.strip().lstrip('"')
        if bare.startswith("#") and not body:
            keys.append((number, _key_text(line)))
        elif bare.startswith("#"):
            raise InputError("a '#' line below the header; '# key: value' lines come first", file=path, line=number)
        elif line.strip(" \t,;") or (line.strip() and not body):
            body.append((number, line))
    if not body:
        found = "an empty file" if not keys else "no header line below the '#' lines"
        raise InputError(f"{found}; expected a header such as 'time [s],{example}' and rows below it", file=path)
    header_line, header_text = body[0]
    delimiter = next((mark for mark in ";\t" if mark in header_text), ",")
    header = _cells(path, header_line, header_text, delimiter)
    rows = [(number, _cells(path, number, text, delimiter)) for number, text in body[1:]]
    table = Table(path, delimiter, keys, header_line, header, rows, empty)
    _square_up(table)
    return table


def _text(path: Path, what: str) -> str:
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        raise InputError(f"there is no such {what}", file=path) from None
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", file=path) from error
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise InputError("is UTF-16 text; save it as 'CSV UTF-8'", file=path)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise InputError(
            f"byte 0x{data[error.start]:02x} is not UTF-8 text; save the file as 'CSV UTF-8'", file=path, line=line
        ) from None
    if "\0" in text:
        raise InputError("is a binary file, not CSV text", file=path, line=text.count("\n", 0, text.index("\0")) + 1)
    return text


def _key_text(line: str) -> str:
    """Return a ``#`` line's text: without ``#``, quotes that a spreadsheet put around it and separators behind it."""
    text = line.strip().rstrip(",;\t ")
    if text.startswith('"') and text.endswith('"') and len(text) > 1:
        text = text[1:-1].replace('""', '"').rstrip(",;\t ")
    return text.lstrip('"')[1:].strip()


def _cells(path: Path, line: int, text: str, delimiter: str) -> list[str]:
    try:
        (cells,) = csv.reader([text], delimiter=delimiter, strict=True)
    except (csv.Error, ValueError) as error:
        raise InputError(f"the cells cannot be told apart ({error}); check the quotes", file=path, line=line) from error
    return [cell.strip() for cell in cells]


def _square_up(table: Table) -> None:
    """Drop empty cells to the right of the table; refuse rows that are shorter or longer than the header."""
    while len(table.header) > 1 and not table.header[-1]:
        table.header.pop()
    width = len(table.header)
    for line, cells in table.rows:
        while len(cells) > width and not cells[-1]:
            cells.pop()
        if len(cells) > width:
            hint = " (is the comma a decimal comma? then separate cells with ';')" if table.delimiter == "," else ""
            raise table.error(
                f"the row has {len(cells)} cells, the header {width}: '{cells[width]}' belongs to no column{hint}",
                line,
                width + 1,
            )
        if len(cells) < width:
            raise table.error(
                f"the row has {len(cells)} cells, the header {width}: "
                f"the cell for '{table.header[len(cells)]}' is missing; leave it empty for '{table.empty}'",
                line,
                len(cells) + 1,
            )
