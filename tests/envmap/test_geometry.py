"""Geometries: lookups against closed forms."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflet.envmap.geometry import KINDS, Box, Ellipsoid, Hemisphere, InfiniteSphere, Sphere, pack

SPHERE = Sphere((1.0, 2.0, 3.0), (2.0, 2.0, 2.0), (1.5, 2.0, 2.5))
ELLIPSOID = Ellipsoid((0.1, 0.2, 0.3), (1.0, 2.0, 0.5), (0.0, 0.0, 0.2))
BOX = Box((-2.0, 0.0, -3.0), (2.0, 2.5, 3.0), (0.1, 0.4, -0.2))
HEMISPHERE = Hemisphere((0.0, 0.0, 0.0), (5.0, 5.0, 5.0), 0.0, (0.0, 0.5, 0.0))
unit = (
    st.tuples(*[st.floats(-1, 1)] * 3)
    .filter(lambda d: np.linalg.norm(d) > 0.1)
    .map(lambda d: np.array(d) / np.linalg.norm(d))
)
inside = st.tuples(*[st.floats(-0.4, 0.4)] * 3).map(np.array)

# float64; the ellipsoid's root is the worst: a few hundred ulp
CLOSE = 1e-10


@given(inside, unit)
def test_sphere_lookup_points_from_origin_to_the_hit(q: np.ndarray, r: np.ndarray) -> None:
    p = np.array(SPHERE.centre) + q
    h = SPHERE.lookup_direction(p, r) * 2.0 + np.array(SPHERE.origin)
    assert np.linalg.norm(h - SPHERE.centre) == pytest.approx(2.0, abs=CLOSE)
    assert np.linalg.norm(np.cross(h - p, r)) < CLOSE and np.dot(h - p, r) > 0


@given(inside, unit)
def test_ellipsoid_hit_lies_on_the_ellipsoid_and_the_ray(q: np.ndarray, r: np.ndarray) -> None:
    radii = np.array(ELLIPSOID.radii)
    p = np.array(ELLIPSOID.centre) + q * radii
    h = ELLIPSOID.lookup_direction(p, r) * radii + np.array(ELLIPSOID.origin)
    assert (((h - ELLIPSOID.centre) / radii) ** 2).sum() == pytest.approx(1.0, abs=CLOSE)
    assert np.linalg.norm(np.cross(h - p, r)) < CLOSE


@given(inside, unit)
def test_box_hit_lies_on_a_wall(q: np.ndarray, r: np.ndarray) -> None:
    lower, upper = np.array(BOX.lower), np.array(BOX.upper)
    p = (lower + upper) / 2 + q * (upper - lower)
    h = BOX.lookup_direction(p, r) + np.array(BOX.origin)
    assert np.minimum(np.abs(h - lower), np.abs(h - upper)).min() < CLOSE
    assert (h > lower - CLOSE).all() and (h < upper + CLOSE).all()
    assert np.linalg.norm(np.cross(h - p, r)) < CLOSE * 10  # components below 1e-12 are replaced by 1e-12


def test_axis_parallel_rays_meet_the_box() -> None:
    p = np.zeros((6, 3)) + [0.0, 1.0, 0.0]
    r = np.concatenate([np.eye(3), -np.eye(3)])
    h = BOX.lookup_direction(p, r) + np.array(BOX.origin)
    np.testing.assert_allclose(h, [[2, 1, 0], [0, 2.5, 0], [0, 1, 3], [-2, 1, 0], [0, 0, 0], [0, 1, -3]], atol=1e-11)


def test_hemisphere_has_a_floor_and_a_dome() -> None:
    p = np.array([[1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    down, up, flat = np.array([0.6, -0.8, 0.0]), np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0])
    h = HEMISPHERE.lookup_direction(p, np.stack([down, up, flat])) + np.array(HEMISPHERE.origin)
    np.testing.assert_allclose(h[0], [1.75, 0.0, 0.0], atol=CLOSE)
    np.testing.assert_allclose(h[1], [1.0, np.sqrt(24.0), 0.0], atol=CLOSE)
    np.testing.assert_allclose(h[2], [np.sqrt(24.0), 1.0, 0.0], atol=CLOSE)


@given(unit)
def test_a_growing_sphere_becomes_the_sphere_at_infinity(r: np.ndarray) -> None:
    p = np.array([0.3, -0.2, 0.1])
    far = Sphere((0.0, 0.0, 0.0), (1e6,) * 3, (0.0, 0.0, 0.0)).lookup_direction(p, r)
    # the parallax of |p| = 0.37 m at 1000 km
    np.testing.assert_allclose(far, InfiniteSphere().lookup_direction(p, r), atol=1e-6)


def test_rays_that_graze_or_miss_an_ellipsoid_do_not_magnify_rounding() -> None:
    """At the silhouette the chord is a square root of zero: an error of 1e-7 in p would become 3e-4 in the lookup."""
    unit_ball = Sphere((0.0, 0.0, 0.0), (1.0, 1.0, 1.0), (0.0, 0.0, 0.0))
    heights = np.linspace(0.9, 1.2, 30001)
    p = np.stack([np.full_like(heights, -2.0), heights, np.zeros_like(heights)], -1)
    hits = unit_ball.lookup_direction(p, np.broadcast_to([1.0, 0.0, 0.0], p.shape))
    assert np.isfinite(hits).all()
    # slope of sqrt at the least half chord: h/0.1 for a height h of about 1, and 1 for the height itself
    assert np.linalg.norm(np.diff(hits, axis=0), axis=-1).max() <= (heights[1] - heights[0]) * 11
    missed = hits[heights > 1.0]
    np.testing.assert_allclose(missed[:, 0], 0.1, atol=CLOSE)


def test_packing_names_the_kind_and_keeps_the_numbers() -> None:
    for number, geometry in enumerate((InfiniteSphere(), SPHERE, ELLIPSOID, BOX, HEMISPHERE)):
        packed = pack(geometry)
        assert packed[0] == number and packed.dtype == np.float32
        assert KINDS[geometry.kind] is type(geometry)
    np.testing.assert_allclose(pack(BOX), [3, -2, 0, -3, 0, 2, 2.5, 3, 0, 0.1, 0.4, -0.2], rtol=1e-7)
    np.testing.assert_allclose(pack(HEMISPHERE), [4, 0, 0, 0, 0, 5, 5, 5, 0, 0, 0.5, 0])
