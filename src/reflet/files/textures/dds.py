"""DDS: DirectDraw surfaces of 2D textures, arrays of them and cubes, with DirectX 10's header or the older codes."""

import os
import struct
from dataclasses import dataclass
from itertools import accumulate
from pathlib import Path

import numpy as np

from reflet.errors import RefletError
from reflet.files.atomic import atomic_path
from reflet.files.textures.texel_formats import TEXEL_FORMATS, TexelFormat
from reflet.files.textures.texture import Texture, level_shape, most_levels
from reflet.files.unreadable import unreadable

MAGIC = b"DDS "

DXGI_FORMATS = {
    2: "rgba32f",
    6: "rgb32f",
    10: "rgba16f",
    11: "rgba16",
    26: "r11g11b10f",
    28: "rgba8",
    29: "rgba8_srgb",
    41: "r32f",
    54: "r16f",
    56: "r16",
    61: "r8",
    67: "rgb9e5",
    71: "bc1",
    72: "bc1_srgb",
    74: "bc2",
    75: "bc2_srgb",
    77: "bc3",
    78: "bc3_srgb",
    87: "bgra8",
    88: "bgrx8",
    91: "bgra8_srgb",
    93: "bgrx8_srgb",
    95: "bc6h",
    96: "bc6h_signed",
    98: "bc7",
    99: "bc7_srgb",
}
"""Names in `TEXEL_FORMATS` by DXGI_FORMAT."""

# Formats without a type, as some writers have them, are taken for the plain ones of their kind.
_TYPELESS = {1: 2, 5: 6, 9: 10, 27: 28, 39: 41, 53: 54, 60: 61, 70: 71, 73: 74, 76: 77, 90: 87, 92: 88, 94: 95, 97: 98}

# The older header knows no sRGB: 8 bits are taken as pictures are, sRGB-encoded.
_FOUR_CODES = {
    36: "rgba16",
    111: "r16f",
    113: "rgba16f",
    114: "r32f",
    116: "rgba32f",
    int.from_bytes(b"DXT1", "little"): "bc1_srgb",
    int.from_bytes(b"DXT2", "little"): "bc2_srgb",
    int.from_bytes(b"DXT3", "little"): "bc2_srgb",
    int.from_bytes(b"DXT4", "little"): "bc3_srgb",
    int.from_bytes(b"DXT5", "little"): "bc3_srgb",
}
_PREMULTIPLIED_CODES = {int.from_bytes(code, "little") for code in (b"DXT2", b"DXT4")}
_DX10 = int.from_bytes(b"DX10", "little")
_MASKS = {  # bits a texel; masks of red, green, blue and alpha
    (32, 0xFF0000, 0xFF00, 0xFF, 0xFF000000): "bgra8_srgb",
    (32, 0xFF0000, 0xFF00, 0xFF, 0): "bgrx8_srgb",
    (32, 0xFF, 0xFF00, 0xFF0000, 0xFF000000): "rgba8_srgb",
    (32, 0xFF, 0xFF00, 0xFF0000, 0): "rgbx8_srgb",
    (24, 0xFF0000, 0xFF00, 0xFF, 0): "bgr8_srgb",
    (24, 0xFF, 0xFF00, 0xFF0000, 0): "rgb8_srgb",
    (8, 0xFF, 0, 0, 0): "r8_srgb",
}

_HEADER = struct.Struct("<4s 7I 44x 8I 5I")
_DX10_HEADER = struct.Struct("<5I")
_CAPS, _HEIGHT, _WIDTH, _PITCH, _PIXEL_FORMAT, _MIP_COUNT = 0x1, 0x2, 0x4, 0x8, 0x1000, 0x20000
_FOURCC, _ALPHA_PIXELS = 0x4, 0x1
_COMPLEX, _TEXTURE, _MIPMAP = 0x8, 0x1000, 0x400000
_CUBE, _ALL_FACES, _VOLUME = 0x200, 0xFC00, 0x200000
_DX10_2D, _DX10_3D, _DX10_CUBE, _PREMULTIPLIED = 3, 4, 0x4, 2


