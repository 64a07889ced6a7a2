"""Fitted geometries against shapes whose fit is known."""

import numpy as np
import pytest
from synthetic import mirror_scene, sphere_mesh

from reflet.envmap.geometry import Box, Ellipsoid, Hemisphere, InfiniteSphere, Sphere
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.cube import texel_directions
from reflet.envmap.relief import Relief
from reflet.envmap.shapes import FAR_AWAY
from reflet.errors import RefletError
from reflet.infer.fit_geometry import bounding_ellipsoid, em_origin, fit
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.scene import Scene
from reflet.trace.layers import ShellProbe, Shells, StaticProbe


def box_mesh(lower: tuple[float, float, float], upper: tuple[float, float, float]) -> Mesh:
    """Twelve triangles; normals do not matter here."""
    low, high = np.array(lower), np.array(upper)
    corner = np.array([[(i >> k) & 1 for k in range(3)] for i in range(8)])
    quads = [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)]
    triangles = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))], np.uint32)
    positions = (low + corner * (high - low)).astype(np.float32)
    return Mesh(positions, np.zeros_like(positions), triangles)


@pytest.fixture(scope="module")
def scene() -> Scene:
    """A box of 0.4 × 0.2 × 0.3 m standing on y = 0.1."""
    return mirror_scene(box_mesh((-0.1, 0.1, -0.2), (0.3, 0.3, 0.1)))


def probe_of(origin: tuple[float, float, float], distance: np.ndarray) -> StaticProbe:
    texels = np.zeros((MipChain(distance.shape[-1]).texel_count, 3), np.float32)
    distance = distance.astype(np.float32)
    return StaticProbe(texels, distance, Shells(origin), (ShellProbe(texels, distance),))


def room_probe(lower: tuple[float, float, float], upper: tuple[float, float, float]) -> StaticProbe:
    """What stands at (0.1, 0.2, -0.05) sees of a closed room."""
    origin = np.array([0.1, 0.2, -0.05])
    d = texel_directions(64)
    return probe_of((0.1, 0.2, -0.05), np.maximum((lower - origin) / d, (upper - origin) / d).min(-1))


def test_the_origin_is_the_area_weighted_mean(scene: Scene) -> None:
    assert np.abs(np.subtract(em_origin(scene, (0,)), (0.1, 0.2, -0.05))).max() < 1e-7  # float32 corners


def test_the_least_ellipsoid_around_a_box(scene: Scene) -> None:
    """It touches all eight corners: radii of √3 half edges."""
    ellipsoid = bounding_ellipsoid(scene, (0,))
    assert np.abs(np.subtract(ellipsoid.centre, (0.1, 0.2, -0.05))).max() < 1e-6
    half = np.array([0.2, 0.1, 0.15]) * np.sqrt(3.0)
    assert np.abs(ellipsoid.radii / half - 1.02).max() < 1e-5  # the stated margin of 2 %


def test_the_least_ellipsoid_holds_a_lopsided_part_and_beats_the_box_around_it() -> None:
    """A box with a small sphere beside it: the centre moves, and nothing sticks out."""
    scene = mirror_scene(box_mesh((-0.1, 0.1, -0.2), (0.3, 0.3, 0.1)), sphere_mesh(0.05, 8, (0.6, 0.25, 0.0)))
    ellipsoid = bounding_ellipsoid(scene, (0, 1))
    points = np.concatenate([part.mesh.positions for part in scene.parts])
    inside = (((points - ellipsoid.centre) / ellipsoid.radii) ** 2).sum(1)
    assert inside.max() < 1.0
    around_box = np.prod(np.ptp(points, axis=0) / 2.0) * 3.0**1.5
    assert np.prod(ellipsoid.radii) < 0.95 * around_box


def test_a_sphere_mesh_gets_a_sphere() -> None:
    ellipsoid = bounding_ellipsoid(mirror_scene(sphere_mesh(0.3, 16, (0.1, 0.2, 0.3))), (0,))
    assert np.abs(np.divide(ellipsoid.radii, 0.3 * 1.02) - 1.0).max() < 1e-3
    sphere = fit("sphere", mirror_scene(sphere_mesh(0.3, 16)), (0,))
    assert isinstance(sphere, Sphere)
    assert abs(sphere.radii[0] - 0.306) < 1e-6


def test_a_box_map_takes_the_walls_and_stands_on_the_supporting_plane(scene: Scene) -> None:
    box = fit("box", scene, (0,), room_probe((-2.0, 0.1, -1.5), (2.5, 2.0, 1.0)))
    assert isinstance(box, Box)
    # Distances are float32 and walls are hit exactly: their median is a wall.
    assert np.abs(np.subtract(box.lower, (-2.0, 0.1, -1.5))).max() < 1e-5
    assert np.abs(np.subtract(box.upper, (2.5, 2.0, 1.0))).max() < 1e-5
    assert box.origin == (0.1, 0.2, -0.05)


