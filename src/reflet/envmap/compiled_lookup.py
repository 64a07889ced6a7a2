"""The lookup of `geometry`, `relief`, `lod` and `texture_filter`, compiled: from a ray to eight weighted texels.

Scalar functions for use inside compiled loops, in float64. The NumPy modules say what is computed and why; tests hold
the two to each other.
"""

from math import floor, log2, pi, sqrt

import numpy as np
from numba import njit

from reflet.envmap.geometry import BOX, HEMISPHERE, INFINITE_SPHERE, RELIEF, Geometry, pack
from reflet.envmap.parameterizations.compiled_parameterization import CUBE, face_of, point_of, project, rate_at
from reflet.envmap.relief import FETCHES, FLAT, SETTLED, STEP, Relief
from reflet.envmap.shapes import LEAST_HALF_CHORD

_SMALL = 1e-12
_LEAST_SQUARE = LEAST_HALF_CHORD**2
_SMALLEST_RHO = 1e-6
EVEN_CUBE = (2.0 / pi) ** 2  # texels a steradian of a cube of size 1 whose texels were π/2 of its rows apart
STEEP = 0.9  # |y| of rays that are tilted from +x, not from +y


def compiled_geometry(geometry: Geometry) -> tuple[np.ndarray, np.ndarray]:
    """What the functions below take for a geometry: its twelve numbers, and a relief's padded faces (else one zero)."""
    faces = geometry.padded if isinstance(geometry, Relief) else np.zeros((6, 3, 3))
    return pack(geometry).astype(np.float64), faces


@njit(cache=True, error_model="numpy")
def _box_exit(g, px, py, pz, rx, ry, rz):  # type: ignore[no-untyped-def]
    """t where a ray leaves the box, and the ray with no component too small."""
    rx = rx if abs(rx) >= _SMALL else _SMALL
    ry = ry if abs(ry) >= _SMALL else _SMALL
    rz = rz if abs(rz) >= _SMALL else _SMALL
    tx = max((g[1] - px) / rx, (g[5] - px) / rx)
    ty = max((g[2] - py) / ry, (g[6] - py) / ry)
    tz = max((g[3] - pz) / rz, (g[7] - pz) / rz)
    return min(tx, ty, tz), rx, ry, rz


@njit(cache=True, error_model="numpy")
def lookup_direction(g, px, py, pz, rx, ry, rz):  # type: ignore[no-untyped-def]
    """Direction that a ray from p along r looks up in a map of one of the `shapes`, packed by `geometry.pack`."""
    kind = int(g[0])
    if kind == INFINITE_SPHERE:
        return rx, ry, rz
    if kind == BOX:
        t, rx, ry, rz = _box_exit(g, px, py, pz, rx, ry, rz)
        return px + t * rx - g[9], py + t * ry - g[10], pz + t * rz - g[11]
    qx, qy, qz = (px - g[1]) / g[5], (py - g[2]) / g[6], (pz - g[3]) / g[7]
    vx, vy, vz = rx / g[5], ry / g[6], rz / g[7]
    a = vx * vx + vy * vy + vz * vz
    b = qx * vx + qy * vy + qz * vz
    c = qx * qx + qy * qy + qz * qz - 1.0
    t = max((-b + sqrt(max(b * b - a * c, _LEAST_SQUARE * a))) / a, 0.0)
    if kind == HEMISPHERE:
        if ry < -_SMALL:
            t = min(t, max((g[4] - py) / ry, 0.0))
        return px + t * rx - g[9], py + t * ry - g[10], pz + t * rz - g[11]
    return (
        qx + t * vx + (g[1] - g[9]) / g[5],
        qy + t * vy + (g[2] - g[10]) / g[6],
        qz + t * vz + (g[3] - g[11]) / g[7],
    )


@njit(cache=True, error_model="numpy")
def _fetch(faces, x, y, z):  # type: ignore[no-untyped-def]
    """`relief.fetch`."""
    face = face_of(x, y, z)
    s, t, _ = project(face, x, y, z)
    size = faces.shape[1] - 2
    x, y = (0.5 + 0.5 * s) * size - 0.5, (0.5 + 0.5 * t) * size - 0.5
    column, row = min(max(floor(x), -1), size - 1), min(max(floor(y), -1), size - 1)
    fx, fy = x - column, y - row
    i, j = row + 1, column + 1
    upper = faces[face, i, j] * (1.0 - fx) + faces[face, i, j + 1] * fx
    lower = faces[face, i + 1, j] * (1.0 - fx) + faces[face, i + 1, j + 1] * fx
    return upper * (1.0 - fy) + lower * fy


