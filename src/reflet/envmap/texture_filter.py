"""The texture filter of the target graphics system: trilinear, seamless over the edges of faces.

A lookup is a weighted sum of eight texels, four on each of two mip levels. Which texels lie across an edge is settled
once, in a table a level with one texel of padding around every face. At a cube's corner three faces meet, so that one
of four taps is missing: its weight goes to the other three in equal shares, as graphics APIs prescribe.
"""

from functools import lru_cache

import numpy as np
from jaxtyping import Float, Int, Int32

from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.parameterization import NONE

MISSING = -1  # the table's entry for the texel beyond a cube's corner


def padded_indices(chain: MipChain, mip_level: int) -> Int32[np.ndarray, "faces rows columns"]:
    """Texel indices of one mip level, each face surrounded by its neighbours' nearest texels; `MISSING` at corners."""
    faces, rows, columns = chain.level_shape(mip_level)
    at = np.meshgrid(np.arange(faces), np.arange(-1, rows + 1), np.arange(-1, columns + 1), indexing="ij")
    face, row, column = chain.parameterization.across_seams(*at, rows)
    index = chain.offsets[mip_level] + (face * rows + row) * columns + column
    return np.where(face == NONE, MISSING, index).astype(np.int32)


@lru_cache(maxsize=8)
def padded_index_table(chain: MipChain) -> tuple[Int32[np.ndarray, "entries"], Int32[np.ndarray, "levels"]]:
    """All levels' `padded_indices` in one flat table, and where each level starts in it. Read-only."""
    levels = [padded_indices(chain, level).ravel() for level in range(chain.level_count)]
    table = np.concatenate(levels)
    starts = np.cumsum([0] + [len(level) for level in levels])[:-1].astype(np.int32)
    table.setflags(write=False)
    starts.setflags(write=False)
    return table, starts


def taps(
    chain: MipChain, direction: Float[np.ndarray, "n 3"], lod: Float[np.ndarray, "n"]
) -> tuple[Int[np.ndarray, "n 8"], Float[np.ndarray, "n 8"]]:
    """Indices and weights of the eight texels of each lookup; the weights are at least 0 and add up to 1.

    Directions need not be unit vectors. ``lod`` lies in [0, level_count - 1]. A missing corner tap keeps weight 0.
    """
    table, starts = padded_index_table(chain)
    face, uv = chain.parameterization.uv_from_direction(direction)
    aspect = chain.parameterization.aspect
    finer = np.minimum(np.floor(lod).astype(np.int64), max(chain.level_count - 2, 0))
    fraction = lod - finer
    indices, weights = [], []
    for level, level_weight in ((finer, 1.0 - fraction), (np.minimum(finer + 1, chain.level_count - 1), fraction)):
        size = chain.size >> level
        columns = aspect * size
        x, y = uv[..., 0] * columns - 0.5, uv[..., 1] * size - 0.5
        column, row = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
        # A direction exactly on an edge may round to one texel further than the padding holds.
        column, row = np.clip(column, -1, columns - 1), np.clip(row, -1, size - 1)
        fx, fy = x - column, y - row
        index = np.stack(
            [
                table[starts[level] + (face * (size + 2) + row + dy + 1) * (columns + 2) + column + dx + 1]
                for dy in (0, 1)
                for dx in (0, 1)
            ],
            -1,
        )
        weight = np.stack([(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy], -1)
        missing = index == MISSING
        weight = np.where(missing, 0.0, weight + (weight * missing).sum(-1, keepdims=True) / 3.0)
        # An index must name some texel even where it has no weight.
        index = np.where(missing, index.max(-1, keepdims=True), index)
        indices.append(index)
        weights.append(weight * level_weight[:, None])
    return np.concatenate(indices, -1), np.concatenate(weights, -1)


def sample(
    chain: MipChain,
    texels: Float[np.ndarray, "texels channels"],
    direction: Float[np.ndarray, "n 3"],
    lod: Float[np.ndarray, "n"],
) -> Float[np.ndarray, "n channels"]:
    """Filtered texels in the given directions, as the graphics system shows them."""
    indices, weights = taps(chain, direction, lod)
    return np.einsum("nk,nkc->nc", weights, texels[indices].astype(np.float64))
