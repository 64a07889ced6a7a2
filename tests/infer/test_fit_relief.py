"""Reliefs and boxes of distances that are known."""

import numpy as np
import pytest
from synthetic import mirror_scene, sphere_mesh

from reflet.envmap.parameterizations.cube import texel_directions
from reflet.envmap.relief import Relief
from reflet.envmap.shapes import FAR_AWAY, Box, InfiniteSphere
from reflet.infer import fit_relief
from reflet.infer.fit_geometry import fit
from reflet.infer.fit_relief import last_relief, median_box, near_relief, weighted_median
from reflet.infer.fit_shells import fit_shells
from reflet.trace.layers import ShellProbe, Shells, StaticProbe

ORIGIN = (0.1, 0.2, -0.3)
START = Box((-2.0, -1.0, -2.0), (2.0, 2.0, 2.0), ORIGIN)
HALF = 2.0**-11  # the rounding of half floats


def room(half: float, size: int) -> np.ndarray:
    """Distances to the walls of a cube from its middle: their inverse Chebyshev distance is 1/half everywhere."""
    return half / np.abs(texel_directions(size)).max(-1)


def walls(lower: tuple[float, float, float], upper: tuple[float, float, float], size: int) -> np.ndarray:
    """Distances from `ORIGIN` to the sides of a box around it; sides may be infinitely far."""
    d = texel_directions(size)
    return np.maximum((np.array(lower) - ORIGIN) / d, (np.array(upper) - ORIGIN) / d).min(-1)


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Reliefs of 8 rows, from probes of 16: blocks of 2 × 2."""
    monkeypatch.setattr(fit_relief, "RELIEF_SIZE", 8)


def test_a_near_relief_is_the_mean_over_what_is_there() -> None:
    distance = np.full((6, 16, 16), np.inf)
    distance[2, 4, 6], distance[2, 5, 7] = room(1.0, 16)[2, 4, 6], room(0.25, 16)[2, 5, 7]
    relief = near_relief(distance, ORIGIN, START)
    # 1/1 and 1/0.25 over two of the block's four texels; all else is filled in, from the one that is known
    assert relief.inverse_distance[2, 2, 3] == 2.5
    np.testing.assert_array_equal(relief.inverse_distance, 2.5)
    assert (relief.lower, relief.upper, relief.origin) == (START.lower, START.upper, ORIGIN)


def test_gaps_of_a_near_relief_go_on_as_what_is_around_them() -> None:
    """Of a wall all around, of which only some is there, exactly; between two depths, monotonically."""
    there = np.random.default_rng(0).random((6, 16, 16)) < 0.1
    relief = near_relief(np.where(there, room(0.4, 16), np.inf), ORIGIN, START)
    np.testing.assert_allclose(relief.inverse_distance, 2.5, rtol=2 * HALF)
    distance = room(1.0, 16)
    distance[4] = room(0.25, 16)[4]  # pz at 1/4 m, nz and the columns beside it at 1 m, nothing between
    distance[0, :, 2:14] = np.inf
    across = near_relief(distance, ORIGIN, START).inverse_distance[0].astype(float)  # pz is left of px
    assert (across[:, 0] == 1.0).all() and (across[:, -1] == 1.0).all()  # what is there stays
    assert across.min() >= 1.0 and across.max() < 4.0


def test_without_anything_a_near_relief_is_infinitely_far() -> None:
    assert not near_relief(np.full((6, 16, 16), np.inf), ORIGIN, InfiniteSphere()).inverse_distance.any()


def test_of_a_last_shell_the_nearest_counts() -> None:
    distance = room(2.0, 16)
    distance[1, 0, 3] = room(0.5, 16)[1, 0, 3]
    distance[5, 8:10, 8:10] = np.inf
    relief = last_relief(distance, ORIGIN, START)
    assert isinstance(relief, Relief)
    expected = np.full((6, 8, 8), 0.5)
    expected[1, 0, 1], expected[5, 4, 4] = 2.0, 0.0
    np.testing.assert_array_equal(relief.inverse_distance, expected)


def test_what_touches_the_origin_is_near_and_finite() -> None:
    """The floor on which a flat mirror lies: lookups end there, and nothing is not a number."""
    distance = np.where(texel_directions(8)[..., 1] < 0.0, 0.0, room(2.0, 8))
    for relief in (last_relief(distance, ORIGIN, START), near_relief(distance, ORIGIN, START)):
        assert isinstance(relief, Relief) and np.isfinite(relief.inverse_distance).all()
        assert relief.inverse_distance[3].min() >= 2.0**14 and np.isfinite(relief.limit)
        r = np.array([[0.6, -0.8, 0.0], [0.6, 0.8, 0.0]])
        found = relief.lookup_direction(np.array([[0.3, 0.2, -0.3]] * 2), r)
        assert np.isfinite(found).all()
        np.testing.assert_allclose(found[0] / found[0, 0], [1.0, 0.0, 0.0], atol=1e-3)  # what lies under the point
        np.testing.assert_allclose(found[1] / found[1, 1], [(0.2 + 1.5) / 2.0, 1.0, 0.0], rtol=1e-3)


def test_a_probe_smaller_than_a_relief_is_its_relief() -> None:
    relief = last_relief(room(2.0, 4), ORIGIN, InfiniteSphere())
    assert isinstance(relief, Relief) and relief.inverse_distance.shape == (6, 4, 4)
    assert relief.lower == (-FAR_AWAY,) * 3 and relief.upper == (FAR_AWAY,) * 3
    assert isinstance(last_relief(np.full((6, 4, 4), np.inf), ORIGIN, START), InfiniteSphere)


def test_the_median_box_of_a_room_is_the_room() -> None:
    lower, upper = (-2.0, -1.7, -2.4), (2.2, 2.0, 1.9)
    box = median_box(walls(lower, upper, 32), ORIGIN)
    assert isinstance(box, Box)
    # a face sees its own wall where the others do not stand before it: here most of each
    np.testing.assert_allclose([box.lower, box.upper], [lower, upper], rtol=1e-12)


def test_an_open_side_of_the_median_box_is_far_away() -> None:
    only = np.full((6, 16, 16), np.inf)
    only[3] = room(0.7, 16)[3]
    box = median_box(only, ORIGIN)
    assert isinstance(box, Box)
    assert box.lower == pytest.approx((-FAR_AWAY, ORIGIN[1] - 0.7, -FAR_AWAY))
    assert box.upper == pytest.approx((FAR_AWAY,) * 3)
    assert isinstance(median_box(np.full((6, 4, 4), np.inf), ORIGIN), InfiniteSphere)


def test_weighted_medians() -> None:
    assert weighted_median(np.array([3.0, 1.0, 2.0]), np.ones(3)) == 2.0
    assert weighted_median(np.array([3.0, 1.0, 2.0]), np.array([5.0, 1.0, 1.0])) == 3.0


SCENE = mirror_scene(sphere_mesh(0.2, 6, ORIGIN))


def probe(*distances: np.ndarray) -> StaticProbe:
    shells = tuple(ShellProbe(np.zeros((1, 3), np.float32), each.astype(np.float32)) for each in distances)
    layout = Shells(ORIGIN, tuple(1.0 + number for number in range(len(distances) - 1)))
    return StaticProbe(np.zeros((1, 3), np.float32), np.min(distances, 0).astype(np.float32), layout, shells)


def test_shells_have_the_geometries_of_what_they_hold() -> None:
    block = np.full((6, 16, 16), np.inf)
    block[3, 4:12, 4:12] = room(0.5, 16)[3, 4:12, 4:12]
    seen = probe(block, walls((-2.0, -1.5, -2.0), (2.0, 2.0, 2.0), 16))
    near, far = fit_shells(("relief", "box"), SCENE, (0,), seen)
    assert isinstance(near, Relief) and isinstance(far, Box)
    np.testing.assert_array_equal(near.inverse_distance[3], 2.0)  # filled in over the rest
    np.testing.assert_allclose([far.lower, far.upper], [(-2.0, -1.5, -2.0), (2.0, 2.0, 2.0)], rtol=1e-6)
    _, again = fit_shells(("relief", "relief"), SCENE, (0,), seen)
    assert isinstance(again, Relief) and (again.lower, again.upper) == (far.lower, far.upper)
    first, second, _ = fit_shells(("relief", "relief", "box"), SCENE, (0,), probe(block, block * 2.0, seen.distance))
    assert isinstance(first, Relief) and isinstance(second, Relief)
    np.testing.assert_allclose(2.0 * second.inverse_distance, first.inverse_distance, rtol=2 * HALF)
    assert fit_shells(("box",), SCENE, (0,), seen) == [fit("box", SCENE, (0,), seen)]


@pytest.mark.parametrize("last", ["relief", "box", "infinite_sphere"])
def test_shells_may_end_at_the_sky(last: str) -> None:
    """What is far is then the sphere at infinity, and this is a kind that can be asked for again."""
    block = np.full((6, 16, 16), np.inf)
    block[3] = room(0.5, 16)[3]
    geometries = fit_shells(("relief", last), SCENE, (0,), probe(block, np.full((6, 16, 16), np.inf)))
    assert [geometry.kind for geometry in geometries] == ["relief", "infinite_sphere"]
    again = fit_shells(["relief", "infinite_sphere"], SCENE, (0,), probe(block, np.full((6, 16, 16), np.inf)))
    assert again == geometries


@pytest.mark.parametrize("kinds", [("box", "relief"), ("relief", "ellipsoid"), ("relief", "hemisphere", "box")])
def test_other_kinds_of_shells_are_refused(kinds: tuple[str, ...]) -> None:
    with pytest.raises(ValueError, match="shells have reliefs"):
        fit_shells(kinds, SCENE, (0,), probe(*[room(2.0, 4)] * len(kinds)))
