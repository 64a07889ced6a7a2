"""The key-value pairs of KTX files, alike in both versions."""

import struct
from collections.abc import Mapping


def pack_metadata(pairs: Mapping[str, bytes], byte_order: str = "<") -> bytes:
    """Pairs sorted by key, each padded to 4 bytes; values get a NUL at their end, as text has."""
    out = b""
    for key, value in sorted(pairs.items()):
        pair = key.encode() + b"\0" + value + b"\0"
        out += struct.pack(byte_order + "I", len(pair)) + pair + bytes(-len(pair) % 4)
    return out


def unpack_metadata(data: bytes, byte_order: str = "<") -> tuple[dict[str, bytes], bool]:
    """The pairs in ``data``, one NUL at a value's end taken off; and whether the data is sound to its end.

    Pairs from the first damaged one on are left out.
    """
    pairs: dict[str, bytes] = {}
    at = 0
    while at + 4 <= len(data):
        (length,) = struct.unpack_from(byte_order + "I", data, at)
        pair = data[at + 4 : at + 4 + length]
        key, separator, value = pair.partition(b"\0")
        if len(pair) < length or not separator:
            return pairs, not any(data[at:])  # zeros are padding that some writers count in
        pairs[key.decode("utf-8", "replace")] = value.removesuffix(b"\0")
        at += 4 + length + -length % 4
    return pairs, True
