"""PNG pictures for the eye: 8 bits a channel, sRGB."""

import os

import numpy as np
from jaxtyping import UInt8
from PIL import Image

from reflet.errors import RefletError
from reflet.files.atomic import atomic_path


def write_png(path: str | os.PathLike[str], image_srgb: UInt8[np.ndarray, "height width channels"]) -> None:
    """Writes an sRGB-encoded picture of 3 (RGB) or 4 (RGBA) channels, atomically. Raises RefletError if it cannot."""
    with atomic_path(path) as temporary:
        Image.fromarray(np.ascontiguousarray(image_srgb)).save(temporary, format="PNG")


def read_png(path: str | os.PathLike[str]) -> UInt8[np.ndarray, "height width 4"]:
    """The 8-bit RGBA pixels of a PNG, JPEG or WebP file. Raises RefletError for anything else."""
    try:
        with Image.open(path) as image:
            return np.asarray(image.convert("RGBA"))
    except FileNotFoundError:
        raise RefletError(f"{path} does not exist; check the name.") from None
    except (OSError, SyntaxError, ValueError) as error:
        raise RefletError(f"{path} is not a readable picture ({error}); export it again as PNG.") from error
