"""8-bit pictures: PNG for the eye, and whatever textures come as."""

import io
import os
from pathlib import Path

import numpy as np
from jaxtyping import UInt8
from PIL import Image

from reflet.errors import RefletError
from reflet.files.atomic import atomic_path


def write_png(path: str | os.PathLike[str], image_srgb: UInt8[np.ndarray, "height width channels"]) -> None:
    """Writes an sRGB-encoded picture of 3 (RGB) or 4 (RGBA) channels, atomically. Raises RefletError if it cannot."""
    with atomic_path(path) as temporary:
        Image.fromarray(np.ascontiguousarray(image_srgb)).save(temporary, format="PNG")


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
        raise RefletError(f"{name} is not a readable picture ({error}); export it again as PNG.") from error


def read_picture(path: str | os.PathLike[str]) -> UInt8[np.ndarray, "height width 4"]:
    """RGBA pixels of a PNG, JPEG or WebP file. Raises RefletError where it is missing or cannot be decoded."""
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise RefletError(f"{path} cannot be read ({error.strerror}); check the name.") from error
    return decode_picture(data, str(path))
