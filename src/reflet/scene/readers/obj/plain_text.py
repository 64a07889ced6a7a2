"""The bytes of text files as tools write them: byte-order marks, UTF-16, and letters of older encodings."""

import codecs
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from jaxtyping import UInt8

from reflet.errors import RefletError

_MARKS = (
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF32_LE, "utf-32-le"),  # begins like UTF-16's and must be asked first
    (codecs.BOM_UTF32_BE, "utf-32-be"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)


def read_text_bytes(path: Path) -> UInt8[np.ndarray, "bytes"]:
    """A text file's bytes without byte-order mark and zeros at its end; UTF-16 and UTF-32 are turned into UTF-8.

    Raises RefletError where the file cannot be read.
    """
    try:
        data = np.fromfile(path, np.uint8)
    except OSError as error:
        raise RefletError(f"{path} cannot be read ({error.strerror or error}); check the name.") from error
    head = data[:4].tobytes()
    for mark, encoding in _MARKS:
        if head.startswith(mark):
            return _as_utf8(data[len(mark) :], encoding)
    if len(head) == 4 and head[0] and head[2] and not head[1] and not head[3]:  # Latin letters, and no mark
        return _as_utf8(data, "utf-16-le")
    padding = 0
    while padding < len(data) and data[len(data) - 1 - padding] == 0:
        padding += 1
    return data[: len(data) - padding]


def _as_utf8(data: UInt8[np.ndarray, "bytes"], encoding: str) -> UInt8[np.ndarray, "utf_8"]:
    if encoding == "utf-8":
        return data
    # a bytearray can be written to, as what is read plainly: compiled code is for one kind of array
    return np.frombuffer(bytearray(data.tobytes().decode(encoding, "replace"), "utf-8"), np.uint8)


def decoded(data: bytes) -> str:
    """Text of one line: UTF-8, or Latin-1 where it is none."""
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def quoted(line: str) -> str:
    """A line as a sentence may repeat it."""
    text = " ".join(line.split())
    return f'"{text[:60]}…"' if len(text) > 60 else f'"{text}"'


def lines(data: bytes) -> Iterator[tuple[int, str]]:
    """Lines and their numbers, from 1: any line end parts them, a backslash before it does not (but in comments)."""
    started, first = "", 1
    for number, raw in enumerate(re.split(rb"\r\n|\r|\n", data), 1):
        text = started + decoded(raw)
        if not started:
            first = number
        if text.endswith("\\") and not text.lstrip().startswith("#"):
            started = text[:-1] + " "
        else:
            started = ""
            yield first, text
    if started:
        yield first, started


def name_of(text: str) -> str:
    """A name without the comment behind it: # after a blank and before one. Names such as ``Material #25`` stay."""
    return re.sub(r"\s#(\s.*)?$", "", text, flags=re.DOTALL).strip()


def bare_name(text: str) -> str:
    """A name without anything behind a blank and #, which may have been a comment."""
    return re.sub(r"\s#.*$", "", text, flags=re.DOTALL).strip()


def listed(names: Sequence[str]) -> str:
    """Names for a sentence: the first eight, and how many more there are."""
    return ", ".join(names[:8]) + (f" and {len(names) - 8} more" if len(names) > 8 else "")
