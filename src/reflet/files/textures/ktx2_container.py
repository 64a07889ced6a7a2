"""KTX 2.0: any texture in and out of the container. Implements the Khronos Texture File Format 2.0."""

import os
import struct
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import zstandard

from reflet.errors import RefletError
from reflet.files.atomic import atomic_path
from reflet.files.textures.basis import CODES, read_basis_texture
from reflet.files.textures.data_format_descriptor import data_format_descriptor
from reflet.files.textures.ktx_metadata import pack_metadata, unpack_metadata
from reflet.files.textures.picture_count import PictureCount, damaged_metadata, picture_count
from reflet.files.textures.texel_formats import TEXEL_FORMATS, TexelFormat
from reflet.files.textures.texture import Texture, level_shape, most_levels
from reflet.files.unreadable import unreadable

IDENTIFIER = b"\xabKTX 20\xbb\r\n\x1a\n"

VK_FORMATS = {
    9: "r8",
    15: "r8_srgb",
    23: "rgb8",
    29: "rgb8_srgb",
    30: "bgr8",
    36: "bgr8_srgb",
    37: "rgba8",
    43: "rgba8_srgb",
    44: "bgra8",
    50: "bgra8_srgb",
    51: "rgba8",
    57: "rgba8_srgb",
    70: "r16",
    76: "r16f",
    84: "rgb16",
    91: "rgba16",
    90: "rgb16f",
    97: "rgba16f",
    100: "r32f",
    106: "rgb32f",
    109: "rgba32f",
    122: "r11g11b10f",
    123: "rgb9e5",
    131: "bc1",
    132: "bc1_srgb",
    133: "bc1",
    134: "bc1_srgb",
    135: "bc2",
    136: "bc2_srgb",
    137: "bc3",
    138: "bc3_srgb",
    143: "bc6h",
    144: "bc6h_signed",
    145: "bc7",
    146: "bc7_srgb",
}
"""Names in `TEXEL_FORMATS` by VkFormat."""

_HEADER = struct.Struct("<12s 9I 4I 2Q")  # identifier; format to supercompression; DFD and KVD; supercompression data
_LEVEL = struct.Struct("<3Q")  # offset, length, uncompressed length
_NONE, _BASIS_LZ, _ZSTD, _ZLIB = 0, 1, 2, 3
_PACKED = {_ZSTD: "zstd", _ZLIB: "zlib"}
_FAMILIES = {"ETC2": range(147, 157), "ASTC": range(157, 185), "ASTC HDR": range(1000066000, 1000066014)}
_PRIMARIES = {
    2: "BT.601",
    3: "BT.601",
    4: "BT.2020",
    5: "CIE XYZ",
    6: "ACES",
    7: "ACEScc",
    10: "Display P3",
    11: "Adobe RGB",
}

_ZSTD_LEVEL = 6  # beyond, half floats shrink by 2 % more and take many times as long

