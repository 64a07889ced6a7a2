"""Grey pictures as AVIF files: AV1 without chroma, 8 bits, full range: every decoder gives the same integers."""

import io

import numpy as np
from jaxtyping import UInt8
from PIL import Image, features

from reflet.errors import RefletError
from reflet.pem.coding.boxes import announced_shapes

MOST_PIXELS = 2**28  # of AVIF libraries, as they come
MOST_ROWS = 2**15
_SPEED, _SPEED_OF_LARGE, _LARGE = 8, 10, 2**23
_ADVANCED = {"tune": "psnr"}  # these pictures are looked up, not looked at


def fits(rows: int, columns: int) -> bool:
    """Whether libraries take a picture of this size."""
    return rows * columns <= MOST_PIXELS and max(rows, columns) <= MOST_ROWS


def encode_grey(picture: UInt8[np.ndarray, "rows columns"], quality: int) -> bytes:
    """An AVIF file of ``quality`` 0 to 100, which loses nothing. Equal pictures give equal bytes.

    Raises RefletError where this Pillow cannot.
    """
    if not features.check("avif"):
        raise RefletError("This Pillow was built without AVIF; install one with it, or give --codec none.")
    file = io.BytesIO()
    Image.fromarray(picture).save(
        file,
        format="AVIF",
        codec="aom",
        quality=quality,
        subsampling="4:0:0",
        range="full",
        speed=_SPEED_OF_LARGE if picture.size > _LARGE else _SPEED,
        max_threads=1,
        advanced=_ADVANCED,
    )
    return file.getvalue()


def decode_grey(file: bytes, shape: tuple[int, int]) -> UInt8[np.ndarray, "rows columns"]:
    """The picture in a file, which must be of this shape: no more memory is taken. Raises ValueError otherwise."""
    from imagecodecs import avif_decode  # takes 0.4 s to import

    if announced_shapes(file) != {shape}:
        raise ValueError(f"not of {shape[1]}×{shape[0]} pixels")
    try:
        picture = avif_decode(file, numthreads=1)
    except RuntimeError as error:
        raise ValueError(str(error).partition("\n")[0]) from None
    if picture.shape != shape or picture.dtype != np.uint8:
        raise ValueError("not grey, of 8 bits")
    return picture
