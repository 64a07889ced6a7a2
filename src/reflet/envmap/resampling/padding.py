"""Texels beside the faces of a map, so that filters never meet an edge: over seams, and outside round maps' discs."""

import numpy as np
from jaxtyping import Bool, Shaped

from reflet.envmap.parameterizations.parameterization import NONE, Parameterization


def padded(
    parameterization: Parameterization, texels: Shaped[np.ndarray, "faces rows columns *channels"]
) -> Shaped[np.ndarray, "faces rows_padded columns_padded *channels"]:
    """One level with its neighbours' nearest texels around every face; where none is, at a cube's corners, the mean of
    the three texels there."""
    faces, rows, columns = texels.shape[:3]
    out = np.empty((faces, rows + 2, columns + 2, *texels.shape[3:]), texels.dtype)
    out[:, 1:-1, 1:-1] = texels
    fill_padding(parameterization, out)
    return out


def fill_padding(
    parameterization: Parameterization, out: Shaped[np.ndarray, "faces rows_padded columns_padded *channels"]
) -> None:
    """Writes what is around every face in an array that is `padded`, from what is in it."""
    texels = out[:, 1:-1, 1:-1]
    faces, rows, columns = texels.shape[:3]
    along_row, along_column = np.arange(-1, columns + 1), np.arange(-1, rows + 1)
    missing = []
    for row, column in ((-1, along_row), (rows, along_row), (along_column, -1), (along_column, columns)):
        face, row, column = (at.copy() for at in np.broadcast_arrays(np.arange(faces)[:, None], row, column))
        on, row_on, column_on = parameterization.across_seams(face, row, column, rows)
        there = on != NONE
        out[face[there], row[there] + 1, column[there] + 1] = texels[on[there], row_on[there], column_on[there]]
        missing.append(np.stack([face[~there], row[~there] + 1, column[~there] + 1]))
    face, row, column = np.concatenate(missing, -1)
    inner_row, inner_column = np.clip(row, 1, rows), np.clip(column, 1, columns)
    three = out[face, inner_row, inner_column] + out[face, row, inner_column] + out[face, inner_row, column]
    out[face, row, column] = three / 3.0


def outside_disc(parameterization: Parameterization, size: int) -> Bool[np.ndarray, "rows columns"]:
    """Texels of a face whose centres lie outside the disc of a round map; in other maps none."""
    _, rows, columns = parameterization.shape(size)
    square = ((2.0 * np.arange(size) + 1.0) / size - 1.0) ** 2
    if parameterization.is_round:
        return np.asarray(square + square[:, None] > 1.0)
    return np.zeros((rows, columns), bool)


def continued(
    parameterization: Parameterization,
    texels: Shaped[np.ndarray, "faces rows columns *channels"],
    unknown: Bool[np.ndarray, "rows columns"],
) -> Shaped[np.ndarray, "faces rows columns *channels"]:
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
    taps = []
    for down in (0, 1):
        for right in (0, 1):
            r, c = np.floor(y).astype(np.int64) + down, np.floor(x).astype(np.int64) + right
            weight = (1.0 - np.abs(y - r)) * (1.0 - np.abs(x - c))
            r, c = np.clip(r, 0, size - 1), np.clip(c, 0, size - 1)
            taps.append((r, c, np.where(unknown[r, c], 0.0, weight)))
    all_weights = sum(weight for _, _, weight in taps)
    out = texels.copy()
    for face in range(faces):
        out[face, row, column] = sum(
            texels[faces - 1 - face, r, c] * (weight / all_weights).reshape(-1, *[1] * (texels.ndim - 3))
            for r, c, weight in taps
        )
    return out


def with_corners(
    parameterization: Parameterization, texels: Shaped[np.ndarray, "faces rows columns channels"]
) -> Shaped[np.ndarray, "faces rows columns channels"]:
    """One level as stored texels are to be: the corners of a round map, if its picture leaves them blank, continued.

    Photographs of mirror balls are black there, and so would be the part of each texel on the rim that lies inside the
    disc. Blank is what is of one colour to a hundredth of the map's mean, in all texels wholly outside the disc.
    """
    if not parameterization.is_round:
        return texels
    size = texels.shape[1]
    corners = parameterization.texel_solid_angle(size)[0] == 0.0
    if not corners.any() or np.ptp(texels[:, corners, :3], axis=(0, 1)).max() > 0.01 * texels[..., :3].mean():
        return texels
    return continued(parameterization, texels, outside_disc(parameterization, size))
