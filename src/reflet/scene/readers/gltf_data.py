"""The bytes of a glTF file: buffers, accessors and images."""

import base64
import binascii
from functools import lru_cache
from pathlib import Path
from urllib.parse import unquote, unquote_to_bytes

import numpy as np
from jaxtyping import UInt8
from pygltflib import GLTF2

from reflet.errors import RefletError
from reflet.files.pictures.png import decode_picture

_DTYPES = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


class GltfData:
    """Decodes what a parsed file refers to. Raises RefletError, in one sentence, where the file breaks its promises."""

    def __init__(self, gltf: GLTF2, path: Path) -> None:
        self.gltf, self.path = gltf, path
        # each buffer is read once, however many accessors look into it
        self._buffer = lru_cache(maxsize=None)(self._read_buffer)

    def _refusal(self, what: str) -> RefletError:
        return RefletError(f"{self.path} is damaged: {what}; export it again.")

    def _read_uri(self, uri: str) -> bytes:
        if uri.startswith("data:"):
            head, _, body = uri.partition(",")
            try:
                return base64.b64decode(body, validate=True) if head.endswith(";base64") else unquote_to_bytes(body)
            except binascii.Error as error:
                raise self._refusal(f"a data URI does not decode ({error})") from error
        if "://" in uri:
            raise RefletError(f"{self.path} refers to {uri} on another machine; download it beside the file.")
        target = self.path.parent / unquote(uri)
        try:
            return target.read_bytes()
        except OSError as error:
            raise RefletError(f"{self.path} refers to {target}, which cannot be read ({error.strerror}).") from error

    def _read_buffer(self, index: int) -> bytes:
        buffer = self.gltf.buffers[index]
        data = self._read_uri(buffer.uri) if buffer.uri else self.gltf.binary_blob()
        if data is None or len(data) < buffer.byteLength:
            raise self._refusal(f"buffer {index} holds {len(data or b'')} of {buffer.byteLength} bytes")
        return data

    def _view(self, index: int) -> tuple[bytes, int, int, int]:
        """Buffer, start, length and stride (0 where tightly packed) of a buffer view."""
        view = self.gltf.bufferViews[index]
        data, start = self._buffer(view.buffer), view.byteOffset or 0
        if start + view.byteLength > len(data):
            raise self._refusal(f"buffer view {index} ends behind its buffer")
        return data, start, view.byteLength, view.byteStride or 0

    def _elements(self, view: int, offset: int, component: int, width: int, count: int) -> np.ndarray:
        data, start, length, stride = self._view(view)
        dtype = np.dtype(_DTYPES[component]).newbyteorder("<")
        stride = stride or dtype.itemsize * width
        if count and offset + (count - 1) * stride + dtype.itemsize * width > length:
            raise self._refusal(f"an accessor ends behind buffer view {view}")
        return np.ndarray((count, width), dtype, data, start + offset, (stride, dtype.itemsize))

    def accessor(self, index: int) -> np.ndarray:
        """(count, width) elements: normalized integers as float32, other ones as they are stored."""
        item = self.gltf.accessors[index]
        if item.type not in _WIDTHS or item.componentType not in _DTYPES:
            raise self._refusal(f"accessor {index} has an unexpected type")
        width, dtype = _WIDTHS[item.type], _DTYPES[item.componentType]
        if item.bufferView is None:
            values = np.zeros((item.count, width), dtype)
        else:
            values = self._elements(item.bufferView, item.byteOffset or 0, item.componentType, width, item.count)
        if item.sparse is not None:
            values = self._with_substitutes(item, values, width)
        if item.normalized and values.dtype.kind in "iu":
            # [glTF 2.0, 3.6.2.2]: f = max(c / largest, -1)
            values = np.maximum(values.astype(np.float32) / np.float32(np.iinfo(values.dtype).max), np.float32(-1.0))
        return np.ascontiguousarray(values)

    def _with_substitutes(self, item: object, values: np.ndarray, width: int) -> np.ndarray:
        sparse = item.sparse  # type: ignore[attr-defined]
        where = self._elements(
            sparse.indices.bufferView, sparse.indices.byteOffset or 0, sparse.indices.componentType, 1, sparse.count
        )[:, 0]
        if where.size and where.max() >= len(values):
            raise self._refusal("a sparse accessor substitutes elements that it does not have")
        component = item.componentType  # type: ignore[attr-defined]
        values = values.copy()
        values[where] = self._elements(
            sparse.values.bufferView, sparse.values.byteOffset or 0, component, width, sparse.count
        )
        return values

    def image(self, index: int) -> UInt8[np.ndarray, "height width 4"]:
        """RGBA pixels of an image, row 0 at the top."""
        image = self.gltf.images[index]
        if image.uri:
            data, name = self._read_uri(image.uri), image.uri
        else:
            buffer, start, length, _ = self._view(image.bufferView)
            data, name = buffer[start : start + length], image.name or str(index)
        return decode_picture(data, f"Image {name[:60]} of {self.path}")
