"""Rays through the tree, compiled: the reference of ``shaders/bvh.wgsl``, with its arithmetic in float32."""

import numpy as np
from jaxtyping import Float32, Int64
from numba import njit, prange

from reflet.scene.bvh.bvh import MOST_DEPTH
from reflet.scene.bvh.nodes import BvhNodes

SMALL_COMPONENT = np.float32(1e-12)  # of directions: smaller ones are taken as this, so that slabs stay finite
SLACK = np.float32(1.0000004)  # of where a ray leaves a box: three roundings [Ize13]
_FAR = np.float32(3e38)
_ALL = 2**62


def closest_hits(
    nodes: BvhNodes,
    corners: Float32[np.ndarray, "met 3 3"],
    origins: Float32[np.ndarray, "rays 3"],
    directions: Float32[np.ndarray, "rays 3"],
) -> tuple[Int64[np.ndarray, "rays"], Float32[np.ndarray, "rays 3"]]:
    """The nearest triangle that each ray meets, in the order of the leaves, -1 for none; and (t, b1, b2) of the hit.

    Both sides of triangles count, those without area never. ``corners`` are in the order of the leaves.
    """
    first, edges = np.ascontiguousarray(corners[:, 0]), corners[:, 1:] - corners[:, :1]
    triangle, at = np.empty(len(origins), np.int64), np.empty((len(origins), 3), np.float32)
    _closest(nodes.lower, nodes.upper, nodes.link, nodes.counts, first, edges, origins, directions, triangle, at)
    return triangle, at


@njit(cache=True, error_model="numpy", inline="always")
def _enters(lower, upper, i, o, inverse, limit):  # type: ignore[no-untyped-def]
    """Distance to where a ray enters a node's box, `_FAR` where it does not before ``limit``."""
    near, far = np.float32(0.0), limit
    for k in range(3):
        a, b = (lower[i, k] - o[k]) * inverse[k], (upper[i, k] - o[k]) * inverse[k]
        near, far = max(near, min(a, b)), min(far, max(a, b) * SLACK)
    return near if near <= far else _FAR


@njit(cache=True, error_model="numpy")
def trace(lower, upper, link, counts, first, edges, o, d, stack, any_hit, most_nodes):  # type: ignore[no-untyped-def]
    """(triangle or -1, t, b1, b2, nodes looked at) of one ray; the first that is found if ``any_hit`` will do, or what
    was found when it had looked at ``most_nodes``. ``stack`` is scratch."""
    zero, one = np.float32(0.0), np.float32(1.0)
    best, t_best, b1_best, b2_best = np.int64(-1), _FAR, zero, zero
    inverse, seen = np.empty(3, np.float32), 1
    for k in range(3):
        inverse[k] = one / (d[k] if abs(d[k]) >= SMALL_COMPONENT else SMALL_COMPONENT)
    if len(counts) == 0 or _enters(lower, upper, 0, o, inverse, t_best) == _FAR:
        return best, t_best, b1_best, b2_best, seen
    top, node = 0, np.int64(0)
    while seen < most_nodes:
        if counts[node]:
            for i in range(link[node], link[node] + counts[node]):
                # [MoellerTrumbore97]
                e1, e2 = edges[i, 0], edges[i, 1]
                hx, hy, hz = d[1] * e2[2] - d[2] * e2[1], d[2] * e2[0] - d[0] * e2[2], d[0] * e2[1] - d[1] * e2[0]
                det = e1[0] * hx + e1[1] * hy + e1[2] * hz
                if det == zero:
                    continue
                inv = one / det
                wx, wy, wz = o[0] - first[i, 0], o[1] - first[i, 1], o[2] - first[i, 2]
                b1 = (wx * hx + wy * hy + wz * hz) * inv
                qx, qy, qz = wy * e1[2] - wz * e1[1], wz * e1[0] - wx * e1[2], wx * e1[1] - wy * e1[0]
                b2 = (d[0] * qx + d[1] * qy + d[2] * qz) * inv
                t = (e2[0] * qx + e2[1] * qy + e2[2] * qz) * inv
                if b1 >= zero and b2 >= zero and b1 + b2 <= one and zero < t < t_best:
                    best, t_best, b1_best, b2_best = np.int64(i), t, b1, b2
                    if any_hit:
                        return best, t_best, b1_best, b2_best, seen
        else:
            near, far = np.int64(node + 1), np.int64(link[node])
            t_near = _enters(lower, upper, near, o, inverse, t_best)
            t_far = _enters(lower, upper, far, o, inverse, t_best)
            seen += 2
            if t_far < t_near:
                near, far, t_near, t_far = far, near, t_far, t_near
            if t_near < _FAR:
                node = near
                if t_far < _FAR:
                    stack[top] = far
                    top += 1
                continue
        if top == 0:
            return best, t_best, b1_best, b2_best, seen
        top -= 1
        node = stack[top]
    return best, t_best, b1_best, b2_best, seen


@njit(cache=True, parallel=True, error_model="numpy")
def _closest(lower, upper, link, counts, first, edges, origins, directions, triangle, at):  # type: ignore[no-untyped-def]
    for i in prange(len(origins)):
        stack = np.empty(MOST_DEPTH, np.int64)
        found, t, b1, b2, _ = trace(
            lower, upper, link, counts, first, edges, origins[i], directions[i], stack, False, _ALL
        )
        triangle[i] = found
        at[i, 0], at[i, 1], at[i, 2] = t, b1, b2
