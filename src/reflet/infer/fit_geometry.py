"""Fitting of env map geometries to a scene."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float

from reflet.envmap.geometry import KINDS, Geometry
from reflet.envmap.parameterizations.cube import face_from_direction, texel_directions, texel_solid_angle
from reflet.envmap.shapes import FAR_AWAY, Box, Ellipsoid, Hemisphere, InfiniteSphere, Sphere, Vec3
from reflet.errors import RefletError
from reflet.infer.fit_relief import last_relief, weighted_median
from reflet.scene.scene import Scene
from reflet.trace.layers import StaticProbe

_MARGIN = 1.02  # of shapes that must hold a part: rays start inside them
_DOWN = 3  # the face of a cube that looks down
_ROUNDS = 40  # of the search for a least ellipsoid; ten suffice for most meshes


def em_origin(scene: Scene, parts: Sequence[int]) -> Vec3:
    """Origin of the parts' env maps: the area-weighted mean of their triangles' centroids [Hakura01, sec. 4]."""
    corners = _corners(scene, parts)
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=-1)
    return _vec3(np.average(corners.mean(1), axis=0, weights=area))


def fit(kind: str, scene: Scene, parts: Sequence[int], probe: StaticProbe | None = None) -> Geometry:
    """A geometry of the given kind for env maps of ``parts``.

    ``ellipsoid`` without a probe bounds the parts; with a probe, ``sphere``, ``ellipsoid``, ``box`` and ``hemisphere``
    fit the environment at the probe's distances [Hakura01, sec. 4, "EM Representation"], and ``relief`` is these
    distances. A side of the box with nothing at a finite distance is `FAR_AWAY`. Where most of what is above is
    infinitely far, the sphere at infinity stands for sphere and ellipsoid, and a hemisphere has its floor alone; for
    box and relief it stands where all is. Raises `RefletError` for an unknown kind, and `ValueError` for a kind that
    needs a probe and gets none.
    """
    if kind not in KINDS:
        raise RefletError(f"A geometry must be one of {', '.join(KINDS)}, not {kind}.")
    if kind == "infinite_sphere":
        return InfiniteSphere()
    if kind == "relief" and probe is not None:
        return last_relief(probe.distance, probe.origin, fit("box", scene, parts, probe))
    if probe is None:
        if kind == "ellipsoid":
            return bounding_ellipsoid(scene, parts)
        if kind == "sphere":
            return _bounding_sphere(scene, parts)
        raise ValueError(f"fitting a {kind} takes a probe of the environment")
    return _fit_environment(kind, scene, parts, probe)


def bounding_ellipsoid(scene: Scene, parts: Sequence[int]) -> Ellipsoid:
    """The axis-aligned ellipsoid of least volume around the parts, its centre free.

    Found by the multiplicative algorithm for least enclosing ellipsoids [Titterington78], restricted to the axes.
    """
    centre, radii = _least_ellipsoid(_vertices(scene, parts))
    return Ellipsoid(_vec3(centre), _vec3(radii * _MARGIN), em_origin(scene, parts))


def _bounding_sphere(scene: Scene, parts: Sequence[int]) -> Sphere:
    origin = em_origin(scene, parts)
    radius = float(np.linalg.norm(_vertices(scene, parts) - origin, axis=1).max()) * _MARGIN
    return Sphere(origin, (radius,) * 3, origin)


def _least_ellipsoid(points: Float[np.ndarray, "n 3"]) -> tuple[Float[np.ndarray, "3"], Float[np.ndarray, "3"]]:
    """Centre and radii. Few points touch the ellipsoid: it is found for some, those that stick out of it the most join
    them, and so on until none does."""
    low, high = points.min(0), points.max(0)
    scale = np.where(high - low > 1e-9 * (high - low).max(), high - low, (high - low).max() * 1e-3)
    unit = (points - 0.5 * (low + high)) / scale
    directions = np.stack(np.meshgrid(*[(-1.0, 0.0, 1.0)] * 3), -1).reshape(-1, 3)
    chosen = np.unique([(unit @ direction).argmax() for direction in directions])
    for _ in range(_ROUNDS):
        centre, squares = _touching_ellipsoid(unit[chosen])
        distance = ((unit - centre) ** 2 / squares).sum(1)
        octant = (unit > centre) @ np.array([1, 2, 4])
        farthest = [np.where(octant == o, distance, 0.0).argmax() for o in range(8)]
        sticks_out = distance[farthest] > distance[chosen].max() * (1.0 + 1e-6)
        if not sticks_out.any():
            break
        chosen = np.union1d(chosen, np.array(farthest)[sticks_out])
    radii = np.sqrt(squares * distance.max())
    return 0.5 * (low + high) + centre * scale, radii * scale


def _touching_ellipsoid(points: Float[np.ndarray, "n 3"]) -> tuple[Float[np.ndarray, "3"], Float[np.ndarray, "3"]]:
    """Centre and squared radii, up to a common factor, by multiplicative updates of the points' weights.

    At the optimum the weights w of the touching points satisfy radii² = 3·Σ w·(p - centre)², centre = Σ w·p.
    """
    weight = np.full(len(points), 1.0 / len(points))
    for _ in range(400):
        centre = weight @ points
        variance = np.maximum(weight @ (points - centre) ** 2, 1e-8)
        weight *= ((points - centre) ** 2 / variance).sum(1) / 3.0
        weight /= weight.sum()
    centre = weight @ points
    return centre, np.maximum(weight @ (points - centre) ** 2, 1e-8)


def _fit_environment(kind: str, scene: Scene, parts: Sequence[int], probe: StaticProbe) -> Geometry:
    size = probe.distance.shape[-1]
    direction = texel_directions(size)
    solid_angle = np.broadcast_to(texel_solid_angle(size), probe.distance.shape)
    corners = _vertices(scene, parts)
    origin = np.asarray(probe.origin)
    floor = float(corners[:, 1].min())
    finite = np.isfinite(probe.distance)
    point = origin + np.where(finite, probe.distance, 0.0)[..., None] * direction
    # What lies at or below the supporting plane is the floor of box and hemisphere, not their walls nor their sky.
    extent = float(np.linalg.norm(corners - origin, axis=1).max())
    wall = finite & (point[..., 1] > floor + 0.02 * extent)
    above = direction[..., 1] > 0.0
    if kind == "box":
        return _box(corners, origin, floor, point, finite, wall | (above & ~finite), solid_angle)
    far = float(solid_angle[above & ~finite].sum()) > 0.5 * float(solid_angle[above].sum())
    if far or not wall.any():
        if kind == "hemisphere":
            return Hemisphere(_vec3((origin[0], floor, origin[2])), (100.0 * extent,) * 3, floor, _vec3(origin))
        return InfiniteSphere()
    distance = weighted_median(probe.distance[wall], solid_angle[wall])
    radius = max(distance, _MARGIN * extent)
    if kind == "hemisphere":
        centre = _vec3((origin[0], floor, origin[2]))
        return Hemisphere(centre, (max(radius, _MARGIN * extent + float(origin[1]) - floor),) * 3, floor, _vec3(origin))
    if kind == "sphere":
        return Sphere(_vec3(origin), (radius,) * 3, _vec3(origin))
    radii = []
    for axis in range(3):
        face, _, _ = face_from_direction(direction)
        seen = wall & (face // 2 == axis)
        reach = (
            weighted_median(np.abs(point[seen][:, axis] - origin[axis]), solid_angle[seen]) if seen.any() else radius
        )
        radii.append(max(reach, _MARGIN * np.sqrt(3.0) * float(np.abs(corners[:, axis] - origin[axis]).max())))
    return Ellipsoid(_vec3(origin), _vec3(np.array(radii)), _vec3(origin))


def _box(
    corners: Float[np.ndarray, "vertices 3"],
    origin: Float[np.ndarray, "3"],
    floor: float,
    point: Float[np.ndarray, "6 size size 3"],
    finite: Bool[np.ndarray, "6 size size"],
    beside: Bool[np.ndarray, "6 size size"],
    solid_angle: Float[np.ndarray, "6 size size"],
) -> Box | InfiniteSphere:
    """The box whose sides are the medians of what the faces of a cube see at ``point``, around ``corners`` at least.

    What is infinitely far counts as `FAR_AWAY`; where all sides are there is no box. All but the side below are of what
    is ``beside`` the object, above its floor.
    """
    low, high = corners.min(0), corners.max(0)
    margin = 0.5 * (_MARGIN - 1.0) * (high - low)
    lower, upper = low - margin, high + margin
    lower[1] = floor
    for face in range(6):
        axis, below = divmod(face, 2)
        counts = beside[face] | (face == _DOWN)
        reach = np.where(finite[face], np.abs(point[face][..., axis] - origin[axis]), FAR_AWAY)
        side = weighted_median(reach[counts], solid_angle[face][counts]) if counts.any() else FAR_AWAY
        if below:
            lower[axis] = min(lower[axis], origin[axis] - side)
        else:
            upper[axis] = max(upper[axis], origin[axis] + side)
    if np.minimum(-lower, upper).min() >= 0.5 * FAR_AWAY:
        return InfiniteSphere()
    return Box(_vec3(lower), _vec3(upper), _vec3(origin))


def _vertices(scene: Scene, parts: Sequence[int]) -> Float[np.ndarray, "vertices 3"]:
    return np.concatenate([scene.parts[p].mesh.positions for p in parts]).astype(np.float64)


def _corners(scene: Scene, parts: Sequence[int]) -> Float[np.ndarray, "triangles 3 3"]:
    return np.concatenate([scene.parts[p].mesh.positions[scene.parts[p].mesh.triangles] for p in parts]).astype(
        np.float64
    )


def _vec3(values: np.ndarray | tuple[float, float, float]) -> Vec3:
    return float(values[0]), float(values[1]), float(values[2])
