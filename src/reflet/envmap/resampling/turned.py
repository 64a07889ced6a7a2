"""Environments turned as a whole.

A rotation is given as ``source_from_result``: the result shows in direction d what the source shows in that matrix
times d.
"""

import numpy as np

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.resampling.padding import continued, outside_disc
from reflet.envmap.resampling.resample import resample
from reflet.envmap.rotations import UNTURNED, Rotation

_NEAR = 1e-3  # texels: what is no farther from a texel's centre is that texel


def turned(image: EnvImage, to: Parameterization, size: int, source_from_result: Rotation) -> EnvImage:
    """`resample`, but texel by texel, without any loss, where the rotation leads every texel onto another.

    So it is for lat-long maps turned about the vertical by whole texels and for cubes turned by right angles.
    """
    result = None
    if (to, size) == (image.parameterization, image.size) and not np.array_equal(source_from_result, UNTURNED):
        result = _texel_by_texel(image, source_from_result)
    return resample(image, to, size, source_from_result) if result is None else result


def _texel_by_texel(image: EnvImage, source_from_result: Rotation) -> EnvImage | None:
    """The result where all its valid texels are texels of the source, else None: mostly a few rows tell."""
    to, size = image.parameterization, image.size
    if not _source_texels(to, size, np.linspace(0, size - 1, min(size, 5)).astype(np.int64), source_from_result)[1]:
        return None
    texels = np.empty_like(image.texels)
    for row in range(size):
        (face, at, column), exact = _source_texels(to, size, np.array([row]), source_from_result)
        if not exact:
            return None
        texels[:, row] = image.texels[face[:, 0], at[:, 0], column[:, 0]]
    return EnvImage(to, continued(to, texels, outside_disc(to, size)))


def _source_texels(
    parameterization: Parameterization, size: int, rows: np.ndarray, source_from_result: Rotation
) -> tuple[tuple[np.ndarray, np.ndarray, np.ndarray], bool]:
    """Face, row and column of the source's texels that rows of the result show, and whether they show just these."""
    faces, _, columns = parameterization.shape(size)
    face, row, column = np.meshgrid(np.arange(faces), rows, np.arange(columns), indexing="ij")
    uv = np.stack([(column + 0.5) / columns, (row + 0.5) / size], -1)
    direction, valid = parameterization.direction_from_uv(face, uv)
    on, uv_on = parameterization.uv_from_direction(direction @ np.asarray(source_from_result).T)
    place = uv_on * [columns, size] - 0.5
    nearest = np.rint(place)
    exact = bool((np.abs(place - nearest)[valid] < _NEAR).all())
    nearest = np.clip(nearest.astype(np.int64), 0, [columns - 1, size - 1])
    return (on, nearest[..., 1], nearest[..., 0]), exact
