"""Whether two meshes come close to each other."""

import numba
import numpy as np
from jaxtyping import Float

from reflet.scene.mesh import Mesh

Triangles = Float[np.ndarray, "triangles 3 3"]


def touch(a: Mesh, b: Mesh, tolerance: float) -> bool:
    """True if any two triangles of the meshes intersect or come within ``tolerance`` metres of each other.

    Only triangles whose boxes meet the other mesh's box take part; they are swept along the axis of the widest spread.
    Near the tolerance the answer is exact: distances of triangles follow from those of their vertices and edges.
    """
    p, q = _near(a, b, tolerance), _near(b, a, tolerance)
    if not len(p) or not len(q):
        return False
    axis = int(np.argmax(np.maximum(np.ptp(p, axis=(0, 1)), np.ptp(q, axis=(0, 1)))))
    p = p[np.argsort(p[:, :, axis].min(axis=1))]
    q = q[np.argsort(q[:, :, axis].min(axis=1))]
    return bool(_sweep(p, q, axis, tolerance))


def _near(mesh: Mesh, other: Mesh, tolerance: float) -> Triangles:
    """The mesh's triangles whose boxes come within ``tolerance`` of the other mesh's box."""
    triangles = mesh.positions[mesh.triangles].astype(np.float64)
    low, high = other.positions.min(axis=0) - tolerance, other.positions.max(axis=0) + tolerance
    near = (triangles.min(axis=1) <= high).all(axis=1) & (triangles.max(axis=1) >= low).all(axis=1)
    return np.ascontiguousarray(triangles[near])


@numba.njit(cache=True)
def _sweep(p: Triangles, q: Triangles, axis: int, tolerance: float) -> bool:
    """Sweep and prune: both lists are ordered by their smallest coordinate along ``axis``."""
    reach = 0.0
    for j in range(len(q)):
        reach = max(reach, q[j, :, axis].max() - q[j, :, axis].min())
    begin = 0
    for i in range(len(p)):
        low, high = p[i, :, axis].min() - tolerance, p[i, :, axis].max() + tolerance
        while begin < len(q) and q[begin, :, axis].min() + reach < low:
            begin += 1
        for j in range(begin, len(q)):
            if q[j, :, axis].min() > high:
                break
            apart = False
            for k in range(3):
                if q[j, :, k].min() > p[i, :, k].max() + tolerance or q[j, :, k].max() < p[i, :, k].min() - tolerance:
                    apart = True
            if not apart and _close(p[i], q[j], tolerance):
                return True
    return False


@numba.njit(cache=True)
def _close(p: Float[np.ndarray, "3 3"], q: Float[np.ndarray, "3 3"], tolerance: float) -> bool:
    """Triangles are nearest to each other at two edges or at a vertex of one, if no edge of one pierces the other."""
    limit = tolerance * tolerance
    for i in range(3):
        if _to_triangle(p[i], q) <= limit or _to_triangle(q[i], p) <= limit:
            return True
        if _pierces(p[i], p[(i + 1) % 3], q) or _pierces(q[i], q[(i + 1) % 3], p):
            return True
        for j in range(3):
            if _between_edges(p[i], p[(i + 1) % 3], q[j], q[(j + 1) % 3]) <= limit:
                return True
    return False


@numba.njit(cache=True)
def _to_triangle(x: Float[np.ndarray, "3"], q: Float[np.ndarray, "3 3"]) -> float:
    """Squared distance of a point to the plane of a triangle where it lies above its inside, else infinity."""
    n = np.cross(q[1] - q[0], q[2] - q[0])
    for i in range(3):
        if np.dot(np.cross(q[(i + 1) % 3] - q[i], x - q[i]), n) < 0.0:
            return np.inf
    height = np.dot(x - q[0], n)
    return height * height / max(np.dot(n, n), 1e-300)


@numba.njit(cache=True)
def _pierces(a: Float[np.ndarray, "3"], b: Float[np.ndarray, "3"], q: Float[np.ndarray, "3 3"]) -> bool:
    """True if the segment from a to b crosses the triangle."""
    n = np.cross(q[1] - q[0], q[2] - q[0])
    from_a, from_b = np.dot(a - q[0], n), np.dot(b - q[0], n)
    if from_a * from_b > 0.0 or from_a == from_b:
        return False
    return _to_triangle(a + (b - a) * (from_a / (from_a - from_b)), q) < np.inf


@numba.njit(cache=True)
def _between_edges(
    a: Float[np.ndarray, "3"], b: Float[np.ndarray, "3"], c: Float[np.ndarray, "3"], d: Float[np.ndarray, "3"]
) -> float:
    """Squared distance of the segments a-b and c-d: minimized over one, clamped, then over the other, clamped again."""
    u, v, w = b - a, d - c, a - c
    uu, uv, vv = np.dot(u, u), np.dot(u, v), np.dot(v, v)
    uw, vw = np.dot(u, w), np.dot(v, w)
    determinant = uu * vv - uv * uv
    s = min(max((uv * vw - vv * uw) / determinant, 0.0), 1.0) if determinant > 1e-14 * uu * vv else 0.0
    t = min(max((uv * s + vw) / max(vv, 1e-300), 0.0), 1.0)
    s = min(max((uv * t - uw) / max(uu, 1e-300), 0.0), 1.0)
    gap = w + s * u - t * v
    return np.dot(gap, gap)
