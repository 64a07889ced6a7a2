"""Normals and tangents computed at the corners of triangles, and meshes made by welding corners.

A triangle's corner k is row 3·triangle + k. Whatever differs between the corners that meet in a point (a crease, a seam
of the texture coordinates) simply differs by row; `weld` then shares vertices where nothing differs.
"""

import numpy as np
from jaxtyping import Float, Float32, Int, Integer
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from reflet.scene.meshes.mesh import Mesh

Corners3 = Float[np.ndarray, "corners 3"]


def face_normals(corners: Corners3) -> tuple[Float[np.ndarray, "triangles 3"], Float[np.ndarray, "triangles"]]:
    """Unit normals (zero for degenerate triangles) and areas of the triangles; counter-clockwise is the front."""
    triangle = corners.reshape(-1, 3, 3).astype(np.float64)
    cross = np.cross(triangle[:, 1] - triangle[:, 0], triangle[:, 2] - triangle[:, 0])
    length = np.linalg.norm(cross, axis=1)
    return cross / np.where(length > 0.0, length, 1.0)[:, None], 0.5 * length


def _corner_angles(corners: Corners3) -> Float[np.ndarray, "corners"]:
    triangle = corners.reshape(-1, 3, 3).astype(np.float64)
    to_next, to_last = np.roll(triangle, -1, axis=1) - triangle, np.roll(triangle, 1, axis=1) - triangle
    cross = np.linalg.norm(np.cross(to_next, to_last), axis=2)
    return np.arctan2(cross, np.einsum("tki,tki->tk", to_next, to_last)).ravel()


def unique_rows(rows: np.ndarray) -> tuple[Int[np.ndarray, "unique"], Int[np.ndarray, "rows"]]:
    """Index of the first of each set of bitwise equal rows, in order of appearance, and the set of every row."""
    packed = np.ascontiguousarray(rows + 0.0 if rows.dtype.kind == "f" else rows)  # + 0.0 turns -0.0 into 0.0
    keys = packed.view(np.dtype((np.void, packed.dtype.itemsize * packed.shape[1]))).ravel()
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return first[order], rank[inverse]


def crease_normals(corners: Corners3, crease_deg: float) -> Corners3:
    """Unit normals that are smooth over every edge where the faces turn by less than ``crease_deg`` degrees.

    0 gives flat faces. Each normal is the mean, weighted by the corners' angles, of the faces that are joined over
    smooth edges around the point.
    """
    normals, _ = face_normals(corners)
    by_corner = np.repeat(normals, 3, axis=0)
    if crease_deg <= 0.0:
        return by_corner
    _, point = unique_rows(corners)
    count = len(corners)
    a = np.arange(count)
    b = np.where(a % 3 == 2, a - 2, a + 1)  # edges run from each corner a to the triangle's next corner b
    low, high = np.minimum(point[a], point[b]), np.maximum(point[a], point[b])
    order = np.lexsort((high, low))
    same = (low[order[1:]] == low[order[:-1]]) & (high[order[1:]] == high[order[:-1]])
    e, f = order[:-1][same], order[1:][same]  # corners whose edges join the same two points
    smooth = np.einsum("ei,ei->e", normals[e // 3], normals[f // 3]) > np.cos(np.radians(crease_deg))
    e, f = e[smooth], f[smooth]
    # faces wound alike run along a shared edge in opposite directions: a of one meets b of the other
    opposite = point[a[e]] == point[b[f]]
    start, end = np.where(opposite, b[f], f), np.where(opposite, f, b[f])
    links = (np.concatenate([e, b[e]]), np.concatenate([start, end]))
    graph = coo_matrix((np.ones(len(links[0]), np.int8), links), shape=(count, count))
    _, fan = connected_components(graph, directed=False)
    weighted = by_corner * _corner_angles(corners)[:, None]
    total = np.stack([np.bincount(fan, weighted[:, i]) for i in range(3)], axis=1)[fan]
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return np.where(length > 1e-12, total / np.maximum(length, 1e-12), by_corner)


def corner_tangents(
    corners: Corners3, normals: Corners3, uv: Float[np.ndarray, "corners 2"]
) -> Float[np.ndarray, "corners 4"]:
    """Tangents along +u with glTF's handedness in the fourth component: bitangent = w·cross(normal, tangent).

    As MikkTSpace does: faces that share a point, normal and uv there, and are mapped with the same orientation, share
    the mean of their tangents, each projected into the normal's plane and weighted by the corner's angle. (The original
    also parts faces that meet in the point alone.) Where the mapping is degenerate any perpendicular vector stands in.

    With edges e1, e2 and their (du, dv): dP/du ∝ dv2·e1 - dv1·e2, times the sign of the mapped area. glTF's v runs
    down the image while a normal map's green points up it, so that an unmirrored mapping (drawn right way round, its
    area clockwise in (u, v)) has bitangent -dP/dv and w = +1.
    """
    p = corners.reshape(-1, 3, 3).astype(np.float64)
    t = uv.reshape(-1, 3, 2).astype(np.float64)
    e1, e2 = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
    (du1, dv1), (du2, dv2) = (t[:, 1] - t[:, 0]).T, (t[:, 2] - t[:, 0]).T
    orientation = np.sign(du1 * dv2 - du2 * dv1)
    along_u = np.repeat((dv2[:, None] * e1 - dv1[:, None] * e2) * orientation[:, None], 3, axis=0)
    n = normals.astype(np.float64)
    along_u -= n * np.einsum("ci,ci->c", along_u, n)[:, None]
    length = np.linalg.norm(along_u, axis=1, keepdims=True)
    along_u = np.where(length > 1e-20, along_u / np.maximum(length, 1e-20), 0.0) * _corner_angles(corners)[:, None]
    handedness = np.where(np.repeat(orientation, 3) > 0.0, -1.0, 1.0)
    keys = np.column_stack([corners, normals, uv, handedness]).astype(np.float32)
    _, group = unique_rows(keys)
    total = np.stack([np.bincount(group, along_u[:, i]) for i in range(3)], axis=1)[group]
    length = np.linalg.norm(total, axis=1, keepdims=True)
    axis = np.eye(3)[np.abs(n).argmin(axis=1)]
    fallback = np.cross(n, axis)
    fallback /= np.maximum(np.linalg.norm(fallback, axis=1, keepdims=True), 1e-20)
    tangent = np.where(length > 1e-12, total / np.maximum(length, 1e-12), fallback)
    return np.column_stack([tangent, handedness])


def weld(
    corners: Corners3,
    normals: Corners3,
    uv: Float[np.ndarray, "corners 2"] | None = None,
    tangents: Float[np.ndarray, "corners 4"] | None = None,
) -> Mesh:
    """The mesh of these triangles, in their order, with one vertex for all corners that agree in every attribute."""
    columns = [np.asarray(c, np.float32) for c in (corners, normals, uv, tangents) if c is not None]
    first, vertex = unique_rows(np.column_stack(columns))

    def pick(attribute: np.ndarray | None) -> np.ndarray | None:
        return None if attribute is None else np.ascontiguousarray(attribute[first], dtype=np.float32)

    positions: Float32[np.ndarray, "vertices 3"] = np.ascontiguousarray(corners[first], dtype=np.float32)
    shading = np.ascontiguousarray(normals[first], dtype=np.float32)
    triangles: Integer[np.ndarray, "triangles 3"] = vertex.reshape(-1, 3).astype(np.uint32)
    return Mesh(positions, shading, triangles, pick(uv), pick(tangents))
