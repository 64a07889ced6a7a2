"""The one entrance to files of env images: which form a file has, and which parameterization its picture is."""

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterization import Parameterization
from reflet.envmap.parameterizations import PARAMETERIZATIONS
from reflet.errors import RefletError
from reflet.files.exr import read_exr, write_exr
from reflet.files.hdr import read_hdr


def read_env_image(path: str | os.PathLike[str], parameterization: Parameterization | None = None) -> EnvImage:
    """The finest level of `read_levels`."""
    return read_levels(path, parameterization)[0]


def read_levels(path: str | os.PathLike[str], parameterization: Parameterization | None = None) -> tuple[EnvImage, ...]:
    """All mip levels of a file, finest first; pictures have one."""
    image = read_hdr(path) if Path(path).suffix.lower() == ".hdr" else read_exr(path)
    height, width = image.shape[:2]
    if parameterization is None:
        if width != 2 * height:
            raise RefletError(f"{path} is {width}×{height} pixels, which may be several things; name its kind.")
        parameterization = PARAMETERIZATIONS["latlong"]
    faces, rows, columns = parameterization.shape(height // parameterization.face_count)
    return (EnvImage(parameterization, image.reshape(faces, rows, columns, -1)),)


def write_env_image(path: str | os.PathLike[str], levels: Sequence[EnvImage], layout: str | None = None) -> None:
    """Writes the finest of ``levels`` as a picture, the faces one below the other."""
    texels = levels[0].texels
    write_exr(path, np.ascontiguousarray(texels.reshape(-1, *texels.shape[2:]), np.float32))
