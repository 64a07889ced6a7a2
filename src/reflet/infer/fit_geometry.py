"""Fitting of env map geometries to a scene."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from reflet.envmap.geometry import KINDS, Geometry
from reflet.envmap.parameterizations.cube import face_from_direction, texel_directions, texel_solid_angle
from reflet.envmap.shapes import Box, Ellipsoid, Hemisphere, InfiniteSphere, Sphere, Vec3
from reflet.errors import RefletError
from reflet.infer.fit_relief import last_relief
from reflet.scene.scene import Scene
from reflet.trace.layers import StaticProbe

_MARGIN = 1.02  # of shapes that must hold a part: rays start inside them
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
    distances. Where most of the environment is infinitely far, the sphere at infinity is returned for the others (a
    hemisphere keeps its floor). Raises `RefletError` for an unknown kind, and `ValueError` for a kind that needs a
    probe and gets none.
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
    # What lies at or below the supporting plane is the floor of box and hemisphere, not their walls.
    extent = float(np.linalg.norm(corners - origin, axis=1).max())
    wall = finite & (point[..., 1] > floor + 0.02 * extent)
    above = direction[..., 1] > 0.0
    far = float(solid_angle[above & ~finite].sum()) > 0.5 * float(solid_angle[above].sum())
    if far or not wall.any():
        if kind == "hemisphere":
            return Hemisphere(_vec3((origin[0], floor, origin[2])), (100.0 * extent,) * 3, floor, _vec3(origin))
        return InfiniteSphere()
    if kind == "box":
        lower, upper = corners.min(0), corners.max(0)
        middle, half = 0.5 * (lower + upper), 0.5 * _MARGIN * (upper - lower)
        lower, upper = middle - half, middle + half
        face, _, _ = face_from_direction(direction)
        for axis in range(3):
            for side in range(2):
                seen = wall & (face == 2 * axis + side)
                if seen.any():
                    plane = _weighted_median(point[seen][:, axis], solid_angle[seen])
                    if side:
                        lower[axis] = min(lower[axis], plane)
                    else:
                        upper[axis] = max(upper[axis], plane)
        lower[1] = floor
        return Box(_vec3(lower), _vec3(upper), _vec3(origin))
    distance = _weighted_median(probe.distance[wall], solid_angle[wall])
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
            _weighted_median(np.abs(point[seen][:, axis] - origin[axis]), solid_angle[seen]) if seen.any() else radius
        )
        radii.append(max(reach, _MARGIN * np.sqrt(3.0) * float(np.abs(corners[:, axis] - origin[axis]).max())))
    return Ellipsoid(_vec3(origin), _vec3(np.array(radii)), _vec3(origin))


def _vertices(scene: Scene, parts: Sequence[int]) -> Float[np.ndarray, "vertices 3"]:
    return np.concatenate([scene.parts[p].mesh.positions for p in parts]).astype(np.float64)


def _corners(scene: Scene, parts: Sequence[int]) -> Float[np.ndarray, "triangles 3 3"]:
    return np.concatenate([scene.parts[p].mesh.positions[scene.parts[p].mesh.triangles] for p in parts]).astype(
        np.float64
    )


def _weighted_median(values: np.ndarray, weights: np.ndarray) -> float:
    order = np.argsort(values, kind="stable")
    running = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(running, 0.5 * running[-1])])


def _vec3(values: np.ndarray | tuple[float, float, float]) -> Vec3:
    return float(values[0]), float(values[1]), float(values[2])
