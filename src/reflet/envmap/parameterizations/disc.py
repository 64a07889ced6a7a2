"""What the round maps share: areas of texels inside the unit disc, and neighbours over its rim."""

import numpy as np
from jaxtyping import Float

from reflet.envmap.parameterizations.parameterization import Faces

Corners = Float[np.ndarray, "half half"]


def corner_arcs(size: int) -> tuple[Corners, Corners, Corners, Corners, Corners]:
    """Of the rectangles from the origin to each texel corner (x, y) of a face over [-1, 1]²: where the disc ends.

    Returns (x, y, x_end, y_end, arc) for the corners of the first quadrant, rows of one y: the edges of the rectangle's
    part inside the disc go up to x_end along the line at height y and up to y_end along the line at x; ``arc`` is the
    angle of the circle between the two.
    """
    edge = _edges(size)
    y, x = np.meshgrid(edge, edge, indexing="ij")
    x_end = np.minimum(x, np.sqrt(1.0 - y * y))
    y_end = x_end.T
    arc = np.where(x * x + y * y > 1.0, np.arctan2(y, x_end) - np.arctan2(y_end, x), 0.0)
    return x, y, x_end, y_end, np.maximum(arc, 0.0)


def texels_from_corners(corner: Corners, size: int) -> Float[np.ndarray, "size size"]:
    """What each texel holds, from what the rectangles from the origin to its corners hold (`corner_arcs`)."""
    # The integral from the origin is odd in either coordinate.
    index = np.arange(size // 2 + 1)
    sign = np.concatenate([-np.ones(len(index)), np.ones(len(index))])
    index = np.concatenate([index[::-1], index])
    if size % 2 == 0:
        sign, index = np.delete(sign, size // 2), np.delete(index, size // 2)
    signed = corner[np.ix_(index, index)] * sign * sign[:, None]
    texels = np.diff(np.diff(signed, axis=0), axis=1)
    nearest = np.abs(2.0 * np.arange(size) + 1.0 - size) - 1.0  # of a texel's two edges, in half texels
    inside = np.maximum(nearest, 0.0) ** 2 + np.maximum(nearest, 0.0)[:, None] ** 2 < size**2
    # Differences of large sums: outside the disc, and at its rim, rounding may leave some 1e-16.
    return np.where(inside, np.maximum(texels, 0.0), 0.0)


def rectangle_in_disc(size: int) -> Float[np.ndarray, "size size"]:
    """Area of each texel of a face over [-1, 1]² inside the unit disc; the sum is π.

    By Green's theorem the area is ½∮(x·dy - y·dx) over the two straight edges and the arc.
    """
    x, y, x_end, y_end, arc = corner_arcs(size)
    return texels_from_corners(0.5 * (x * y_end + arc + y * x_end), size)


def over_the_rim(row: Faces, column: Faces, size: int) -> tuple[Faces, Faces]:
    """Texels at places up to one texel outside a face whose whole rim is one direction.

    A path that leaves the disc at radius r > 1 has passed that direction and comes back on the other side, at radius
    2 - r. Places inside the face are returned as they are.
    """
    x, y = (2.0 * column + 1.0) / size - 1.0, (2.0 * row + 1.0) / size - 1.0
    outside = np.maximum(np.abs(x), np.abs(y)) > 1.0
    radius = np.where(outside, np.hypot(x, y), 1.0)
    scale = 1.0 - 2.0 / radius
    column_on, row_on = (
        np.clip(np.floor((c * scale + 1.0) * (0.5 * size)).astype(np.int64), 0, size - 1) for c in (x, y)
    )
    return np.where(outside, row_on, row), np.where(outside, column_on, column)


def _edges(size: int) -> Float[np.ndarray, "half"]:
    """Texel edges at and above 0; of odd sizes, where 0 lies amid a texel, those beside it count as one."""
    return (2.0 * np.arange(size // 2 + 1) + size % 2) / size
