"""Normals and tangents computed at the corners of triangles, and meshes made by welding corners.

A triangle's corner k is row 3·triangle + k. Whatever differs between the corners that meet in a point (a crease, a seam
of the texture coordinates) simply differs by row; `weld` then shares vertices where nothing differs.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, Float32, Int, Integer

from reflet.scene.meshes.compiled_corners import equal_rows, smooth_fans
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
    if packed.dtype.itemsize % 4 or len(packed) >= 2**31:
        raise ValueError(f"{len(packed)} rows of {packed.dtype} cannot be compared")
    return equal_rows(packed.view(np.uint32).reshape(len(packed), packed.shape[1] * packed.itemsize // 4))


def crease_normals(corners: Corners3, crease_deg: float) -> Corners3:
    """Unit normals that are smooth over every edge where the faces turn by less than ``crease_deg`` degrees.

    0 gives flat faces. Each normal is the mean, weighted by the corners' angles, of the faces that are joined over
    smooth edges around the point.
    """
    if crease_deg <= 0.0:
        return np.repeat(face_normals(corners)[0], 3, axis=0)
    first, point = unique_rows(corners)
    count = len(corners) // 3
    limits = np.full(count, np.cos(np.radians(crease_deg)))
    fan, normals = smooth_fans(point, corners[first].astype(np.float64), np.zeros(count, np.int64), limits)
    return normals[fan]


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
    colors: Float[np.ndarray, "corners 4"] | None = None,
    more_uv: Sequence[Float[np.ndarray, "corners 2"]] = (),
) -> Mesh:
    """The mesh of these triangles, in their order, with one vertex for all corners that agree in every attribute."""
    columns = [np.asarray(c, np.float32) for c in (corners, normals, uv, tangents, colors, *more_uv) if c is not None]
    first, vertex = unique_rows(np.column_stack(columns))

    def pick(attribute: np.ndarray | None) -> np.ndarray | None:
        return None if attribute is None else np.ascontiguousarray(attribute[first], dtype=np.float32)

    positions: Float32[np.ndarray, "vertices 3"] = np.ascontiguousarray(corners[first], dtype=np.float32)
    shading = np.ascontiguousarray(normals[first], dtype=np.float32)
    triangles: Integer[np.ndarray, "triangles 3"] = vertex.reshape(-1, 3).astype(np.uint32)
    further = tuple(np.ascontiguousarray(values[first], dtype=np.float32) for values in more_uv)
    return Mesh(positions, shading, triangles, pick(uv), pick(tangents), pick(colors), further)
