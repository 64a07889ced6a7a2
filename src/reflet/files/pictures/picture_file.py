"""Pictures of any format, with what they say of themselves."""

import math
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from jaxtyping import Float32, UInt8

from reflet.errors import RefletError
from reflet.files.pictures.exr import read_exr_picture, write_exr
from reflet.files.pictures.hdr import hdr_size, read_hdr_with_doubts, write_hdr
from reflet.files.pictures.notes import read_notes
from reflet.files.pictures.png import read_linear_picture_with_doubts, write_png
from reflet.files.srgb import srgb_from_linear

READ = {".hdr": "Radiance", ".exr": "OpenEXR", ".png": "PNG", ".jpg": "JPEG", ".jpeg": "JPEG", ".webp": "WebP"}
"""Formats by suffix."""

WRITTEN = (".hdr", ".exr", ".png")

_UNREAD = {".tif": "TIFF", ".tiff": "TIFF", ".heic": "HEIC", ".heif": "HEIC", ".avif": "AVIF", ".jxl": "JPEG XL"}
_UNREAD |= {".pfm": "PFM", ".psd": "Photoshop's", ".bmp": "BMP", ".gif": "GIF", ".tga": "Targa", ".jxr": "JPEG XR"}
_UNREAD |= dict.fromkeys((".dng", ".cr2", ".cr3", ".nef", ".arw", ".raw"), "a raw photograph")
_UNREAD |= {".pvr": "PVR", ".basis": "Basis Universal without KTX"}


@dataclass(frozen=True)
class PictureFile:
    """A decoded picture, what it says of itself, and OpenEXR's own layout where it has that.

    ``doubts`` are sentences about what cannot be meant as it stands in the file, and what was done instead.
    """

    pixels: Float32[np.ndarray, "height width channels"]
    notes: dict[str, str]
    openexr_layout: Literal["latlong", "cube"] | None = None
    doubts: tuple[str, ...] = ()
    most: float = math.inf  # the greatest radiance that the format has


def read_picture_file(path: str | os.PathLike[str], layer: str | None = None) -> PictureFile:
    """Linear radiance of a file of one of the formats in `READ`; of .exr the ``layer`` of that name.

    Raises RefletError where it cannot be read.
    """
    suffix = Path(path).suffix.lower()
    if suffix == ".exr":
        exr = read_exr_picture(path, layer)
        return PictureFile(exr.pixels, read_notes(path), exr.layout, exr.doubts)
    if layer is not None:
        raise RefletError(f"{path} has no layers, for only .exr files have; leave {layer} out.")
    if suffix == ".hdr":
        pixels, doubts = read_hdr_with_doubts(path)
        return PictureFile(pixels, read_notes(path), doubts=doubts)
    pixels, doubts = read_linear_picture_with_doubts(path)
    if pixels.shape[2] == 4 and pixels[..., 3].any():  # alpha is kept premultiplied; 0 everywhere it hides nothing
        pixels[..., :3] *= pixels[..., 3:]
    return PictureFile(pixels, read_notes(path), doubts=doubts, most=1.0)


def picture_outline(path: str | os.PathLike[str], layer: str | None = None) -> PictureFile:
    """The same with pixels that are all 0 and take no memory, where size and notes can be read without the others.

    Raises RefletError where it cannot be read.
    """
    if layer is not None or Path(path).suffix.lower() != ".hdr":
        return read_picture_file(path, layer)
    height, width = hdr_size(path)
    return PictureFile(np.broadcast_to(np.float32(0.0), (height, width, 3)), read_notes(path))


def unread_sentence(path: str | os.PathLike[str], what: str, suffixes: Iterable[str]) -> str:
    """What is said of a file whose suffix is none of those read; ``what`` it should be."""
    suffix = Path(path).suffix.lower()
    name = _UNREAD.get(suffix)
    if name is not None:
        return f"{path} is {name}, which is not read; save it as .exr, or as .png where it has but 8 bits."
    return f"{path} is no {what} that can be read; give a file that ends in {' '.join(suffixes)}."


def clipped_sentence(path: str | os.PathLike[str], most: float, share: float) -> str:
    """What is said of a file of a format that ends at the radiance ``most``, where ``share`` of its light is."""
    return (
        f"{path} holds no radiance above {most:g}: {100.0 * share:.3g} % of its light is there and may have been "
        "brighter; lamps and the sun are cut."
    )


def write_picture_file(
    path: Path,
    pixels: Float32[np.ndarray, "height width channels"],
    notes: Mapping[str, str],
    *,
    openexr_layout: Literal["latlong", "cube"] | None = None,
    half: bool = False,
) -> None:
    """Writes a picture as its suffix says; PNG clips radiance to [0, 1] and encodes it as sRGB.

    Raises RefletError where the format cannot hold it or the file cannot be written.
    """
    suffix = path.suffix.lower()
    if suffix == ".exr":
        write_exr(path, pixels, openexr_layout, half, notes)
    elif suffix == ".hdr":
        if pixels.shape[2] != 3:
            raise RefletError(f"{path} cannot be written: .hdr holds no alpha; write .exr instead.")
        write_hdr(path, pixels, notes)
    else:
        write_png(path, as_srgb(pixels), notes)


def as_srgb(pixels: Float32[np.ndarray, "height width channels"]) -> UInt8[np.ndarray, "height width channels"]:
    """Linear colours, premultiplied where there is alpha, clipped to [0, 1] and encoded as PNG files have them."""
    color, alpha = pixels[..., :3], pixels[..., 3:]
    if alpha.shape[-1]:
        color = color / np.where(alpha > 0.0, alpha, 1.0)
    color = np.clip(color, 0.0, 1.0)
    encoded = srgb_from_linear(color)
    return np.rint(255.0 * np.concatenate([encoded, np.clip(alpha, 0.0, 1.0)], -1)).astype(np.uint8)