@dataclass(frozen=True)
class _Header:
    """What a file says of itself; its pictures begin at byte ``end``."""

    end: int
    form: TexelFormat
    height: int
    width: int
    level_count: int
    layers: int  # cubes where it is one
    is_cube: bool  # by either header
    is_volume: bool
    face_count: int  # of a cube by the older header; 0 where that says nothing
    alpha_is_premultiplied: bool


def read_dds_texture(path: str | os.PathLike[str]) -> Texture:
    """Opens a 2D texture, an array of them or a whole cube, of any size and number of levels.

    A cube may be marked in either header. Where the numbers of pictures and levels do not account for the file's size,
    but those of one cube, one picture, one level or all levels do, these are read (and doubted). The older header's
    8-bit and DXT forms are taken as sRGB. Raises RefletError for files that are missing, foreign, damaged, or hold what
    reflet does not read.
    """
    path = Path(path)
    try:
        data = np.memmap(path, np.uint8, "r") if path.stat().st_size else np.zeros(0, np.uint8)
    except OSError as error:
        raise unreadable(path, error) from error
    header = _read_header(path, data)
    form, height, width = header.form, header.height, header.width
    if header.is_volume or not width or not height or (header.is_cube and width != height):
        raise RefletError(f"{path} is neither a 2D texture, an array of them nor a whole cube; save it as one.")
    images, level_count, doubts = _contents(path, header, len(data) - header.end)
    is_cube = images % 6 == 0 and (header.is_cube or (images == 6 and header.layers == 1))
    sizes = [form.image_bytes(*level_shape(height, width, k)) for k in range(level_count)]
    # one picture after the other, each with all its levels
    pictures = data[header.end : header.end + images * sum(sizes)].reshape(images, -1)
    if is_cube and images > 6:
        doubts += (f"{path} holds {images // 6} cubes; the first is read.",)
        pictures = pictures[:6]
    starts = np.cumsum([0, *sizes])
    levels = tuple(pictures[:, starts[k] : starts[k + 1]] for k in range(level_count))
    return Texture(form, height, width, is_cube, levels, {}, header.alpha_is_premultiplied, doubts=doubts)


def _read_header(path: Path, data: np.ndarray) -> _Header:
    """Raises RefletError for files that are foreign, truncated, or hold texels that reflet does not read."""
    head = data[: _HEADER.size].tobytes()
    if not head.startswith(MAGIC):
        raise RefletError(f"{path} is not a DDS file; check what it is.")
    if len(head) < _HEADER.size:
        raise RefletError(_truncated(path))
    numbers = _HEADER.unpack(head)[1:]
    _, _, height, width, _, depth, level_count = numbers[:7]
    _, kind_of_format, code, bits, *masks = numbers[7:15]
    cube_and_volume = numbers[16]
    at, layers = _HEADER.size, 1
    is_cube, is_volume = bool(cube_and_volume & _CUBE), bool(cube_and_volume & _VOLUME) and depth > 1
    premultiplied = bool(kind_of_format & _FOURCC) and code in _PREMULTIPLIED_CODES
    if kind_of_format & _FOURCC and code == _DX10:
        if len(data) < at + _DX10_HEADER.size:
            raise RefletError(_truncated(path))
        dxgi, dimension, flags, layers, alpha_mode = _DX10_HEADER.unpack_from(data[at:].data)
        at += _DX10_HEADER.size
        name, code_name = DXGI_FORMATS.get(_TYPELESS.get(dxgi, dxgi)), f"DXGI format {dxgi}"
        is_cube |= bool(flags & _DX10_CUBE)
        is_volume |= dimension == _DX10_3D and depth > 1
        premultiplied = alpha_mode & 7 == _PREMULTIPLIED
    elif kind_of_format & _FOURCC:
        name, code_name = _FOUR_CODES.get(code), f"code {code} ({code.to_bytes(4, 'little')!r})"
    else:
        alpha = masks[3] if kind_of_format & _ALPHA_PIXELS else 0
        name, code_name = _MASKS.get((bits, *masks[:3], alpha)), f"{bits} bits in an unusual order"
    if name is None:
        raise RefletError(
            f"{path} holds texels of {code_name}; expected floats of 16 or 32 bits, RGB9E5, R11G11B10, BC1, BC2, BC3, "
            "BC6H, BC7, or 8 or 16 bits a channel: save it as one of these."
        )
    return _Header(
        at, TEXEL_FORMATS[name], height, width, max(level_count, 1), max(layers, 1), is_cube, is_volume,
        (cube_and_volume & _ALL_FACES).bit_count() if cube_and_volume & _CUBE else 0, premultiplied,
    )  # fmt: skip


