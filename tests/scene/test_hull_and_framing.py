from dataclasses import replace

import numpy as np
import pytest

from reflet.errors import RefletError
from reflet.scene.assemble import assemble
from reflet.scene.bounds import bounding_sphere, object_positions, object_triangles, supporting_height
from reflet.scene.builtin.newell import PARTS
from reflet.scene.builtin.solids import box, sphere
from reflet.scene.builtin.teapot import teapot_mesh
from reflet.scene.builtin.teapot_room import teapot_room
from reflet.scene.material import MIRROR, EnvironmentLight, Material
from reflet.scene.meshes.corners import face_normals, weld
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.scene import Part, ReflectiveObject, Scene
from reflet.scene.surfaces.hull import TOLERANCE, hull_triangles
from reflet.scene.views.camera import Camera
from reflet.scene.views.framing import check_camera, frame_orbit, winding_number

SKY = EnvironmentLight(np.ones((2, 4, 3), np.float32))


def solid_mesh(solid):
    return weld(solid.corners, solid.normals)


def torus(major=1.0, minor=0.25, steps=48, around=16):
    theta, phi = (2 * np.pi * np.arange(n) / n for n in (steps, around))
    ring = major + minor * np.cos(phi)
    at = np.stack([ring * np.cos(theta)[:, None], np.broadcast_to(minor * np.sin(phi), (steps, around)),
                   -ring * np.sin(theta)[:, None]], -1).reshape(-1, 3)  # fmt: skip
    i, j = np.meshgrid(np.arange(steps), np.arange(around), indexing="ij")
    a, b = i * around + j, i * around + (j + 1) % around
    c, d = (i + 1) % steps * around + j, (i + 1) % steps * around + (j + 1) % around
    triangles = np.stack([a, c, d, a, d, b], -1).reshape(-1, 3)
    outside = np.repeat((np.cos(phi) + np.cos(phi + 2 * np.pi / around) > -1e-9)[None], steps, 0).ravel()
    centre = np.column_stack([major * np.cos(theta), np.zeros(steps), -major * np.sin(theta)]).repeat(around, axis=0)
    mesh = Mesh(at.astype(np.float32), ((at - centre) / minor).astype(np.float32), triangles.astype(np.uint32))
    return mesh, np.repeat(outside, 2)


@pytest.fixture(scope="module")
def teapot():
    return assemble([Part(name, teapot_mesh(name), MIRROR) for name in PARTS], environment=SKY)


def test_convex_shapes_lie_on_their_hull_and_other_parts_are_not_flagged():
    parts = [Part("ball", solid_mesh(sphere((0, 0, 0), 1.0, 0)), MIRROR),
             Part("cube", solid_mesh(box((5, 0, 0), (1, 1, 1), 0)), MIRROR),
             Part("wall", solid_mesh(box((0, 0, 9), (1, 1, 1), 0)), Material(metallic=0.0))]  # fmt: skip
    scene = assemble(parts, environment=SKY, reflect=["ball"])  # the wall does not
    flags = np.split(hull_triangles(scene), scene.triangle_offsets[1:-1])
    assert flags[0].all() and flags[1].all() and not flags[2].any()


def test_a_double_sided_shell_is_never_flagged():
    """Its inside mirrors the rest of it, and both sides look up the same layers."""
    metal = replace(MIRROR, double_sided=True)
    scene = assemble([Part("shell", solid_mesh(sphere((0, 0, 0), 1.0, 0)), metal)], environment=SKY)
    assert not hull_triangles(scene).any()


def test_a_shell_turned_inside_out_is_never_flagged():
    mesh = solid_mesh(sphere((0, 0, 0), 1.0, 0))
    scene = assemble([Part("ball", replace(mesh, triangles=mesh.triangles[:, ::-1].copy()), MIRROR)], environment=SKY)
    assert not hull_triangles(scene).any()


def test_a_torus_lies_on_its_hull_with_its_outer_half():
    mesh, outside = torus()
    np.testing.assert_array_equal(hull_triangles(assemble([Part("torus", mesh, MIRROR)], environment=SKY)), outside)


