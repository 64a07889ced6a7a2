"""Cutting a mesh's triangles into smaller ones."""

import numpy as np

from reflet.scene.meshes.corners import weld
from reflet.scene.meshes.mesh import Mesh


def tessellated(mesh: Mesh, longest_edge: float) -> Mesh:
    """The same surface in triangles none of whose edges is longer than ``longest_edge``, in metres.

    All triangles are cut alike, into n² of a grid, so that no cracks open between them; normals, texture
    coordinates and colours are interpolated, tangents left out.
    """
    corners = mesh.positions[mesh.triangles].astype(np.float64)
    longest = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=-1).max()
    n = max(int(np.ceil(longest / longest_edge)), 1)
    barycentric = _grid(n)

    def cut(attribute: np.ndarray) -> np.ndarray:
        return np.einsum("gk,tkc->tgc", barycentric, attribute[mesh.triangles]).reshape(-1, attribute.shape[-1])

    normals = cut(mesh.normals)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    uv, colors = (None if values is None else cut(values) for values in (mesh.uv, mesh.colors))
    return weld(cut(mesh.positions), normals, uv, None, colors, [cut(values) for values in mesh.more_uv])


def _grid(n: int) -> np.ndarray:
    """Barycentric coordinates of the corners of n² triangles in one: n(n + 1)/2 that stand as it does, the rest upside
    down."""
    i, j = (x.ravel() for x in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    upright = i + j < n
    inverted = i + j < n - 1
    a = [np.stack([i + di, j + dj], -1)[upright] for di, dj in ((0, 0), (1, 0), (0, 1))]
    b = [np.stack([i + di, j + dj], -1)[inverted] for di, dj in ((1, 1), (0, 1), (1, 0))]
    second_and_third = np.concatenate([np.stack(a, 1), np.stack(b, 1)]).reshape(-1, 2) / n
    return np.concatenate([1.0 - second_and_third.sum(-1, keepdims=True), second_and_third], -1)
