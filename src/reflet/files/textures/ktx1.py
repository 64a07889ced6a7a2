"""KTX 1: any texture in and out of the container. Implements the Khronos KTX File Format Specification 1.0.

A file's numbers may be of either byte order; we write little-endian ones. Rows are padded to 4 bytes, as OpenGL takes
them by default.
"""

import os
import struct
from pathlib import Path

import numpy as np

from reflet.errors import RefletError
from reflet.files.atomic import atomic_path
from reflet.files.textures.ktx_metadata import pack_metadata, unpack_metadata
from reflet.files.textures.texel_formats import TEXEL_FORMATS, TexelFormat
from reflet.files.textures.texture import Texture, level_shape, most_levels

IDENTIFIER = b"\xabKTX 11\xbb\r\n\x1a\n"

# glType and glFormat tell how texels lie in memory ...
_TYPES = {0x1401: "8", 0x140B: "16f", 0x1406: "32f"}
_CHANNELS = {0x1903: "r", 0x1907: "rgb", 0x1908: "rgba", 0x80E0: "bgr", 0x80E1: "bgra", 0x1909: "r"}
# (Filament's tools write the internal format for the type of R11F_G11F_B10F.)
_PACKED = {0x8C3E: "rgb9e5", 0x8C3B: "r11g11b10f", 0x8C3A: "r11g11b10f"}
# ... and glInternalFormat whether 8 bits are sRGB-encoded, and what blocks are.
_SRGB = {0x8C40, 0x8C41, 0x8C42, 0x8C43, 0x8FBD}
_COMPRESSED = {
    0x83F0: "bc1",
    0x83F1: "bc1",
    0x8C4C: "bc1_srgb",
    0x8C4D: "bc1_srgb",
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

    Levels whose bytes lie in the file as they are wanted are memory maps. Raises RefletError for files that are
    missing, foreign, damaged, or hold what reflet does not read.
    """
    path = Path(path)
    try:
        data = np.memmap(path, np.uint8, "r") if path.stat().st_size else np.zeros(0, np.uint8)
    except OSError as error:
        raise RefletError(f"{path} cannot be read: {error.strerror}.") from error
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
    if depth or not width or not height or faces not in (1, 6) or (faces == 6 and (layers or width != height)):
        raise RefletError(
            f"{path} holds {width}×{height}×{depth} texels, {layers} layers and {faces} faces; expected one cube, a 2D "
            "texture or an array of them."
        )
    if level_count > most_levels(height, width):
        raise RefletError(f"{path} declares {level_count} mip levels of {width}×{height} texels; it is damaged.")
    at = _HEADER_SIZE + metadata_length
    if at > len(data):
        raise RefletError(_truncated(path))
    metadata = unpack_metadata(data[_HEADER_SIZE:at].tobytes(), str(path), order)
    images = max(layers, 1) * faces
    levels = []
    for mip_level in range(level_count):
        rows, columns = level_shape(height, width, mip_level)
        stride = _padded_row(form, columns)
        image_bytes = form.image_bytes(rows, columns) // form.row_bytes(columns) * stride
        # Of a cube the level's size is that of one face; faces and levels are multiples of 4 bytes here.
        declared = int.from_bytes(data[at : at + 4].tobytes(), "little" if order == "<" else "big")
        at += 4
        if declared not in (image_bytes, images * image_bytes) or at + images * image_bytes > len(data):
            raise RefletError(_truncated(path))
        rows_of_blocks = data[at : at + images * image_bytes].reshape(images, -1, stride)
        at += images * image_bytes
        level = rows_of_blocks[:, :, : form.row_bytes(columns)].reshape(images, -1)
        if order == ">" and form.word_bytes > 1:
            level = level.reshape(images, -1, form.word_bytes)[:, :, ::-1].reshape(images, -1)
        levels.append(level)
    return Texture(form, height, width, faces == 6, tuple(levels), metadata)


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


def _padded_row(form: TexelFormat, columns: int) -> int:
    row = form.row_bytes(columns)
    return row + -row % 4


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
        padded = np.zeros((texture.image_count, rows, _padded_row(form, columns)), np.uint8)
        padded[:, :, : form.row_bytes(columns)] = level.reshape(texture.image_count, rows, -1)
        image_size = padded[0].size if texture.is_cube else padded.size
        body += [struct.pack("<I", image_size), padded.reshape(-1).data]
    with atomic_path(path) as temporary, temporary.open("wb") as file:
        file.writelines(body)


def _truncated(path: Path) -> str:
    return f"{path} is truncated or damaged; copy it again."
