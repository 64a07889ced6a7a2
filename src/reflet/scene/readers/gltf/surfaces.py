"""Meshes out of placed vertices: turned to their fronts, with the normals and tangents that are missing."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float32, UInt32

from reflet.scene.meshes.corners import corner_tangents, crease_normals, weld
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.readers.gltf.pose import Vertices

_BLOCK = 16384


@dataclass(frozen=True)
class Looks:
    """What a primitive's vertices have for its material: `Mesh.uv`, `Mesh.more_uv` and `Mesh.colors`."""

    uv: Float32[np.ndarray, "vertices 2"] | None
    more_uv: tuple[Float32[np.ndarray, "vertices 2"], ...]
    colors: Float32[np.ndarray, "vertices 4"] | None

    def at(self, vertices: UInt32[np.ndarray, "picked"]) -> "Looks":
        """Those of some vertices."""
        uv, colors = (None if values is None else values[vertices] for values in (self.uv, self.colors))
        return Looks(uv, tuple(uv[vertices] for uv in self.more_uv), colors)


def surface(vertices: Vertices, triangles: UInt32[np.ndarray, "triangles 3"], looks: Looks, bumps: int | None) -> Mesh:
    """The mesh, with flat normals and, where there are ``bumps`` by its texture coordinates of this number, with
    tangents of its own making where it has none."""
    triangles = _facing(triangles, vertices.mirrored)
    if bumps is not None and vertices.tangents is None:
        corner = triangles.ravel()
        at, here = vertices.positions[corner], looks.at(corner)
        normals = crease_normals(at, 0.0) if vertices.normals is None else vertices.normals[corner].astype(np.float64)
        along = (here.uv, *here.more_uv)[bumps]
        assert along is not None
        return weld(at, normals, here.uv, corner_tangents(at, normals, along), here.colors, here.more_uv)
    if vertices.normals is None:
        return _flat(vertices.positions, triangles, looks)
    tangents = vertices.tangents
    return Mesh(vertices.positions, vertices.normals, triangles, looks.uv, tangents, looks.colors, looks.more_uv)


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
    looks: Looks,
) -> Mesh:
    """Three vertices of its own for each triangle: faces that bend share none, and those that do not cost little."""
    at = np.empty((3 * len(triangles), 3), np.float32)
    normals = np.empty_like(at)
    for start in range(0, len(triangles), _BLOCK):
        block = slice(3 * start, 3 * (start + _BLOCK))
        at[block] = positions[triangles[start : start + _BLOCK].ravel()]
        normals[block] = crease_normals(at[block], 0.0)
    own = np.arange(len(at), dtype=np.uint32).reshape(-1, 3)
    here = looks.at(triangles.ravel())
    return Mesh(at, normals, own, here.uv, None, here.colors, here.more_uv)
