"""KTX 1: any texture in and out of the container. Implements the Khronos KTX File Format Specification 1.0.

A file's numbers may be of either byte order; we write little-endian ones. Rows are padded to 4 bytes, as OpenGL takes
them by default.
"""

import os
import struct
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from reflet.errors import RefletError
from reflet.files.atomic import atomic_path
from reflet.files.textures.ktx_metadata import pack_metadata, unpack_metadata
from reflet.files.textures.picture_count import damaged_metadata, picture_count
from reflet.files.textures.texel_formats import TEXEL_FORMATS, TexelFormat
from reflet.files.textures.texture import Texture, level_shape, most_levels
from reflet.files.unreadable import unreadable

IDENTIFIER = b"\xabKTX 11\xbb\r\n\x1a\n"

# glType and glFormat tell how texels lie in memory ...
# (0x8D61 is half floats in OpenGL ES 2, 0x8367 a word of four bytes; 0x8C40 and 0x8C42 say sRGB by the format.)
_TYPES = {0x1401: "8", 0x8367: "8", 0x1403: "16", 0x140B: "16f", 0x8D61: "16f", 0x1406: "32f"}
_CHANNELS = {0x1903: "r", 0x1909: "r", 0x1907: "rgb", 0x8C40: "rgb", 0x1908: "rgba", 0x8C42: "rgba"}
_CHANNELS |= {0x80E0: "bgr", 0x80E1: "bgra"}
# (Filament's tools write the internal format for the type of R11F_G11F_B10F.)
_PACKED = {0x8C3E: "rgb9e5", 0x8C3B: "r11g11b10f", 0x8C3A: "r11g11b10f"}
# ... and glInternalFormat whether 8 bits are sRGB-encoded, and what blocks are.
_SRGB = {0x8C40, 0x8C41, 0x8C42, 0x8C43, 0x8FBD}
_COMPRESSED = {
    0x83F0: "bc1",
    0x83F1: "bc1",
    0x8C4C: "bc1_srgb",
    0x8C4D: "bc1_srgb",
    0x83F2: "bc2",
    0x8C4E: "bc2_srgb",
    0x83F3: "bc3",
    0x8C4F: "bc3_srgb",
    0x8E8C: "bc7",
    0x8E8D: "bc7_srgb",
    0x8E8E: "bc6h_signed",
    0x8E8F: "bc6h",
}
# name: glType, glFormat, glInternalFormat, glBaseInternalFormat
_WRITTEN = {
    "r16f": (0x140B, 0x1903, 0x822D, 0x1903),
    "rgb16f": (0x140B, 0x1907, 0x881B, 0x1907),
    "rgba16f": (0x140B, 0x1908, 0x881A, 0x1908),
    "r32f": (0x1406, 0x1903, 0x822E, 0x1903),
    "rgb32f": (0x1406, 0x1907, 0x8815, 0x1907),
    "rgba32f": (0x1406, 0x1908, 0x8814, 0x1908),
    "rgb9e5": (0x8C3E, 0x1907, 0x8C3D, 0x1907),
    "r11g11b10f": (0x8C3B, 0x1907, 0x8C3A, 0x1907),
}

_HEADER_SIZE = 64
_ORDERS = {b"\x01\x02\x03\x04": "<", b"\x04\x03\x02\x01": ">"}


