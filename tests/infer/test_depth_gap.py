"""Gaps in depth of surroundings that are known."""

import numpy as np
import pytest

from reflet.envmap.parameterizations.cube import texel_directions
from reflet.infer.depth_gap import _pairs, _score, depth_gaps

SIZE = 32


def room(half: float) -> np.ndarray:
    """Distances to the walls of a cube from its middle."""
    return half / np.abs(texel_directions(SIZE)).max(-1)


def cap(axis: tuple[float, float, float], degrees: float) -> np.ndarray:
    """Directions within an angle of an axis."""
    return texel_directions(SIZE) @ np.divide(axis, np.linalg.norm(axis)) > np.cos(np.radians(degrees))


def test_a_block_before_walls_is_divided_from_them() -> None:
    """It stands 0.6 to 0.6/cos 25° away, the walls at least 2."""
    (end,) = depth_gaps(np.where(cap((0, -1, 0), 25.0), room(0.6), room(2.0)), 0.3, 1)
    assert 0.6 / np.cos(np.radians(25.0)) < end <= 2.0


@pytest.mark.parametrize("distance", [np.full((6, SIZE, SIZE), 2.0), room(2.0), np.full((6, SIZE, SIZE), np.inf)])
@pytest.mark.parametrize("most", [1, 2])
def test_surroundings_of_one_piece_have_no_gap(distance: np.ndarray, most: int) -> None:
    assert depth_gaps(distance, 0.3, most) == ()


def test_a_slope_has_no_gap() -> None:
    """Half the surroundings recede from 1 to 20, by less than a quarter from texel to texel: nothing divides them."""
    y = texel_directions(SIZE)[..., 1]
    assert depth_gaps(np.exp(np.log(20.0) * (y + 1.0) / 2.0), 0.3, 2) == ()


def test_the_sky_is_behind_all_that_is_finite() -> None:
    """However evenly far that is: here all of it is 2 metres away."""
    (end,) = depth_gaps(np.where(cap((1, 0.5, 0), 50.0), 2.0, np.inf), 0.3, 2)
    assert end > 2.0
    before_the_sky = np.where(cap((1, 0, 0), 40.0), 3.0, np.inf)
    near, far = sorted(depth_gaps(np.where(cap((1, 0, 0), 15.0), 0.8, before_the_sky), 0.3, 2))
    assert 0.8 < near <= 3.0 < far


def test_what_touches_the_origin_is_the_nearest() -> None:
    """The floor on which a flat mirror lies, under the middle of a room."""
    distance = np.where(texel_directions(SIZE)[..., 1] < 0.0, 0.0, room(2.0))
    (end,) = depth_gaps(distance, 0.3, 1)
    assert 0.3 <= end <= 2.0


def test_nothing_is_divided_below_the_object_itself() -> None:
    block = cap((0, -1, 0), 25.0)
    (end,) = depth_gaps(np.where(block, room(0.6), room(2.0)), 1.2, 1)
    assert 1.2 <= end <= 2.0
    assert depth_gaps(np.where(block, room(0.6), room(0.9)), 1.7, 1) == ()


THINGS = np.where(cap((0, -1, 0), 15.0), 0.5, np.where(cap((0, -1, 0), 40.0), 1.5, room(5.0)))


def test_of_two_gaps_the_stronger_one_comes_first() -> None:
    """A thing before a thing: the larger one is farther away; alone it is the gap that separates more."""
    stronger, weaker = depth_gaps(THINGS, 0.3, 2)
    assert 0.5 < weaker <= 1.5 < stronger <= 5.0
    assert depth_gaps(THINGS, 0.3, 1) == (stronger,)
    assert depth_gaps(THINGS, 0.3, 3) == (stronger, weaker)
    assert depth_gaps(THINGS, 0.3, 0) == ()


def test_one_gap_serves_things_apart() -> None:
    """Where nothing near hides what is less near, one distance separates both from the walls."""
    distance = np.where(cap((1, 1, 1), 20.0), 0.5, np.where(cap((0, -1, 0), 35.0), 1.5, room(5.0)))
    (end,) = depth_gaps(distance, 0.3, 2)
    assert 1.5 < end <= 5.0


def test_units_of_length_do_not_matter() -> None:
    ends = depth_gaps(THINGS, 0.3, 2)
    for scale in (1e-3, 1e3):
        assert depth_gaps(scale * THINGS, scale * 0.3, 2) == pytest.approx(np.multiply(scale, ends), rel=1e-12)


def test_pairs_go_over_all_twelve_edges_alike() -> None:
    """Faces of different depth: only pairs over edges differ, from either side `SIZE` of them an edge."""
    near, far = _pairs(np.broadcast_to(np.arange(1.0, 7.0)[:, None, None], (6, SIZE, SIZE)))
    pairs, counts = np.unique(np.round([near, far]), axis=1, return_counts=True)
    over_edges = pairs[0] != pairs[1]
    assert over_edges.sum() == 12 and (counts[over_edges] == 2 * SIZE).all()
    opposite = {(1.0, 2.0), (3.0, 4.0), (5.0, 6.0)}
    assert not opposite & {(float(a), float(b)) for a, b in pairs.T}


def test_a_cut_costs_half_of_what_a_jump_gains() -> None:
    """Of 12 jumps from 1 to 2 metres ten are left; 18 smooth pairs go from 1.3 to 1.5, two lie beyond."""
    near, far = np.array([1.0] * 12 + [1.3] * 18 + [1.6] * 2), np.array([2.0] * 12 + [1.5] * 18 + [1.7] * 2)
    jumps = np.arange(32) < 12
    left = jumps & (np.arange(32) < 10)
    assert _score(near, far, left, jumps, 1.4) == pytest.approx((10 - 0.5 * 18) / 12)
    assert _score(near, far, left, jumps, 1.2) == pytest.approx(10 / 12)
