"""Triangles on an object's convex hull: their fronts cannot see the object itself."""

import numpy as np
from jaxtyping import Bool

from reflet.scene.bounds import object_positions
from reflet.scene.meshes.convex_hull import all_behind, convex_hull
from reflet.scene.meshes.corners import face_normals
from reflet.scene.scene import Scene

TOLERANCE = 1e-4
"""How far, as a share of the object's diagonal, vertices may rise above a triangle's plane: what rounding and
tessellation leave of a convex surface."""


def hull_triangles(scene: Scene) -> Bool[np.ndarray, "triangles"]:
    """Flags the triangles (of all parts, in the scene's order) whose plane has their whole object on its back side.

    Such a triangle lies on the object's convex hull with its front outwards, and no ray that leaves the front can meet
    the object again [Hakura01, sec. 4]; conversely every triangle on the hull is found. Back faces and parts that do
    not reflect are never flagged, nor are double-sided parts: the inside of a thin shell sees the rest of it.
    """
    flags = np.zeros(scene.triangle_offsets[-1], bool)
    for index, item in enumerate(scene.objects):
        positions = object_positions(scene, index)
        limit = TOLERANCE * float(np.linalg.norm(np.ptp(positions, axis=0)))
        hull = convex_hull(positions)
        for p in item.parts:
            if scene.parts[p].material.double_sided:
                continue
            mesh = scene.parts[p].mesh
            corners = mesh.positions[mesh.triangles].astype(np.float64)
            normals, _ = face_normals(corners.reshape(-1, 3))
            heights = np.einsum("ti,tki->tk", normals, corners).min(axis=1)
            span = slice(scene.triangle_offsets[p], scene.triangle_offsets[p + 1])
            flags[span] = all_behind(hull, normals, heights + limit)
    return flags
