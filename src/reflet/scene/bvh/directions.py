"""Which way rays that leave a triangle may meet the mirrors again: most never do, and need not look.

Directions are divided into 8×8 cells of the octahedral parameterization. Rays are cast from random points of a triangle
through random directions of each cell above it, and below it where the back is seen; a cell where one of them meets
something counts together with the four beside it, and patches of neighbouring triangles share their answers: that makes
up for rays not cast, and bounds their number. Some 0.1 % of the rays that would meet something are missed so.
"""

import numpy as np
from jaxtyping import Bool, Float32, Int, UInt32
from numba import njit, prange

from reflet.envmap.parameterizations.compiled_parameterization import OCTAHEDRAL, direction_at
from reflet.envmap.parameterizations.octahedral import fold
from reflet.scene.bvh.bvh import MOST_DEPTH
from reflet.scene.bvh.closest_hit import trace
from reflet.scene.bvh.nodes import BvhNodes

CELLS = 8  # a side
OFFSET = np.float32(1e-5)  # a ray starts so far off its triangle, in units of the largest coordinate there
LEAST_CLIMB = 0.001  # of mirrored rays above their triangle
MOST_PATCHES = 2**11  # of two triangles at least
RAYS = 2**22  # at most so many are cast
MOST_RAYS = 64  # through a cell
NODES = 128  # so many a ray may be looked at; where that is spent, as among triangles that coincide, the rest counts


def direction_bits(
    nodes: BvhNodes,
    corners: Float32[np.ndarray, "met 3 3"],
    looks: Bool[np.ndarray, "met"],
    double_sided: Bool[np.ndarray, "met"],
) -> UInt32[np.ndarray, "met 2"]:
    """`Bvh.directions` of triangles in the order of the leaves; 0 where a triangle does not ``look``.

    A cell's number is 8·row + column of the map.
    """
    looking = np.flatnonzero(looks)
    patches = min((len(looking) + 1) // 2, MOST_PATCHES)
    starts = np.linspace(0, len(looking), patches + 1).astype(np.int64)
    rays = min(RAYS // (CELLS * CELLS * max(patches, 1)), MOST_RAYS)
    first, edges = np.ascontiguousarray(corners[:, 0]), corners[:, 1:] - corners[:, :1]
    found = np.zeros(len(corners), np.uint64)
    _cast(nodes.lower, nodes.upper, nodes.link, nodes.counts, first, edges, looking, starts, double_sided, rays, found)
    return np.stack([found & np.uint64(0xFFFFFFFF), found >> np.uint64(32)], axis=1).astype(np.uint32)


def _neighbours() -> Int[np.ndarray, "cells 4"]:
    """The four cells beside each, over the map's edges too."""
    row, column = np.indices((CELLS, CELLS)).reshape(2, -1, 1)
    row, column = fold(row + np.array([-1, 0, 0, 1]), column + np.array([0, -1, 1, 0]), CELLS)
    return CELLS * row + column


_BESIDE = _neighbours()


@njit(cache=True)
def _random(seed):  # type: ignore[no-untyped-def]
    """A number in [0, 1) that looks random, of a whole number [Steele14]."""
    z = np.uint64(seed) * np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return float((z ^ (z >> np.uint64(31))) >> np.uint64(11)) * 2.0**-53


@njit(cache=True, parallel=True, error_model="numpy")
def _cast(lower, upper, link, counts, first, edges, looking, starts, double_sided, rays, found):  # type: ignore[no-untyped-def]
    """Sets ``found`` of all triangles of ``looking``; patch p of them begins at ``starts[p]``."""
    for p in prange(len(starts) - 1):
        stack = np.empty(MOST_DEPTH, np.int64)
        o, d = np.empty(3, np.float32), np.empty(3, np.float32)
        begin, size = starts[p], starts[p + 1] - starts[p]
        met = np.zeros(CELLS * CELLS, np.bool_)
        left = CELLS * CELLS * rays * NODES
        for cell in range(CELLS * CELLS):
            for ray in range(rays):
                seed = ((p * CELLS * CELLS + cell) * rays + ray) * 5
                i = looking[begin + min(int(_random(seed) * size), size - 1)]
                u, v = (cell % CELLS + _random(seed + 1)) / CELLS, (cell // CELLS + _random(seed + 2)) / CELLS
                dx, dy, dz = direction_at(OCTAHEDRAL, 0, u, v)
                a, b = edges[i, 0], edges[i, 1]
                nx, ny, nz = a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
                length = np.sqrt(float(nx) * nx + float(ny) * ny + float(nz) * nz)
                climb = (dx * nx + dy * ny + dz * nz) / length
                side = 1.0 if climb > 0.0 else -1.0
                if not abs(climb) >= LEAST_CLIMB or (side < 0.0 and not double_sided[i]):
                    continue
                b1 = np.sqrt(_random(seed + 3))
                b2 = _random(seed + 4) * b1
                b1 = 1.0 - b1
                extent = 0.0
                for k in range(3):
                    o[k] = first[i, k] + b1 * a[k] + b2 * b[k]
                    extent = max(extent, abs(o[k]), abs(first[i, k]))
                away = side * extent * OFFSET / length
                o[0], o[1], o[2] = o[0] + away * nx, o[1] + away * ny, o[2] + away * nz
                d[0], d[1], d[2] = dx, dy, dz
                hit = trace(lower, upper, link, counts, first, edges, o, d, stack, True, left)
                left -= hit[4]
                if hit[0] >= 0 or left <= 0:
                    met[cell] = True
                    break
        bits = np.uint64(0)
        for cell in range(CELLS * CELLS):
            near = met[cell]
            for k in range(4):
                near = near or met[_BESIDE[cell, k]]
            if near:
                bits |= np.uint64(1) << np.uint64(cell)
        for m in range(begin, begin + size):
            found[looking[m]] = bits