def test_parts_of_one_object_share_their_hull():
    """Two balls that touch: of each, the triangles whose plane has the other ball in front are not on the hull."""
    balls = [solid_mesh(sphere((x, 0, 0), 1.0, 0)) for x in (-1.0, 1.0)]
    scene = assemble([Part(n, ball, MIRROR) for n, ball in zip("ab", balls, strict=True)], environment=SKY)
    assert len(scene.objects) == 1
    normals, _ = face_normals(np.concatenate([ball.positions[ball.triangles] for ball in balls]).reshape(-1, 3))
    away = np.repeat([-1.0, 1.0], len(balls[0].triangles)) * normals[:, 0]
    flags = hull_triangles(scene)
    step = np.sin(np.pi / 24)  # facets that turn by less than a step to either side may go either way
    assert flags[away > step].all() and not flags[away < -step].any()


def test_teapot_share_is_that_of_a_teapot_and_no_vertex_lies_before_a_flagged_triangle(teapot):
    flags = hull_triangles(teapot)
    corners = object_triangles(teapot, 0)
    normals, areas = face_normals(corners.reshape(-1, 3))
    assert 0.30 < areas[flags].sum() / areas.sum() < 0.40  # the lower body, the rim, the tips of knob, spout and handle
    positions = object_positions(teapot, 0)
    some = np.flatnonzero(flags)[::7]
    heights = positions @ normals[some].T - np.einsum("ti,ti->t", corners[some, 0], normals[some])
    # 1e-7 for the rounding of normals and for another corner as the plane's foot
    assert heights.max() <= TOLERANCE * np.linalg.norm(np.ptp(positions, axis=0)) + 1e-7


def test_rays_from_flagged_triangles_leave_the_teapot(teapot):
    """Random rays above the planes of flagged triangles miss the object; from the others a good part hits it."""
    flags, corners = hull_triangles(teapot), object_triangles(teapot, 0)
    random = np.random.default_rng(1)
    normals, _ = face_normals(corners.reshape(-1, 3))
    e1, e2 = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]

    def hits(chosen):
        count = 0
        for k in chosen:
            d = random.normal(size=3)
            d /= np.linalg.norm(d)
            d -= 2.0 * min(d @ normals[k], 0.0) * normals[k]
            d += 0.001 * normals[k]  # where the project bends rays to
            o = corners[k].mean(axis=0)
            p, s = np.cross(d, e2), o - corners[:, 0]
            determinant = np.einsum("ti,ti->t", e1, p)
            safe = np.where(np.abs(determinant) < 1e-18, np.nan, determinant)
            q = np.cross(s, e1)
            u, v, t = np.einsum("ti,ti->t", s, p) / safe, q @ d / safe, np.einsum("ti,ti->t", e2, q) / safe
            count += bool(((u >= 0) & (v >= 0) & (u + v <= 1) & (t > 1e-6)).any())
        return count

    assert hits(random.choice(np.flatnonzero(flags), 120)) == 0
    assert hits(random.choice(np.flatnonzero(~flags), 120)) > 20


def test_supporting_plane_and_bounding_sphere(teapot):
    assert supporting_height(teapot, 0) == 0.0
    centre, radius = bounding_sphere(object_positions(teapot, 0))
    np.testing.assert_allclose(centre, [0.0217, 0.1575, 0.0], atol=1e-4)
    assert np.linalg.norm(object_positions(teapot, 0) - centre, axis=1).max() == pytest.approx(radius)


def test_default_orbit_shows_the_whole_object_from_everywhere(teapot):
    orbit = frame_orbit(teapot)
    assert (orbit.azimuth_deg, orbit.elevation_deg, orbit.fov_deg, orbit.image_size) == (60.0, 22.0, 36.0, 512)
    at = np.column_stack([object_positions(teapot, 0), np.ones(sum(len(p.mesh.positions) for p in teapot.parts))])
    largest = 0.0
    for azimuth in range(0, 360, 30):
        clip = at @ orbit.camera({"azimuth_deg": azimuth}).clip_from_world(0.1, 10.0).T
        largest = max(largest, np.abs(clip[:, :2] / clip[:, 3:]).max())
    assert 0.8 < largest < 1.0  # near the picture's edge, never beyond


