"""Products with a rendering matrix: rows from texels and back.

Every sum runs in one fixed order, whatever the number of threads.
"""

import numpy as np
from jaxtyping import Float, Float32
from numba import njit, prange

from reflet.infer.records import RenderingMatrix, Rows

_BLOCKS = 64  # units of parallel work, and of partial sums
_GATHERERS = 4  # partial gradients: as many threads go through rows at once


def multiply(
    matrix: RenderingMatrix, texels: Float[np.ndarray, "texels channels"]
) -> Float[np.ndarray, "rows channels"]:
    """A·x: the rows' values where ``texels`` are shown."""
    x = np.ascontiguousarray(texels, dtype=np.float32)
    out = np.empty((len(matrix.starts) - 1, x.shape[1]), np.float32)
    _multiply(matrix.starts, matrix.columns, matrix.weights, x, out)
    return out


class Gatherer:
    """Sums Aᵀ·W·r over many blocks of rows in one pass through each of their matrices, for r = A·x or A·x - target.

    Of up to four channels. Holds five vectors of all texels and four channels in float32.
    """

    def __init__(self, texels: Float[np.ndarray, "texels channels"]) -> None:
        """``texels`` are x."""
        self._channels = texels.shape[1]
        self._x = np.zeros((len(texels), 4), np.float32)
        self._x[:, : self._channels] = texels
        self._sums = np.zeros((_GATHERERS, *self._x.shape), np.float32)

    def add(self, rows: Rows, *, minus_target: bool = False) -> float:
        """Add some rows. Returns their Σ weights·r²."""
        a, squares = rows.matrix, np.zeros(_GATHERERS)
        target = rows.target if minus_target else rows.target[:0]
        _gather_rows(a.starts, a.columns, a.weights, rows.weights, target, self._x, self._sums, squares)
        return float(squares.sum())

    def planar_sum(self) -> Float32[np.ndarray, "channels texels"]:
        """What was gathered."""
        out = np.empty((self._channels, len(self._x)), np.float32)
        _add_up(self._sums, out)
        return out


def squared_columns(rows: Rows, out: Float32[np.ndarray, "texels"]) -> None:
    """Adds Σ weights·a² of every texel to ``out``: the diagonal of Aᵀ·W·A."""
    _square(rows.matrix.starts, rows.matrix.columns, rows.matrix.weights, rows.weights, out)


@njit(parallel=True, cache=True)
def _multiply(starts, columns, weights, x, out):  # type: ignore[no-untyped-def]
    rows = len(starts) - 1
    for block in prange(_BLOCKS):
        for row in range(block * rows // _BLOCKS, (block + 1) * rows // _BLOCKS):
            out[row] = 0.0
            for k in range(starts[row], starts[row + 1]):
                for c in range(x.shape[1]):
                    out[row, c] += weights[k] * x[columns[k], c]


@njit(parallel=True, cache=True)
def _gather_rows(starts, columns, a, weights, target, x, sums, squares):  # type: ignore[no-untyped-def]
    rows, parts = len(weights), sums.shape[0]
    for part in prange(parts):
        square = 0.0
        for row in range(part * rows // parts, (part + 1) * rows // parts):
            weight = weights[row]
            if weight == 0.0:
                continue
            s0, s1, s2, s3 = np.float32(0.0), np.float32(0.0), np.float32(0.0), np.float32(0.0)
            for k in range(starts[row], starts[row + 1]):
                column, share = columns[k], a[k]
                s0 += share * x[column, 0]
                s1 += share * x[column, 1]
                s2 += share * x[column, 2]
                s3 += share * x[column, 3]
            if len(target):
                s0 -= target[row, 0]
                s1 -= target[row, 1]
                s2 -= target[row, 2]
                if target.shape[1] > 3:
                    s3 -= target[row, 3]
            square += weight * (s0 * s0 + s1 * s1 + s2 * s2 + s3 * s3)
            s0, s1, s2, s3 = weight * s0, weight * s1, weight * s2, weight * s3
            for k in range(starts[row], starts[row + 1]):
                column, share = columns[k], a[k]
                sums[part, column, 0] += share * s0
                sums[part, column, 1] += share * s1
                sums[part, column, 2] += share * s2
                sums[part, column, 3] += share * s3
        squares[part] = square


@njit(parallel=True, cache=True)
def _add_up(sums, out):  # type: ignore[no-untyped-def]
    n = out.shape[1]
    for block in prange(_BLOCKS):
        for texel in range(block * n // _BLOCKS, (block + 1) * n // _BLOCKS):
            for c in range(out.shape[0]):
                total = np.float32(0.0)
                for part in range(sums.shape[0]):
                    total += sums[part, texel, c]
                out[c, texel] = total


@njit(cache=True)
def _square(starts, columns, a, weights, out):  # type: ignore[no-untyped-def]
    for row in range(len(weights)):
        for k in range(starts[row], starts[row + 1]):
            out[columns[k]] += weights[row] * a[k] * a[k]
