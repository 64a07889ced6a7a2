"""Shapes that approximate the environment an env map stands for.

A lookup at surface point ``p`` along the mirrored unit ray ``r`` meets the shape at ``h = p + t·r`` and samples the map
in the direction ``h - origin`` [Hakura01, sec. 4]. Points are in metres, in world space; the returned directions are
not normalized. ``p`` is taken to lie inside the shape; from outside the far intersection is used. A ray that grazes a
sphere or ellipsoid, or misses it, is taken to leave it `LEAST_HALF_CHORD` radii beyond its closest approach: where the
square root of the chord goes to zero, it would magnify rounding without bound, and drivers would differ.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

Vec3 = tuple[float, float, float]
Points = Float[np.ndarray, "*batch 3"]

LEAST_HALF_CHORD = 0.1
FAR_AWAY = 1e15  # metres to a box's side that is not there: its square, and it over `_SMALL`, are finite in float32
_SMALL = 1e-12  # direction components below this are taken as this: keeps slabs finite


@dataclass(frozen=True)
class InfiniteSphere:
    """The environment is infinitely far: the direction alone decides."""

    kind = "infinite_sphere"

    def lookup_direction(self, p: Points, r: Points) -> Points:
        """The mirrored ray itself."""
        return np.broadcast_to(r, np.broadcast_shapes(p.shape, r.shape))


@dataclass(frozen=True)
class Ellipsoid:
    """Axis-aligned ellipsoid; a sphere where the radii are equal.

    The lookup direction is divided by the radii, so that the map's texels spread over the ellipsoid as they do over a
    sphere instead of crowding at its far ends.
    """

    centre: Vec3
    radii: Vec3
    origin: Vec3
    kind = "ellipsoid"

    def lookup_direction(self, p: Points, r: Points) -> Points:
        """(h - origin)/radii, where h is where the ray leaves the ellipsoid."""
        centre, radii, origin = np.asarray(self.centre), np.asarray(self.radii), np.asarray(self.origin)
        q, v = (p - centre) / radii, r / radii
        return q + _leave_unit_sphere(q, v)[..., None] * v + (centre - origin) / radii


@dataclass(frozen=True)
class Sphere(Ellipsoid):
    """Sphere of one finite radius: an `Ellipsoid` whose three radii are equal."""

    kind = "sphere"


@dataclass(frozen=True)
class Box:
    """Axis-aligned box from ``lower`` to ``upper``: rooms. A side that is not there is `FAR_AWAY`."""

    lower: Vec3
    upper: Vec3
    origin: Vec3
    kind = "box"

    def lookup_direction(self, p: Points, r: Points) -> Points:
        """h - origin, where h is where the ray leaves the box."""
        safe = np.where(np.abs(r) < _SMALL, _SMALL, r)
        return p + self.exit_distance(p, r)[..., None] * safe - np.asarray(self.origin)

    def exit_distance(self, p: Points, r: Points) -> Float[np.ndarray, "*batch"]:
        """t of p + t·r where the ray leaves the box: the least over the axes of the slab's far face."""
        safe = np.where(np.abs(r) < _SMALL, _SMALL, r)
        return np.asarray(np.maximum((np.asarray(self.lower) - p) / safe, (np.asarray(self.upper) - p) / safe).min(-1))


@dataclass(frozen=True)
class Hemisphere:
    """Ellipsoid above a horizontal floor at height ``floor`` (the y of world space): objects on open ground."""

    centre: Vec3
    radii: Vec3
    floor: float
    origin: Vec3
    kind = "hemisphere"

    def lookup_direction(self, p: Points, r: Points) -> Points:
        """h - origin, where h is the first of floor (for falling rays) and dome."""
        centre, radii = np.asarray(self.centre), np.asarray(self.radii)
        t = _leave_unit_sphere((p - centre) / radii, r / radii)
        falling = r[..., 1] < -_SMALL
        to_floor = (self.floor - p[..., 1]) / np.where(falling, r[..., 1], -1.0)
        t = np.where(falling, np.minimum(t, np.maximum(to_floor, 0.0)), t)
        return p + t[..., None] * r - np.asarray(self.origin)


def _leave_unit_sphere(q: Points, v: Points) -> Float[np.ndarray, "*batch"]:
    """t ≥ 0 with |q + t·v| = 1, the later one: (-b + sqrt(b² - a·c))/a with a = v·v, b = q·v, c = q·q - 1."""
    a = np.einsum("...i,...i->...", v, v)
    b = np.einsum("...i,...i->...", q, v)
    c = np.einsum("...i,...i->...", q, q) - 1.0
    return np.asarray(np.maximum((-b + np.sqrt(np.maximum(b * b - a * c, LEAST_HALF_CHORD**2 * a))) / a, 0.0))
