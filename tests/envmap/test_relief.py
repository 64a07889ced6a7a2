"""Relief: searches against shapes that are known in closed form."""

from itertools import pairwise

import numpy as np
import pytest
from reliefs import BALL, NOWHERE, ROOM, angle_deg, plane_relief, rays, relief_of

from reflet.envmap.compiled_lookup import compiled_geometry, inverse_hit
from reflet.envmap.geometry import RELIEF, Box, InfiniteSphere, lookup_directions, pack
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.cube import texel_directions
from reflet.envmap.relief import Relief, fetch, inverse_chebyshev, padded_faces
from reflet.envmap.shapes import FAR_AWAY
from reflet.envmap.texture_filter import sample

TEXEL_DEG = 90.0 / 128


def test_the_infinitely_far_is_the_ray_itself() -> None:
    p, r = rays(1000, seed=1)
    np.testing.assert_array_equal(relief_of(InfiniteSphere()).lookup_direction(p, r), r)


@pytest.mark.parametrize("start", [None, Box((-4.0, -1.0, -4.0), (4.0, 4.0, 4.0), (0.0, 0.0, 0.0))])
def test_a_plane_is_met_exactly(start: Box | None) -> None:
    """Its inverse distance is bilinear on each face, and M affine in w: two steps find it from wherever they start."""
    p, r = rays(20000, seed=2)
    falling = r[:, 1] < -0.05
    p, r = p[falling], r[falling]
    exact = p + r * ((-0.5 - p[:, 1]) / r[:, 1])[:, None]
    error = angle_deg(plane_relief(0.5, start=start).lookup_direction(p, r), exact)
    # Half floats round q by 2^-12 (0.02 degrees at 45); the rest is within a texel of the edges between faces, where
    # q bends, and where rays come down slantwise, far from what lies below the origin.
    assert np.median(error) < 0.02
    assert np.percentile(error, 99) < 0.25 * TEXEL_DEG


def test_a_sky_above_a_plane_stays_infinitely_far() -> None:
    p, r = rays(20000, seed=3)
    rising = r[:, 1] > 0.3  # what runs along the horizon sees both through the bilinear filter
    error = angle_deg(plane_relief(0.5).lookup_direction(p[rising], r[rising]), r[rising])
    assert error.max() < 0.5 * TEXEL_DEG


@pytest.mark.parametrize("shape", [ROOM, BALL], ids=lambda s: s.kind)
def test_a_room_and_a_ball_are_met(shape) -> None:  # type: ignore[no-untyped-def]
    p, r = rays(20000, seed=4)
    p = p + shape.origin
    scale = np.asarray(getattr(shape, "radii", 1.0))
    exact = shape.lookup_direction(p, r) * scale
    error = angle_deg(relief_of(shape, start=Box((-3.0,) * 3, (4.0,) * 3, (0.0,) * 3)).lookup_direction(p, r), exact)
    # Edges between walls are as blunt as a texel is wide.
    assert np.median(error) < 0.02
    assert np.percentile(error, 99) < TEXEL_DEG


def test_more_fetches_come_closer() -> None:
    """From infinity, in a room: the search is a secant's, each step worth several of a bisection's."""
    p, r = rays(5000, seed=5)
    p = p + ROOM.origin
    exact = ROOM.lookup_direction(p, r)
    relief, error = relief_of(ROOM), []
    for fetches in (1, 2, 3, 4, 6):
        w = relief.inverse_hit(p, r, fetches)
        error.append(np.mean(angle_deg(r + w[:, None] * (p - ROOM.origin), exact)))
    assert all(after < before for before, after in pairwise(error))
    assert error[3] < 0.1 * error[0]


def test_neighbours_meet_the_samples_own_distance() -> None:
    p, r = rays(300, seed=6)
    p, r = np.stack([p, p + 0.01, p - 0.01]), np.stack([r, np.roll(r, 1, 1), -r])
    relief = relief_of(ROOM)
    d = lookup_directions(relief, p, r)
    w = relief.inverse_hit(p[0], r[0])
    np.testing.assert_array_equal(d[0], relief.lookup_direction(p[0], r[0]))
    np.testing.assert_allclose(d[1:], r[1:] + w[:, None] * (p[1:] - relief.origin), rtol=1e-15)
    shape = lookup_directions(ROOM, p, r)
    np.testing.assert_array_equal(shape, ROOM.lookup_direction(p, r))