# A block of a Zstandard frame takes 4 bytes at least and makes 128 KiB at most; 2 bits of deflated data make 258 bytes.
_BEST_RATIO = {_NONE: 1, _ZSTD: (128 << 10) // 4, _ZLIB: 1032}


@dataclass(frozen=True)
class Ktx2Header:
    """What a file says of itself, checked against its size: every level lies inside it.

    Of files in Basis Universal code, which their decoder checks, the levels' places are not told.
    """

    texel_format: TexelFormat
    rows: int
    columns: int
    level_count: int
    pictures: PictureCount
    level_places: tuple[tuple[int, int, int], ...]  # offset, length, uncompressed length; finest first
    supercompression: str | None  # "zstd", "zlib", or one of Basis Universal's codes
    alpha_is_premultiplied: bool
    metadata: dict[str, bytes]
    doubts: tuple[str, ...]


def read_header(path: Path) -> Ktx2Header:
    """Reads all but the texels. Raises RefletError for files that are missing, foreign, damaged or not readable."""
    try:
        size_on_disk = path.stat().st_size
        with path.open("rb") as file:
            head = file.read(_HEADER.size)
            if not head.startswith(IDENTIFIER):
                raise RefletError(f"{path} is not a KTX 2.0 file; check what it is.")
            if len(head) < _HEADER.size:
                raise RefletError(_truncated(path))
            kind, _, width, height, depth, layers, faces, level_count, scheme = _HEADER.unpack(head)[1:10]
            descriptor_at, descriptor_length, metadata_at, metadata_length = _HEADER.unpack(head)[10:14]
            level_count = max(level_count, 1)
            if level_count > most_levels(height, width):
                raise RefletError(
                    f"{path} declares {level_count} mip levels of {width}×{height} texels; it is damaged."
                )
            index = file.read(_LEVEL.size * level_count)
            if max(descriptor_at + descriptor_length, metadata_at + metadata_length) > size_on_disk:
                raise RefletError(_truncated(path))
            file.seek(descriptor_at)
            descriptor = file.read(descriptor_length)
            file.seek(metadata_at)
            metadata = file.read(metadata_length)
    except OSError as error:
        raise unreadable(path, error) from error
    pictures = picture_count(path, width, height, depth, layers, faces)
    pairs, is_sound = unpack_metadata(metadata)
    model = descriptor[12] if len(descriptor) > 15 else 0
    if scheme == _BASIS_LZ or model in CODES:
        code = CODES.get(model, "basis universal")
        return Ktx2Header(TEXEL_FORMATS["rgba8"], height, width, level_count, pictures, (), code, False, pairs, ())
    _check_is_decodable(path, kind, scheme)
    places = tuple(_LEVEL.iter_unpack(index[: len(index) // _LEVEL.size * _LEVEL.size]))
    texel_format = TEXEL_FORMATS[VK_FORMATS[kind]]
    if len(places) < level_count:
        raise RefletError(_truncated(path))
    for mip_level, (offset, length, uncompressed) in enumerate(places):
        expected = texel_format.image_bytes(*level_shape(height, width, mip_level)) * pictures.stored
        smallest = expected / _BEST_RATIO[scheme]
        declared = length if scheme == _NONE else uncompressed  # of plain levels some writers leave the latter 0
        if declared != expected or length < smallest or offset + length > size_on_disk:
            raise RefletError(_truncated(path))
    return Ktx2Header(
        texel_format,
        height,
        width,
        level_count,
        pictures,
        places,
        _PACKED.get(scheme),
        len(descriptor) > 15 and bool(descriptor[15] & 1),
        pairs,
        (
            *pictures.doubts,
            *(() if is_sound else (damaged_metadata(path, pairs),)),
            *_doubts_of_colours(path, texel_format, descriptor, pairs),
        ),
    )


def _check_is_decodable(path: Path, kind: int, scheme: int) -> None:
    """Raises RefletError for texels that reflet cannot decode."""
    if scheme not in _BEST_RATIO:
        raise RefletError(
            f"{path} is supercompressed by the unknown scheme {scheme}; store it plain, with Zstandard or with ZLIB."
        )
    if kind not in VK_FORMATS:
        family = next((f" ({name})" for name, numbers in _FAMILIES.items() if kind in numbers), "")
        raise RefletError(
            f"{path} holds texels of VkFormat {kind}{family}; expected floats of 16 or 32 bits, RGB9E5, B10G11R11, "
            "BC1, BC2, BC3, BC6H, BC7, or 8 or 16 bits a channel: save it as one of these."
        )


def _doubts_of_colours(path: Path, form: TexelFormat, descriptor: bytes, pairs: Mapping[str, bytes]) -> Iterator[str]:
    """What a file says of its colours that is not honoured."""
    if len(descriptor) > 15:
        primaries, transfer = descriptor[13], descriptor[14]
        if primaries > 1:
            name = _PRIMARIES.get(primaries, f"number {primaries}")
            yield f"{path} says that its primaries are {name}; its colours are taken as Rec. 709."
        is_srgb = form.name.endswith("_srgb")
        if transfer not in (0, 2 if is_srgb else 1):
            yield (
                f"{path} says that its texels have transfer function {transfer}, but their format is "
                f"{'sRGB' if is_srgb else 'linear'}; they are taken as that."
            )
    swizzle = pairs.get("KTXswizzle", b"").decode("latin-1")
    if swizzle and swizzle[: form.channels] != "rgba"[: form.channels]:
        yield f"{path} wants its channels swizzled ({swizzle[:8]}); they are read as they are stored."


def read_texture(path: str | os.PathLike[str]) -> Texture:
    """Opens a 2D texture, an array of them or a cube, of any size and number of levels.

    A depth, a number of layers or of faces of 1 means as little as 0; of several cubes the first is taken. Plain levels
    are memory maps: nothing is read until asked. Others are unpacked, to the very size that the header and the
    texture's dimensions give. Raises RefletError as `read_header` does.
    """
    path = Path(path)
    header = read_header(path)
    pictures = header.pictures
    if not header.level_places:
        code = header.supercompression or ""
        return read_basis_texture(
            path, code, header.rows, header.columns, header.level_count, pictures, header.metadata
        )
    levels = []
    for offset, length, uncompressed in header.level_places:
        level = np.memmap(path, np.uint8, "r", offset, (length,)) if length else np.zeros(0, np.uint8)
        if header.supercompression is not None:
            unpack = _unpacked_zstd if header.supercompression == "zstd" else _unpacked_zlib
            level = unpack(path, level.tobytes(), uncompressed)
        levels.append(level.reshape(pictures.stored, -1)[: pictures.used])
    return Texture(
        header.texel_format,
        header.rows,
        header.columns,
        pictures.is_cube,
        tuple(levels),
        header.metadata,
        header.alpha_is_premultiplied,
        header.supercompression,
        header.doubts,
    )


def _unpacked_zstd(path: Path, packed: bytes, size: int) -> np.ndarray:
    try:
        # The frame's own idea of its size would be allocated unseen.
        if zstandard.frame_content_size(packed) not in (-1, size):
            raise RefletError(_truncated(path))
        data = zstandard.ZstdDecompressor().decompress(packed, max_output_size=size)
    except zstandard.ZstdError as error:
        raise RefletError(_truncated(path)) from error
    if len(data) != size:
        raise RefletError(_truncated(path))
    return np.frombuffer(data, np.uint8)


def _unpacked_zlib(path: Path, packed: bytes, size: int) -> np.ndarray:
    stream = zlib.decompressobj()
    try:
        data = stream.decompress(packed, size)
        if len(data) != size or stream.decompress(stream.unconsumed_tail, 1) or not stream.eof:
            raise RefletError(_truncated(path))
    except zlib.error as error:
        raise RefletError(_truncated(path)) from error
    return np.frombuffer(data, np.uint8)


def write_texture(path: str | os.PathLike[str], texture: Texture) -> None:
    """Writes a texture, atomically; equal textures give equal bytes.

    With ``supercompression`` "zstd" each level is one Zstandard frame. The data format descriptor says linear and Rec.
    709. Raises RefletError where the file cannot be written, ValueError for formats that are only read.
    """
    form = texture.texel_format
    descriptor = data_format_descriptor(form, premultiplied=texture.alpha_is_premultiplied)
    metadata = pack_metadata(texture.metadata)
    descriptor_at = _HEADER.size + _LEVEL.size * len(texture.levels)
    metadata_at = descriptor_at + len(descriptor)
    position = metadata_at + len(metadata)
    is_zstd = texture.supercompression == "zstd"
    # A level begins at a multiple of its texel's size and of 4; frames of Zstandard begin anywhere.
    alignment = 1 if is_zstd else int(np.lcm(form.block_bytes, 4))
    index: list[bytes] = []
    body: list[bytes | memoryview] = []
    for level in reversed(texture.levels):  # the format wants the coarsest level first
        data = np.ascontiguousarray(level).reshape(-1).data
        packed = zstandard.ZstdCompressor(_ZSTD_LEVEL).compress(data) if is_zstd else data
        padding = -position % alignment
        index.append(_LEVEL.pack(position + padding, len(packed), len(data)))
        body += [bytes(padding), packed]
        position += padding + len(packed)
    layers = 0 if texture.is_cube or texture.image_count == 1 else texture.image_count
    vk_format = next(number for number, name in VK_FORMATS.items() if name == form.name)
    header = _HEADER.pack(
        IDENTIFIER,
        *(vk_format, form.word_bytes, texture.columns, texture.rows, 0, layers, 6 if texture.is_cube else 1),
        *(len(texture.levels), _ZSTD if is_zstd else _NONE),
        *(descriptor_at, len(descriptor), metadata_at, len(metadata)),
        *(0, 0),
    )
    with atomic_path(path) as temporary, temporary.open("wb") as file:
        file.writelines([header, *reversed(index), descriptor, metadata, *body])


def _truncated(path: Path) -> str:
    return f"{path} is truncated or damaged; copy it again."
