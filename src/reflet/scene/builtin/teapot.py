"""The teapot as a mesh: Newell's patches, evenly subdivided, with analytic normals."""

import numpy as np
from jaxtyping import Float

from reflet.scene.builtin.newell import patches
from reflet.scene.meshes.corners import face_normals, weld
from reflet.scene.meshes.mesh import Mesh

SCALE = 0.1  # metres per unit of Newell's: 0.315 m high, 0.643 m from handle to spout


def teapot_mesh(part: str, subdivisions: int = 25) -> Mesh:
    """One of ``body``, ``lid``, ``handle``, ``spout``, every patch cut into ``subdivisions``² quads of two triangles.

    +Y up, metres, standing on y = 0, the spout towards +x. Smooth everywhere, open where Newell's is; at 25
    subdivisions the four parts have 39,800 triangles.
    """
    control = patches(part)
    along_count, around_count = control.shape[:2]
    step = np.arange(subdivisions) / subdivisions
    rows = [(k, t) for k in range(along_count) for t in step] + [(along_count - 1, 1.0)]
    patch = np.array([k for k, _ in rows])
    t = np.array([x for _, x in rows])
    positions, normals = evaluate(control[patch], t[:, None, None], step[None, None, :])
    shape = (len(rows), around_count * subdivisions, 3)
    positions, normals = (_y_up(x).reshape(shape) for x in (positions, normals))
    return _grid_mesh(positions * SCALE, normals)


def evaluate(
    control: Float[np.ndarray, "*batch 4 4 3"], along: np.ndarray, around: np.ndarray
) -> tuple[Float[np.ndarray, "*points 3"], Float[np.ndarray, "*points 3"]]:
    """Points and unit normals of bicubic patches at parameters in [0, 1].

    ``control`` is (rows, patches around, 4, 4, 3); ``along`` and ``around`` broadcast to (rows, patches around, steps).
    Where a row of control points falls together (along = 0 or 1, a pole) ∂around vanishes; it grows from there like
    ±∂²/∂around∂along, which takes its place.
    """
    a, da = _bernstein(along)
    b, db = _bernstein(around)

    def surface(rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
        return np.einsum("rpsi,rpsj,rpijc->rpsc", *np.broadcast_arrays(rows, columns), control, optimize=True)

    shape = np.broadcast_shapes(along.shape, around.shape, (*control.shape[:2], 1))
    a, da, b, db = (np.broadcast_to(x, (*shape, 4)) for x in (a, da, b, db))
    d_along, d_around = surface(da, b), surface(a, db)
    size = np.linalg.norm(d_around, axis=-1, keepdims=True)
    inwards = np.where(np.broadcast_to(along, shape)[..., None] < 0.5, 1.0, -1.0)
    d_around = np.where(size < 1e-9, inwards * surface(da, db), d_around)
    normal = np.cross(d_along, d_around)
    return surface(a, b), normal / np.linalg.norm(normal, axis=-1, keepdims=True)


def _bernstein(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The four cubic Bernstein polynomials and their derivatives, along a last axis."""
    s = 1.0 - t
    value = np.stack([s**3, 3 * t * s**2, 3 * t**2 * s, t**3], axis=-1)
    slope = np.stack([-3 * s**2, 3 * s**2 - 6 * t * s, 6 * t * s - 3 * t**2, 3 * t**2], axis=-1)
    return value, slope


def _y_up(points: np.ndarray) -> np.ndarray:
    return np.stack([points[..., 0], points[..., 2], -points[..., 1]], axis=-1)


def _grid_mesh(positions: Float[np.ndarray, "along around 3"], normals: Float[np.ndarray, "along around 3"]) -> Mesh:
    """Two triangles for every cell of a grid that closes around; cells that shrink to a line or point give fewer."""
    along, around = positions.shape[:2]
    i, j = np.meshgrid(np.arange(along - 1), np.arange(around), indexing="ij")
    here, right = i * around + j, i * around + (j + 1) % around
    below, diagonal = here + around, right + around
    # ∂along × ∂around points outwards: below, then right
    triangles = np.stack([here, diagonal, right, here, below, diagonal], axis=-1).reshape(-1, 3)
    corner_positions = positions.reshape(-1, 3).astype(np.float32)[triangles]
    _, area = face_normals(corner_positions.reshape(-1, 3))
    kept = area > 0.0
    return weld(corner_positions[kept].reshape(-1, 3), normals.reshape(-1, 3)[triangles[kept]].reshape(-1, 3))
