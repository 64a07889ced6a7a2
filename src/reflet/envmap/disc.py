"""Areas of texels inside the unit disc, for the round maps."""

import numpy as np
from jaxtyping import Float


def corner_arcs(size: int) -> tuple[np.ndarray, ...]:
    """Of the rectangles from the origin to each texel corner (|x|, |y|) of a face over [-1, 1]²: where the disc ends.

    Returns (x, y, x_end, y_end, arc), each of shape (size + 1, size + 1), in the first quadrant: the edges of the
    rectangle's part inside the disc go up to x_end along the line at height y and up to y_end along the line at x;
    ``arc`` is the angle of the circle between the two.
    """
    edge = np.abs(2.0 * np.arange(size + 1) / size - 1.0)
    x, y = edge[None, :] + 0.0 * edge[:, None], edge[:, None] + 0.0 * edge[None, :]
    x_end = np.minimum(x, np.sqrt(np.maximum(1.0 - y * y, 0.0)))
    y_end = np.minimum(y, np.sqrt(np.maximum(1.0 - x * x, 0.0)))
    arc = np.where(x * x + y * y > 1.0, np.arctan2(y, x_end) - np.arctan2(y_end, x), 0.0)
    return x, y, x_end, y_end, np.maximum(arc, 0.0)


def texels_from_corners(corner: Float[np.ndarray, "corners corners"]) -> Float[np.ndarray, "size size"]:
    """What each texel holds, from what the rectangles from the origin to its corners hold (`corner_arcs`)."""
    size = len(corner) - 1
    sign = np.sign(2.0 * np.arange(size + 1) / size - 1.0)
    signed = corner * sign[:, None] * sign[None, :]
    texels = signed[1:, 1:] - signed[:-1, 1:] - signed[1:, :-1] + signed[:-1, :-1]
    return np.maximum(texels, 0.0)  # outside the disc rounding may leave less


def rectangle_in_disc(size: int) -> Float[np.ndarray, "size size"]:
    """Area of each texel of a face over [-1, 1]² inside the unit disc; the sum is π.

    By Green's theorem the area is ½∮(x·dy - y·dx) over the two straight edges and the arc.
    """
    x, y, x_end, y_end, arc = corner_arcs(size)
    return texels_from_corners(0.5 * (x * y_end + arc + y * x_end))
