"""Colours for test renderings: few enough to need few renderings, enough to tell texels apart."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Float32, Int8, Int32
from numba import njit

from reflet.envmap.mip_chain import MipChain
from reflet.envmap.texture_filter import padded_index_table

_MOST_COLORS = 32  # of one class of levels: texels have eight neighbours, a few more where seams meet
_ROUNDS = 8  # of colouring anew in the order of colours, each of which needs no more of them


@dataclass(frozen=True)
class Coloring:
    """A colour and a name for each texel of a mip chain.

    No lookup ever weighs two texels of one colour. Among the texels of one colour a texel is known by its ``names``:
    its rank, written as three digits to the base ``base``, centred on zero. Small numbers let small weights be read:
    filters round to about 1e-7 of the number.
    """

    colors: Int8[np.ndarray, "texels"]
    color_count: int
    ranked: Int32[np.ndarray, "texels"]  # texels by colour, then rank
    starts: Int32[np.ndarray, "colors_and_one"]  # where each colour begins in ``ranked``
    base: int

    def names(self, color: int) -> Float32[np.ndarray, "texels 4"]:
        """What a test rendering shows of each texel of one colour, times its weight: (1, name); 0 of all others."""
        texels = self._texels(color)
        rank = np.arange(len(texels))
        digits = np.stack([rank // self.base**k % self.base for k in range(3)], -1)
        out = np.zeros((len(self.colors), 4), np.float32)
        out[texels, 0], out[texels, 1:] = 1.0, digits - self.base // 2
        return out

    def texels_of(self, color: int, names: Float32[np.ndarray, "n 3"]) -> Int32[np.ndarray, "n"]:
        """Indices of the texels of one colour that have these names, -1 where there is none."""
        texels = self._texels(color)
        digits = np.rint(names).astype(np.int64) + self.base // 2
        rank = digits @ self.base ** np.arange(3)
        known = ((digits >= 0) & (digits < self.base)).all(1) & (rank < len(texels))
        return np.where(known, texels[np.where(known, rank, 0)], -1).astype(np.int32)

    def _texels(self, color: int) -> Int32[np.ndarray, "n"]:
        return self.ranked[self.starts[color] : self.starts[color + 1]]


@lru_cache(maxsize=8)
def coloring(chain: MipChain) -> Coloring:
    """Colours of all texels, found greedily.

    Texels conflict where a bilinear footprint holds both; the padded index table shows all footprints as 2×2 windows.
    A lookup meets two neighbouring mip levels, of which one is even and one odd: each kind has colours of its own.
    """
    table, starts = padded_index_table(chain)
    padded = np.array([chain.level_shape(level) for level in range(chain.level_count)]) + (0, 2, 2)
    place_starts, places = _places(table, chain.texel_count)
    parity = np.repeat(np.arange(chain.level_count) & 1, np.diff(chain.offsets))
    colors, count = np.empty(chain.texel_count, np.int8), 0
    for odd in (0, 1):
        texels = np.flatnonzero(parity == odd).astype(np.int32)
        if not len(texels):
            continue
        order = texels
        for _ in range(_ROUNDS):
            found = _color(order, colors, table, starts, padded, place_starts, places)
            # Whole colours in any order need no more colours than there were; the last first mixes them best.
            order = texels[np.argsort(-colors[texels], kind="stable")]
        colors[texels] += count
        count += found
    ranked = np.argsort(colors, kind="stable").astype(np.int32)
    sizes = np.bincount(colors, minlength=count)
    starts_of_colors = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int32)
    return Coloring(colors, count, ranked, starts_of_colors, int(np.ceil(np.cbrt(sizes.max()))))


def _places(table: Int32[np.ndarray, "entries"], texel_count: int) -> tuple[np.ndarray, np.ndarray]:
    """Where each texel stands in the table: (where its places begin, places)."""
    present = np.flatnonzero(table >= 0)
    order = np.argsort(table[present], kind="stable")
    starts = np.concatenate([[0], np.cumsum(np.bincount(table[present], minlength=texel_count))])
    return starts, present[order]


@njit(cache=True)
def _color(order, colors, table, starts, padded, place_starts, places):  # type: ignore[no-untyped-def]
    """Gives texels in this order the first colour that no neighbour has; the number of colours used."""
    for texel in order:
        colors[texel] = -1
    taken = np.full(_MOST_COLORS, -1, np.int32)
    count = 0
    for texel in order:
        for k in range(place_starts[texel], place_starts[texel + 1]):
            level = np.searchsorted(starts, places[k], side="right") - 1
            rows, columns = padded[level, 1], padded[level, 2]
            row = (places[k] - starts[level]) // columns % rows
            column = (places[k] - starts[level]) % columns
            for j in range(max(row - 1, 0) - row, min(row + 1, rows - 1) - row + 1):
                for i in range(max(column - 1, 0) - column, min(column + 1, columns - 1) - column + 1):
                    other = table[places[k] + j * columns + i]
                    if other >= 0 and colors[other] >= 0:
                        taken[colors[other]] = texel
        color = 0
        while taken[color] == texel:
            color += 1
        colors[texel] = color
        count = max(count, color + 1)
    return count