@njit(cache=True, error_model="numpy")
def _along(faces, ax, ay, az, rx, ry, rz, w):  # type: ignore[no-untyped-def]
    x, y, z = rx + w * ax, ry + w * ay, rz + w * az
    return max(abs(x), abs(y), abs(z)) * _fetch(faces, x, y, z)


@njit(cache=True, error_model="numpy")
def inverse_hit(g, faces, px, py, pz, rx, ry, rz):  # type: ignore[no-untyped-def]
    """`Relief.inverse_hit` of one ray."""
    ax, ay, az = px - g[9], py - g[10], pz - g[11]
    limit = g[4]
    t, _, _, _ = _box_exit(g, px, py, pz, rx, ry, rz)
    low, high = 0.0, limit
    before = 1.0 / t if t * limit > 1.0 else limit
    m_before = _along(faces, ax, ay, az, rx, ry, rz, before)
    if m_before > before:
        low = before
    else:
        high = before
    w = min(m_before, limit)
    for _ in range(FETCHES - 1):
        m = _along(faces, ax, ay, az, rx, ry, rz, w)
        if m > w:
            low = max(low, w)
        else:
            high = min(high, w)
        change = (m - m_before) - (w - before)
        after = m if abs(change) <= FLAT * limit else w - (m - w) * (w - before) / change
        settled = abs(w - before) <= SETTLED * w
        before, m_before = w, m
        if settled:
            continue
        slack = SETTLED * w
        if not (low - slack <= after <= high + slack) and abs(after - w) > slack:
            after = 0.5 * (low + high) if high < limit else 2.0 * low + STEP * limit
        w = min(max(after, 0.0), limit)
    return w


@njit(cache=True, error_model="numpy")
def _met(g, w, px, py, pz, rx, ry, rz):  # type: ignore[no-untyped-def]
    """Lookup direction of a ray; ``w`` is the inverse hit of its lookup's first ray where ``g`` is a relief."""
    if int(g[0]) == RELIEF:
        return rx + w * (px - g[9]), ry + w * (py - g[10]), rz + w * (pz - g[11])
    return lookup_direction(g, px, py, pz, rx, ry, rz)


@njit(cache=True, error_model="numpy")
def tilted(rx, ry, rz, spread):  # type: ignore[no-untyped-def]
    """Two unit rays at an angle from r, whose sine is ``spread``, in directions perpendicular to each other."""
    if abs(ry) < STEEP:
        tx, ty, tz = -rz, 0.0, rx
    else:
        tx, ty, tz = 0.0, rz, -ry
    scale = spread / sqrt(tx * tx + ty * ty + tz * tz)
    tx, ty, tz = tx * scale, ty * scale, tz * scale
    bx, by, bz = ry * tz - rz * ty, rz * tx - rx * tz, rx * ty - ry * tx
    c = sqrt(1.0 - spread * spread)
    return (c * rx + tx, c * ry + ty, c * rz + tz), (c * rx + bx, c * ry + by, c * rz + bz)


@njit(cache=True, error_model="numpy")
def _squared_gap(kind, face, x, y, z, a, b, c):  # type: ignore[no-untyped-def]
    """From a lookup to a neighbour in direction (a, b, c): on the lookup's cube face, where (x, y) are its s and t;
    else between unit vectors."""
    if kind == CUBE:
        s, t, ahead = project(face, a, b, c)
        return (s - x) ** 2 + (t - y) ** 2 if ahead else np.inf
    scale = 1.0 / sqrt(a * a + b * b + c * c)
    return (a * scale - x) ** 2 + (b * scale - y) ** 2 + (c * scale - z) ** 2


