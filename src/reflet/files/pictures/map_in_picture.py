"""The env image in a picture: which kind of map it is, and where its faces lie."""

from pathlib import Path

import numpy as np

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.latlong import LatLong
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.errors import RefletError
from reflet.files.map_kinds import expected_shape, unknown_kind
from reflet.files.pictures.cube_layouts import faces_from_picture, layout_of
from reflet.files.pictures.openexr_layout import cube_from_openexr, latlong_from_openexr
from reflet.files.pictures.panorama import crop_of, doubts_of_pose, placed, strip_of
from reflet.files.pictures.picture_file import PictureFile

NOTE = "parameterization"
"""The name under which pictures tell theirs."""

_LATLONG = LatLong()


def kind_of_picture(picture: PictureFile) -> Parameterization | None:
    """What the file says that it holds, else what its shape tells; None where neither does."""
    if picture.openexr_layout:
        return CUBE if picture.openexr_layout == "cube" else _LATLONG
    height, width, _ = picture.pixels.shape
    if crop_of(picture.notes, height, width) is not None:
        return _LATLONG
    named = PARAMETERIZATIONS.get(picture.notes.get(NOTE, ""))
    if named is not None and layout_of(named, height, width):
        return named
    return next((guess for guess in (_LATLONG, CUBE) if layout_of(guess, height, width)), None)


def image_in_picture(
    path: Path, picture: PictureFile, parameterization: Parameterization | None
) -> tuple[EnvImage, list[str]]:
    """The map that a picture of 3 or 4 channels holds, and what is in doubt about it.

    ``parameterization`` outweighs what the file says. Lat-long pictures that are not whole are put in their place
    (`panorama`): by what the file says of that, and in the middle where they are called lat-long and wider than 2:1.
    Raises RefletError where the kind is not known, or the picture's shape does not suit it.
    """
    pixels = picture.pixels
    height, width, _ = pixels.shape
    if picture.openexr_layout is not None:
        openexr = CUBE if picture.openexr_layout == "cube" else _LATLONG
        if parameterization not in (None, openexr):
            raise RefletError(f"{path} says that it is OpenEXR's {openexr} map, not {parameterization}.")
        return cube_from_openexr(pixels) if openexr == CUBE else latlong_from_openexr(pixels), []
    laid_out = parameterization or kind_of_picture(picture)
    doubts = doubts_of_pose(path, picture.notes) if laid_out == _LATLONG else []
    if laid_out == _LATLONG and (crop := crop_of(picture.notes, height, width) or strip_of(height, width)):
        pixels, doubt = placed(path, pixels, crop)
        height, width, _ = pixels.shape
        doubts.append(doubt)
    if laid_out is None:
        fitting = [name for name, each in PARAMETERIZATIONS.items() if layout_of(each, height, width)]
        raise RefletError(unknown_kind(path, f"{width}×{height} pixels", fitting, strip_of(height, width) is not None))
    layout = layout_of(laid_out, height, width)
    if layout is None:
        raise RefletError(f"{path} is {width}×{height} pixels, which is no {laid_out} map; {expected_shape(laid_out)}.")
    return faces_from_picture(np.ascontiguousarray(pixels), laid_out, layout), doubts
