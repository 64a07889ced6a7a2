"""Meshes out of placed vertices: turned to their fronts, with the normals and tangents that are missing."""

import numpy as np
from jaxtyping import Bool, Float32, UInt32

from reflet.scene.meshes.corners import corner_tangents, crease_normals, weld
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.readers.gltf.pose import Vertices

_BLOCK = 16384


def surface(
    vertices: Vertices,
    triangles: UInt32[np.ndarray, "triangles 3"],
    uv: Float32[np.ndarray, "vertices 2"] | None,
    bumpy: bool,
) -> Mesh:
    """The mesh, with flat normals and, where it is ``bumpy``, with tangents of its own making where it has none."""
    triangles = _facing(triangles, vertices.mirrored)
    if bumpy and uv is not None and vertices.tangents is None:
        corner = triangles.ravel()
        at = vertices.positions[corner]
        normals = crease_normals(at, 0.0) if vertices.normals is None else vertices.normals[corner].astype(np.float64)
        return weld(at, normals, uv[corner], corner_tangents(at, normals, uv[corner]))
    if vertices.normals is None:
        return _flat(vertices.positions, triangles, uv)
    return Mesh(vertices.positions, vertices.normals, triangles, uv, vertices.tangents)


def _facing(
    triangles: UInt32[np.ndarray, "triangles 3"], mirrored: bool | Bool[np.ndarray, "vertices"]
) -> UInt32[np.ndarray, "triangles 3"]:
    """Triangles turned over where their transform is mirrored, most of their corners' where it differs [glTF 2.0,
    3.7.4]."""
    turned = np.asarray(mirrored) if isinstance(mirrored, bool) else mirrored[triangles].sum(axis=1) >= 2
    return np.where(turned[..., None], triangles[:, ::-1], triangles) if turned.any() else triangles


def _flat(
    positions: Float32[np.ndarray, "vertices 3"],
    triangles: UInt32[np.ndarray, "triangles 3"],
    uv: Float32[np.ndarray, "vertices 2"] | None,
) -> Mesh:
    """Three vertices of its own for each triangle: faces that bend share none, and those that do not cost little."""
    at = np.empty((3 * len(triangles), 3), np.float32)
    normals = np.empty_like(at)
    for start in range(0, len(triangles), _BLOCK):
        block = slice(3 * start, 3 * (start + _BLOCK))
        at[block] = positions[triangles[start : start + _BLOCK].ravel()]
        normals[block] = crease_normals(at[block], 0.0)
    own = np.arange(len(at), dtype=np.uint32).reshape(-1, 3)
    return Mesh(at, normals, own, None if uv is None else uv[triangles.ravel()])
