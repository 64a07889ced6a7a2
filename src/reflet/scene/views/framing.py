"""Cameras that suit a scene: an orbit that frames its reflective objects, and the refusal of cameras inside them."""

import numpy as np
from jaxtyping import Float
from numba import njit, prange

from reflet.errors import RefletError
from reflet.scene.bounds import bounding_sphere, object_positions, object_triangles
from reflet.scene.scene import Scene
from reflet.scene.views.camera import Camera, Vec3
from reflet.scene.views.parameter_space import Orbit

AZIMUTH_DEG, ELEVATION_DEG, FOV_DEG = 60.0, 22.0, 36.0
_MARGIN = 1.05  # room around the bounding sphere
_WALL = 0.95  # share of the way to the nearest wall that a camera may go


def frame_orbit(
    scene: Scene,
    *,
    azimuth_deg: float | None = None,
    elevation_deg: float | None = None,
    distance: float | None = None,
    target: Vec3 | None = None,
    fov_deg: float | None = None,
    image_size: int = 512,
) -> Orbit:
    """An orbit around all reflective objects but the scene's own floor. What is not given is chosen; what is given is
    kept.

    The target is the centre of their bounding box. The distance is such that the sphere around the target that holds
    them just fits the picture, and less where something opaque would stand between camera and objects at any azimuth:
    the walls of a room.
    """
    framed = [o for o, item in enumerate(scene.objects) if not set(scene.floor) & set(item.parts)]
    positions = np.concatenate([object_positions(scene, o) for o in framed])
    centre, _ = bounding_sphere(positions)
    aim = centre if target is None else np.asarray(target, np.float64)
    radius = float(np.linalg.norm(positions - aim, axis=1).max())
    elevation = ELEVATION_DEG if elevation_deg is None else elevation_deg
    fov = FOV_DEG if fov_deg is None else fov_deg
    if distance is None:
        distance = _MARGIN * radius / float(np.sin(np.radians(min(fov, 179.0)) / 2.0))
        free = _free_way(scene, aim, radius, elevation)
        # nearer than the sphere itself no camera sees the objects whole: then the wall is the user's to deal with
        distance = max(min(distance, _WALL * free), 1.01 * radius)
    return Orbit(
        target=(float(aim[0]), float(aim[1]), float(aim[2])),
        azimuth_deg=AZIMUTH_DEG if azimuth_deg is None else azimuth_deg,
        elevation_deg=elevation,
        distance=distance,
        fov_deg=fov,
        image_size=image_size,
    )


def _free_way(scene: Scene, aim: Float[np.ndarray, "3"], radius: float, elevation_deg: float) -> float:
    """Distance from the target, outside the objects' sphere, to the nearest other surface, at all azimuths."""
    phi, theta = np.radians(np.arange(0.0, 360.0, 5.0)), np.radians(elevation_deg)
    flat, rise = np.cos(theta), np.full_like(phi, np.sin(theta))
    ways = np.stack([np.cos(phi) * flat, rise, -np.sin(phi) * flat], axis=1)
    nearest = np.full(len(ways), np.inf)
    for number, part in enumerate(scene.parts):
        if not part.reflective or number in scene.floor:
            _first_hits(aim + radius * ways, ways, part.mesh.positions, part.mesh.triangles, nearest)
    return float(nearest.min()) + radius


@njit(parallel=True, cache=True, error_model="numpy")
def _first_hits(origins, ways, positions, triangles, nearest):  # type: ignore[no-untyped-def]
    """Lowers ``nearest`` to the distance along each ray to the nearest triangle, from either side [Moeller97]."""
    for ray in prange(len(ways)):
        ox, oy, oz = origins[ray]
        dx, dy, dz = ways[ray]
        for k in range(len(triangles)):
            a, b, c = triangles[k]
            ax, ay, az = float(positions[a, 0]), float(positions[a, 1]), float(positions[a, 2])
            ux, uy, uz = positions[b, 0] - ax, positions[b, 1] - ay, positions[b, 2] - az
            vx, vy, vz = positions[c, 0] - ax, positions[c, 1] - ay, positions[c, 2] - az
            px, py, pz = dy * vz - dz * vy, dz * vx - dx * vz, dx * vy - dy * vx
            determinant = ux * px + uy * py + uz * pz
            sx, sy, sz = ox - ax, oy - ay, oz - az
            u = (sx * px + sy * py + sz * pz) / determinant
            if not 0.0 <= u <= 1.0:  # most of all triangles, and those without area
                continue
            qx, qy, qz = sy * uz - sz * uy, sz * ux - sx * uz, sx * uy - sy * ux
            v = (qx * dx + qy * dy + qz * dz) / determinant
            if v >= 0.0 and u + v <= 1.0:
                t = (vx * qx + vy * qy + vz * qz) / determinant
                if 0.0 < t < nearest[ray]:
                    nearest[ray] = t


def winding_number(point: Float[np.ndarray, "3"], triangles: Float[np.ndarray, "triangles 3 3"]) -> float:
    """Solid angle of a surface seen from a point, over 4π: 1 inside a closed surface, 0 outside, between the two where
    it has holes. Implements [Jacobson13, eq. 4-5].
    """
    a, b, c = np.moveaxis(triangles - point, 1, 0)
    la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
    volume = np.einsum("ti,ti->t", a, np.cross(b, c))
    dots = (np.einsum("ti,ti->t", x, y) for x, y in ((a, b), (b, c), (c, a)))
    denominator = la * lb * lc + sum(d * length for d, length in zip(dots, (lc, la, lb), strict=True))
    return float(2.0 * np.arctan2(volume, denominator).sum() / (4.0 * np.pi))


def object_around(scene: Scene, camera: Camera) -> str | None:
    """Name of the reflective object that a camera stands in, if any: whose surface, holes and all, covers more than
    half of what can be seen."""
    position = np.asarray(camera.position, np.float64)
    for index, item in enumerate(scene.objects):
        meshes = [scene.parts[p].mesh for p in item.parts]
        low = np.min([mesh.positions.min(axis=0) for mesh in meshes], axis=0)
        high = np.max([mesh.positions.max(axis=0) for mesh in meshes], axis=0)
        if (position < low).any() or (position > high).any():  # beside it, above or below: no need to measure
            continue
        if abs(winding_number(position, object_triangles(scene, index))) > 0.5:
            return item.name
    return None


def check_camera(scene: Scene, camera: Camera) -> None:
    """Raises RefletError if the camera stands inside a reflective object (`object_around`)."""
    name = object_around(scene, camera)
    if name is not None:
        x, y, z = camera.position
        raise RefletError(
            f"The camera at ({x:.3g}, {y:.3g}, {z:.3g}) is inside {name}; choose a larger distance or another target."
        )
