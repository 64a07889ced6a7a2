"""Colours for test renderings: few enough to need few renderings, enough to tell texels apart."""

import numpy as np
from jaxtyping import Float32, Int8, Int32

from reflet.envmap.mip_chain import MipChain

COLORS_PER_LEVEL = 6
COLOR_COUNT = 2 * COLORS_PER_LEVEL

# Color of a texel by its face and the parities of its row and column. Within a face the 2×2 texels of any bilinear
# footprint differ. Where faces meet, the two border colours of one face are never among the two of the other, so that
# footprints over edges and corners differ too: the four side faces are one band whose columns go on alternating, and
# top and bottom bring two colours of their own to keep clear of it.
_SIDE, _TOP, _BOTTOM = ((0, 1), (2, 3)), ((2, 3), (4, 5)), ((0, 1), (4, 5))
_BY_PARITY = np.array([_SIDE, _SIDE, _TOP, _BOTTOM, _SIDE, _SIDE], np.int8)

# The parities (row, column) of the texels of a face that have a color; -1 where none has.
_PARITIES = np.full((6, COLORS_PER_LEVEL, 2), -1)
for _face, _row, _column in np.ndindex(6, 2, 2):
    _PARITIES[_face, _BY_PARITY[_face, _row, _column]] = _row, _column


def texel_colors(chain: MipChain) -> Int8[np.ndarray, "texels"]:
    """A colour in 0..11 for each texel; no lookup ever weighs two texels of one colour.

    A lookup meets two neighbouring mip levels, of which one is even and one odd: each kind has six colours.
    """
    out = np.empty(chain.texel_count, np.int8)
    for mip_level, size in enumerate(chain.level_sizes):
        parity = np.arange(size) & 1
        # The coarsest level has one texel a face, any of which may meet any other.
        by_parity = _BY_PARITY[:, parity][:, :, parity] if size > 1 else np.arange(6, dtype=np.int8).reshape(6, 1, 1)
        chain.level(out, mip_level)[...] = by_parity + COLORS_PER_LEVEL * (mip_level & 1)
    return out


def texel_names(chain: MipChain) -> Float32[np.ndarray, "texels 4"]:
    """What a test rendering shows of each texel, times its weight: (1, name).

    Colour tells the parities of column, row and mip level, so that names hold halves of them; they are centred on zero.
    Small numbers let small weights be read: filters round to about 1e-7 of the number.
    """
    out = np.ones((chain.texel_count, 4), np.float32)
    for mip_level, size in enumerate(chain.level_sizes):
        face, row, column = np.meshgrid(np.arange(6), np.arange(size), np.arange(size), indexing="ij")
        kind = 8 * face + mip_level // 2 - 20
        chain.level(out, mip_level)[..., 1:] = np.stack([column // 2 - size // 4, row // 2 - size // 4, kind], -1)
    return out


def texels_from_names(chain: MipChain, color: int, names: Float32[np.ndarray, "n 3"]) -> Int32[np.ndarray, "n"]:
    """Indices of the texels of one colour that have these names, -1 where there is none."""
    half_column, half_row, kind = np.rint(names).astype(np.int64).T
    face, half_level = np.divmod(kind + 20, 8)
    mip_level = 2 * half_level + color // COLORS_PER_LEVEL
    known = (face >= 0) & (face < 6) & (mip_level < chain.level_count)
    face, mip_level = np.where(known, face, 0), np.where(known, mip_level, 0)
    size = np.asarray(chain.level_sizes)[mip_level]
    parity = np.where(size[:, None] > 1, _PARITIES[face, color % COLORS_PER_LEVEL], 0)
    column = 2 * (half_column + size // 4) + parity[:, 1]
    row = 2 * (half_row + size // 4) + parity[:, 0]
    known &= (parity >= 0).all(1) & (column >= 0) & (column < size) & (row >= 0) & (row < size)
    texel = np.asarray(chain.offsets)[mip_level] + (face * size + row) * size + column
    return np.where(known, texel, -1).astype(np.int32)