def test_given_values_are_kept(teapot):
    given = {"azimuth_deg": 10.0, "elevation_deg": -5.0, "distance": 2.0, "fov_deg": 50.0}
    orbit = frame_orbit(teapot, **given, target=(0.0, 0.1, 0.2), image_size=64)
    assert (orbit.azimuth_deg, orbit.elevation_deg, orbit.distance) == (10.0, -5.0, 2.0)
    assert (orbit.target, orbit.fov_deg, orbit.image_size) == ((0.0, 0.1, 0.2), 50.0, 64)


def test_camera_stays_within_the_walls():
    """A ball of radius 1 in a room whose walls stand 2 m from its centre: without them it would go to 3.4 m."""
    walls = solid_mesh(box((0, 0, 0), (4, 4, 4), 0))
    inwards = replace(walls, triangles=walls.triangles[:, ::-1].copy())
    ball = Part("ball", solid_mesh(sphere((0, 0, 0), 1.0, 0)), MIRROR)
    scene = assemble([ball, Part("walls", inwards, Material(metallic=0.0))], environment=SKY)
    orbit = frame_orbit(scene)
    nearest_wall = 2.0 / np.cos(np.radians(22.0))  # at φ = 0
    assert orbit.distance == pytest.approx(0.95 * nearest_wall, rel=1e-6)
    for azimuth in range(0, 360, 15):
        position = np.array(orbit.camera({"azimuth_deg": azimuth}).position)
        assert np.abs(position).max() < 2.0 and np.linalg.norm(position) > 1.0
    assert frame_orbit(teapot_room()).distance == pytest.approx(1.135, abs=0.01)  # that room is large enough


def test_winding_number_of_closed_and_half_spheres():
    ball = solid_mesh(sphere((0, 0, 0), 1.0, 0))
    triangles = ball.positions[ball.triangles].astype(float)
    for point, inside in (((0.3, 0.2, -0.4), 1.0), ((1.2, 0.0, 0.3), 0.0)):
        assert winding_number(np.array(point), triangles) == pytest.approx(inside, abs=1e-6)  # float32 positions
    upper = triangles[triangles[:, :, 1].min(axis=1) > -1e-6]
    assert winding_number(np.zeros(3), upper) == pytest.approx(0.5, abs=1e-6)  # half of all directions


def test_cameras_inside_an_object_are_refused(teapot):
    check_camera(teapot, frame_orbit(teapot).camera())
    check_camera(teapot, Camera((0.0, 0.5, 0.0), (0.1, 0.0, 0.0)))  # above the lid
    with pytest.raises(RefletError, match=r"is inside body\+lid\+handle\+spout; choose a larger distance"):
        check_camera(teapot, Camera((0.05, 0.12, 0.03), (1.0, 0.1, 0.0)))


def test_a_camera_before_stacked_sheets_is_not_inside_them():
    """Four sheets one behind the other fill more than half of all that can be seen, added up."""
    edge = np.array([[-1, 0, -1], [-1, 0, 1], [1, 0, 1], [1, 0, -1]], np.float32)
    positions = np.concatenate([edge - np.float32([0, 0.01 * k, 0]) for k in range(4)])
    triangles = np.concatenate([np.array([[0, 1, 2], [0, 2, 3]]) + 4 * k for k in range(4)]).astype(np.uint32)
    sheets = Mesh(positions, np.tile(np.float32([0, 1, 0]), (16, 1)), triangles)
    scene = assemble([Part("sheets", sheets, MIRROR)], environment=SKY)
    position = (0.0, 0.3, 0.0)
    assert winding_number(np.array(position), object_triangles(scene, 0)) < -0.5
    check_camera(scene, Camera(position, (0.0, 0.0, 0.01)))


def test_the_nearest_wall_is_found_among_triangles_without_area():
    walls = solid_mesh(box((0, 0, 0), (4, 4, 4), 0))
    sliver = np.array([[0, 0, 0], [0, 0, 1]], np.uint32)
    part = Part("walls", replace(walls, triangles=np.concatenate([sliver, walls.triangles])), Material(metallic=0.0))
    ball = Part("ball", solid_mesh(sphere((0, 0, 0), 1.0, 0)), MIRROR, True)
    scene = Scene((ball, part), (ReflectiveObject("ball", (0,)),), SKY)
    # level with the target the nearest wall stands 2 m away, at φ = 0
    assert frame_orbit(scene, elevation_deg=0.0).distance == pytest.approx(0.95 * 2.0, rel=1e-6)