def read_ktx1_texture(path: str | os.PathLike[str]) -> Texture:
    """Opens a 2D texture, an array of them or a cube, of any size and number of levels.

    Read as meant: a depth or a number of layers of 1 and a number of faces of 0 or 1 are a single 2D texture, 6 faces
    with 1 layer a cube; of several cubes the first is taken. Rows are padded to 4 bytes or not at all, as the sizes
    say. Levels whose bytes lie in the file as they are wanted are memory maps. Raises RefletError for files that are
    missing, foreign, damaged, or hold what reflet does not read.
    """
    path = Path(path)
    try:
        data = np.memmap(path, np.uint8, "r") if path.stat().st_size else np.zeros(0, np.uint8)
    except OSError as error:
        raise unreadable(path, error) from error
    head = data[:_HEADER_SIZE].tobytes()
    if not head.startswith(IDENTIFIER):
        raise RefletError(f"{path} is not a KTX 1 file; check what it is.")
    if len(head) < _HEADER_SIZE or head[12:16] not in _ORDERS:
        raise RefletError(_truncated(path))
    order = _ORDERS[head[12:16]]
    numbers = struct.unpack(order + "12I", head[16:])
    gl_type, _, gl_format, internal, _, width, height, depth, layers, faces, level_count, metadata_length = numbers
    form = _texel_format(path, gl_type, gl_format, internal)
    level_count = max(level_count, 1)  # 0 asks the reader to make the coarser ones
    count = picture_count(path, width, height, depth, layers, faces)
    if level_count > most_levels(height, width):
        raise RefletError(f"{path} declares {level_count} mip levels of {width}×{height} texels; it is damaged.")
    at = _HEADER_SIZE + metadata_length
    if at > len(data):
        raise RefletError(_truncated(path))
    metadata, is_sound = unpack_metadata(data[_HEADER_SIZE:at].tobytes(), order)
    doubts = count.doubts if is_sound else (*count.doubts, damaged_metadata(path, metadata))
    shapes = [level_shape(height, width, mip_level) for mip_level in range(level_count)]
    places = _level_places(data, at, form, shapes, count.stored, order)
    if places is None:
        # The sizes are wrong; where the dimensions account for the whole file, they are no loss.
        places = _level_places(data, at, form, shapes, count.stored, None)
        if places is None or not _ends_with(data, places[-1], count.stored):
            raise RefletError(_truncated(path))
        doubts += (f"{path} declares sizes of its mip levels that its dimensions deny; the dimensions hold.",)
    levels = []
    for (rows, columns), (start, stride, image_stride) in zip(shapes, places, strict=True):
        # of the bytes of each picture, its rows of blocks; of those, what is no padding
        bands = -(-rows // form.block_side)
        pictures = data[start : start + count.stored * image_stride].reshape(count.stored, image_stride)[: count.used]
        level = pictures[:, : bands * stride].reshape(count.used, bands, stride)[:, :, : form.row_bytes(columns)]
        level = level.reshape(count.used, -1)
        if order == ">" and form.word_bytes > 1:
            level = level.reshape(count.used, -1, form.word_bytes)[:, :, ::-1].reshape(count.used, -1)
        levels.append(level)
    return Texture(form, height, width, count.is_cube, tuple(levels), metadata, doubts=doubts)


def _level_places(
    data: np.ndarray, at: int, form: TexelFormat, shapes: Sequence[tuple[int, int]], images: int, order: str | None
) -> list[tuple[int, int, int]] | None:
    """Of each level: its first byte, and the bytes of a row of blocks and of a picture, padding included.

    The format pads rows, faces and levels to 4 bytes. Writers that do not are known by the sizes that they declare:
    of the ways to pad, the first is taken by which these agree and the file ends where the last level does; else the
    first by which they agree. None where none does. The sizes are in the byte ``order``; None ignores them.
    """
    fitting = []
    for alignment in ((4, 4), (1, 4), (1, 1)):  # of rows, and of faces and levels
        places = _places_if_padded(data, at, form, shapes, images, order, alignment)
        if places is not None:
            if _ends_with(data, places[-1], images):
                return places
            fitting.append(places)
    return fitting[0] if fitting else None


def _ends_with(data: np.ndarray, last_level: tuple[int, int, int], images: int) -> bool:
    """Whether the file ends where its last level does, or with the padding behind that."""
    start, _, image_stride = last_level
    return 0 <= len(data) - (start + images * image_stride) < 4


def _places_if_padded(
    data: np.ndarray,
    at: int,
    form: TexelFormat,
    shapes: Sequence[tuple[int, int]],
    images: int,
    order: str | None,
    alignment: tuple[int, int],
) -> list[tuple[int, int, int]] | None:
    places = []
    for rows, columns in shapes:
        stride = _aligned(form.row_bytes(columns), alignment[0])
        image = -(-rows // form.block_side) * stride
        # A cube's pictures begin at multiples of 4 bytes, others follow each other; both do where rows are padded.
        image_stride = _aligned(image, alignment[1]) if images == 6 else image
        declared = int.from_bytes(data[at : at + 4].tobytes(), "little" if order == "<" else "big")
        # The size is that of one face of a cube, but of all pictures of others; writers differ.
        if order is not None and declared not in (image, images * image, images * image_stride):
            return None
        at += 4
        if at + images * image > len(data):
            return None
        places.append((at, stride, image_stride))
        at += _aligned(images * image_stride, alignment[1])
    start, _, image_stride = places[-1]
    return places if start + images * image_stride <= len(data) else None


def _texel_format(path: Path, gl_type: int, gl_format: int, internal: int) -> TexelFormat:
    name = _PACKED.get(gl_type)
    if gl_type == 0:
        name = _COMPRESSED.get(internal)
    elif gl_type in _TYPES and gl_format in _CHANNELS:
        srgb = "_srgb" if gl_type == 0x1401 and internal in _SRGB else ""
        name = _CHANNELS[gl_format] + _TYPES[gl_type] + srgb
    if name not in TEXEL_FORMATS:
        raise RefletError(
            f"{path} holds texels of OpenGL's type {gl_type:#x}, format {gl_format:#x} and internal format "
            f"{internal:#x}; expected floats of 16 or 32 bits, RGB9E5, R11F_G11F_B10F, BC1, BC3, BC6H, BC7 or 8 bits a "
            "channel."
        )
    return TEXEL_FORMATS[name]


def _aligned(size: int, alignment: int) -> int:
    return size + -size % alignment


def write_ktx1_texture(path: str | os.PathLike[str], texture: Texture, *, filament: bool = False) -> None:
    """Writes a texture, atomically; equal textures give equal bytes.

    ``filament``: R11G11B10F is marked as Filament's tools do, the only way that its reader knows it by. Raises
    RefletError where the file cannot be written, ValueError for formats that are only read.
    """
    form = texture.texel_format
    if form.name not in _WRITTEN:
        raise ValueError(f"{form.name} is only read")
    gl_type, gl_format, internal, base = _WRITTEN[form.name]
    if filament and form.name == "r11g11b10f":
        gl_type = internal
    metadata = dict(texture.metadata)
    if metadata.get("KTXorientation") == b"rd":  # KTX 2.0's way to say it
        metadata["KTXorientation"] = b"S=r,T=d"
    pairs = pack_metadata(metadata)
    layers = 0 if texture.is_cube or texture.image_count == 1 else texture.image_count
    body: list[bytes | memoryview] = [
        IDENTIFIER,
        struct.pack("<5I", 0x04030201, gl_type, form.word_bytes, gl_format, internal),
        struct.pack("<4I", base, texture.columns, texture.rows, 0),
        struct.pack("<4I", layers, 6 if texture.is_cube else 1, len(texture.levels), len(pairs)),
        pairs,
    ]
    for mip_level, level in enumerate(texture.levels):
        rows, columns = texture.level_shape(mip_level)
        stride = _aligned(form.row_bytes(columns), 4)
        padded = np.zeros((texture.image_count, rows, stride), np.uint8)
        padded[:, :, : form.row_bytes(columns)] = level.reshape(texture.image_count, rows, -1)
        image_size = padded[0].size if texture.is_cube else padded.size
        body += [struct.pack("<I", image_size), padded.reshape(-1).data]
    with atomic_path(path) as temporary, temporary.open("wb") as file:
        file.writelines(body)


def _truncated(path: Path) -> str:
    return f"{path} is truncated or damaged; copy it again."