def test_results_do_not_depend_on_the_unit_of_length() -> None:
    p, r = rays(2000, seed=7)
    p = p + ROOM.origin
    small = relief_of(ROOM, start=ROOM)
    k = 1024.0  # a power of two: half floats scale exactly, as far as they are normal
    large = Relief(
        (small.inverse_distance.astype(float) / k).astype(np.float16),
        tuple(k * np.array(small.lower)), tuple(k * np.array(small.upper)), tuple(k * np.array(small.origin)),
    )  # fmt: skip
    error = angle_deg(large.lookup_direction(k * p, r), small.lookup_direction(p, r))
    assert np.percentile(error, 99) < 0.02  # half floats below 6e-5 keep fewer digits


def test_steps_to_the_infinitely_far_do_not_hang_on_a_rounding() -> None:
    """Between a plate and the sky a secant through two zeros of M leads to w = 0, where the bracket ends."""
    direction = texel_directions(32)
    plate = (direction[..., 1] < -0.9) & (np.abs(direction[..., 0]) < 0.5)
    relief = Relief((1.2 * plate).astype(np.float16), (-2.0, -FAR_AWAY, -2.0), (2.0, 2.0, 2.0), (0.0, 0.0, 0.0))
    p, r = rays(20000, seed=13)
    moved = relief.inverse_hit(p + 1e-13, r)
    error = np.abs(moved - relief.inverse_hit(p, r))
    assert ((moved > 0.0) & (moved < 0.1)).any() and (moved == 0.0).any()  # rays by the plate's edge, and past it
    assert error.max() < 1e-9  # steep beside the edge


def test_compiled_search_is_the_same() -> None:
    p, r = rays(500, seed=8)
    p = p + ROOM.origin
    relief = relief_of(ROOM, start=Box((-3.0,) * 3, (4.0,) * 3, (0.0,) * 3))
    packed, faces = compiled_geometry(relief)
    found = np.array([inverse_hit(packed, faces, *p[k], *r[k]) for k in range(500)])
    # The packed origin is float32; where a step leaves its bracket the two may part, if it does so by rounding.
    assert np.percentile(np.abs(found - relief.inverse_hit(p, r)), 99) < 1e-5


def test_packing() -> None:
    packed = pack(relief_of(ROOM, start=ROOM))
    limit = 64.0 * float(relief_of(ROOM).inverse_distance.max())
    np.testing.assert_allclose(packed, [RELIEF, -2, -0.5, -3, limit, 2.5, 2, 3.5, 0, 0.1, 0.2, -0.3], rtol=1e-7)


def test_padded_lookups_are_the_texture_filters() -> None:
    """Over edges and corners too."""
    rng = np.random.default_rng(9)
    q = rng.random((6, 8, 8))
    _, r = rays(5000, seed=10)
    chain = MipChain(8)
    texels = np.zeros((chain.texel_count, 1))
    chain.level(texels, 0)[..., 0] = q
    expected = sample(chain, texels, r, np.zeros(len(r)))[:, 0]
    np.testing.assert_allclose(fetch(padded_faces(q), r), expected, rtol=1e-12)


def test_inverse_chebyshev_of_a_cube_is_constant() -> None:
    distance = 3.0 / np.abs(texel_directions(16)).max(-1)
    np.testing.assert_allclose(inverse_chebyshev(distance), 1.0 / 3.0, rtol=1e-12)
    assert (inverse_chebyshev(np.full((6, 4, 4), np.inf)) == 0.0).all()


def test_what_is_no_relief_is_refused() -> None:
    with pytest.raises(ValueError, match="half floats"):
        Relief(np.zeros((6, 8, 8)), *NOWHERE, (0.0, 0.0, 0.0))
