"""Where objects are and how large."""

import numpy as np
from jaxtyping import Float

from reflet.scene.scene import Scene


def object_positions(scene: Scene, index: int) -> Float[np.ndarray, "vertices 3"]:
    """Vertices of all parts of one reflective object, in metres."""
    return np.concatenate([scene.parts[p].mesh.positions for p in scene.objects[index].parts]).astype(np.float64)


def object_triangles(scene: Scene, index: int) -> Float[np.ndarray, "triangles 3 3"]:
    """Corners of all triangles of one reflective object, in the order of its parts, in metres."""
    meshes = [scene.parts[p].mesh for p in scene.objects[index].parts]
    return np.concatenate([mesh.positions[mesh.triangles] for mesh in meshes]).astype(np.float64)


def bounding_sphere(positions: Float[np.ndarray, "vertices 3"]) -> tuple[Float[np.ndarray, "3"], float]:
    """Centre of the bounding box, and the radius of the sphere around it that holds all points."""
    centre = 0.5 * (positions.min(axis=0) + positions.max(axis=0))
    return centre, float(np.sqrt(((positions - centre) ** 2).sum(axis=1).max()))


def reach(scene: Scene, index: int, origin: tuple[float, float, float]) -> float:
    """Metres from a point to the farthest vertex of an object."""
    return float(np.linalg.norm(object_positions(scene, index) - origin, axis=1).max())


def supporting_height(scene: Scene, index: int) -> float:
    """Height (y) in metres of the horizontal plane that an object rests on: its lowest vertex [Hakura01, sec. 4]."""
    return float(object_positions(scene, index)[:, 1].min())
