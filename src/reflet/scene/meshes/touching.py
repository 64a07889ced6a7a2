"""Whether two meshes come close to each other."""

import numpy as np
from jaxtyping import Float
from scipy.spatial import cKDTree

from reflet.scene.meshes.mesh import Mesh

Points = Float[np.ndarray, "points 3"]


def touch(a: Mesh, b: Mesh, tolerance: float) -> bool:
    """True if the surfaces of two meshes intersect or come close to each other; ``tolerance`` is positive, in metres.

    Always true up to 0.7 of the tolerance, never beyond it. Both surfaces are cut, where they lie near the other's
    bounding box, into triangles with edges of at most h = tolerance/4. No surface point is farther than h/√3 from a
    centroid then, so the nearest two centroids are at most 2h/√3 < 0.3·tolerance farther apart than the surfaces.
    """
    near_a, near_b = _points_near(a, b, tolerance), _points_near(b, a, tolerance)
    if not len(near_a) or not len(near_b):
        return False
    tree = cKDTree(near_a)
    stride = 32  # surfaces that touch mostly do so in many points: a few of them tell
    batches = (near_b[start::stride] for start in range(stride))
    return any(np.isfinite(tree.query(batch, distance_upper_bound=tolerance)[0]).any() for batch in batches)


def _points_near(mesh: Mesh, other: Mesh, tolerance: float) -> Points:
    """Centroids of the mesh's triangles, cut small, that come within ``tolerance`` of the other mesh's box."""
    low, high = other.positions.min(axis=0) - tolerance, other.positions.max(axis=0) + tolerance
    pending = mesh.positions[mesh.triangles].astype(np.float64)
    done = []
    while len(pending):
        pending = pending[(pending.min(axis=1) <= high).all(axis=1) & (pending.max(axis=1) >= low).all(axis=1)]
        edges = np.linalg.norm(pending - np.roll(pending, -1, axis=1), axis=2).max(axis=1)
        small = edges <= tolerance / 4.0
        done.append(pending[small].mean(axis=1))
        p, q = pending[~small], 0.5 * (pending[~small] + np.roll(pending[~small], -1, axis=1))
        pending = np.concatenate([np.stack([p[:, k], q[:, k], q[:, k - 1]], axis=1) for k in range(3)] + [q])
    return np.concatenate(done)
