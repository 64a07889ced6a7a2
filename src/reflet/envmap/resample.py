"""Env images from one parameterization and size to another."""

import numpy as np
from jaxtyping import Float

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterization import NONE, Parameterization


def resample(image: EnvImage, to: Parameterization, size: int) -> EnvImage:
    """The same radiance in the parameterization ``to``, with ``size`` rows a face."""
    direction, _ = to.texel_directions(size)
    return EnvImage(to, radiance_at(image, direction).astype(image.texels.dtype))


def radiance_at(
    image: EnvImage, direction: Float[np.ndarray, "*batch 3"], solid_angle: float | None = None
) -> Float[np.ndarray, "*batch channels"]:
    """Bilinearly filtered radiance in directions of any length but zero, seamless."""
    padded = padded_texels(image)
    face, uv = image.parameterization.uv_from_direction(direction)
    _, rows, columns = image.parameterization.shape(image.size)
    x, y = uv[..., 0] * columns - 0.5, uv[..., 1] * rows - 0.5
    # A direction exactly on an edge may round to one texel further than the padding holds.
    column = np.clip(np.floor(x).astype(np.int64), -1, columns - 1)
    row = np.clip(np.floor(y).astype(np.int64), -1, rows - 1)
    fx, fy = (x - column)[..., None], (y - row)[..., None]
    upper = (1.0 - fx) * padded[face, row + 1, column + 1] + fx * padded[face, row + 1, column + 2]
    lower = (1.0 - fx) * padded[face, row + 2, column + 1] + fx * padded[face, row + 2, column + 2]
    return np.asarray((1.0 - fy) * upper + fy * lower)


def padded_texels(image: EnvImage) -> Float[np.ndarray, "faces rows columns channels"]:
    """The texels with one texel of their neighbours around every face; beyond a cube's corner the mean of three."""
    faces, rows, columns = image.parameterization.shape(image.size)
    at = np.meshgrid(np.arange(faces), np.arange(-1, rows + 1), np.arange(-1, columns + 1), indexing="ij")
    face, row, column = image.parameterization.across_seams(*at, rows)
    padded = image.texels[face, row, column]
    for f, r, c in np.argwhere(face == NONE):
        inner_r, inner_c = (1 if r == 0 else r - 1), (1 if c == 0 else c - 1)
        padded[f, r, c] = (padded[f, inner_r, inner_c] + padded[f, r, inner_c] + padded[f, inner_r, c]) / 3.0
    return padded
