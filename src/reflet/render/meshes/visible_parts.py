"""Which parts reach into which face of a map: by bounding spheres, so that none is left out that might."""

import numpy as np
from jaxtyping import Bool, Float

from reflet.envmap.parameterizations.cube import AXES
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.scene import Scene

# A dual paraboloid's faces go on to their corners, and triangles a little farther (`shaders/matte.wgsl`): to 120° from
# their middle.
_WIDEST = np.radians(120.0)


def bounding_spheres(scene: Scene) -> Float[np.ndarray, "parts 4"]:
    """Centre and radius of a sphere around each part: that of its bounding box, as it stands in the scene."""
    return np.array([_sphere(part.mesh) for part in scene.parts]).reshape(-1, 4)


def _sphere(mesh: Mesh) -> Float[np.ndarray, "4"]:
    low, high = mesh.positions.min(0).astype(np.float64), mesh.positions.max(0).astype(np.float64)
    centre = 0.5 * (low + high)
    radius = np.linalg.norm(mesh.positions - centre, axis=1).max()
    return np.array([*centre, radius * (1.0 + 1e-6)])  # float32 positions move by that much


def reach_into_cube(
    centre: Float[np.ndarray, "parts 3"], radius: Float[np.ndarray, "parts"]
) -> Bool[np.ndarray, "6 parts"]:
    """Whether spheres, around centres in the map's space, reach into the pyramid of each face.

    A face's four planes outward = ±s, outward = ±t have normals of length √2.
    """
    outward, s, t = np.einsum("fak,pk->afp", AXES, centre)
    return (outward - np.abs(s) >= -np.sqrt(2.0) * radius) & (outward - np.abs(t) >= -np.sqrt(2.0) * radius)


def reach_into_paraboloids(
    centre: Float[np.ndarray, "parts 3"], radius: Float[np.ndarray, "parts"]
) -> Bool[np.ndarray, "2 parts"]:
    """Whether they reach into each face of a dual paraboloid: the angle to its middle, less what the sphere spans."""
    distance = np.maximum(np.linalg.norm(centre, axis=-1), 1e-30)
    spans = np.where(distance > radius, np.arcsin(np.minimum(radius / distance, 1.0)), np.pi)
    angle = np.arccos(np.clip(centre[:, 2] / distance, -1.0, 1.0))
    return np.stack([angle, np.pi - angle]) - spans <= _WIDEST
