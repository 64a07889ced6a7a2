"""The loop of `hemispheres.join_hemispheres`, compiled: means over many points of two blended round pictures.

`HemispherePicture` says in NumPy what one picture shows; tests hold the two to each other. A ``lens`` packs what tells
directions from pixels: middle column and row, pixels a unit of the projection's radius, radians from axis to edge,
number of the projection, the side on which +x is seen (1 for right, -1 for left), and the radius up to which pixels are
read.
"""

from math import atan2, ceil, hypot, sin, sqrt, tan

import numpy as np
from numba import njit, prange

from reflet.envmap.parameterizations.compiled_parameterization import direction_at, rate_at
from reflet.envmap.resampling.projections import EQUIDISTANT, EQUISOLID, STEREOGRAPHIC

RIM = 1.5  # pixels on the edge of a circle that are not read: they mix with the black around, as bilinear lookups do
_LEAST_BORDER = 1e-9  # radians: a border without width still divides


@njit(cache=True, error_model="numpy")
def _radius(projection, theta):  # type: ignore[no-untyped-def]
    """Distance from the middle at which the angle to the axis is seen."""
    if projection == EQUIDISTANT:
        return theta
    if projection == EQUISOLID:
        return sin(0.5 * theta)
    if projection == STEREOGRAPHIC:
        return tan(0.5 * theta)
    return sin(theta)


@njit(cache=True, error_model="numpy")
def _add(out, weight, pixels, lens, x, y, z):  # type: ignore[no-untyped-def]
    """Adds what a picture shows in a direction, bilinear, outside the circle as on its edge."""
    rows, columns, channels = pixels.shape
    across = hypot(x, y)
    ring = min(lens[2] * _radius(int(lens[4]), min(atan2(across, z), lens[3])), lens[6]) / max(across, 1e-12)
    u = min(max(lens[0] + ring * x * lens[5] - 0.5, 0.0), columns - 1.0)
    v = min(max(lens[1] - ring * y - 0.5, 0.0), rows - 1.0)
    left, top = min(int(u), max(columns - 2, 0)), min(int(v), max(rows - 2, 0))
    right, below = min(left + 1, columns - 1), min(top + 1, rows - 1)
    fu, fv = u - left, v - top
    for c in range(channels):
        upper = (1.0 - fu) * pixels[top, left, c] + fu * pixels[top, right, c]
        lower = (1.0 - fu) * pixels[below, left, c] + fu * pixels[below, right, c]
        out[c] += weight * ((1.0 - fv) * upper + fv * lower)


@njit(cache=True, error_model="numpy")
def _add_blended(out, front, front_lens, back, back_lens, front_from_back, blend, widest, gain, x, y, z):  # type: ignore[no-untyped-def]
    """Adds both pictures in a direction, the front one with weight alpha; ``blend`` below 0 is all both see."""
    r = front_from_back
    # the inverse of a rotation is its transpose
    bx = r[0, 0] * x + r[1, 0] * y + r[2, 0] * z
    by = r[0, 1] * x + r[1, 1] * y + r[2, 1] * z
    bz = r[0, 2] * x + r[1, 2] * y + r[2, 2] * z
    beyond_front = atan2(hypot(x, y), z) - front_lens[3]
    beyond_back = atan2(hypot(bx, by), bz) - back_lens[3]
    # Half way between the two edges alpha is 1/2; it changes over the width of the border. Where that is all both see,
    # it is 0 and 1 right on the edges.
    width = blend if blend >= 0.0 else min(-(beyond_front + beyond_back), widest)
    alpha = min(max(0.5 + (beyond_back - beyond_front) / (2.0 * max(width, _LEAST_BORDER)), 0.0), 1.0)
    if alpha > 0.0:
        _add(out, alpha, front, front_lens, x, y, z)
    if alpha < 1.0:
        _add(out, (1.0 - alpha) * gain, back, back_lens, bx, by, bz)


@njit(cache=True, parallel=True, error_model="numpy")
def join_into(texels, kind, front, front_lens, back, back_lens, front_from_back, blend, widest, gain, finest):  # type: ignore[no-untyped-def]
    """Fills ``texels`` with means over a square grid of points in each, half a pixel apart or less.

    Summed over such a grid each pixel's bilinear tent has the same weight to a per cent: energy is kept. ``finest`` is
    the most pixels per steradian. With an empty ``back`` the front picture is mirrored at the plane z = 0.
    """
    faces, rows, columns, channels = texels.shape
    mirrored = back.shape[0] == 0
    for line in prange(faces * rows):
        face, row = line // rows, line % rows
        total = np.empty(channels)
        for column in range(columns):
            x, y, z = direction_at(kind, face, (column + 0.5) / columns, (row + 0.5) / rows)
            density = max(rate_at(kind, x, y, z) * rows * rows, 1e-9)
            points = max(ceil(2.0 * sqrt(finest / density)), 1)
            total[:] = 0.0
            for i in range(points):
                for j in range(points):
                    u, v = (column + (j + 0.5) / points) / columns, (row + (i + 0.5) / points) / rows
                    x, y, z = direction_at(kind, face, u, v)
                    if mirrored:
                        _add(total, 1.0, front, front_lens, x, y, abs(z))
                    else:
                        _add_blended(
                            total, front, front_lens, back, back_lens, front_from_back, blend, widest, gain, x, y, z
                        )  # fmt: skip
            for c in range(channels):
                texels[face, row, column, c] = total[c] / (points * points)
