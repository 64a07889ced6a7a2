"""Whole arrays as zlib streams, which browsers unpack by themselves. FORMAT.md describes both encodings."""

import zlib
from typing import Any, Literal

import numpy as np
from jaxtyping import Shaped

Encoding = Literal["deflate", "delta"]
_MOST = 1032  # bytes that one byte of a zlib stream can stand for [RFC 1951]: whatever claims more is damaged


def deflated(array: Shaped[np.ndarray, "..."], encoding: Encoding) -> bytes:
    """A little-endian array as a zlib stream.

    Of its bytes; or, "delta", of byte planes, lowest first, of the difference of each whole number from the one before
    it, modulo its size, signs in the lowest bit: small differences become small numbers.
    """
    if encoding == "deflate":
        return zlib.compress(array.tobytes(), 9)
    bits = 8 * array.itemsize
    values = array.reshape(-1).view(_unsigned(array.dtype))
    steps = np.diff(values, prepend=values.dtype.type(0))
    signs = (steps >> values.dtype.type(bits - 1)) * values.dtype.type(2**bits - 1)
    folded = (steps << values.dtype.type(1)) ^ signs
    planes = folded.view(np.uint8).reshape(-1, array.itemsize).T
    return zlib.compress(planes.tobytes(), 9)


def inflated(packed: bytes, encoding: str, dtype: np.dtype[Any], count: int) -> Shaped[np.ndarray, "count"]:
    """The array that `deflated` packed. Raises ValueError, with the reason, where the stream does not hold ``count``
    such numbers, neither more nor less; memory is bounded by its length."""
    size = count * dtype.itemsize
    if size > _MOST * len(packed):
        raise ValueError(f"{len(packed)} bytes cannot hold {count} numbers")
    stream = zlib.decompressobj()
    try:
        data = stream.decompress(packed, size + 1)
    except zlib.error:
        raise ValueError("its zlib stream is broken") from None
    if len(data) != size or not stream.eof:
        raise ValueError(f"its zlib stream does not hold {count} numbers")
    if encoding == "deflate":
        return np.frombuffer(data, dtype)
    if encoding != "delta" or dtype.kind == "f":
        raise ValueError(f"its encoding {encoding!r} is unknown")
    planes = np.frombuffer(data, np.uint8).reshape(dtype.itemsize, count)
    whole = _unsigned(dtype)
    folded = np.ascontiguousarray(planes.T).view(whole).reshape(-1)
    one = whole.type(1)
    steps = (folded >> one) ^ (whole.type(0) - (folded & one))
    return np.cumsum(steps, dtype=whole).view(dtype)


def _unsigned(dtype: np.dtype[Any]) -> np.dtype[Any]:
    return np.dtype(f"<u{dtype.itemsize}")
