"""From fine mip levels to coarse ones and back."""

import numpy as np
from jaxtyping import Float, Shaped

from reflet.envmap.env_image import EnvImage
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.angular import Angular
from reflet.envmap.parameterizations.dual_paraboloid import DualParaboloid
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.resampling.compiled_mips import halve
from reflet.envmap.resampling.padding import continued, outside_disc, padded

Level = Shaped[np.ndarray, "faces rows columns *channels"]


def mip_levels_from_finest(
    chain: MipChain, finest: Float[np.ndarray, "faces rows columns *channels"]
) -> Float[np.ndarray, "texels *channels"]:
    """A whole mip chain whose coarser texels are means of the finest ones they cover, weighted by solid angle.

    Implements [Heidrich00, sec. 2.4]. The mean over all directions is the same on every level. Seams do not show: over
    the edges of faces the texture filter is continuous whatever the texels, and what a dual paraboloid or angular map
    has outside its disc counts in the means like the rest (`mean_weights`), so that the texels on both sides of the rim
    are means of one and the same radiance. For that the outside is taken from inside, whatever came; texels wholly
    outside the disc are so filled on every level, the finest too.
    """
    parameterization = chain.parameterization
    solid_angle = parameterization.texel_solid_angle(chain.size)
    total = _total(finest, solid_angle)
    texels = np.empty((chain.texel_count, *finest.shape[3:]), finest.dtype)
    chain.level(texels, 0)[...] = continued(parameterization, finest, solid_angle[0] == 0.0)
    fine = continued(parameterization, finest, outside_disc(parameterization, chain.size))
    weight = mean_weights(parameterization, chain.size)
    for level in range(1, chain.level_count):
        fine, weight = _halved(parameterization, fine, weight)
        if parameterization.is_round:
            # What the means gave away over the rim, some millionths on fine levels.
            have = _total(fine, parameterization.texel_solid_angle(fine.shape[1]))
            fine = fine * np.divide(total, have, where=have != 0.0, out=np.ones_like(have))
        chain.level(texels, level)[...] = fine
    return texels


def mip_images(image: EnvImage) -> tuple[EnvImage, ...]:
    """The image and all its coarser mip levels, finest first. Raises RefletError if its size is no power of two."""
    chain = MipChain(image.size, image.parameterization)
    texels = mip_levels_from_finest(chain, image.texels)
    return tuple(EnvImage(image.parameterization, chain.level(texels, level)) for level in range(chain.level_count))


def halved(
    parameterization: Parameterization, texels: Level
) -> Shaped[np.ndarray, "faces half_rows half_columns *channels"]:
    """The next coarser level of a map with an even number of rows: solid-angle weighted means of two by two texels."""
    weight = parameterization.texel_solid_angle(texels.shape[1])
    dtype = np.float64 if texels.dtype == np.float64 else np.float32
    return _halved(parameterization, texels, weight, dtype)[0].astype(texels.dtype, copy=False)


def _halved(
    parameterization: Parameterization,
    fine: Level,
    weight: Float[np.ndarray, "faces rows columns"],
    dtype: type[np.floating] = np.float64,
) -> tuple[np.ndarray, np.ndarray]:
    """Weighted means of two by two texels, and the sums of their weights."""
    faces, rows, columns = fine.shape[:3]
    total = np.empty((faces, rows // 2, columns // 2))
    coarse = np.empty((*total.shape, *fine.shape[3:]), dtype)
    fine = fine if fine.dtype.itemsize >= 4 else fine.astype(np.float32)  # half floats are none of the compiler's
    halve(fine.reshape(faces, rows, columns, -1), weight, coarse.reshape(*total.shape, -1), total)
    return continued(parameterization, coarse, total[0] == 0.0), total


def mean_weights(parameterization: Parameterization, size: int) -> Float[np.ndarray, "faces rows columns"]:
    """Weights of texels in the means that make coarser levels: their solid angles, up to a common factor.

    Texels at and outside the rim of a round map have that of all their continuation sees: 4·dA/(1 + r²)² goes on over
    the dual paraboloid's rim, |sin πr|·dA/r over the angular map's. (The gazing ball's outside is all one direction.)
    The sum is more than the sphere's, for the two hemispheres overlap.
    """
    square = ((2.0 * np.arange(size) + 1.0) / size - 1.0) ** 2
    square = square + square[:, None]
    if isinstance(parameterization, DualParaboloid):
        return np.broadcast_to(1.0 / (1.0 + square) ** 2, (2, size, size))
    if isinstance(parameterization, Angular):
        return np.abs(np.sinc(np.sqrt(square)))[None]
    return parameterization.texel_solid_angle(size)


def _total(texels: Level, solid_angle: Float[np.ndarray, "faces rows columns"]) -> np.ndarray:
    """∫ L dω, in double precision."""
    return np.einsum("frc,frck->k", solid_angle, texels.reshape(*texels.shape[:3], -1)).reshape(texels.shape[3:])


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