def _contents(path: Path, header: _Header, size: int) -> tuple[int, int, tuple[str, ...]]:
    """How many pictures of how many levels lie in ``size`` bytes, and what is doubtful about that.

    Headers are often wrong in these numbers, so what accounts for the very size comes first, then what the header says.
    Raises RefletError where the file is shorter than that.
    """
    form, height, width = header.form, header.height, header.width
    most = most_levels(height, width)
    told = 6 * header.layers if header.is_cube else header.layers
    # Six layers may be a cube's faces, counted; a cube that no header marks is six pictures all the same.
    images = [told, *([6] if header.is_cube and header.layers == 6 else [])]
    if header.layers == 1 and width == height:
        images += [6, 1]
    level_counts = [header.level_count, 1, most] if header.level_count <= most else [1, most]
    sizes = list(accumulate(form.image_bytes(*level_shape(height, width, k)) for k in range(most)))
    exact = next(((i, n) for n in level_counts for i in images if i * sizes[n - 1] == size), None)
    if exact is None and header.level_count > most:
        raise RefletError(f"{path} declares {header.level_count} mip levels of {width}×{height} texels; it is damaged.")
    count, level_count = exact or (told, header.level_count)
    if 0 < header.face_count < 6 and (exact is None or count % 6):
        raise RefletError(f"{path} is a cube with only {header.face_count} of its six faces; save them all.")
    if count * sizes[level_count - 1] > size:
        raise RefletError(_truncated(path))
    if (count, level_count) == (told, header.level_count):
        return count, level_count, ()
    declared = _counted(header.level_count, "mip level")
    if count != told:
        declared = f"{_counted(told, 'picture')} of {declared}"
    found = f"{'a cube' if count == 6 else _counted(count, 'picture')} of {_counted(level_count, 'mip level')}"
    doubt = f"{path} declares {declared}, but by its size it is {found}, and read so."
    return count, level_count, (doubt,)


def _counted(number: int, word: str) -> str:
    return f"{number} {word}{'' if number == 1 else 's'}"


def write_dds_texture(path: str | os.PathLike[str], texture: Texture) -> None:
    """Writes a texture with DirectX 10's header, atomically; equal textures give equal bytes.

    Raises RefletError where the file cannot be written or DDS knows no such format.
    """
    form = texture.texel_format
    dxgi = next((number for number, name in DXGI_FORMATS.items() if name == form.name), None)
    if dxgi is None:
        raise RefletError(f"{path} cannot hold texels stored as {form.name}; choose another texel format.")
    flags = _CAPS | _HEIGHT | _WIDTH | _PITCH | _PIXEL_FORMAT | _MIP_COUNT
    caps = _TEXTURE | (_MIPMAP if len(texture.levels) > 1 else 0)
    caps |= _COMPLEX if texture.is_cube or len(texture.levels) > 1 else 0
    header = _HEADER.pack(
        MAGIC,
        *(124, flags, texture.rows, texture.columns, form.row_bytes(texture.columns), 0, len(texture.levels)),
        *(32, _FOURCC, _DX10, 0, 0, 0, 0, 0),
        *(caps, _CUBE | _ALL_FACES if texture.is_cube else 0, 0, 0, 0),
    )
    layers = 1 if texture.is_cube else texture.image_count
    alpha_mode = _PREMULTIPLIED if texture.alpha_is_premultiplied else 0
    header += _DX10_HEADER.pack(dxgi, _DX10_2D, _DX10_CUBE if texture.is_cube else 0, layers, alpha_mode)
    with atomic_path(path) as temporary, temporary.open("wb") as file:
        file.write(header)
        for image in range(texture.image_count):
            file.writelines(np.ascontiguousarray(level[image]).data for level in texture.levels)


def _truncated(path: Path) -> str:
    return f"{path} is truncated or damaged; copy it again."
