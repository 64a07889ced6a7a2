"""From fine mip levels to coarse ones and back."""

import numpy as np
from jaxtyping import Float, Shaped

from reflet.envmap.env_image import EnvImage
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.padding import continued, padded
from reflet.envmap.parameterization import Parameterization


def mip_levels_from_finest(
    chain: MipChain, finest: Float[np.ndarray, "faces rows columns *channels"]
) -> Float[np.ndarray, "texels *channels"]:
    """A whole mip chain whose coarser texels are the solid-angle weighted means of the finest ones they cover.

    The mean over all directions is thus the same on every level.
    """
    texels = np.empty((chain.texel_count, *finest.shape[3:]), finest.dtype)
    solid_angle = chain.parameterization.texel_solid_angle(chain.size)
    weight = solid_angle.reshape(*solid_angle.shape, *[1] * (finest.ndim - 3))
    chain.level(texels, 0)[...] = finest
    flux = finest * weight
    for level in range(1, chain.level_count):
        flux, weight = _sum_of_four(flux), _sum_of_four(weight)
        chain.level(texels, level)[...] = flux / np.maximum(weight, 1e-30)
    return texels


def halved(
    parameterization: Parameterization, texels: Float[np.ndarray, "faces rows columns channels"]
) -> Float[np.ndarray, "faces half_rows half_columns channels"]:
    """The next coarser level of a map of an even number of rows: solid-angle weighted means of two by two texels."""
    solid_angle = parameterization.texel_solid_angle(texels.shape[1])[..., None]
    weight = _sum_of_four(solid_angle)
    coarse = (_sum_of_four(texels * solid_angle) / np.where(weight > 0.0, weight, 1.0)).astype(texels.dtype)
    return continued(parameterization, coarse, weight[0, ..., 0] == 0.0)


def mip_images(image: EnvImage) -> tuple[EnvImage, ...]:
    """The image and all its coarser mip levels, finest first. Raises RefletError if its size is no power of two."""
    chain = MipChain(image.size, image.parameterization)
    texels = mip_levels_from_finest(chain, image.texels)
    return tuple(EnvImage(image.parameterization, chain.level(texels, level)) for level in range(chain.level_count))


def _sum_of_four(fine: np.ndarray) -> np.ndarray:
    faces, rows, columns = fine.shape[:3]
    return fine.reshape(faces, rows // 2, 2, columns // 2, 2, *fine.shape[3:]).sum((2, 4))


def prolong(
    chain: MipChain, texels: Shaped[np.ndarray, "texels *channels"], mip_level: int
) -> Float[np.ndarray, "faces rows columns *channels"]:
    """What level ``mip_level`` looks like if taken from the next coarser one alone: seamless bilinear interpolation."""
    coarse = pad(chain, texels, mip_level + 1)
    for axis in (1, 2):
        # Fine texel centres lie a quarter of a coarse texel beside the coarse centres.
        fine = np.arange(chain.level_shape(mip_level)[axis])
        index = fine // 2 + 1
        beside = index + np.where(fine % 2, 1, -1)
        coarse = 0.75 * np.take(coarse, index, axis) + 0.25 * np.take(coarse, beside, axis)
    return coarse


def pad(
    chain: MipChain, texels: Shaped[np.ndarray, "texels *channels"], mip_level: int
) -> Float[np.ndarray, "faces rows columns *channels"]:
    """One level, `padded`."""
    return padded(chain.parameterization, chain.level(texels, mip_level))
