"""Products with a rendering matrix: rows from texels and back.

Vectors are planar, (channels, n), in float32; every sum runs in one fixed order, whatever the number of threads.
"""

import numpy as np
from jaxtyping import Float
from numba import njit, prange

from reflet.infer.records import RenderingMatrix

_BLOCKS = 64  # units of parallel work, and of partial sums


def multiply(
    matrix: RenderingMatrix, texels: Float[np.ndarray, "texels channels"]
) -> Float[np.ndarray, "rows channels"]:
    """A·x: the rows' values where ``texels`` are shown."""
    planar = np.ascontiguousarray(texels.T, dtype=np.float32)
    out = np.empty((planar.shape[0], len(matrix.starts) - 1), np.float32)
    multiply_planar(matrix.starts, matrix.columns, matrix.weights, planar, out)
    return np.ascontiguousarray(out.T)


def transpose(matrix: RenderingMatrix) -> RenderingMatrix:
    """The same matrix by columns: one row a texel, its ``columns`` being the rows that see it."""
    rows = len(matrix.starts) - 1
    starts, columns, weights = _transpose(matrix.starts, matrix.columns, matrix.weights, matrix.texel_count)
    return RenderingMatrix(starts, columns, weights, rows)


@njit(parallel=True, cache=True)
def multiply_planar(starts, columns, weights, x, out):  # type: ignore[no-untyped-def]
    """out = A·x for planar vectors."""
    rows = len(starts) - 1
    for block in prange(_BLOCKS):
        for row in range(block * rows // _BLOCKS, (block + 1) * rows // _BLOCKS):
            for c in range(x.shape[0]):
                total = np.float32(0.0)
                for k in range(starts[row], starts[row + 1]):
                    total += weights[k] * x[c, columns[k]]
                out[c, row] = total


@njit(cache=True)
def _transpose(starts, columns, weights, count):  # type: ignore[no-untyped-def]
    out_starts = np.zeros(count + 1, np.int32)
    for k in range(len(columns)):
        out_starts[columns[k] + 1] += 1
    for i in range(count):
        out_starts[i + 1] += out_starts[i]
    at = out_starts[:-1].copy()
    out_columns, out_weights = np.empty(len(columns), np.int32), np.empty(len(columns), np.float32)
    for row in range(len(starts) - 1):
        for k in range(starts[row], starts[row + 1]):
            place = at[columns[k]]
            out_columns[place], out_weights[place] = row, weights[k]
            at[columns[k]] += 1
    return out_starts, out_columns, out_weights
