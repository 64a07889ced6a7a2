"""The bytes that a glTF document refers to: buffers, and the views into them."""

import base64
import binascii
from dataclasses import dataclass
from urllib.parse import unquote_to_bytes

import meshopt
import numpy as np
from jaxtyping import UInt8

from reflet.files.unreadable import unreadable
from reflet.scene.readers.gltf.document import Document
from reflet.scene.readers.gltf.values import DamagedError, JsonObject, extension, index_or_none, text, whole
from reflet.scene.readers.resources import find_resource

Bytes = UInt8[np.ndarray, "bytes"]

_MESHOPT = ("EXT_meshopt_compression", "KHR_meshopt_compression")
_MESHOPT_RATIO = 2048  # its densest code spends 2 bits on 256 bytes: whatever claims more is damaged


@dataclass(frozen=True)
class View:
    """Bytes of a buffer view, and the step from one element to the next in bytes, 0 where they follow tightly."""

    data: Bytes
    stride: int


class Buffers:
    """Reads each buffer once, however many views look into it."""

    def __init__(self, document: Document) -> None:
        self._document = document
        self._read: dict[int, Bytes] = {}
        self._views: dict[int, View] = {}

    def view(self, index: int) -> View:
        """Buffer view ``index``, decompressed where it is compressed."""
        if index not in self._views:
            view = self._document.item("bufferViews", index)
            packed = next((found for name in _MESHOPT if (found := extension(view, name)) is not None), None)
            if packed is None:
                self._views[index] = View(self._slice(view, index), whole(view.get("byteStride", 0), "byteStride"))
            else:
                self._views[index] = self._unpacked(packed, index)
        return self._views[index]

    def _slice(self, view: JsonObject, index: int) -> Bytes:
        start, length = whole(view.get("byteOffset", 0), "byteOffset"), whole(view.get("byteLength"), "byteLength")
        buffer = self._buffer(whole(view.get("buffer"), "buffer"))
        if start + length > len(buffer):
            raise DamagedError(f"buffer view {index} ends at byte {start + length} of a buffer of {len(buffer)}")
        return buffer[start : start + length]

    def _unpacked(self, packed: JsonObject, index: int) -> View:
        """[EXT_meshopt_compression]: the view's own buffer is a fallback that need not exist."""
        data, count = self._slice(packed, index), whole(packed.get("count"), "count")
        stride = whole(packed.get("byteStride"), "byteStride")
        if count * stride > _MESHOPT_RATIO * len(data):
            raise DamagedError(f"the {len(data)} bytes of buffer view {index} cannot hold {count} elements")
        if count == 0:
            return View(np.empty(0, np.uint8), stride)
        try:
            mode, filter_ = text(packed, "mode"), text(packed, "filter") or None
            decoded = meshopt.decode_gltf_buffer(data, count, stride, mode, filter_)  # type: ignore[arg-type]
        except (ValueError, RuntimeError) as error:
            raise DamagedError(f"buffer view {index} does not decompress ({error})") from error
        return View(np.ascontiguousarray(decoded).view(np.uint8).reshape(-1), stride)

    def _buffer(self, index: int) -> Bytes:
        if index not in self._read:
            uri = self._document.item("buffers", index).get("uri")
            blob = self._document.blob if index == 0 else None
            data = blob if uri is None else self.resource(uri)
            if data is None:
                raise DamagedError(f"buffer {index} has neither a name nor a chunk of a .glb file behind it")
            self._read[index] = np.frombuffer(data, np.uint8)
        return self._read[index]

    def resource(self, uri: object) -> bytes:
        """The bytes behind a URI: of a data URI itself, or of the file that it names.

        Raises RefletError where the file is missing or cannot be read.
        """
        if not isinstance(uri, str):
            raise DamagedError("a URI is no text")
        if uri.lstrip()[:5].lower() == "data:":
            return _data_uri(uri)
        target = find_resource(self._document.path.parent, uri, is_uri=True)
        try:
            return target.read_bytes()
        except OSError as error:
            raise unreadable(target, error) from error

    def image(self, index: int) -> bytes:
        """The encoded bytes of an image."""
        image = self._document.item("images", index)
        view = index_or_none(image, "bufferView")
        return self.resource(image.get("uri")) if view is None else self.view(view).data.tobytes()


def _data_uri(uri: str) -> bytes:
    """Whatever the media type: lines may be wrapped, padding left out, and the alphabet that of file names."""
    head, _, body = uri.partition(",")
    data = unquote_to_bytes("".join(body.split()))
    if not head.rstrip().lower().endswith(";base64"):
        return data
    data = data.translate(bytes.maketrans(b"-_", b"+/"), b" \t\r\n").rstrip(b"=")
    try:
        return base64.b64decode(data + b"=" * (-len(data) % 4), validate=True)
    except binascii.Error as error:
        raise DamagedError(f"a data URI does not decode ({error})") from error
