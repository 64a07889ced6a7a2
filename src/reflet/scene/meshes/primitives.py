"""Meshes from formulas: a sphere and a torus with analytic normals, to look at env maps with."""

import numpy as np
from jaxtyping import Float

from reflet.scene.meshes.mesh import Mesh

Vec3 = tuple[float, float, float]


def sphere_mesh(radius: float = 1.0, centre: Vec3 = (0.0, 0.0, 0.0), around: int = 128) -> Mesh:
    """A sphere of ``around`` meridians and half as many rings, its poles at ±y; ``around``·(``around`` - 2) triangles.

    u runs to the right around it, v down: a picture wraps it like a globe.
    """
    rings = around // 2
    v, u = np.meshgrid(np.linspace(0.0, 1.0, rings + 1), np.linspace(0.0, 1.0, around + 1), indexing="ij")
    theta, phi = np.pi * v, -2.0 * np.pi * u
    normals = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)], -1)
    triangles = _cells(rings, around).reshape(rings, around, 2, 3)
    # Of the cells at the poles one of two triangles has no area.
    kept = np.concatenate([triangles[0, :, 1], triangles[1:-1].reshape(-1, 3), triangles[-1, :, 0]])
    return _mesh(np.asarray(centre) + radius * normals, normals, np.stack([u, v], -1), kept)


def torus_mesh(
    major: float = 0.7, minor: float = 0.3, centre: Vec3 = (0.0, 0.0, 0.0), around: int = 144, sides: int = 72
) -> Mesh:
    """A torus around the y axis, a tube of radius ``minor``; ``major`` is its middle's. 2·around·sides triangles.

    u runs around the axis, v down the tube's outside.
    """
    v, u = np.meshgrid(np.linspace(0.0, 1.0, sides + 1), np.linspace(0.0, 1.0, around + 1), indexing="ij")
    theta, phi = 2.0 * np.pi * v, -2.0 * np.pi * u
    outward = np.stack([np.cos(phi), np.zeros_like(phi), np.sin(phi)], -1)
    normals = np.sin(theta)[..., None] * outward + np.cos(theta)[..., None] * np.array([0.0, 1.0, 0.0])
    positions = np.asarray(centre) + major * outward + minor * normals
    return _mesh(positions, normals, np.stack([u, v], -1), _cells(sides, around))


def _cells(rows: int, columns: int) -> np.ndarray:
    """Two triangles for every cell of a grid of (rows + 1)·(columns + 1) vertices, seen with u right and v down."""
    i, j = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    here = i * (columns + 1) + j
    right, below, diagonal = here + 1, here + columns + 1, here + columns + 2
    return np.stack([here, diagonal, right, here, below, diagonal], -1).reshape(-1, 3)


def _mesh(
    positions: Float[np.ndarray, "rows columns 3"],
    normals: Float[np.ndarray, "rows columns 3"],
    uv: Float[np.ndarray, "rows columns 2"],
    triangles: np.ndarray,
) -> Mesh:
    flat = (x.reshape(-1, x.shape[-1]).astype(np.float32) for x in (positions, normals, uv))
    positions_flat, normals_flat, uv_flat = flat
    return Mesh(positions_flat, normals_flat, triangles.astype(np.uint32), uv_flat)
