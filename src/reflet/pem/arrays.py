"""Arrays in binary files, described in JSON: ``{"uri", "byteOffset", "componentType", "shape"}``.

Component types are glTF's numbers; data are little-endian and row-major, offsets multiples of four.
"""

from math import prod
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Shaped

from reflet.errors import RefletError
from reflet.files.atomic import atomic_path
from reflet.files.unreadable import unreadable

UNSIGNED_BYTE, UNSIGNED_SHORT, UNSIGNED_INT, FLOAT = 5121, 5123, 5125, 5126
_DTYPES: dict[int, np.dtype[Any]] = {
    UNSIGNED_BYTE: np.dtype("u1"),
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
        self._arrays: list[np.ndarray] = []

    def add(self, array: Shaped[np.ndarray, "..."]) -> dict[str, Any]:
        """Append an array of uint8, uint16, uint32 or float32, which must not change any more; its description."""
        little = np.ascontiguousarray(array, array.dtype.newbyteorder("<"))
        description = {
            "uri": self.uri,
            "byteOffset": self.length,
            "componentType": _COMPONENT_TYPES[little.dtype],
            "shape": list(little.shape),
        }
        self._arrays.append(little)
        self.length += little.nbytes + -little.nbytes % 4
        return description

    def write(self, folder: Path) -> None:
        """Write the file, atomically. No array is copied."""
        with atomic_path(folder / self.uri) as path, path.open("wb") as file:
            for array in self._arrays:
                file.write(array.data)
                file.write(bytes(-array.nbytes % 4))


def read_array(folder: Path, description: dict[str, Any]) -> Shaped[np.ndarray, "..."]:
    """Read one described array. Raises RefletError where its file is missing or too short."""
    path, shape = folder / description["uri"], description["shape"]
    dtype = _DTYPES[description["componentType"]]
    try:
        flat = np.fromfile(path, dtype, prod(shape), offset=description["byteOffset"])
    except OSError as error:
        raise unreadable(path, error) from None
    if flat.size != prod(shape):
        raise RefletError(f"{path} is truncated or damaged; copy it again, or bake again into a new folder.")
    return flat.reshape(shape).astype(dtype.newbyteorder("="), copy=False)
