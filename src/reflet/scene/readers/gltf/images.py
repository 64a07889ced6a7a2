"""Textures: pictures of every kind that glTF files hold, and how they repeat."""

import numpy as np
from jaxtyping import UInt8

from reflet.errors import RefletError
from reflet.files.pictures.png import decode_picture, shown_alike
from reflet.scene.material import REPEATS, Texture, Wrap
from reflet.scene.readers.gltf.buffers import Buffers
from reflet.scene.readers.gltf.document import Document
from reflet.scene.readers.gltf.values import DamagedError, JsonObject, extension, index_or_none, text

_WRAPS: dict[int, Wrap] = {10497: "repeat", 33071: "clamp", 33648: "mirror"}

_KTX2 = b"\xabKTX 20\xbb\r\n\x1a\n"
_LARGEST = 2**28  # texels
_SOURCES = ("EXT_texture_webp", "EXT_texture_avif", "KHR_texture_basisu", "MSFT_texture_dds")


class Textures:
    """Decodes each texture once. One that cannot be read is noted and is None: its material shows its factors alone."""

    def __init__(self, document: Document, buffers: Buffers) -> None:
        self._document, self._buffers = document, buffers
        self._read: dict[int, Texture | None] = {}

    def texture(self, info: JsonObject | None) -> Texture | None:
        """What a material's texture info stands for."""
        if info is None:
            return None
        index = index_or_none(info, "index")
        if index is None:
            return None
        if index not in self._read:
            self._read[index] = self._decoded(index)
        return self._read[index]

    def _wraps(self, number: int, texture: JsonObject) -> tuple[Wrap, Wrap]:
        """What the texture's sampler does beyond the picture's sides, and above and below."""
        index = index_or_none(texture, "sampler")
        try:
            sampler = {} if index is None else self._document.item("samplers", index)
        except DamagedError as error:
            self._document.notes.add("textures whose sampler is not there repeat", "textures", number, str(error))
            return REPEATS
        given = [index_or_none(sampler, key) or 10497 for key in ("wrapS", "wrapT")]
        for code in given:
            if code not in _WRAPS:
                self._document.notes.add("textures that wrap in no way of glTF's repeat", "textures", number, str(code))
        return _WRAPS.get(given[0], "repeat"), _WRAPS.get(given[1], "repeat")

    def _decoded(self, index: int) -> Texture | None:
        try:
            texture = self._document.item("textures", index)
            pixels, encoded = self._pixels(texture)
        except (RefletError, DamagedError) as error:
            self._document.notes.add(
                "some pictures cannot be read, and the materials that use them show their factors alone",
                "textures", index, str(error).rstrip("."),
            )  # fmt: skip
            return None
        return Texture(pixels, self._wraps(index, texture), encoded=encoded)

    def _pixels(self, texture: JsonObject) -> tuple[UInt8[np.ndarray, "height width 4"], bytes | None]:
        """Of the first source that can be read; the plain one is there for readers without the extensions."""
        named = [found for name in _SOURCES if (found := extension(texture, name)) is not None]
        sources = [source for item in [*named, texture] if (source := index_or_none(item, "source")) is not None]
        if not sources:
            raise DamagedError("a texture names no picture")
        refusal: RefletError | DamagedError | None = None
        for source in sources:
            try:
                return self._picture(source)
            except (RefletError, DamagedError) as error:
                refusal = refusal or error
        assert refusal is not None
        raise refusal

    def _picture(self, index: int) -> tuple[UInt8[np.ndarray, "height width 4"], bytes | None]:
        """RGBA pixels of an image, row 0 at the top, and its file if viewers show it so. The bytes tell what it is, not
        the media type."""
        image = self._document.item("images", index)
        uri = text(image, "uri")
        name = text(image, "name") or (f"number {index}" if not uri or uri.startswith("data:") else uri)
        data = self._buffers.image(index)
        if data.startswith(_KTX2):
            return _basis_pixels(data, f"image {name[:60]}"), None
        return decode_picture(data, f"image {name[:60]}"), data if shown_alike(data) else None


def _basis_pixels(data: bytes, name: str) -> UInt8[np.ndarray, "height width 4"]:
    """The finest level of a KTX 2 file in one of the two Basis Universal codes, ETC1S and UASTC."""
    try:
        import opengl_basisu
    except ImportError as error:
        raise RefletError(
            f"{name} is in Basis Universal code, for which this machine has no decoder; undo the code with: "
            "npx @gltf-transform/cli ktxdecompress OLD.glb NEW.glb"
        ) from error
    try:
        texture = opengl_basisu.open(data)
        if texture.width * texture.height > _LARGEST:
            raise RefletError(f"{name} has {texture.width}×{texture.height} texels, too many to read")
        return np.asarray(texture.transcode("rgba8").data)
    except (ValueError, IndexError, MemoryError) as error:
        raise RefletError(f"{name} is no KTX 2 picture in Basis Universal code ({error}); make it PNG") from error
