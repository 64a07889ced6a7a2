"""Arrays in binary files, described in JSON: ``{"uri", "byteOffset", "componentType", "shape"}``.

Component types are glTF's numbers; data are little-endian and row-major, offsets multiples of four. Where there is an
``encoding``, ``byteLength`` bytes hold them as a zlib stream (`reflet.pem.deflate`).
"""

from math import prod
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Shaped, UInt8

from reflet.errors import RefletError
from reflet.files.atomic import atomic_path
from reflet.files.unreadable import unreadable
from reflet.pem.deflate import Encoding, deflated, inflated

UNSIGNED_BYTE, SHORT, UNSIGNED_SHORT, UNSIGNED_INT, FLOAT = 5121, 5122, 5123, 5125, 5126
_DTYPES: dict[int, np.dtype[Any]] = {
    UNSIGNED_BYTE: np.dtype("u1"),
    SHORT: np.dtype("<i2"),
    UNSIGNED_SHORT: np.dtype("<u2"),
    UNSIGNED_INT: np.dtype("<u4"),
    FLOAT: np.dtype("<f4"),
}
_COMPONENT_TYPES = {dtype: number for number, dtype in _DTYPES.items()}


class BufferWriter:
    """Collects arrays that `write` puts into one file."""

    def __init__(self, uri: str) -> None:
        self.uri = uri
        self.length = 0
        self._data: list[np.ndarray] = []  # bytes

    def add(self, array: Shaped[np.ndarray, "..."], encoding: Encoding | None = None) -> dict[str, Any]:
        """Append an array of uint8, int16, uint16, uint32 or float32, which must not change any more; its description.

        Numbers are stored as they are, or as a zlib stream: ``"deflate"`` of their bytes, ``"delta"`` of each whole
        number's difference to the one before it.
        """
        little = np.ascontiguousarray(array, array.dtype.newbyteorder("<"))
        description = {
            "uri": self.uri,
            "byteOffset": self.length,
            "componentType": _COMPONENT_TYPES[little.dtype],
            "shape": list(little.shape),
        }
        if encoding is None:
            self._append(little.reshape(-1).view(np.uint8))
        else:
            packed = deflated(little, encoding)
            description |= {"encoding": encoding, "byteLength": len(packed)}
            self._append(np.frombuffer(packed, np.uint8))
        return description

    def add_bytes(self, data: bytes) -> int:
        """Append bytes of another kind; the offset at which they begin."""
        at = self.length
        self._append(np.frombuffer(data, np.uint8))
        return at

    def _append(self, data: UInt8[np.ndarray, "bytes"]) -> None:
        self._data.append(data)
        self.length += len(data) + -len(data) % 4

    def write(self, folder: Path) -> None:
        """Write the file, atomically. No array is copied."""
        with atomic_path(folder / self.uri) as path, path.open("wb") as file:
            for data in self._data:
                file.write(data.data)
                file.write(bytes(-len(data) % 4))


def read_array(folder: Path, description: dict[str, Any]) -> Shaped[np.ndarray, "..."]:
    """Read one described array. Raises RefletError where its file is missing, too short or does not hold it."""
    path, shape = folder / description["uri"], description["shape"]
    dtype = _DTYPES[description["componentType"]]
    encoding = description.get("encoding")
    start, length = description["byteOffset"], description.get("byteLength", 0)
    if not all(type(size) is int and size >= 0 for size in (*shape, start, length)):
        raise ValueError(f"an array of {path.name} has the shape {shape!r} and {length!r} bytes from {start!r} on")
    if encoding is None:
        flat = np.frombuffer(read_bytes(path, start, prod(shape) * dtype.itemsize), dtype)
    else:
        packed = read_bytes(path, start, length)
        try:
            flat = inflated(packed, encoding, dtype, prod(shape))
        except ValueError as error:
            raise damaged(path, str(error)) from None
    return flat.reshape(shape).astype(dtype.newbyteorder("="))


def read_bytes(path: Path, start: int, length: int) -> bytes:
    """``length`` bytes of a file. Raises RefletError where it is missing or has not so many."""
    try:
        if path.stat().st_size < start + length:  # asked first: reading would allocate whatever is asked for
            raise damaged(path)
        with path.open("rb") as file:
            file.seek(start)
            data = file.read(length)
    except OSError as error:
        raise unreadable(path, error) from None
    if len(data) != length:
        raise damaged(path)
    return data


def damaged(path: Path, why: str = "") -> RefletError:
    """What is said of a file that does not hold what its description says."""
    detail = f" ({why})" if why else ""
    return RefletError(f"{path} is truncated or damaged{detail}; copy it again, or bake again into a new folder.")
