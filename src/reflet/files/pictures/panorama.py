"""Panoramas that are not whole: where the picture lies in the lat-long map of all directions.

Programs that stitch say so in XMP, by Google's Photo Sphere names (GPano): the size of the whole panorama and the place
of the picture in it. What is not there is black. Sizes are in pixels of the original; the picture may have been scaled
since.
"""

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32

Pixels = Float32[np.ndarray, "height width channels"]

_PROPERTY = re.compile(r"[<\s](GPano:\w+)\s*(?:=\s*[\"']([^\"']*)[\"']|>([^<]*)<)")
_LEVEL_DEG = 0.5  # a camera tilted by less stood upright


def panorama_notes(xmp: str) -> dict[str, str]:
    """The GPano properties in a picture's XMP, as attributes or as elements."""
    return {name: (quoted or element).strip() for name, quoted, element in _PROPERTY.findall(xmp)}


@dataclass(frozen=True)
class Crop:
    """Where a picture lies in a whole of ``rows`` by twice as many columns, all in pixels of the picture."""

    rows: int
    top: int
    left: int


def crop_of(notes: Mapping[str, str], height: int, width: int) -> Crop | None:
    """What GPano says of a picture of this size; None where that is nothing, a whole panorama, or makes no sense."""
    names = ("FullPanoWidthPixels", "CroppedAreaImageWidthPixels", "CroppedAreaLeftPixels", "CroppedAreaTopPixels")
    try:
        full, cropped, left, top = (float(notes[f"GPano:{name}"]) for name in names)
    except (KeyError, ValueError):
        return None
    if not (0.0 < cropped <= full < 1e6 and 0.0 <= left < full and 0.0 <= top < full):
        return None
    scale = width / cropped
    rows = round(0.5 * full * scale)
    crop = Crop(rows, min(round(top * scale), rows - height), min(round(left * scale), 2 * rows - width))
    fits = crop.top >= 0 and crop.left >= 0 and (height, width) != (rows, 2 * rows)
    return crop if fits else None


def strip_of(height: int, width: int) -> Crop | None:
    """A picture of the whole way around whose top and bottom are missing in equal parts; None for those that are
    2:1 or higher."""
    rows = -(-width // 2)
    return Crop(rows, (rows - height) // 2, 0) if height < rows else None


def placed(
    path: str | os.PathLike[str], pixels: Pixels, crop: Crop
) -> tuple[Float32[np.ndarray, "rows columns channels"], str]:
    """The whole panorama, black where the picture is not, and a sentence about how much that is."""
    height, width, channels = pixels.shape
    whole = np.zeros((crop.rows, 2 * crop.rows, channels), np.float32)
    whole[crop.top : crop.top + height, crop.left : crop.left + width] = pixels
    if channels == 4:
        whole[..., 3] = 1.0  # black, not see-through: where the picture is not as where it is
        whole[crop.top : crop.top + height, crop.left : crop.left + width, 3] = pixels[..., 3]
    upper, lower = np.cos(np.pi * np.array([crop.top, crop.top + height]) / crop.rows)
    missing = 1.0 - 0.5 * (upper - lower) * width / (2 * crop.rows)
    return whole, (
        f"{path} shows a part of all directions, rows {crop.top} to {crop.top + height - 1} and columns {crop.left} to "
        f"{crop.left + width - 1} of {2 * crop.rows}×{crop.rows}; the rest, {100.0 * missing:.3g} %, is black."
    )


def doubts_of_pose(path: str | os.PathLike[str], notes: Mapping[str, str]) -> list[str]:
    """Sentences about what GPano says of the camera, which is not honoured."""
    doubts = []
    projection = notes.get("GPano:ProjectionType", "equirectangular")
    if projection.lower() not in ("equirectangular", ""):
        doubts.append(f"{path} says that its projection is {projection[:40]}; it is taken as lat-long.")
    heading, pitch, roll = (_degrees(notes, f"Pose{name}Degrees") for name in ("Heading", "Pitch", "Roll"))
    if max(abs(pitch), abs(roll)) > _LEVEL_DEG:
        doubts.append(f"{path} was taken by a camera pitched {pitch:g}° and rolled {roll:g}°; that is not undone.")
    if heading % 360.0 > 0.0:
        doubts.append(
            f"{path} looks {heading:g}° from north in its middle, which becomes +x all the same; "
            "reflet convert --turn turns it."
        )
    return doubts


def _degrees(notes: Mapping[str, str], name: str) -> float:
    try:
        number = float(notes.get(f"GPano:{name}", "0"))
    except ValueError:
        return 0.0
    return number if np.isfinite(number) else 0.0
