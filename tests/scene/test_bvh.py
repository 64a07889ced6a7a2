"""The tree of a scene's mirrors: it finds what brute force finds, stays shallow, and knows where rays may go."""

from dataclasses import replace

import numpy as np
import pytest

from reflet.scene.bvh.build import build_bvh
from reflet.scene.bvh.bvh import LARGEST_LEAF, MOST_DEPTH, Bvh, corners_of, met_triangles
from reflet.scene.bvh.closest_hit import closest_hits
from reflet.scene.bvh.compiled_split import split
from reflet.scene.bvh.nodes import checked_bvh, refitted
from reflet.scene.material import Material
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.meshes.primitives import sphere_mesh, torus_mesh
from reflet.scene.scene import Part, ReflectiveObject, Scene
from reflet.scene.surfaces.hull import hull_triangles

MIRROR = Material(metallic=1.0)


def soup(corners: np.ndarray, material: Material = MIRROR) -> Part:
    """Triangles that share nothing."""
    positions = np.asarray(corners, np.float32).reshape(-1, 3)
    triangles = np.arange(len(positions), dtype=np.uint32).reshape(-1, 3)
    return Part("soup", Mesh(positions, np.zeros_like(positions), triangles), material, True)


def scene_of(*parts: Part) -> Scene:
    """All that reflects is one object."""
    named = tuple(replace(part, name=f"{part.name} {k}") for k, part in enumerate(parts))
    reflective = tuple(k for k, part in enumerate(parts) if part.reflective)
    return Scene(named, (ReflectiveObject("object", reflective),))


def all_on_hull(scene: Scene) -> np.ndarray:
    """No direction is asked about: that takes long where all triangles are in each other's way."""
    return np.ones(scene.triangle_offsets[-1], bool)


def depths(leaf_counts: np.ndarray) -> np.ndarray:
    """How many inner nodes lie above each node."""
    out, pending = [], [0]
    for count in leaf_counts:
        depth = pending.pop()
        out.append(depth)
        pending += [depth + 1] * 2 if count == 0 else []
    assert not pending
    return np.array(out)


def brute_force(corners: np.ndarray, origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The nearest triangle and its distance in float64, -1 and infinity for none."""
    a, e1, e2 = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    h = np.cross(directions[:, None], e2)
    det = np.einsum("tc,rtc->rt", e1, h)
    det = np.where(det == 0.0, np.nan, det)
    w = origins[:, None] - a
    q = np.cross(w, e1)
    b1, b2 = np.einsum("rtc,rtc->rt", w, h) / det, np.einsum("rc,rtc->rt", directions, q) / det
    t = np.einsum("tc,rtc->rt", e2, q) / det
    t = np.where((b1 >= 0) & (b2 >= 0) & (b1 + b2 <= 1) & (t > 0), t, np.inf)
    return np.where(np.isfinite(t.min(1)), t.argmin(1), -1), t.min(1)


def hits(scene: Scene, bvh: Bvh, origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The scene's number of the triangle that each ray meets, -1 for none, and the distance."""
    corners = corners_of(scene, bvh.order)
    place, at = closest_hits(refitted(bvh.leaf_counts, corners), corners, origins, directions)
    return np.where(place >= 0, bvh.order[place].astype(np.int64), -1), at[:, 0]


def rays(count: int, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """From a cube around the origin, in all directions, many of them along axes."""
    random = np.random.default_rng(seed)
    directions = random.normal(size=(count, 3))
    directions[::7, 0] = 0.0
    directions[::21, 1] = 0.0
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return random.uniform(-1, 1, (count, 3)).astype(np.float32), directions.astype(np.float32)


def test_rays_find_what_brute_force_finds() -> None:
    """Among triangles of all sizes, some without area; of parts that do not reflect those alone that are close."""
    random = np.random.default_rng(0)
    corners = random.uniform(-1, 1, (600, 1, 3)) + random.normal(size=(600, 3, 3)) * 10.0 ** random.uniform(
        -3, -0.5, (600, 1, 1)
    )
    corners[:20, 2] = corners[:20, 1]
    wall = replace(soup(random.uniform(-1, 1, (50, 3, 3)) * (9, 1, 1)), reflective=False)
    beside = random.uniform(-1, 1, (30, 3, 3))
    scene = scene_of(wall, soup(corners), replace(soup(beside), reflective=False))
    bvh = build_bvh(scene, all_on_hull(scene))
    assert bvh.companions == (2,) and len(bvh.order) == 630
    corners = np.concatenate([corners, beside])
    origins, directions = rays(700)
    found, distance = hits(scene, bvh, origins, directions)
    expected, expected_distance = brute_force(
        corners.astype(np.float32).astype(np.float64), origins.astype(np.float64), directions.astype(np.float64)
    )
    expected = np.where(expected >= 0, expected + 50, -1)
    assert 150 < (found >= 0).sum() < 650
    assert (found != expected).mean() < 0.003  # rays through edges, where float32 decides otherwise
    same = (found == expected) & (found >= 0)
    np.testing.assert_allclose(distance[same], expected_distance[same], rtol=1e-4)  # flat hits lose digits


@pytest.mark.parametrize(
    "corners",
    [
        np.zeros((5000, 3, 3)),  # all in one point
        np.tile(np.random.default_rng(2).uniform(size=(1, 3, 3)), (5000, 1, 1)),  # one triangle many times
        np.random.default_rng(3).normal(size=(300, 3, 3)) * 2.0 ** -np.arange(300)[:, None, None],  # ever smaller
        np.random.default_rng(4).normal(size=(200, 3, 3)) * 1e37,  # areas overflow float32
        np.cumprod(np.full((120, 1, 1), 1.9), axis=0) * np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]]),
        np.random.default_rng(5).normal(size=(1, 3, 3)),
    ],
    ids=["a point", "coincident", "ever smaller", "huge", "ever larger", "one"],
)
def test_trees_stay_shallow_and_whole(corners: np.ndarray) -> None:
    scene = scene_of(soup(corners))
    bvh = build_bvh(scene, all_on_hull(scene))
    checked_bvh(scene, bvh.order, bvh.leaf_counts, bvh.directions)
    leaves = bvh.leaf_counts > 0
    assert bvh.leaf_counts.max() <= LARGEST_LEAF
    assert depths(bvh.leaf_counts)[leaves].max() <= MOST_DEPTH
    # What is on the device: 32 bytes a node, 48 a triangle, 8 of directions.
    assert 32 * len(bvh.leaf_counts) + 56 * len(corners) <= 150 * len(corners)


