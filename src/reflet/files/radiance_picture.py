"""Any picture file as linear radiance."""

import os
from pathlib import Path

import numpy as np
from jaxtyping import Float32

from reflet.errors import RefletError
from reflet.files.exr import read_exr
from reflet.files.hdr import read_hdr
from reflet.files.png import read_picture

EIGHT_BIT = (".png", ".jpg", ".jpeg", ".webp")


def read_radiance_picture(path: str | os.PathLike[str]) -> Float32[np.ndarray, "height width channels"]:
    """Linear radiance of a .hdr or .exr file, or of a .png, .jpg or .webp one, whose sRGB white becomes radiance 1.

    Raises RefletError where the file is missing, damaged, or holds radiance that is negative or not finite.
    """
    suffix = Path(path).suffix.lower()
    if suffix in EIGHT_BIT:
        encoded = np.arange(256) / 255.0
        linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
        return linear.astype(np.float32)[read_picture(path)[..., :3]]
    if suffix not in (".hdr", ".exr"):
        raise RefletError(f"{path} is no picture that can be read; give a .hdr, .exr, .png, .jpg or .webp file.")
    image = read_hdr(path) if suffix == ".hdr" else read_exr(path)
    if not np.isfinite(image).all():
        raise RefletError(f"{path} holds radiance that is not finite (NaN or infinite); repair these pixels.")
    if image.min() < 0.0:
        raise RefletError(f"{path} holds negative radiance ({image.min():g}); clip it to zero.")
    return image