@njit(cache=True, error_model="numpy")
def place(kind, g, faces, map_from_world, position, direction, spread, size, lod_bias, k):  # type: ignore[no-untyped-def]
    """(face, u, v, lod) of lookup ``k`` of a G-buffer's ``position``, ``direction`` (three rays each) and ``spread``.

    ``kind`` is the parameterization's, ``g`` and ``faces`` the geometry (`compiled_geometry`), ``map_from_world`` the
    rotation into the map's frame (of cubes the world's, whatever it says), ``size`` the map's rows at its finest level.
    """
    px, py, pz = position[0, k, 0], position[0, k, 1], position[0, k, 2]
    rx, ry, rz = float(direction[0, k, 0]), float(direction[0, k, 1]), float(direction[0, k, 2])
    w = inverse_hit(g, faces, px, py, pz, rx, ry, rz) if int(g[0]) == RELIEF else 0.0
    x, y, z = _met(g, w, px, py, pz, rx, ry, rz)
    if kind == CUBE:
        face = face_of(x, y, z)
        s, t, _ = project(face, x, y, z)
        u, v = 0.5 + 0.5 * s, 0.5 + 0.5 * t
        x, y, z, texels = s, t, 0.0, 0.25 * size * size
    else:
        scale = 1.0 / sqrt(x * x + y * y + z * z)
        x, y, z = x * scale, y * scale, z * scale
        m = map_from_world
        turned_x = m[0, 0] * x + m[0, 1] * y + m[0, 2] * z
        turned_y = m[1, 0] * x + m[1, 1] * y + m[1, 2] * z
        turned_z = m[2, 0] * x + m[2, 1] * y + m[2, 2] * z
        face, u, v = point_of(kind, turned_x, turned_y, turned_z)
        texels = rate_at(kind, turned_x, turned_y, turned_z) * size * size
    furthest = 0.0  # squared distance of a neighbour
    for j in range(1, 3):
        a, b, c = _met(
            g, w, position[j, k, 0], position[j, k, 1], position[j, k, 2],
            direction[j, k, 0], direction[j, k, 1], direction[j, k, 2],
        )  # fmt: skip
        furthest = max(furthest, _squared_gap(kind, face, x, y, z, a, b, c))
    lod = log2(max(sqrt(furthest * texels), _SMALLEST_RHO)) + lod_bias
    if spread[k] > 0.0:
        squared = 1.0  # distances of both tilted rays, multiplied
        x, y, z = _met(g, w, px, py, pz, rx, ry, rz)
        scale = 1.0 / sqrt(x * x + y * y + z * z)
        for ray in tilted(rx, ry, rz, spread[k]):
            a, b, c = _met(g, w, px, py, pz, ray[0], ray[1], ray[2])
            squared *= _squared_gap(-1, face, x * scale, y * scale, z * scale, a, b, c)
        if kind == CUBE:
            texels = EVEN_CUBE * size * size
        lod = max(lod, log2(max(sqrt(sqrt(squared) * texels), _SMALLEST_RHO)))
    return face, u, v, min(max(lod, 0.0), log2(size))


@njit(cache=True, error_model="numpy")
def taps_into(indices, weights, table, starts, aspect, size, level_count, face, u, v, lod):  # type: ignore[no-untyped-def]
    """Writes the eight texel indices and weights of one lookup; ``table`` and ``starts`` from `padded_index_table`.

    ``aspect`` is the parameterization's: columns over rows.
    """
    finer = min(floor(lod), max(level_count - 2, 0))
    fraction = lod - finer
    for k in range(2):
        level = min(finer + k, level_count - 1)
        level_weight = fraction if k else 1.0 - fraction
        rows = size >> level
        columns = aspect * rows
        x, y = u * columns - 0.5, v * rows - 0.5
        column, row = min(max(floor(x), -1), columns - 1), min(max(floor(y), -1), rows - 1)
        fx, fy = x - column, y - row
        width = columns + 2
        at = starts[level] + (face * (rows + 2) + row + 1) * width + column + 1
        first = 4 * k
        indices[first], indices[first + 1] = table[at], table[at + 1]
        indices[first + 2], indices[first + 3] = table[at + width], table[at + width + 1]
        weights[first], weights[first + 1] = (1.0 - fx) * (1.0 - fy) * level_weight, fx * (1.0 - fy) * level_weight
        weights[first + 2], weights[first + 3] = (1.0 - fx) * fy * level_weight, fx * fy * level_weight
        for missing in range(first, first + 4):
            if indices[missing] < 0:
                share = weights[missing] / 3.0
                for other in range(first, first + 4):
                    weights[other] += share
                # Any of the others may stand in for the index.
                indices[missing], weights[missing] = indices[first + (missing - first + 1) % 4], 0.0
