"""The benchmarks' scenes hold together: objects found, fronts towards the teapot, closed or open as they should be."""

import runpy
from pathlib import Path

import numpy as np
import pytest

from reflet.scene.meshes.corners import face_normals
from reflet.scene.scene import Scene

ROOMS = runpy.run_path(str(Path(__file__).parents[2] / "benchmarks" / "furniture_rooms.py"))


@pytest.fixture(scope="module")
def room() -> Scene:
    return ROOMS["furniture_room"](subdivisions=3)


@pytest.fixture(scope="module")
def yard() -> Scene:
    return ROOMS["half_open"](subdivisions=3)


def first_hits(scene: Scene, origin: np.ndarray, ray: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distances along unit rays to what does not reflect, infinite where nothing is; cosines of ray and normal."""
    corners = np.concatenate([p.mesh.positions[p.mesh.triangles] for p in scene.parts if not p.reflective]).astype(
        float
    )
    a, e1, e2 = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(e1, e2)
    denominator = ray @ normal.T
    with np.errstate(divide="ignore", invalid="ignore"):
        t = np.einsum("kc,kc->k", a - origin, normal) / denominator
        at = origin + t[..., None] * ray[:, None] - a
        b1 = np.einsum("rkc,kc->rk", np.cross(at, e2), normal) / (normal**2).sum(-1)
        b2 = np.einsum("rkc,kc->rk", np.cross(e1, at), normal) / (normal**2).sum(-1)
        hit = (t > 1e-6) & (b1 >= -1e-9) & (b2 >= -1e-9) & (b1 + b2 <= 1.0 + 1e-9)
    t = np.where(hit, t, np.inf)
    nearest = t.argmin(1)
    cosine = denominator[np.arange(len(ray)), nearest] / np.linalg.norm(normal[nearest], axis=1)
    return t.min(1), cosine


def rays(count: int, seed: int) -> np.ndarray:
    r = np.random.default_rng(seed).normal(size=(count, 3))
    return r / np.linalg.norm(r, axis=1, keepdims=True)


@pytest.mark.parametrize("name", ["room", "yard"])
def test_one_teapot_reflects_on_one_diffuse_part(name: str, request: pytest.FixtureRequest) -> None:
    scene = request.getfixturevalue(name)
    (teapot,) = scene.objects
    assert sorted(scene.parts[p].name for p in teapot.parts) == ["body", "handle", "lid", "spout"]
    low = min(float(scene.parts[p].mesh.positions[:, 1].min()) for p in teapot.parts)
    assert 0.0 <= low < 0.01  # it stands on y = 0
    reflecting = sum(len(scene.parts[p].mesh.triangles) for p in teapot.parts)
    assert reflecting == 276 + 132 + 72 + 72  # of 3 subdivisions
    assert 1000 < scene.triangle_offsets[-1] - reflecting < 10000
    for part in scene.parts:
        corners = part.mesh.positions[part.mesh.triangles].reshape(-1, 3)
        face, _ = face_normals(corners)
        normals = part.mesh.normals[part.mesh.triangles].mean(1)
        assert (np.einsum("kc,kc->k", face, normals) > 0.0).all()


def test_the_room_is_closed_and_shows_fronts(room: Scene) -> None:
    for seed, origin in enumerate([(0.0, 0.15, 0.0), (1.0, 1.5, -1.9), (-2.3, -0.6, 2.3)]):
        distance, cosine = first_hits(room, np.array(origin), rays(150, seed))
        assert np.isfinite(distance).all()
        assert (cosine < 0.0).all()
    extent = np.ptp(room.parts[0].mesh.positions, axis=0)
    np.testing.assert_allclose(extent, (5.0, 3.0, 5.0), atol=1e-6)


def test_the_shelf_is_half_a_metre_from_the_teapot(room: Scene) -> None:
    teapot = np.concatenate([part.mesh.positions for part in room.parts if part.reflective])
    ray = np.array([[0.0, 0.0, -1.0]])
    heights = np.array([-0.04, 0.29, 0.605])  # boards
    found = [first_hits(room, np.array([0.3, y, -0.55]), ray)[0][0] + 0.55 for y in heights]
    assert all(abs(z + float(teapot[:, 2].min()) - 0.5) < 0.02 for z in found)  # the belly is 0.2 m deep


def test_the_yard_is_open_above_and_before_the_wall(yard: Scene) -> None:
    origin, r = np.array([0.0, 0.15, 0.0]), rays(400, 7)
    distance, cosine = first_hits(yard, origin, r)
    assert (cosine[np.isfinite(distance)] < 0.0).all()
    up = r[:, 1] > 0.02
    assert np.isinf(distance[up & (r[:, 2] > 0.0)]).all()
    assert np.isfinite(distance[r[:, 1] < -0.2]).all()  # the floor reaches 6 m
    ahead = r[:, 2] < 0.0
    x, y = (r[ahead, k] / -r[ahead, 2] * 1.3 + origin[k] for k in (0, 1))
    onto_wall = (np.abs(x) < 2.4) & (y > -0.5) & (y < 1.6)
    assert onto_wall.sum() > 50 and np.isfinite(distance[ahead][onto_wall]).all()


def test_the_sky_has_a_soft_sun_where_it_says_and_no_seam() -> None:
    sky = ROOMS["sky"]()
    assert sky.dtype == np.float32 and sky.min() > 0.0 and 40.0 < sky.max() < 70.0  # half floats hold it
    row, column = np.unravel_index(sky[..., 0].argmax(), sky.shape[:2])
    theta, phi = np.pi * (row + 0.5) / 128, 2.0 * np.pi * ((column + 0.5) / 256 - 0.5)
    towards = np.array(ROOMS["SUN_TOWARDS"]) / np.linalg.norm(ROOMS["SUN_TOWARDS"])
    seen = np.array([np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)])
    assert np.degrees(np.arccos(seen @ towards)) < 1.4  # texels of 180/128 degrees
    steps = np.abs(np.diff(sky, axis=1, append=sky[:, :1]))[:64]
    assert steps[:, -1].max() < 1.5 * steps[:, [-2, 0]].max()
    assert steps.max() < 0.25 * sky.max()  # no texel is the sun's alone
