"""The boxes that an AVIF file is made of (ISO/IEC 14496-12), one of our own among them, and what they say of its size.

Whoever decodes a file allocates what its headers ask for; so these are read first.
"""

import struct
from collections.abc import Iterator
from uuid import UUID

_OURS = UUID("6a1c2f7e-3b0d-5d5a-9d0e-52454d415031").bytes
_NEST = {b"meta": 4, b"iprp": 0, b"ipco": 0}  # boxes whose contents are boxes, after so many bytes
_SEQUENCE_HEADER = 1


def with_own_box(file: bytes, payload: bytes) -> bytes:
    """The file with a box of ours at its end, which others skip: a "uuid" box."""
    return file + struct.pack(">I4s16s", 24 + len(payload), b"uuid", _OURS) + payload


def own_box(file: bytes) -> bytes:
    """What `with_own_box` put in. Raises ValueError where it is missing or cut short."""
    for kind, contents in _boxes(file):
        if kind == b"uuid" and contents[:16] == _OURS:
            return contents[16:]
    raise ValueError("no box of ours")


def announced_shapes(file: bytes) -> set[tuple[int, int]]:
    """(rows, columns) that the file's headers announce: AVIF's own and that of the AV1 picture within.

    Raises ValueError where either is missing, or is not of a single grey picture.
    """
    shapes, pictures = set(), 0
    for kind, contents in _boxes(file):
        if kind == b"ispe" and len(contents) >= 12:
            _, columns, rows = struct.unpack(">III", contents[:12])
            shapes.add((rows, columns))
        if kind == b"mdat":
            pictures += 1
            shapes.add(_sequence_shape(contents))
    if pictures != 1 or not shapes:
        raise ValueError("not a single picture")
    return shapes


def _boxes(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    """All boxes, outer ones before those within them."""
    at = 0
    while at < len(data):
        size, kind = struct.unpack_from(">I4s", data, at) if at + 8 <= len(data) else (0, b"")
        if not 8 <= size <= len(data) - at:
            raise ValueError("a box is cut short")
        contents = data[at + 8 : at + size]
        yield kind, contents
        if kind in _NEST:
            yield from _boxes(contents[_NEST[kind] :])
        at += size


def _sequence_shape(units: bytes) -> tuple[int, int]:
    """(rows, columns) by the sequence header of a still picture in AV1's low-overhead format."""
    at = 0
    while at + 2 <= len(units):
        kind, has_extension, has_size = units[at] >> 3 & 15, units[at] >> 2 & 1, units[at] >> 1 & 1
        at += 1 + has_extension
        size = shift = 0
        while has_size and at < len(units):  # seven bits a byte, the least significant first
            size |= (units[at] & 127) << shift
            has_size, at, shift = units[at] >> 7, at + 1, shift + 7
        if kind == _SEQUENCE_HEADER:
            return _still_shape(units[at : at + size])
        at += size
    raise ValueError("no AV1 picture")


def _still_shape(header: bytes) -> tuple[int, int]:
    """The same from the contents of the header: three bits of profile, two that say it is a still picture with the
    short header, five of level, four each for the lengths of the two numbers that follow, less one."""
    bits = f"{int.from_bytes(header, 'big'):0{8 * len(header)}b}" if header else ""
    if bits[:5] != "00011" or len(bits) < 18:
        raise ValueError("not an AV1 still picture of profile 0")
    wide, high = int(bits[10:14], 2) + 1, int(bits[14:18], 2) + 1
    if len(bits) < 18 + wide + high:
        raise ValueError("an AV1 header is cut short")
    columns, rows = int(bits[18 : 18 + wide], 2) + 1, int(bits[18 + wide : 18 + wide + high], 2) + 1
    return rows, columns
