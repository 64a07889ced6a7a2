"""Typed arrays out of buffer views: accessors, strided, sparse or normalized."""

from collections.abc import Collection

import numpy as np
from jaxtyping import Float32, UInt32

from reflet.scene.readers.gltf.buffers import Buffers
from reflet.scene.readers.gltf.document import Document
from reflet.scene.readers.gltf.values import DamagedError, JsonObject, child, index_or_none, whole

_DTYPES = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
_MOST_ZEROS = 2**26  # elements that no byte of the file stands for


class Accessors:
    """Decodes accessors. Raises DamagedError where the file breaks its promises."""

    def __init__(self, document: Document, buffers: Buffers) -> None:
        self._document, self._buffers = document, buffers

    def floats(
        self, index: int, widths: Collection[int], *, fractions: bool = False
    ) -> Float32[np.ndarray, "count width"]:
        """Elements of one of the ``widths`` as float32, normalized integers from -1 or 0 to 1; integers of
        ``fractions`` count as normalized."""
        return as_floats(self._elements(index, widths), fractions or self.is_normalized(index))

    def indices(self, index: int) -> UInt32[np.ndarray, "count"]:
        """Whole numbers, in an array of their own."""
        return self.integers(index, 1)[:, 0].astype(np.uint32)

    def integers(self, index: int, width: int) -> np.ndarray:
        """(count, width) whole numbers as they are stored."""
        values = self._elements(index, (width,))
        if values.dtype.kind != "u":
            raise DamagedError(f"accessor {index} counts in {values.dtype}, not in unsigned whole numbers")
        return values

    def is_normalized(self, index: int) -> bool:
        """Whether the accessor's integers stand for fractions of the largest one."""
        return self._document.item("accessors", index).get("normalized") is True

    def _elements(self, index: int, widths: Collection[int]) -> np.ndarray:
        """(count, width) elements as they are stored: a view into the buffer where that is possible."""
        item = self._document.item("accessors", index)
        width = _WIDTHS.get(str(item.get("type")), 0)
        if width not in widths:
            wanted = " or ".join(name for name, wide in _WIDTHS.items() if wide in widths)
            raise DamagedError(f"accessor {index} is of type {str(item.get('type'))[:20]}, not {wanted}")
        dtype, count = _dtype(item), whole(item.get("count"), "count")
        view = index_or_none(item, "bufferView")
        if view is None and count > _MOST_ZEROS:
            raise DamagedError(f"accessor {index} has {count} elements and no bytes to read them from")
        if view is None:
            values: np.ndarray = np.broadcast_to(np.zeros(1, dtype), (count, width))
        else:
            values = self._read(view, whole(item.get("byteOffset", 0), "byteOffset"), dtype, width, count)
        sparse = child(item, "sparse")
        return self._with_substitutes(sparse, values) if sparse else values

    def _read(self, index: int, offset: int, dtype: np.dtype, width: int, count: int) -> np.ndarray:
        view = self._buffers.view(index)
        stride = view.stride or dtype.itemsize * width
        end = offset + (count - 1) * stride + dtype.itemsize * width
        if count and end > len(view.data):
            raise DamagedError(f"an accessor ends behind buffer view {index}, at byte {end} of {len(view.data)}")
        if not count:
            return np.empty((0, width), dtype)
        return np.ndarray((count, width), dtype, view.data.data, offset, (stride, dtype.itemsize))

    def _with_substitutes(self, sparse: JsonObject, values: np.ndarray) -> np.ndarray:
        count, where, what = whole(sparse.get("count"), "count"), child(sparse, "indices"), child(sparse, "values")
        places = self._read(
            whole(where.get("bufferView"), "bufferView"), whole(where.get("byteOffset", 0), "byteOffset"),
            _dtype(where), 1, count,
        )[:, 0]  # fmt: skip
        if count and (places.dtype.kind != "u" or places.max() >= len(values)):
            raise DamagedError("a sparse accessor substitutes elements that it does not have")
        substituted = np.array(values)
        substituted[places] = self._read(
            whole(what.get("bufferView"), "bufferView"), whole(what.get("byteOffset", 0), "byteOffset"),
            values.dtype, values.shape[1], count,
        )  # fmt: skip
        return substituted


def as_floats(values: np.ndarray, is_normalized: bool) -> Float32[np.ndarray, "count width"]:
    """Stored elements as native float32; normalized integers by [glTF 2.0, 3.6.2.2]: f = max(c / largest, -1)."""
    if is_normalized and values.dtype.kind in "iu":
        return np.maximum(values.astype(np.float32) / np.float32(np.iinfo(values.dtype).max), np.float32(-1.0))
    return values.astype(np.float32, order="C", copy=not (values.flags.c_contiguous and values.flags.aligned))


def _dtype(item: JsonObject) -> np.dtype:
    code = item.get("componentType")
    if code not in _DTYPES:
        raise DamagedError(f"an accessor has the component type {str(code)[:20]}, which there is not")
    return np.dtype(_DTYPES[code]).newbyteorder("<")
