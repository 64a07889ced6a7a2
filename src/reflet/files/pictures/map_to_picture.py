"""Env images written as pictures: one file, six files, or OpenEXR's own layouts."""

from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.latlong import LatLong
from reflet.errors import RefletError
from reflet.files.atomic import atomic_path
from reflet.files.pictures.cube_layouts import as_seen_inside, picture_from_faces
from reflet.files.pictures.map_in_picture import NOTE
from reflet.files.pictures.openexr_layout import openexr_directions
from reflet.files.pictures.picture_file import write_picture_file
from reflet.files.pictures.six_files import PLACEHOLDER, named_files

_LATLONG = LatLong()


def as_stored(path: Path, level: EnvImage) -> EnvImage:
    """The level as files hold it, not copied where it is so already. Raises RefletError where it is no radiance."""
    texels = np.asarray(level.texels)
    if texels.dtype.kind != "f":
        raise RefletError(
            f"{path} cannot be written: a map's texels are linear radiance in floats, and {texels.dtype} came; decode "
            "sRGB pictures first, as read_env_image does, or divide what is linear by its largest number."
        )
    if texels.ndim != 4 or texels.shape[3] not in (3, 4):
        came = f"{texels.shape[3]} came" if texels.ndim == 4 else f"an array of shape {texels.shape} came"
        raise RefletError(f"{path} cannot be written: texels have 3 channels, or 4 with alpha, and {came}.")
    with np.errstate(over="ignore"):
        texels = texels.astype(np.float32, copy=False)
    if not np.isfinite(texels).all():
        raise RefletError(
            f"{path} cannot be written: the radiance is not finite everywhere as 32-bit floats; read it by "
            "read_env_image(..., repair=True), or mend it by reflet convert --repair."
        )
    return replace(level, texels=texels)


def write_map_picture(path: Path, image: EnvImage, layout: str | None, *, half: bool) -> None:
    """Writes a map (`as_stored`) as a picture; ``layout`` as in `write_env_image`, ``half`` for .exr.

    Raises RefletError where the format or the layout cannot hold it, and where a file cannot be written.
    """
    texels = image.texels
    notes = {NOTE: image.parameterization.name}
    if PLACEHOLDER in path.name:
        if image.parameterization != CUBE:
            raise RefletError(
                f"{path} names six files, which are a cube's, not a {image.parameterization} map's (--to cube)."
            )
        if layout is not None:
            raise RefletError(f"{path} names six files, which have no layout; leave {layout} out.")
        with ExitStack() as all_or_none:
            for final, face in zip(named_files(path), as_seen_inside(texels), strict=True):
                write_picture_file(all_or_none.enter_context(atomic_path(final)), face, {NOTE: "cube face"}, half=half)
    elif layout == "openexr":
        _write_openexr(path, image, half=half)
    else:
        write_picture_file(path, picture_from_faces(image, layout), notes, half=half)


def _write_openexr(path: Path, image: EnvImage, *, half: bool) -> None:
    if path.suffix.lower() != ".exr" or image.parameterization not in (CUBE, _LATLONG):
        raise RefletError(
            f"{path} cannot be laid out as OpenEXR does; that is for .exr files of lat-long maps and cubes."
        )
    from reflet.envmap.resampling.resample import radiance_at  # compiled, and needed by nothing else here

    layout: Literal["latlong", "cube"] = "cube" if image.parameterization == CUBE else "latlong"
    width, height = (image.size, 6 * image.size) if layout == "cube" else (2 * image.size, image.size)
    directions = openexr_directions(layout, width, height)
    write_picture_file(path, radiance_at(image, directions).astype(np.float32), {}, openexr_layout=layout, half=half)