def test_a_box_map_holds_the_object_where_the_environment_touches_it(scene: Scene) -> None:
    box = fit("box", scene, (0,), room_probe((-0.11, 0.1, -0.21), (0.15, 0.31, 0.11)))
    assert isinstance(box, Box)
    assert box.upper[0] >= 0.3
    assert box.lower[1] == pytest.approx(0.1)


def probe_of_sides(at: dict[int, float], size: int = 32) -> StaticProbe:
    """What is seen where only some faces of a cube see anything, each a plane before it at a coordinate."""
    origin, distance = (0.1, 0.2, -0.05), np.full((6, size, size), np.inf)
    for face, plane in at.items():
        distance[face] = (plane - origin[face // 2]) / texel_directions(size)[face, ..., face // 2]
    return probe_of(origin, distance)


def test_a_box_under_the_sky_has_the_sides_that_are_there(scene: Scene) -> None:
    """A floor and a wall on it: nothing is at the object's skin where nothing is."""
    box = fit("box", scene, (0,), probe_of_sides({3: 0.1, 5: -1.5}))
    assert isinstance(box, Box)
    assert box.lower == pytest.approx((-FAR_AWAY, 0.1, -1.5), rel=1e-6)
    assert box.upper == pytest.approx((FAR_AWAY,) * 3)
    p = np.array([[0.1, 0.25, 0.11], [0.1, 0.25, 0.11], [0.3, 0.2, 0.0]])
    r = np.array([[0.0, 0.0, -1.0], [0.6, 0.8, 0.0], [0.8, -0.6, 0.0]])
    expected = [[0.0, 0.05, -1.45], [0.6, 0.8, 0.0], [0.2 + 0.8 / 6.0, -0.1, 0.05]]
    found = box.lookup_direction(p, r)
    found[1] /= np.linalg.norm(found[1])
    np.testing.assert_allclose(found, expected, atol=1e-6)  # of the probe's float32


def test_a_side_of_which_most_is_open_is_open(scene: Scene) -> None:
    """Left 45 %, right 55 % of a side is a wall, above the floor, which counts for neither."""
    d = texel_directions(64)
    for share, there in ((0.45, False), (0.55, True)):
        probe = probe_of_sides({0: 2.0, 3: 0.1}, 64)
        right = d[0, ..., 2] / d[0, ..., 0] > 1.0 - 2.0 * share  # columns: shares of the solid angle to some 3 %
        with np.errstate(divide="ignore", invalid="ignore"):
            floor = np.where(d[0, ..., 1] < -0.06, -0.1 / d[0, ..., 1], np.inf)
        probe.distance[0] = np.minimum(np.where(right, probe.distance[0], np.inf), floor)
        box = fit("box", scene, (0,), probe)
        assert isinstance(box, Box)
        assert box.upper[0] == pytest.approx(2.0 if there else FAR_AWAY, rel=1e-6)


def test_a_box_open_below_has_no_floor(scene: Scene) -> None:
    """The object hangs in the air, under a ceiling and between walls."""
    box = fit("box", scene, (0,), probe_of_sides({0: 2.0, 1: -2.0, 2: 3.0, 4: 2.0, 5: -2.0}))
    assert isinstance(box, Box)
    assert box.lower == pytest.approx((-2.0, -FAR_AWAY, -2.0), rel=1e-6)
    assert box.upper == pytest.approx((2.0, 3.0, 2.0), rel=1e-6)


def test_the_floor_of_a_box_is_where_it_is_seen(scene: Scene) -> None:
    """An object that hangs a metre above the floor does not bring it along."""
    box = fit("box", scene, (0,), room_probe((-2.0, -0.9, -1.5), (2.5, 2.0, 1.0)))
    assert isinstance(box, Box)
    assert box.lower == pytest.approx((-2.0, -0.9, -1.5), abs=1e-5)


def test_spheres_take_the_typical_distance(scene: Scene) -> None:
    probe = probe_of((0.1, 0.2, -0.05), np.full((6, 16, 16), 3.0))
    for kind in ("sphere", "hemisphere", "ellipsoid"):
        shape = fit(kind, scene, (0,), probe)
        assert isinstance(shape, Ellipsoid | Hemisphere)
        # An ellipsoid's radii come from single coordinates of the points: their median lies within the radius.
        assert max(shape.radii) == pytest.approx(3.0) if kind != "ellipsoid" else 2.0 < max(shape.radii) <= 3.0
    hemisphere = fit("hemisphere", scene, (0,), probe)
    assert isinstance(hemisphere, Hemisphere)
    assert hemisphere.floor == pytest.approx(0.1)


def test_a_relief_of_a_room_meets_its_walls(scene: Scene) -> None:
    relief = fit("relief", scene, (0,), room_probe((-2.0, 0.1, -3.0), (2.5, 2.6, 1.5)))
    assert isinstance(relief, Relief)
    room = Box((-2.0, 0.1, -3.0), (2.5, 2.6, 1.5), relief.origin)
    rng = np.random.default_rng(0)
    r = rng.standard_normal((2000, 3))
    r /= np.linalg.norm(r, axis=1, keepdims=True)
    p = np.array([0.1, 0.2, -0.05]) + rng.uniform(-0.09, 0.09, (2000, 3))
    met, wall = relief.lookup_direction(p, r), room.lookup_direction(p, r)
    cosine = np.einsum("ni,ni->n", met, wall) / np.linalg.norm(met, axis=1) / np.linalg.norm(wall, axis=1)
    # Half floats, and edges between walls that are as blunt as a texel of 64 to 90 degrees.
    assert np.degrees(np.arccos(np.clip(np.median(cosine), -1.0, 1.0))) < 0.1
    assert np.degrees(np.arccos(np.percentile(cosine, 1))) < 1.4


def test_a_relief_holds_a_wall_under_an_open_sky(scene: Scene) -> None:
    """Of the box one side is there: searches begin at it or infinitely far, and the wall is where it is."""
    d = texel_directions(64)
    with np.errstate(divide="ignore"):
        distance = np.where(d[..., 0] > 0.8, 2.0 / d[..., 0], np.inf)
    relief = fit("relief", scene, (0,), probe_of((0.1, 0.2, -0.05), distance))
    assert isinstance(relief, Relief)
    assert relief.upper == pytest.approx((2.1, FAR_AWAY, FAR_AWAY)) and relief.lower == pytest.approx((-FAR_AWAY,) * 3)
    p, towards = np.array([0.1, 0.2, 0.45]), np.array([1.0, 0.0, 0.0])
    np.testing.assert_allclose(1.0 / relief.inverse_hit(p[None], towards[None]), 2.0, rtol=1e-3)  # of half floats
    np.testing.assert_array_equal(relief.lookup_direction(p[None], -towards[None]), -towards[None])


@pytest.mark.parametrize("kind", ["infinite_sphere", "sphere", "ellipsoid", "box", "relief"])
def test_an_infinitely_far_environment_needs_no_finite_shape(scene: Scene, kind: str) -> None:
    probe = probe_of((0.1, 0.2, -0.05), np.full((6, 16, 16), np.inf))
    assert isinstance(fit(kind, scene, (0,), probe), InfiniteSphere)


def test_a_hemisphere_under_the_open_sky_keeps_its_floor(scene: Scene) -> None:
    hemisphere = fit("hemisphere", scene, (0,), probe_of((0.1, 0.2, -0.05), np.full((6, 16, 16), np.inf)))
    assert isinstance(hemisphere, Hemisphere)
    assert hemisphere.floor == pytest.approx(0.1)
    assert min(hemisphere.radii) > 10.0


def test_an_unknown_kind_is_refused_in_one_sentence(scene: Scene) -> None:
    with pytest.raises(RefletError, match=r"geometry must be one of .* not cylinder\."):
        fit("cylinder", scene, (0,))


def test_the_least_ellipsoid_of_many_points_is_that_of_the_few_that_touch_it() -> None:
    """A point on an ellipsoid's surface in each direction of a cube's corners settles it, whatever lies inside."""
    random = np.random.default_rng(2)
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / np.sqrt(3.0)
    inside = random.normal(size=(4000, 3))
    inside *= 0.999 * random.random(4000)[:, None] / np.linalg.norm(inside, axis=1)[:, None]
    unit = np.concatenate([corners, inside])
    triangles = np.arange(8 + 4000).reshape(-1, 3).astype(np.uint32)
    positions = (unit * [0.3, 0.1, 0.2] + [1.0, 2.0, 3.0]).astype(np.float32)
    ellipsoid = bounding_ellipsoid(mirror_scene(Mesh(positions, np.zeros_like(positions), triangles)), (0,))
    # four hundred updates of the weights leave about 1/400 of what the points inside had; the margin is 2 %
    assert np.abs(np.divide(ellipsoid.radii, (0.306, 0.102, 0.204)) - 1.0).max() < 2.5e-3
    assert np.abs(np.subtract(ellipsoid.centre, (1.0, 2.0, 3.0))).max() < 1e-4
