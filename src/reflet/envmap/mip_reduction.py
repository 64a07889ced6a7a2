"""From fine mip levels to coarse ones and back."""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Float, Shaped

from reflet.envmap.cube import texel_solid_angle
from reflet.envmap.mip_chain import CubeMipChain
from reflet.envmap.texture_filter import padded_indices


def mip_levels_from_finest(
    chain: CubeMipChain, finest: Float[np.ndarray, "6 size size *channels"]
) -> Float[np.ndarray, "texels *channels"]:
    """A whole mip chain whose coarser texels are the solid-angle weighted means of the finest ones they cover.

    The mean over all directions is thus the same on every level.
    """
    texels = np.empty((chain.texel_count, *finest.shape[3:]), finest.dtype)
    weight = texel_solid_angle(chain.size).reshape(1, chain.size, chain.size, *[1] * (finest.ndim - 3))
    chain.level(texels, 0)[...] = finest
    flux = finest * weight
    for level, size in enumerate(chain.level_sizes[1:], 1):
        flux = _sum_of_four(flux, size)
        weight = _sum_of_four(weight, size)
        chain.level(texels, level)[...] = flux / weight
    return texels


def _sum_of_four(fine: np.ndarray, size: int) -> np.ndarray:
    return fine.reshape(fine.shape[0], size, 2, size, 2, *fine.shape[3:]).sum((2, 4))


def prolong(
    chain: CubeMipChain, texels: Shaped[np.ndarray, "texels *channels"], mip_level: int
) -> Float[np.ndarray, "6 size size *channels"]:
    """What level ``mip_level`` looks like if taken from the next coarser one alone: seamless bilinear interpolation."""
    coarse = pad(chain, texels, mip_level + 1)
    size = chain.level_sizes[mip_level]
    for axis in (1, 2):
        # Fine texel centres lie a quarter of a coarse texel beside the coarse centres.
        index = np.arange(size) // 2 + 1
        beside = index + np.where(np.arange(size) % 2, 1, -1)
        coarse = 0.75 * np.take(coarse, index, axis) + 0.25 * np.take(coarse, beside, axis)
    return coarse


def pad(
    chain: CubeMipChain, texels: Shaped[np.ndarray, "texels *channels"], mip_level: int
) -> Float[np.ndarray, "6 padded padded *channels"]:
    """One level with its neighbours' nearest texels around every face; corners: the mean of the three there."""
    index = padded_indices(chain, mip_level)
    padded = texels[index]
    for row, column, inner_row, inner_column in _corners():
        three = ((inner_row, inner_column), (row, inner_column), (inner_row, column))
        padded[:, row, column] = sum(padded[:, r, c] for r, c in three) / 3.0
    return padded


def _corners() -> Iterator[tuple[int, int, int, int]]:
    for row, inner_row in ((0, 1), (-1, -2)):
        for column, inner_column in ((0, 1), (-1, -2)):
            yield row, column, inner_row, inner_column
