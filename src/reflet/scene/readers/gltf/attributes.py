"""The arrays of a primitive, wherever they are stored: in accessors, or compressed by Draco."""

from collections.abc import Collection

import numpy as np
from jaxtyping import Float32, UInt32

from reflet.scene.readers.gltf.accessors import Accessors, as_floats
from reflet.scene.readers.gltf.buffers import Buffers
from reflet.scene.readers.gltf.draco import DracoPrimitive, decode_draco
from reflet.scene.readers.gltf.values import DamagedError, JsonObject, child, extension, index_or_none, whole

TRIANGLES, _STRIP, _FAN = 4, 5, 6


class Attributes:
    """The attributes of one primitive, by glTF's names; None where it has none of that name."""

    def __init__(self, primitive: JsonObject, accessors: Accessors, buffers: Buffers) -> None:
        self._primitive, self._accessors = primitive, accessors
        self._indices = child(primitive, "attributes")
        packed = extension(primitive, "KHR_draco_mesh_compression")
        self._draco: DracoPrimitive | None = None if packed is None else decode_draco(packed, buffers)

    def floats(
        self, name: str, widths: Collection[int], count: int | None = None, *, fractions: bool = False
    ) -> Float32[np.ndarray, "count width"] | None:
        """As float32, ``count`` of them. Integers of ``fractions`` count as normalized even if not marked as such."""
        index = index_or_none(self._indices, name)
        if self._draco is not None and name in self._draco.attributes:
            stored = self._draco.attributes[name]
            if stored.shape[1] not in widths:
                raise DamagedError(f"{name} has {stored.shape[1]} components in Draco's data")
            is_normalized = fractions or (index is not None and self._accessors.is_normalized(index))
            return _counted(as_floats(stored, is_normalized), name, count)
        if index is None:
            return None
        return _counted(self._accessors.floats(index, widths, fractions=fractions), name, count)

    def integers(self, name: str, width: int, count: int) -> np.ndarray | None:
        """(count, width) whole numbers as they are stored."""
        index = index_or_none(self._indices, name)
        if self._draco is not None and name in self._draco.attributes:
            values = self._draco.attributes[name]
            if values.shape[1] != width or values.dtype.kind != "u":
                raise DamagedError(f"{name} is no {width} whole numbers in Draco's data")
            return _counted(values, name, count)
        return None if index is None else _counted(self._accessors.integers(index, width), name, count)

    def triangles(self, vertex_count: int) -> tuple[UInt32[np.ndarray, "triangles 3"], int]:
        """Vertex indices of a list, strip or fan [glTF 2.0, 3.7.2.1], and how many indices make no whole triangle.

        Raises DamagedError for vertices that there are not.
        """
        surplus = 0
        if self._draco is not None:
            triangles = self._draco.triangles
        else:
            at = index_or_none(self._primitive, "indices")
            indices = np.arange(vertex_count, dtype=np.uint32) if at is None else self._accessors.indices(at)
            triangles = _assembled(indices, mode(self._primitive))
            surplus = len(indices) % 3 if mode(self._primitive) == TRIANGLES else 0
        if triangles.size and triangles.max() >= vertex_count:
            raise DamagedError(f"it refers to vertex {triangles.max()} of {vertex_count}")
        return triangles, surplus


def mode(primitive: JsonObject) -> int:
    """What the primitive's vertices make: below TRIANGLES, points and lines."""
    kind = whole(primitive.get("mode", TRIANGLES), "mode")
    if kind > _FAN:
        raise DamagedError(f"a primitive has mode {kind}, which there is not")
    return kind


def _counted(values: np.ndarray, name: str, count: int | None) -> np.ndarray:
    if count is not None and len(values) != count:
        raise DamagedError(f"{name} has {len(values)} elements for {count} vertices")
    return values


def _assembled(indices: UInt32[np.ndarray, "indices"], kind: int) -> UInt32[np.ndarray, "triangles 3"]:
    if kind == TRIANGLES:
        return indices[: len(indices) // 3 * 3].reshape(-1, 3)
    i = np.arange(max(len(indices) - 2, 0))
    if kind == _FAN:
        return np.column_stack([indices[i + 1], indices[i + 2], np.broadcast_to(indices[:1], i.shape)])
    odd = i % 2
    return np.column_stack([indices[i], indices[i + 1 + odd], indices[i + 2 - odd]])
