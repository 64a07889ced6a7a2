"""The lookup of `geometry`, `lod` and `texture_filter`, compiled: from a mirrored ray to eight weighted texels.

Scalar functions for use inside compiled loops, in float64. The NumPy modules say what is computed and why; tests hold
the two to each other.
"""

from math import floor, log2, sqrt

import numpy as np
from numba import njit

from reflet.envmap.cube import AXES
from reflet.envmap.geometry import BOX, HEMISPHERE, INFINITE_SPHERE, LEAST_HALF_CHORD

_AXES = np.ascontiguousarray(AXES)
_SMALL = 1e-12
_LEAST_SQUARE = LEAST_HALF_CHORD**2
_SMALLEST_RHO = 1e-6


@njit(cache=True, error_model="numpy")
def lookup_direction(g, px, py, pz, rx, ry, rz):  # type: ignore[no-untyped-def]
    """Direction that a ray from p along r looks up in a map of geometry ``g``, packed by `geometry.pack`."""
    kind = int(g[0])
    if kind == INFINITE_SPHERE:
        return rx, ry, rz
    if kind == BOX:
        rx = rx if abs(rx) >= _SMALL else _SMALL
        ry = ry if abs(ry) >= _SMALL else _SMALL
        rz = rz if abs(rz) >= _SMALL else _SMALL
        tx = max((g[1] - px) / rx, (g[5] - px) / rx)
        ty = max((g[2] - py) / ry, (g[6] - py) / ry)
        tz = max((g[3] - pz) / rz, (g[7] - pz) / rz)
        t = min(tx, ty, tz)
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
def face_of(x, y, z):  # type: ignore[no-untyped-def]
    """Index of the cube face that a direction meets."""
    if abs(x) >= abs(y) and abs(x) >= abs(z):
        return 0 if x >= 0.0 else 1
    if abs(y) >= abs(z):
        return 2 if y >= 0.0 else 3
    return 4 if z >= 0.0 else 5


@njit(cache=True, error_model="numpy")
def project(face, x, y, z):  # type: ignore[no-untyped-def]
    """(s, t) of a direction on the plane of a face, and whether it points to the plane's side at all."""
    axes = _AXES[face]
    major = x * axes[0, 0] + y * axes[0, 1] + z * axes[0, 2]
    scale = 1.0 / major if major > 0.0 else 0.0
    s = (x * axes[1, 0] + y * axes[1, 1] + z * axes[1, 2]) * scale
    t = (x * axes[2, 0] + y * axes[2, 1] + z * axes[2, 2]) * scale
    return s, t, major > 0.0


@njit(cache=True, error_model="numpy")
def place(g, position, direction, size, lod_bias, k):  # type: ignore[no-untyped-def]
    """(face, s, t, lod) of lookup ``k`` of a G-buffer's ``position`` and ``direction`` (three rays each)."""
    x, y, z = lookup_direction(
        g, position[0, k, 0], position[0, k, 1], position[0, k, 2],
        direction[0, k, 0], direction[0, k, 1], direction[0, k, 2],
    )  # fmt: skip
    face = face_of(x, y, z)
    s, t, _ = project(face, x, y, z)
    furthest = 0.0
    for j in range(1, 3):
        x, y, z = lookup_direction(
            g, position[j, k, 0], position[j, k, 1], position[j, k, 2],
            direction[j, k, 0], direction[j, k, 1], direction[j, k, 2],
        )  # fmt: skip
        s_next, t_next, ahead = project(face, x, y, z)
        distance = (s_next - s) ** 2 + (t_next - t) ** 2
        furthest = max(furthest, distance if ahead else np.inf)
    rho = max(sqrt(furthest) * 0.5 * size, _SMALLEST_RHO)
    coarsest = log2(size)
    return face, s, t, min(max(log2(rho) + lod_bias, 0.0), coarsest)


@njit(cache=True, error_model="numpy")
def taps_into(indices, weights, table, starts, size, level_count, face, s, t, lod):  # type: ignore[no-untyped-def]
    """Writes the eight texel indices and weights of one lookup; ``table`` and ``starts`` from `padded_index_table`."""
    finer = min(floor(lod), max(level_count - 2, 0))
    fraction = lod - finer
    for k in range(2):
        level = min(finer + k, level_count - 1)
        level_weight = fraction if k else 1.0 - fraction
        n = size >> level
        x, y = (s + 1.0) * 0.5 * n - 0.5, (t + 1.0) * 0.5 * n - 0.5
        column, row = min(max(floor(x), -1), n - 1), min(max(floor(y), -1), n - 1)
        fx, fy = x - column, y - row
        at = starts[level] + (face * (n + 2) + row + 1) * (n + 2) + column + 1
        first = 4 * k
        indices[first], indices[first + 1] = table[at], table[at + 1]
        indices[first + 2], indices[first + 3] = table[at + n + 2], table[at + n + 3]
        weights[first], weights[first + 1] = (1.0 - fx) * (1.0 - fy) * level_weight, fx * (1.0 - fy) * level_weight
        weights[first + 2], weights[first + 3] = (1.0 - fx) * fy * level_weight, fx * fy * level_weight
        for missing in range(first, first + 4):
            if indices[missing] < 0:
                share = weights[missing] / 3.0
                for other in range(first, first + 4):
                    weights[other] += share
                # Any of the others may stand in for the index.
                indices[missing], weights[missing] = indices[first + (missing - first + 1) % 4], 0.0
