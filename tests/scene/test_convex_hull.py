"""Convex hulls against a comparison with every point."""

import numpy as np
import pytest

from reflet.scene.meshes.convex_hull import all_behind, convex_hull

RANDOM = np.random.default_rng(5)
BALL = RANDOM.normal(size=(3000, 3))
BALL /= np.linalg.norm(BALL, axis=1)[:, None]
GRID = np.stack(np.meshgrid(*[np.linspace(-1.0, 1.0, 9)] * 3), -1).reshape(-1, 3)
TURN = np.linalg.qr(RANDOM.normal(size=(3, 3)))[0]

SETS = {
    "cloud": RANDOM.normal(size=(3000, 3)) * [1.0, 2.0, 5.0],
    "all on the hull": BALL,
    "many in one plane": GRID @ TURN,
    "flat": GRID[GRID[:, 2] == 0.0],
    "flat and turned": GRID[GRID[:, 2] == 0.0] @ TURN,
    "straight": np.linspace(-1.0, 2.0, 50)[:, None] * TURN[0],
    "three points": BALL[:3],
    "two points": BALL[:2],
    "one point twice": BALL[[0, 0]],
    "one point": BALL[:1],
}


@pytest.mark.parametrize("name", SETS)
def test_planes_have_all_points_behind_them_or_not(name: str) -> None:
    points = SETS[name]
    normals = RANDOM.normal(size=(4000, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    normals[:3] = np.eye(3)
    reach = (normals @ points.T).max(axis=1)
    away = RANDOM.choice([-1e-9, 1e-9], size=len(normals))  # of coordinates up to 20: far above their rounding
    found = all_behind(convex_hull(points), normals, reach + away)
    np.testing.assert_array_equal(found, away > 0.0)


def test_points_inside_are_no_vertices() -> None:
    assert len(convex_hull(GRID @ TURN).vertices) == 8
    assert len(convex_hull(BALL).vertices) == len(BALL)
