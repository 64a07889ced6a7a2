"""The loops of `spread_light`, compiled: sums over the directions around one, and what is put in their place.

Texels are walked tile by tile; tiles too far from the middle are left out, so that a small disc costs little in a large
map. Distances are chords |d - middle|, counted in steps of ``step``, the first half as wide as the others.
"""

from math import sqrt

import numpy as np
from numba import njit, prange

from reflet.envmap.parameterizations.compiled_parameterization import direction_at

TILE = 64  # rows and columns


@njit(cache=True, error_model="numpy")
def _apart(x, y, z, middle):  # type: ignore[no-untyped-def]
    return sqrt((x - middle[0]) ** 2 + (y - middle[1]) ** 2 + (z - middle[2]) ** 2)


@njit(cache=True, error_model="numpy")
def _is_near(kind, face, top, left, bottom, right, rows, columns, middle, reach):  # type: ignore[no-untyped-def]
    """Whether any texel of a tile may lie within ``reach`` of the middle: by the tile's own centre and extent."""
    x, y, z = direction_at(kind, face, 0.5 * (left + right) / columns, 0.5 * (top + bottom) / rows)
    extent = 0.0
    for row in (top, bottom):
        for column in (left, right):
            cx, cy, cz = direction_at(kind, face, column / columns, row / rows)
            extent = max(extent, sqrt((cx - x) ** 2 + (cy - y) ** 2 + (cz - z) ** 2))
    return _apart(x, y, z, middle) <= reach + 1.5 * extent  # tiles bulge, and are folded, between their corners


@njit(cache=True, parallel=True, error_model="numpy")
def sums_by_chord(texels, solid_angle, kind, middle, step, sums):  # type: ignore[no-untyped-def]
    """Adds to ``sums`` (strips, steps, 7): flux of three colours, solid angle, and the flux of all times direction.

    One strip for each row of tiles of each face.
    """
    faces, rows, columns = texels.shape[:3]
    reach = step * (sums.shape[1] - 0.5)
    strips = (rows + TILE - 1) // TILE
    for strip in prange(faces * strips):
        face, top = strip // strips, (strip % strips) * TILE
        bottom = min(top + TILE, rows)
        out = sums[strip]
        for left in range(0, columns, TILE):
            right = min(left + TILE, columns)
            if not _is_near(kind, face, top, left, bottom, right, rows, columns, middle, reach):
                continue
            for row in range(top, bottom):
                for column in range(left, right):
                    x, y, z = direction_at(kind, face, (column + 0.5) / columns, (row + 0.5) / rows)
                    at = int(_apart(x, y, z, middle) / step + 0.5)
                    if at >= out.shape[0]:
                        continue
                    omega = solid_angle[face, row, column]
                    all_colours = 0.0
                    for k in range(3):
                        flux = omega * texels[face, row, column, k]
                        out[at, k] += flux
                        all_colours += flux
                    out[at, 3] += omega
                    out[at, 4] += all_colours * x
                    out[at, 5] += all_colours * y
                    out[at, 6] += all_colours * z


@njit(cache=True, error_model="numpy")
def fill_disc(texels, kind, middle, step, last, colour):  # type: ignore[no-untyped-def]
    """Gives all texels up to step ``last`` one colour."""
    faces, rows, columns = texels.shape[:3]
    reach = step * (last + 0.5)
    for face in range(faces):
        for top in range(0, rows, TILE):
            bottom = min(top + TILE, rows)
            for left in range(0, columns, TILE):
                right = min(left + TILE, columns)
                if not _is_near(kind, face, top, left, bottom, right, rows, columns, middle, reach):
                    continue
                for row in range(top, bottom):
                    for column in range(left, right):
                        x, y, z = direction_at(kind, face, (column + 0.5) / columns, (row + 0.5) / rows)
                        if int(_apart(x, y, z, middle) / step + 0.5) <= last:
                            for k in range(3):
                                texels[face, row, column, k] = colour[k]


@njit(cache=True, parallel=True)
def power(texels, solid_angle):  # type: ignore[no-untyped-def]
    """∫ L dω by channel, in double precision: (channels,)."""
    faces, rows, columns, channels = texels.shape
    sums = np.zeros((faces * rows, channels))
    for line in prange(faces * rows):
        face, row = line // rows, line % rows
        for column in range(columns):
            omega = solid_angle[face, row, column]
            for k in range(channels):
                sums[line, k] += omega * texels[face, row, column, k]
    return sums.sum(0)
