"""Makes XML from elsewhere safe to parse: one encoding, and no document type, which is where entities come from."""

from __future__ import annotations

import codecs
import re
import xml.parsers.expat

from cosim.errors import FmuError

_DECLARATION = re.compile(r"\A<\?xml\b[^>]*\?>")
_ENCODING = re.compile(r"""encoding\s*=\s*["']([A-Za-z0-9._-]+)["']""")
_KNOWN = {"utf-8": "utf-8", "utf-16": "utf-16", "ascii": "utf-8", "iso8859-1": "cp1252", "cp1252": "cp1252"}
_MARKS = ((codecs.BOM_UTF8, "utf-8-sig"), (codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16"))


class _DocumentTypeError(Exception):
    """Stops the parser."""


def utf8_of(content: bytes, name: str) -> tuple[bytes, list[str]]:
    """Return an XML document in UTF-8, and what was amiss with it and is mended: its encoding, or what is before it.

    All parsers see the same after this. Raises FmuError if it has a document type (``<!DOCTYPE``, from which external
    and endlessly nested entities come), an unknown encoding, or is not well-formed; ``name`` is told in the message.
    """
    text, amiss = _decoded(content, name)
    if text != text.lstrip():
        amiss.append("has blanks in front of the XML declaration")
        text = text.lstrip()
    head = _DECLARATION.match(text)
    rest = text[head.end() :] if head else text
    utf8 = ('<?xml version="1.0" encoding="UTF-8"?>' + rest).encode("utf-8", "replace")
    parser = xml.parsers.expat.ParserCreate()
    parser.StartDoctypeDeclHandler = _refuse
    try:
        parser.Parse(utf8, True)
    except _DocumentTypeError:
        raise FmuError(
            f"{name} has a document type (<!DOCTYPE ...>), which can define entities; take it out of the file"
        ) from None
    except xml.parsers.expat.ExpatError as error:
        reason = xml.parsers.expat.ErrorString(error.code)
        raise FmuError(f"{name} is not well-formed XML: line {error.lineno}: {reason}; export it again") from error
    return utf8, amiss


def _decoded(content: bytes, name: str) -> tuple[str, list[str]]:
    for mark, encoding in _MARKS:
        if content.startswith(mark):
            return _decode(content, encoding, name), ["has a byte order mark"]
    found = _ENCODING.search(content.lstrip()[:200].split(b"?>")[0].decode("latin-1"))
    declared = found[1] if found else "utf-8"
    try:
        encoding = _KNOWN[codecs.lookup(declared).name]
    except LookupError as error:
        raise FmuError(f"{name} is in the encoding {declared}; UTF-8 is needed") from error
    if encoding != "utf-8":
        return _decode(content, encoding, name), [f"is in the encoding {declared}; the standard demands UTF-8"]
    try:
        return content.decode(), []
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        return _decode(content, "cp1252", name), [f"is not the UTF-8 it says (line {line}); read as Windows-1252"]


def _decode(content: bytes, encoding: str, name: str) -> str:
    try:
        return content.decode(encoding, "replace" if encoding == "cp1252" else "strict")
    except UnicodeDecodeError as error:
        raise FmuError(f"{name} is not the {encoding} that it says; export it again") from error


def _refuse(*_: object) -> None:
    raise _DocumentTypeError
