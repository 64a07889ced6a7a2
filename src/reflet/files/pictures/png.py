"""sRGB pictures: PNG for the eye, whatever textures come as, and environments that were photographed once."""

import io
import os
from collections.abc import Mapping
from functools import cache
from pathlib import Path

import numpy as np
from jaxtyping import Float32, UInt8, UInt16
from PIL import Image, ImageOps, UnidentifiedImageError
from PIL.ExifTags import Base
from PIL.PngImagePlugin import PngInfo

from reflet.errors import RefletError
from reflet.files.atomic import atomic_path
from reflet.files.pictures.color_profile import doubts_of_encoding, in_srgb
from reflet.files.srgb import linear_from_srgb
from reflet.files.unreadable import unreadable

LARGEST_PICTURE = 2**28  # pixels of 16-bit pictures; of others it is Pillow's to say

_PNG = b"\x89PNG\r\n\x1a\n"
_DEFLATE_LIMIT = 1032  # no byte of a PNG file can stand for more than this many


def write_png(
    path: str | os.PathLike[str],
    image_srgb: UInt8[np.ndarray, "height width channels"],
    notes: Mapping[str, str] | None = None,
) -> None:
    """Writes an sRGB-encoded picture of 3 (RGB) or 4 (RGBA) channels, atomically; ``notes`` become its text.

    Raises RefletError if it cannot.
    """
    info = PngInfo()
    for key, value in (notes or {}).items():
        info.add_text(key, value)
    with atomic_path(path) as temporary:
        Image.fromarray(np.ascontiguousarray(image_srgb)).save(temporary, format="PNG", pnginfo=info)


def decode_picture(data: bytes, name: str) -> UInt8[np.ndarray, "height width 4"]:
    """RGBA pixels of an encoded PNG, JPEG or WebP picture; 16-bit ones are rounded to 8.

    Raises RefletError, calling the picture ``name``, where it cannot be decoded.
    """
    try:
        with Image.open(io.BytesIO(data)) as image:
            if image.mode.startswith("I"):  # 16-bit grey: Pillow's own conversion would clip, not scale
                grey = np.rint(np.asarray(image, dtype=np.float64) / 257.0).astype(np.uint8)
                return np.dstack([grey, grey, grey, np.full_like(grey, 255)])
            return np.asarray(image.convert("RGBA"))
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
        raise RefletError(f"{name} is not a readable picture ({_reason(error)}); export it again as PNG.") from error


def shown_alike(data: bytes) -> bool:
    """Whether a picture that `decode_picture` reads is one that browsers and glTF viewers show the same pixels of: PNG,
    JPEG or WebP of 8 bits, in RGB or grey, of one frame, not turned by its Exif data."""
    if data.startswith(_PNG) and data[24:25] > b"\x08":
        return False
    with Image.open(io.BytesIO(data)) as image:
        plain = image.format in ("PNG", "JPEG", "WEBP") and image.mode in ("RGB", "RGBA", "L", "LA", "P", "1")
        return plain and getattr(image, "n_frames", 1) == 1 and image.getexif().get(Base.Orientation, 1) == 1


def _reason(error: Exception) -> str:
    """Why a picture cannot be decoded. Where Pillow knows no format for it, its words are about an object in memory."""
    return "of no known format" if isinstance(error, UnidentifiedImageError) else str(error)


def read_picture(path: str | os.PathLike[str]) -> UInt8[np.ndarray, "height width 4"]:
    """RGBA pixels of a PNG, JPEG or WebP file. Raises RefletError where it is missing or cannot be decoded."""
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise unreadable(path, error) from error
    return decode_picture(data, str(path))


def read_linear_picture(path: str | os.PathLike[str]) -> Float32[np.ndarray, "height width channels"]:
    """The pixels of `read_linear_picture_with_doubts`."""
    return read_linear_picture_with_doubts(path)[0]


def read_linear_picture_with_doubts(
    path: str | os.PathLike[str],
) -> tuple[Float32[np.ndarray, "height width channels"], tuple[str, ...]]:
    """Linear radiance of a PNG, JPEG or WebP file: 3 channels, or 4 where it has alpha; sRGB white is radiance 1.

    All of the 16 bits of such PNG files count. A photograph is turned as its Exif orientation says; a colour profile is
    applied to pictures of 8 bits. The sentences tell of what in its coding is not honoured. Raises RefletError where
    the file is missing or cannot be decoded.
    """
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise unreadable(path, error) from error
    bits = 8
    if data.startswith(_PNG):
        # signature, length and name of the first chunk, then width, height and bits a channel
        width, height, bits = (int.from_bytes(data[at:end], "big") for at, end in ((16, 20), (20, 24), (24, 25)))
        if width * height > len(data) * _DEFLATE_LIMIT * 8 // max(bits, 1):
            raise RefletError(f"{path} is truncated or damaged: {len(data)} bytes hold no {width}×{height} pixels.")
    try:
        with Image.open(io.BytesIO(data)) as image:
            doubts = doubts_of_encoding(path, data, image.info)
            if bits == 16:
                profile = image.info.get("icc_profile", b"")
                if profile and b"sRGB" not in profile:
                    doubts.append(f"{path} has a colour profile, which is not applied to 16 bits; save it as .exr.")
                return _linear(_sixteen_bits(path, data, width * height)), tuple(doubts)
            upright, problem = in_srgb(ImageOps.exif_transpose(image))
            if problem is not None:
                doubts.append(f"{path} {problem}.")
            return _linear(np.asarray(upright)), tuple(doubts)
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
        raise RefletError(f"{path} is not a readable picture ({_reason(error)}); export it again as PNG.") from error


def _sixteen_bits(
    path: str | os.PathLike[str], data: bytes, pixel_count: int
) -> UInt16[np.ndarray, "height width channels"]:
    """RGB or RGBA of a 16-bit PNG file, of which Pillow would give the upper 8 bits."""
    if pixel_count > LARGEST_PICTURE:
        raise RefletError(f"{path} is {pixel_count} pixels, more than can be read; scale it down.")
    import imagecodecs  # takes 0.4 s to import, and few pictures need it

    try:
        pixels = imagecodecs.png_decode(data)
    except (RuntimeError, ValueError, MemoryError) as error:
        raise RefletError(f"{path} is not a readable picture ({_reason(error)}); export it again as PNG.") from error
    pixels = pixels if pixels.ndim == 3 else pixels[..., None]
    return pixels if pixels.shape[2] >= 3 else np.concatenate([pixels[..., :1]] * 3 + [pixels[..., 1:]], -1)


def _linear(encoded: UInt8[np.ndarray, "h w c"] | UInt16[np.ndarray, "h w c"]) -> Float32[np.ndarray, "h w c"]:
    """Colours decoded from sRGB, alpha as it is."""
    linear = _linear_from_srgb(np.iinfo(encoded.dtype).max)[encoded]
    linear[..., 3:] = encoded[..., 3:] / np.float32(np.iinfo(encoded.dtype).max)
    return linear


@cache
def _linear_from_srgb(highest: int) -> Float32[np.ndarray, "codes"]:
    """What each code from 0 to ``highest`` stands for [IEC 61966-2-1]."""
    linear = linear_from_srgb(np.arange(highest + 1) / highest).astype(np.float32)
    linear.setflags(write=False)
    return linear