def test_numbers_that_are_none_do_no_harm() -> None:
    boxes = np.random.default_rng(0).uniform(size=(1000, 6))
    boxes[:, 3:] += boxes[:, :3]
    boxes[::3, 1] = np.nan
    order, leaf_counts = split(boxes, LARGEST_LEAF, MOST_DEPTH)
    assert sorted(order) == list(range(1000))
    assert leaf_counts.sum() == 1000


def test_directions_are_found_in_bounded_time_among_triangles_that_coincide() -> None:
    """Every ray would look at all of them. What is not known counts."""
    corners = np.tile(np.random.default_rng(2).uniform(size=(1, 3, 3)), (700, 1, 1))
    scene = scene_of(soup(corners))
    bvh = build_bvh(scene, np.zeros(700, bool))
    assert (bvh.directions[:, 1] >> 24 == 0xFF).all()  # the last row of cells


def test_equal_scenes_have_equal_trees() -> None:
    scene = scene_of(Part("torus", torus_mesh(0.3, 0.12, around=60, sides=30), MIRROR, True))
    first, second = (build_bvh(scene, hull_triangles(scene)) for _ in range(2))
    for name in ("order", "leaf_counts", "directions"):
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))


def cells(directions: np.ndarray) -> np.ndarray:
    """The cell of each direction, by the octahedral map of CONVENTIONS.md."""
    x, y, z = (directions / np.abs(directions).sum(1, keepdims=True)).T
    below = y < 0
    s = np.where(below, (1 - np.abs(z)) * np.where(x < 0, -1, 1), x)
    t = np.where(below, (1 - np.abs(x)) * np.where(z < 0, -1, 1), z)
    return 8 * np.minimum(4 * t + 4, 7).astype(int) + np.minimum(4 * s + 4, 7).astype(int)


