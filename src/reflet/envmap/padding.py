"""Texels beside the faces of a map, so that filters never meet an edge: over seams, and outside round maps' discs."""

import numpy as np
from jaxtyping import Bool, Shaped

from reflet.envmap.parameterization import NONE, Parameterization


def padded(
    parameterization: Parameterization, texels: Shaped[np.ndarray, "faces rows columns *channels"]
) -> Shaped[np.ndarray, "faces rows_padded columns_padded *channels"]:
    """One level with its neighbours' nearest texels around every face; where none is, at a cube's corners, the mean of
    the three texels there."""
    faces, rows, columns = texels.shape[:3]
    out = np.empty((faces, rows + 2, columns + 2, *texels.shape[3:]), texels.dtype)
    out[:, 1:-1, 1:-1] = texels
    whole_row, whole_column = np.arange(-1, columns + 1), np.arange(-1, rows + 1)
    for row, column in ((-1, whole_row), (rows, whole_row), (whole_column, -1), (whole_column, columns)):
        face, row, column = (at.copy() for at in np.broadcast_arrays(np.arange(faces)[:, None], row, column))
        on, row_on, column_on = parameterization.across_seams(face, row, column, rows)
        out[face, row + 1, column + 1] = texels[np.where(on == NONE, 0, on), row_on, column_on]
        if (on == NONE).any():
            corner = on == NONE
            f, r, c = face[corner], row[corner] + 1, column[corner] + 1
            inner_r, inner_c = np.clip(r, 1, rows), np.clip(c, 1, columns)
            out[f, r, c] = (out[f, inner_r, inner_c] + out[f, r, inner_c] + out[f, inner_r, c]) / 3.0
    return out


def outside_disc(parameterization: Parameterization, size: int) -> Bool[np.ndarray, "rows columns"]:
    """Texels whose centres lie outside the disc of a round map; none in other maps."""
    _, columns = parameterization.shape(size)[1:]
    _, corner_is_valid = parameterization.direction_from_uv(np.zeros(1, np.int64), np.zeros((1, 2)))
    if corner_is_valid[0]:
        return np.zeros((size, columns), bool)
    square = ((2.0 * np.arange(size) + 1.0) / size - 1.0) ** 2
    return np.asarray(square + square[:, None] > 1.0)


def continued(
    parameterization: Parameterization,
    texels: Shaped[np.ndarray, "faces rows columns channels"],
    unknown: Bool[np.ndarray, "rows columns"],
) -> Shaped[np.ndarray, "faces rows columns channels"]:
    """The texels with the ``unknown`` ones, outside the disc of a round map, replaced by the map's own continuation.

    That is the bilinear mean of known texels where `Parameterization.across_seams` goes on: for the dual paraboloid in
    the other hemisphere at the inverse point, for the others over the rim, at radius 2 - r on the other side.
    """
    if not unknown.any():
        return texels
    faces, size = texels.shape[:2]
    row, column = np.nonzero(unknown)
    x, y = (2.0 * column + 1.0) / size - 1.0, (2.0 * row + 1.0) / size - 1.0
    radius = np.hypot(x, y)
    scale = radius**-2 if faces == 2 else 1.0 - 2.0 / radius
    x, y = (0.5 * size) * (x * scale + 1.0) - 0.5, (0.5 * size) * (y * scale + 1.0) - 0.5
    out = texels.copy()
    for face in range(faces):
        total, weights = 0.0, 0.0
        for down in (0, 1):
            for right in (0, 1):
                r, c = np.floor(y).astype(np.int64) + down, np.floor(x).astype(np.int64) + right
                weight = (1.0 - np.abs(y - r)) * (1.0 - np.abs(x - c))
                r, c = np.clip(r, 0, size - 1), np.clip(c, 0, size - 1)
                weight = np.where(unknown[r, c], 0.0, weight)[:, None]
                total = total + weight * texels[faces - 1 - face, r, c]
                weights = weights + weight
        out[face, row, column] = total / weights
    return out
