"""Textures in Basis Universal code, by its own decoder: 8 bits a channel."""

import shlex
from pathlib import Path

import numpy as np

from reflet.errors import RefletError
from reflet.files.textures.picture_count import PictureCount
from reflet.files.textures.texel_formats import TEXEL_FORMATS
from reflet.files.textures.texture import Texture, level_shape

CODES = {163: "etc1s", 166: "uastc", 167: "uastc hdr"}
"""Basis Universal's codes by the colour model of a KTX 2.0 file's data format descriptor."""

_LARGEST = 2**27  # texels of all pictures, which take 4 bytes each


def read_basis_texture(
    path: Path, code: str, height: int, width: int, level_count: int, pictures: PictureCount, metadata: dict[str, bytes]
) -> Texture:
    """The KTX 2.0 file's pictures in RGBA of 8 bits, sRGB-encoded where its descriptor says so.

    Raises RefletError where this machine has no decoder, where it cannot decode the file, and for files of more than
    2²⁷ texels.
    """
    if pictures.used * height * width > _LARGEST:
        raise RefletError(f"{path} has {width}×{height} texels, more than can be decoded; scale it down.")
    try:
        import opengl_basisu  # is not made for every machine, and few maps need it

        texture = opengl_basisu.open(path.read_bytes())
        levels = []
        for mip_level in range(level_count):
            places = [divmod(number, 6) if pictures.is_cube else (number, 0) for number in range(pictures.used)]
            images = [texture.transcode("rgba8", mip_level, face, layer).data for layer, face in places]
            rows, columns = level_shape(height, width, mip_level)
            levels.append(np.stack([np.asarray(image, np.uint8).reshape(4 * rows * columns) for image in images]))
    except (ImportError, ValueError, IndexError, MemoryError) as error:
        reason = " ".join(str(error).split())[:200]
        raise RefletError(
            f"{path} is stored as {code} and cannot be decoded here ({reason}); Khronos' KTX tools may: "
            f"{shlex.join(['ktx', 'transcode', str(path), 'plain.ktx2'])}."
        ) from error
    form = TEXEL_FORMATS["rgba8_srgb" if texture.srgb else "rgba8"]
    return Texture(
        form, height, width, pictures.is_cube, tuple(levels), metadata, supercompression=code, doubts=pictures.doubts
    )
