"""What texels should be where no sample says so: the prior, changed smoothly across mip levels.

With d = x - prior, the penalty is ‖G·d‖² where (G·d) at level l is d at level l minus the seamless bilinear
prolongation U of d at level l + 1: a texel that no sample sees takes over the change of its coarser neighbourhood,
and a texel whose whole neighbourhood is unseen keeps its prior. The regularization of [Hakura01, sec. 4], which fills
texels "smoothly from defined neighbors", with the neighbours taken from the mip chain.

G·d and its transpose are applied as stencils, face by face; nothing is stored but the index table of the texture
filter. U's weights are products of (1/4, 3/4); beyond a cube's corner stands the mean of the three texels there. Texels
outside the disc of a round map, but for those beside its rim, are seen by no sample ever: what they hold shows nowhere.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numba import njit, prange

from reflet.envmap.mip_chain import MipChain
from reflet.envmap.texture_filter import padded_index_table


@dataclass(frozen=True)
class MipPenalty:
    """‖G·d‖² of a map's chain (`reflet.infer.solve.Penalty`)."""

    chain: MipChain

    def gradient(self, d: Float[np.ndarray, "channels texels"]) -> Float[np.ndarray, "channels texels"]:
        """Gᵀ·G·d: half the gradient of the penalty, in float32. Scratch memory: twice the size of ``d``."""
        chain = self.chain
        table, starts = padded_index_table(chain)
        offsets, shapes = np.array(chain.offsets), np.array([chain.level_shape(k) for k in range(chain.level_count)])
        out, detail = np.empty_like(d), np.empty_like(d)
        padded = np.zeros((d.shape[0], len(table)), np.float32)
        _details(d, detail, padded, table, starts, offsets, shapes)
        _gather(detail, out, padded, starts, offsets, shapes)
        _fold_borders(out, padded, table, starts, shapes)
        return out

    def diagonal(self) -> Float[np.ndarray, "texels"]:
        """Diagonal of Gᵀ·G, taking borders for interior: 1 from the level's own detail, and (2·(1/16 + 9/16))² from
        the sixteen texels that the next finer level prolongs from it."""
        offsets = self.chain.offsets
        diagonal = np.full(self.chain.texel_count, 1.0 + 1.25**2, np.float32)
        diagonal[: offsets[1]] = 1.0
        diagonal[offsets[-2] :] -= 1.0
        return diagonal


@njit(parallel=True, cache=True)
def _details(d, detail, padded, table, starts, offsets, shapes):  # type: ignore[no-untyped-def]
    """detail = G·d; the coarsest level has none."""
    quarter, three = np.float32(0.25), np.float32(0.75)
    faces, levels = shapes[0, 0], len(shapes)
    for task in prange(faces * d.shape[0]):
        c, face = task // faces, task % faces
        for level in range(levels - 1):
            rows, columns = shapes[level, 1], shapes[level, 2]
            height, width = shapes[level + 1, 1] + 2, shapes[level + 1, 2] + 2
            base = starts[level + 1] + face * height * width
            coarse = padded[c, base : base + height * width].reshape(height, width)
            for j in range(height):
                for i in range(width):
                    index = table[base + j * width + i]
                    if index >= 0:
                        coarse[j, i] = d[c, index]
            for j, jn in ((0, 1), (height - 1, height - 2)):
                for i, i_n in ((0, 1), (width - 1, width - 2)):
                    if table[base + j * width + i] < 0:
                        coarse[j, i] = (coarse[jn, i_n] + coarse[j, i_n] + coarse[jn, i]) / np.float32(3.0)
            line = np.empty(width, np.float32)
            at = offsets[level] + face * rows * columns
            for y in range(rows):
                j, beside = y // 2 + 1, y // 2 + (2 if y % 2 else 0)
                for i in range(width):
                    line[i] = three * coarse[j, i] + quarter * coarse[beside, i]
                for x in range(width - 2):
                    k = at + y * columns + 2 * x
                    detail[c, k] = d[c, k] - (three * line[x + 1] + quarter * line[x])
                    detail[c, k + 1] = d[c, k + 1] - (three * line[x + 1] + quarter * line[x + 2])
        columns = shapes[levels - 1, 2]  # of one row
        for k in range(offsets[levels - 1] + face * columns, offsets[levels - 1] + (face + 1) * columns):
            detail[c, k] = 0.0


@njit(parallel=True, cache=True)
def _gather(detail, out, padded, starts, offsets, shapes):  # type: ignore[no-untyped-def]
    """out = detail - Uᵀ·detail inside the faces; what falls on their padding stays in ``padded``."""
    quarter, three = np.float32(0.25), np.float32(0.75)
    faces = shapes[0, 0]
    for task in prange(faces * out.shape[0]):
        c, face = task // faces, task % faces
        finest = shapes[0, 1] * shapes[0, 2]
        for k in range(face * finest, (face + 1) * finest):
            out[c, k] = detail[c, k]
        for level in range(len(shapes) - 1):
            rows, columns = shapes[level, 1], shapes[level, 2]
            height, width = shapes[level + 1, 1] + 2, shapes[level + 1, 2] + 2
            base = starts[level + 1] + face * height * width
            total = padded[c, base : base + height * width].reshape(height, width)
            total[:] = 0.0
            line = np.empty(width, np.float32)
            at = offsets[level] + face * rows * columns
            for y in range(rows):
                line[:] = 0.0
                for x in range(width - 2):
                    left, right = detail[c, at + y * columns + 2 * x], detail[c, at + y * columns + 2 * x + 1]
                    line[x] += quarter * left
                    line[x + 1] += three * (left + right)
                    line[x + 2] += quarter * right
                j, beside = y // 2 + 1, y // 2 + (2 if y % 2 else 0)
                for i in range(width):
                    total[j, i] += three * line[i]
                    total[beside, i] += quarter * line[i]
            at = offsets[level + 1] + face * (height - 2) * (width - 2)
            for y in range(height - 2):
                for x in range(width - 2):
                    k = at + y * (width - 2) + x
                    out[c, k] = detail[c, k] - total[y + 1, x + 1]


@njit(parallel=True, cache=True)
def _fold_borders(out, padded, table, starts, shapes):  # type: ignore[no-untyped-def]
    """Takes from the texels across the edges what the faces' padding gathered for them."""
    for c in prange(out.shape[0]):
        for level in range(1, len(shapes)):
            height, width = shapes[level, 1] + 2, shapes[level, 2] + 2
            for face in range(shapes[0, 0]):
                base = starts[level] + face * height * width
                for j in range(height):
                    step = 1 if j in (0, height - 1) else width - 1
                    for i in range(0, width, step):
                        index, value = table[base + j * width + i], padded[c, base + j * width + i]
                        if index >= 0:
                            out[c, index] -= value
                        else:
                            jn, i_n = min(max(j, 1), height - 2), min(max(i, 1), width - 2)
                            for a, b in ((jn, i_n), (j, i_n), (jn, i)):
                                out[c, table[base + a * width + b]] -= value / np.float32(3.0)