def departures(scene: Scene, triangles: np.ndarray, back: np.ndarray, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Rays from random points of triangles, off their fronts or backs."""
    random = np.random.default_rng(seed)
    corners = corners_of(scene, triangles).astype(np.float64)
    b = random.dirichlet((1, 1, 1), len(triangles))
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals *= np.where(back, -1, 1)[:, None] / np.linalg.norm(normals, axis=1, keepdims=True)
    directions = random.normal(size=(len(triangles), 3))
    directions *= np.sign((directions * normals).sum(1))[:, None]
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    origins = np.einsum("rk,rkc->rc", b, corners) + 1e-5 * normals
    return origins.astype(np.float32), directions.astype(np.float32)


@pytest.mark.parametrize("double_sided", [False, True])
def test_directions_miss_few_rays_that_meet_something(double_sided: bool) -> None:
    """On a torus, from both sides where both are seen; on the hull no ray does."""
    material = replace(MIRROR, double_sided=double_sided)
    scene = scene_of(Part("torus", torus_mesh(0.3, 0.12, around=96, sides=48), material, True))
    on_hull = hull_triangles(scene)
    bvh = build_bvh(scene, on_hull)
    random = np.random.default_rng(5)
    triangles = random.integers(0, len(on_hull), 200_000).astype(np.uint32)
    origins, directions = departures(scene, triangles, double_sided & (random.uniform(size=len(triangles)) < 0.5), 6)
    met = hits(scene, bvh, origins, directions)[0] >= 0
    bits = np.empty((len(on_hull), 2), np.uint32)
    bits[bvh.order] = bvh.directions
    cell = cells(directions.astype(np.float64))
    sought = (bits[triangles, cell >> 5] >> (cell & 31).astype(np.uint32)) & 1 == 1
    assert met.mean() > 0.05
    assert (met & ~sought).sum() < 0.003 * met.sum()
    assert sought.mean() < (0.9 if double_sided else 0.5)  # from inside a tube every ray meets its wall
    if not double_sided:
        assert on_hull.any()
        assert not bits[on_hull].any()


def test_the_hull_of_one_object_sees_another() -> None:
    left = torus_mesh(0.3, 0.12, around=48, sides=24)
    right = replace(left, positions=left.positions + np.float32([1.2, 0.0, 0.0]))
    parts = Part("left", left, MIRROR, True), Part("right", right, MIRROR, True)
    scene = Scene(parts, (ReflectiveObject("left", (0,)), ReflectiveObject("right", (1,))))
    bvh, on_hull = build_bvh(scene, hull_triangles(scene)), hull_triangles(scene)
    looks = bvh.directions[on_hull[bvh.order]].any(1)
    assert 0.2 < looks.mean() < 0.9


def test_patches_share_what_large_meshes_ask() -> None:
    """More triangles than patches: as few rays are missed."""
    scene = scene_of(Part("torus", torus_mesh(0.3, 0.12, around=240, sides=120), MIRROR, True))
    bvh = build_bvh(scene, hull_triangles(scene))
    triangles = met_triangles(scene, ())
    origins, directions = departures(scene, triangles, np.zeros(len(triangles), bool), 7)
    met = hits(scene, bvh, origins, directions)[0] >= 0
    bits = np.empty((len(triangles), 2), np.uint32)
    bits[bvh.order] = bvh.directions
    cell = cells(directions.astype(np.float64))
    sought = (bits[triangles, cell >> 5] >> (cell & 31).astype(np.uint32)) & 1 == 1
    assert len(triangles) > 2**14
    assert (met & ~sought).sum() < 0.003 * met.sum()


def test_the_hull_sees_companions_and_companions_see_nothing() -> None:
    """A ball, all of it on its hull, beside a sheet: rays are sought on the side of the sheet, and none from it."""
    ball = sphere_mesh(0.3, (0.0, 0.0, 0.0), 12)
    sheet = replace(soup([[(0.45, -0.2, -0.2), (0.45, 0.2, -0.2), (0.45, 0.0, 0.3)]]), reflective=False)
    alone, both = scene_of(Part("ball", ball, MIRROR, True)), scene_of(Part("ball", ball, MIRROR, True), sheet)
    assert not build_bvh(alone, hull_triangles(alone)).directions.any()
    bvh = build_bvh(both, hull_triangles(both))
    middle = corners_of(both, bvh.order).mean(1)
    looks, of_ball = bvh.directions.any(1), bvh.order < len(ball.triangles)
    assert looks[of_ball & (middle[:, 0] > 0.25)].all()
    assert not looks[of_ball & (middle[:, 0] < -0.1)].any() and not looks[~of_ball].any()
