"""What must be done corner by corner, compiled: equal rows found, and faces joined over smooth edges."""

import numpy as np
from jaxtyping import Float, Int32, Int64
from numba import njit

_NEAR = 8  # faces at one edge that each is compared with


@njit(cache=True)
def _slot(words, row, table, first):
    """Where a row is in the hash table, or the free place where it belongs."""
    mixed = np.uint64(0x9E3779B97F4A7C15)
    for k in range(words.shape[1]):
        mixed = (mixed ^ np.uint64(words[row, k])) * np.uint64(0xFF51AFD7ED558CCD)
        mixed ^= mixed >> np.uint64(32)
    mask = np.uint64(len(table) - 1)
    slot = mixed & mask
    while table[slot] >= 0:
        other, equal = first[table[slot]], True
        for k in range(words.shape[1]):
            if words[row, k] != words[other, k]:
                equal = False
                break
        if equal:
            break
        slot = (slot + np.uint64(1)) & mask
    return slot


@njit(cache=True)
def equal_rows(words):
    """Of rows of 32-bit words: the first of each set of equal ones, in order of appearance, and the set of each row."""
    count, members = 0, np.empty(len(words), np.int32)
    first = np.empty(64, np.int32)
    table = np.full(256, -1, np.int32)
    for row in range(len(words)):
        if count == len(first):  # at most half of the table is ever taken
            larger = np.empty(2 * count, np.int32)
            larger[:count] = first
            first = larger
            table = np.full(4 * len(first), -1, np.int32)
            for known in range(count):
                table[_slot(words, first[known], table, first)] = known
        slot = _slot(words, row, table, first)
        if table[slot] < 0:
            table[slot] = count
            first[count] = row
            count += 1
        members[row] = table[slot]
    return first[:count].copy(), members


@njit(cache=True)
def _root(parent, corner):
    while parent[corner] != corner:
        parent[corner] = parent[parent[corner]]
        corner = parent[corner]
    return corner


@njit(cache=True)
def _corners_by_point(points, count):
    """Corners sorted by their points, and where each point's begin."""
    begin = np.zeros(count + 1, np.int64)
    for c in range(len(points)):
        begin[points[c] + 1] += 1
    for p in range(count):
        begin[p + 1] += begin[p]
    order, free = np.empty(len(points), np.int32), begin.copy()
    for c in range(len(points)):
        order[free[points[c]]] = c
        free[points[c]] += 1
    return order, begin


@njit(cache=True)
def _unit_normals(points, positions):
    normals = np.zeros((len(points) // 3, 3))
    for t in range(len(normals)):
        a, b, c = positions[points[3 * t]], positions[points[3 * t + 1]], positions[points[3 * t + 2]]
        ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
        vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
        x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        length = np.sqrt(x * x + y * y + z * z)
        if length > 0.0:
            normals[t, 0], normals[t, 1], normals[t, 2] = x / length, y / length, z / length
    return normals


@njit(cache=True)
def _angle(points, positions, corner):
    """The angle of a triangle's corner, in radians."""
    base, k = corner - corner % 3, corner % 3
    at = positions[points[corner]]
    p, q = positions[points[base + (k + 1) % 3]], positions[points[base + (k + 2) % 3]]
    ux, uy, uz = p[0] - at[0], p[1] - at[1], p[2] - at[2]
    vx, vy, vz = q[0] - at[0], q[1] - at[1], q[2] - at[2]
    x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    return np.arctan2(np.sqrt(x * x + y * y + z * z), ux * vx + uy * vy + uz * vz)


@njit(cache=True)
def _join(points, normals, labels, limits, count):
    """For each corner one of those it is joined with over smooth edges, the same for all of them."""
    order, begin = _corners_by_point(points, count)
    parent = np.empty(len(points), np.int32)
    for c in range(len(points)):
        parent[c] = c
    widest = 0
    for point in range(count):
        widest = max(widest, begin[point + 1] - begin[point])
    # the two edges that meet in each corner, by their other ends, chained by these: the newest first
    newest = np.full(count, -1, np.int32)
    older, corner_of = np.empty(2 * widest, np.int32), np.empty(2 * widest, np.int32)
    for point in range(count):
        n = 0
        for at in range(begin[point], begin[point + 1]):
            c = order[at]
            base, k, f = c - c % 3, c % 3, c // 3
            for side in (1, 2):
                end = points[base + (k + side) % 3]
                other = newest[end]
                for _ in range(_NEAR):
                    if other < 0:
                        break
                    d = corner_of[other]
                    g = d // 3
                    turn = normals[f, 0] * normals[g, 0] + normals[f, 1] * normals[g, 1] + normals[f, 2] * normals[g, 2]
                    if labels[f] == labels[g] and turn > max(limits[f], limits[g]):
                        parent[_root(parent, c)] = _root(parent, d)
                    other = older[other]
                older[n], corner_of[n], newest[end] = newest[end], c, n
                n += 1
        for at in range(begin[point], begin[point + 1]):
            c = order[at]
            base, k = c - c % 3, c % 3
            newest[points[base + (k + 1) % 3]] = -1
            newest[points[base + (k + 2) % 3]] = -1
    return parent


@njit(cache=True)
def _fans(points, positions, normals, parent):
    """A number for each joined set of corners, and the unit mean of its faces' normals, weighted by the angles."""
    fan, count = np.full(len(points), -1, np.int32), 0
    for c in range(len(points)):
        root = _root(parent, c)
        if fan[root] < 0:
            fan[root] = count
            count += 1
        fan[c] = fan[root]
    total = np.zeros((count, 3))
    for c in range(len(points)):
        weight = _angle(points, positions, c)
        for k in range(3):
            total[fan[c], k] += weight * normals[c // 3, k]
    cancelled = np.zeros(count, np.bool_)
    for f in range(count):
        length = np.sqrt(total[f, 0] ** 2 + total[f, 1] ** 2 + total[f, 2] ** 2)
        cancelled[f] = length <= 1e-12
        for k in range(3):
            total[f, k] /= 1.0 if cancelled[f] else length
    alone = 0
    for c in range(len(points)):
        alone += cancelled[fan[c]]
    if alone == 0:
        return fan, total
    means = np.empty((count + alone, 3))
    means[:count] = total
    for c in range(len(points)):
        if cancelled[fan[c]]:  # faces that cancel each other keep their own normals
            fan[c] = count
            means[count] = normals[c // 3]
            count += 1
    return fan, means


def smooth_fans(
    points: Int32[np.ndarray, "corners"],
    positions: Float[np.ndarray, "points 3"],
    labels: Int64[np.ndarray, "triangles"],
    limits: Float[np.ndarray, "triangles"],
) -> tuple[Int32[np.ndarray, "corners"], Float[np.ndarray, "fans 3"]]:
    """The corners of triangles joined around their points: the fan of each corner, and each fan's unit normal.

    ``points`` are indices into positions, three a triangle. Two faces are smooth over their common edge if their labels
    are equal and the cosine of their turn exceeds both their limits. A normal is the mean of the fan's faces weighted
    by the corners' angles; corners whose faces cancel each other have fans of their own, with their face's normal.
    """
    normals = _unit_normals(points, positions)
    parent = _join(points, normals, labels, limits, len(positions))
    return _fans(points, positions, normals, parent)
