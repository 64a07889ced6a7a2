"""DDS: DirectDraw surfaces of 2D textures, arrays of them and cubes, with DirectX 10's header or the older codes."""

import os
import struct
from pathlib import Path

import numpy as np

from reflet.errors import RefletError
from reflet.files.atomic import atomic_path
from reflet.files.textures.texel_formats import TEXEL_FORMATS
from reflet.files.textures.texture import Texture, level_shape, most_levels

MAGIC = b"DDS "

DXGI_FORMATS = {
    2: "rgba32f",
    6: "rgb32f",
    10: "rgba16f",
    26: "r11g11b10f",
    28: "rgba8",
    29: "rgba8_srgb",
    41: "r32f",
    54: "r16f",
    61: "r8",
    67: "rgb9e5",
    71: "bc1",
    72: "bc1_srgb",
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

# The older header knows no sRGB: 8 bits are taken as pictures are, sRGB-encoded.
_FOUR_CODES = {
    111: "r16f",
    113: "rgba16f",
    114: "r32f",
    116: "rgba32f",
    int.from_bytes(b"DXT1", "little"): "bc1_srgb",
    int.from_bytes(b"DXT5", "little"): "bc3_srgb",
}
_DX10 = int.from_bytes(b"DX10", "little")
_MASKS = {  # bits a texel; masks of red, green, blue and alpha
    (32, 0xFF0000, 0xFF00, 0xFF, 0xFF000000): "bgra8_srgb",
    (32, 0xFF0000, 0xFF00, 0xFF, 0): "bgrx8_srgb",
    (32, 0xFF, 0xFF00, 0xFF0000, 0xFF000000): "rgba8_srgb",
    (24, 0xFF0000, 0xFF00, 0xFF, 0): "bgr8_srgb",
}

_HEADER = struct.Struct("<4s 7I 44x 8I 5I")
_DX10_HEADER = struct.Struct("<5I")
_CAPS, _HEIGHT, _WIDTH, _PITCH, _PIXEL_FORMAT, _MIP_COUNT = 0x1, 0x2, 0x4, 0x8, 0x1000, 0x20000
_FOURCC, _ALPHA_PIXELS = 0x4, 0x1
_COMPLEX, _TEXTURE, _MIPMAP = 0x8, 0x1000, 0x400000
_CUBE, _ALL_FACES, _VOLUME = 0x200, 0xFC00, 0x200000
_DX10_2D, _DX10_CUBE, _PREMULTIPLIED = 3, 0x4, 2


def read_dds_texture(path: str | os.PathLike[str]) -> Texture:
    """Opens a 2D texture, an array of them or a whole cube, of any size and number of levels.

    The older header's 8-bit and DXT forms are taken as sRGB. Raises RefletError for files that are missing, foreign,
    damaged, or hold what reflet does not read.
    """
    path = Path(path)
    try:
        data = np.memmap(path, np.uint8, "r") if path.stat().st_size else np.zeros(0, np.uint8)
    except OSError as error:
        raise RefletError(f"{path} cannot be read: {error.strerror}.") from error
    head = data[: _HEADER.size].tobytes()
    if not head.startswith(MAGIC):
        raise RefletError(f"{path} is not a DDS file; check what it is.")
    if len(head) < _HEADER.size:
        raise RefletError(_truncated(path))
    numbers = _HEADER.unpack(head)[1:]
    _, _, height, width, _, _, level_count = numbers[:7]
    _, kind_of_format, code, bits, *masks = numbers[7:15]
    cube_and_volume = numbers[16]
    at, layers, premultiplied = _HEADER.size, 1, False
    is_cube = bool(cube_and_volume & _CUBE)
    if kind_of_format & _FOURCC and code == _DX10:
        if len(data) < at + _DX10_HEADER.size:
            raise RefletError(_truncated(path))
        dxgi, dimension, flags, layers, alpha_mode = _DX10_HEADER.unpack_from(data[at:].data)
        at += _DX10_HEADER.size
        name, code_name = DXGI_FORMATS.get(dxgi), f"DXGI format {dxgi}"
        is_cube, premultiplied = bool(flags & _DX10_CUBE), alpha_mode & 7 == _PREMULTIPLIED
        is_flat = dimension == _DX10_2D and not (is_cube and layers != 1)
    else:
        if kind_of_format & _FOURCC:
            name, code_name = _FOUR_CODES.get(code), f"code {code} ({code.to_bytes(4, 'little')!r})"
        else:
            alpha = masks[3] if kind_of_format & _ALPHA_PIXELS else 0
            name, code_name = _MASKS.get((bits, *masks[:3], alpha)), f"{bits} bits in an unusual order"
        is_flat = not cube_and_volume & _VOLUME and (not is_cube or cube_and_volume & _ALL_FACES == _ALL_FACES)
    if name is None:
        raise RefletError(
            f"{path} holds texels of {code_name}; expected floats of 16 or 32 bits, RGB9E5, R11G11B10, BC1, BC3, BC6H, "
            "BC7 or 8 bits a channel."
        )
    if not is_flat or not width or not height or not layers or (is_cube and width != height):
        raise RefletError(f"{path} is neither a 2D texture, an array of them nor a whole cube.")
    level_count = max(level_count, 1)
    if level_count > most_levels(height, width):
        raise RefletError(f"{path} declares {level_count} mip levels of {width}×{height} texels; it is damaged.")
    form = TEXEL_FORMATS[name]
    images = 6 if is_cube else layers
    sizes = [form.image_bytes(*level_shape(height, width, k)) for k in range(level_count)]
    if at + images * sum(sizes) > len(data):
        raise RefletError(_truncated(path))
    # one picture after the other, each with all its levels
    pictures = data[at : at + images * sum(sizes)].reshape(images, -1)
    starts = np.cumsum([0, *sizes])
    levels = tuple(pictures[:, starts[k] : starts[k + 1]] for k in range(level_count))
    return Texture(form, height, width, is_cube, levels, {}, premultiplied)


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
