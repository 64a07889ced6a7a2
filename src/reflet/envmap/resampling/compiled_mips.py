"""The loop of mip levels, compiled: weighted means of two by two texels."""

import numpy as np
from numba import njit, prange


@njit(cache=True, parallel=True)
def halve(fine, weight, out, total):  # type: ignore[no-untyped-def]
    """Fills ``out`` (faces, rows, columns, channels) with means of ``fine`` and ``total`` with sums of weights.

    Where these are 0, so is the mean. Sums are in double precision.
    """
    faces, rows, columns, channels = out.shape
    for line in prange(faces * rows):
        face, row = line // rows, line % rows
        for column in range(columns):
            i, j = 2 * row, 2 * column
            a, b = weight[face, i, j], weight[face, i, j + 1]
            c, d = weight[face, i + 1, j], weight[face, i + 1, j + 1]
            both = b + c + d + a
            total[face, row, column] = both
            scale = np.float64(1.0) / both if both > 0.0 else np.float64(1.0)
            for k in range(channels):
                out[face, row, column, k] = scale * (
                    a * fine[face, i, j, k]
                    + b * fine[face, i, j + 1, k]
                    + c * fine[face, i + 1, j, k]
                    + d * fine[face, i + 1, j + 1, k]
                )
