import json
from pathlib import Path

import numpy as np
import pytest

from reflet.scene.builtin.atlas import GUTTER, pack
from reflet.scene.builtin.newell import PARTS, patches
from reflet.scene.builtin.solids import box, cone, cylinder, quad, sphere
from reflet.scene.builtin.teapot import SCALE, evaluate, teapot_mesh
from reflet.scene.builtin.teapot_room import CEILING, FLOOR, HALF_DEPTH, HALF_WIDTH, teapot_room
from reflet.scene.meshes.corners import face_normals

TEAPOT = Path(__file__).parents[3] / "shared" / "data" / "teapot" / "teapot_newell_306.json"


def canonical(patch):
    """The least of the eight ways to run through a patch's points: patches are equal whatever their parameters."""
    ways = [way[::a, ::b] for way in (patch, patch.transpose(1, 0, 2)) for a in (1, -1) for b in (1, -1)]
    return min(tuple((np.round(way, 6) + 0.0).ravel()) for way in ways)


@pytest.mark.skipif(not TEAPOT.exists(), reason="needs the shared data")
def test_table_gives_exactly_newells_32_patches():
    data = json.loads(TEAPOT.read_text())
    theirs = np.array(data["vertices"])[np.array(data["patches"])].reshape(-1, 4, 4, 3)
    ours = np.concatenate([patches(part).reshape(-1, 4, 4, 3) for part in PARTS])
    assert len(ours) == 32
    assert sorted(map(canonical, ours)) == sorted(map(canonical, theirs))


def test_patches_close_around_and_follow_one_another():
    for part in PARTS:
        control = patches(part)
        np.testing.assert_allclose(control[:, :, :, 3], np.roll(control, -1, axis=1)[:, :, :, 0], atol=1e-12)
        np.testing.assert_allclose(control[:-1, :, 3], control[1:, :, 0], atol=1e-12)


@pytest.mark.parametrize("part", PARTS)
def test_normals_are_those_of_the_surface(part):
    """Against central differences, away from the poles; at the poles they are the axis; across patches they agree."""
    control = patches(part)
    t, u = np.linspace(0.1, 0.9, 5)[:, None], np.linspace(0.1, 0.9, 4)
    h = 1e-5
    for rows in control:
        rows = np.repeat(rows[None], len(t), axis=0)
        along, around = t[:, :, None], u[None, None, :]
        _, normal = evaluate(rows, along, around)
        da = evaluate(rows, along + h, around)[0] - evaluate(rows, along - h, around)[0]
        db = evaluate(rows, along, around + h)[0] - evaluate(rows, along, around - h)[0]
        expected = np.cross(da, db)
        expected /= np.linalg.norm(expected, axis=-1, keepdims=True)
        np.testing.assert_allclose(normal, expected, atol=1e-6)  # differences err by h² and by 1e-16/h
    u = np.linspace(0.0, 1.0, 5)[None, None, :]
    end = evaluate(control[:-1], np.ones((1, 1, 1)), u)[1]
    start = evaluate(control[1:], np.zeros((1, 1, 1)), u)[1]
    # Newell rounded his control points to 4 digits and the knob's to 2: smooth within 1e-2
    np.testing.assert_allclose(end, start, atol=1e-2)
    if part == "body":
        np.testing.assert_allclose(evaluate(control[-1:], np.ones((1, 1, 1)), u)[1][..., 2], -1.0, atol=1e-12)
    if part == "lid":
        np.testing.assert_allclose(evaluate(control[:1], np.zeros((1, 1, 1)), u)[1][..., 2], 1.0, atol=1e-12)


def test_mesh_has_39800_triangles_that_face_outwards():
    meshes = [teapot_mesh(part) for part in PARTS]
    assert sum(len(mesh.triangles) for mesh in meshes) == 39800
    at = np.concatenate([mesh.positions for mesh in meshes])
    np.testing.assert_allclose(at.min(axis=0), [-0.3, 0.0, -0.2], atol=1e-6)  # metres; Newell's box turned y up
    np.testing.assert_allclose(at.max(axis=0)[1:], [0.315, 0.2], atol=1e-6)
    assert abs(at[:, 0].max() - 0.34335) < 1e-4  # the spout's tip lies between two rings
    for mesh in meshes:
        corners = mesh.positions[mesh.triangles].astype(float)
        front, area = face_normals(corners.reshape(-1, 3))
        assert area.min() > 0.0
        np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-6)
        # the tightest bend, at the spout's lip, turns by less than 31° within one triangle
        assert np.einsum("ti,tki->tk", front, mesh.normals[mesh.triangles]).min() > np.cos(np.radians(31.0))
        assert np.einsum("ti,ti->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) > 0.0


def test_body_is_watertight_but_for_its_rim():
    """Every edge belongs to two triangles, running both ways, but for the 4·25 of the rim."""
    mesh = teapot_mesh("body")
    edges = np.concatenate([mesh.triangles[:, [k, (k + 1) % 3]] for k in range(3)]).astype(np.int64)
    forward, backward = edges[:, 0] << 32 | edges[:, 1], edges[:, 1] << 32 | edges[:, 0]
    assert len(np.unique(forward)) == len(forward)
    open_edges = edges[~np.isin(forward, backward)]
    assert len(open_edges) == 100
    np.testing.assert_allclose(mesh.positions[open_edges.ravel(), 1], 2.4 * SCALE, atol=1e-6)


@pytest.fixture(scope="module")
def room():
    return teapot_room()


def test_room_is_made_as_promised(room):
    names = [part.name for part in room.parts]
    assert [n for n, part in zip(names, room.parts, strict=True) if part.reflective] == list(PARTS)
    assert len(room.objects) == 1 and len(room.objects[0].parts) == 4
    assert room.triangle_offsets[-1] < 60_000
    for name in ("lamp", "window"):
        assert max(room.parts[names.index(name)].material.emission) > 1.0
    at = room.parts[names.index("room")].mesh.positions
    np.testing.assert_allclose(at.min(axis=0), [-HALF_WIDTH, FLOOR, -HALF_DEPTH], atol=1e-6)
    np.testing.assert_allclose(at.max(axis=0), [HALF_WIDTH, CEILING, HALF_DEPTH], atol=1e-6)


def test_room_is_closed_and_shows_its_fronts_inwards(room):
    """From where the teapot's lid is, every direction meets the front of a surface first."""
    surroundings = [part.mesh for part in room.parts if not part.reflective]
    triangles = np.concatenate([mesh.positions[mesh.triangles] for mesh in surroundings]).astype(float)
    directions = np.random.default_rng(0).normal(size=(200, 3))
    origin = np.array([0.1, 0.35, 0.05])
    e1, e2 = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    normals, to_origin = np.cross(e1, e2), origin - triangles[:, 0]
    q = np.cross(to_origin, e1)
    for d in directions:
        p = np.cross(d, e2)
        determinant = np.einsum("ti,ti->t", e1, p)
        safe = np.where(np.abs(determinant) < 1e-15, np.nan, determinant)
        u, v = np.einsum("ti,ti->t", to_origin, p) / safe, q @ d / safe
        t = np.einsum("ti,ti->t", e2, q) / safe
        hit = (u >= -1e-9) & (v >= -1e-9) & (u + v <= 1 + 1e-9) & (t > 0)
        assert hit.any()
        nearest = np.flatnonzero(hit)[t[hit].argmin()]
        assert normals[nearest] @ d < 0.0


def test_room_is_the_same_every_time(room):
    again = teapot_room()
    for a, b in zip(room.parts, again.parts, strict=True):
        np.testing.assert_array_equal(a.mesh.positions, b.mesh.positions)
    one, two = (scene.parts[0].material.base_color_texture_srgb.pixels for scene in (room, again))
    np.testing.assert_array_equal(one, two)


@pytest.mark.parametrize(
    ("solid", "volume", "tolerance"),
    [
        (box((3, 1, 2), (0.5, 0.6, 0.7), 0, turn_deg=30), 0.5 * 0.6 * 0.7, 1e-9),
        (sphere((3, 1, 2), 0.5, 0), 4 / 3 * np.pi * 0.125, 0.01),  # an inscribed polyhedron of 48 steps lacks 0.7 %
    ],
)
def test_closed_solids_have_their_volume(solid, volume, tolerance):
    at = solid.corners.reshape(-1, 3, 3) - (3, 1, 2)
    measured = np.einsum("ti,ti->", at[:, 0], np.cross(at[:, 1], at[:, 2])) / 6.0
    assert abs(measured / volume - 1.0) < tolerance


def test_solids_face_their_normals_and_show_pictures_unmirrored():
    """Seen from the front, u runs to the right and v down: (dP/du × dP/dv)·n < 0 on every triangle."""
    solids = [quad((0, 0, 0), (1, 0, 0), (0, -1, 0), 0), box((0, 0, 0), (1, 2, 3), 0), sphere((0, 0, 0), 1.0, 0),
              cylinder((0, 0, 0), 1.0, 2.0, 0, 0), cone((0, 0, 0), 1.0, 2.0, 0)]  # fmt: skip
    for solid in solids:
        front, _ = face_normals(solid.corners)
        assert (np.einsum("ti,tki->tk", front, solid.normals.reshape(-1, 3, 3)) > 0.9).all()
        (du1, dv1), (du2, dv2) = (np.moveaxis(solid.uv.reshape(-1, 3, 2)[:, k] - solid.uv[::3], 1, 0) for k in (1, 2))
        assert (du1 * dv2 - du2 * dv1 < 1e-12).all()


def test_atlas_keeps_every_tile_and_repeats_its_border():
    random = np.random.default_rng(0)
    shapes = [(5, 9), (20, 3), (7, 30), (1, 1), (20, 20), (6, 30)]
    tiles = [random.integers(1, 256, (*shape, 3)).astype(np.uint8) for shape in shapes]
    atlas, rectangles = pack(tiles, 40)
    height, width = atlas.shape[:2]
    for tile, (u, v, extent_u, extent_v) in zip(tiles, rectangles, strict=True):
        left, top, wide, high = (round(x) for x in (u * width, v * height, extent_u * width, extent_v * height))
        np.testing.assert_array_equal(atlas[top : top + high, left : left + wide, :3], tile)
        np.testing.assert_array_equal(atlas[top - GUTTER, left : left + wide, :3], tile[0])
        np.testing.assert_array_equal(atlas[top : top + high, left + wide + GUTTER - 1, :3], tile[:, -1])
