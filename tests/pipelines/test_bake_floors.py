"""Bakes of models on floors: what mirrors show of them, and what is seen of the floors themselves."""

from pathlib import Path

import numpy as np
import pytest

import reflet
from reflet.pipelines.verify_bounces import verify_bounces
from reflet.scene import floor as floors
from reflet.scene.assemble import assemble
from reflet.scene.floor import with_floor
from reflet.scene.floor_kinds import RADIUS, Floor
from reflet.scene.material import COAT_F0, EnvironmentLight, Material
from reflet.scene.meshes.primitives import sphere_mesh
from reflet.scene.scene import Part, Scene
from reflet.scene.views.framing import frame_orbit
from reflet.scene.views.parameter_space import orbit_space
from reflet.trace.light.floor_shadow import floor_shadow

HALVES = EnvironmentLight(np.repeat([[[1.0] * 3] * 32, [[0.5] * 3] * 32], 8, axis=0).astype(np.float32))
WHITE_MIRROR = Material("mirror", (1.0, 1.0, 1.0), 1.0, 0.0)
SMALL = {"em_size": 16, "spp": 16, "sample_count": 4, "codec": "none"}
SIZE = 48


def ball() -> Scene:
    return assemble([Part("ball", sphere_mesh(0.5, (0.0, 0.5, 0.0), 64), WHITE_MIRROR)], environment=HALVES)


def picture(scene: Scene, folder: Path, views: int = 0) -> np.ndarray:
    orbit = frame_orbit(scene, image_size=SIZE, elevation_deg=30.0)
    reflet.bake(scene, folder, orbit_space(orbit, views, 5.0), static=not views, **SMALL)
    pem = reflet.open_pem(folder)
    return np.asarray(reflet.Renderer(pem).frame(orbit.camera({"azimuth_deg": 60.0}), samples=64))


def on_the_ground(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Where each pixel's middle looks at the ground: metres from the ball, and the cosine with the normal."""
    camera = frame_orbit(scene, image_size=SIZE, elevation_deg=30.0).camera({"azimuth_deg": 60.0})
    eye = np.array(camera.position)
    forward = (camera.target - eye) / np.linalg.norm(camera.target - eye)
    right = np.cross(forward, (0.0, 1.0, 0.0)) / np.linalg.norm(np.cross(forward, (0.0, 1.0, 0.0)))
    at = np.tan(np.radians(camera.fov_deg / 2.0)) * (2.0 * (np.arange(SIZE) + 0.5) / SIZE - 1.0)
    x, y = np.meshgrid(at, at)
    way = forward + x[..., None] * right - y[..., None] * np.cross(right, forward)
    way /= np.linalg.norm(way, axis=-1, keepdims=True)
    place = eye - way * (eye[1] / way[..., 1])[..., None]
    return np.hypot(place[..., 0], place[..., 2]), -way[..., 1]


def beside_the_ball() -> np.ndarray:
    """Pixels outside its outline, which nearly fills the picture."""
    row, column = np.mgrid[:SIZE, :SIZE] + 0.5 - SIZE / 2
    return np.hypot(row, column) > SIZE / 2 + 1


@pytest.mark.slow
def test_a_polished_floor_shows_the_sky_over_the_ground(tmp_path: Path) -> None:
    """A ground of albedo 1/2 under a sky of 1: (1 - f)/2 + f, f by Schlick's law and the coat's share."""
    scene = with_floor(ball(), Floor(kind="polished", roughness=0.0))
    seen = picture(scene, tmp_path / "pem", views=1)[..., :3]
    assert np.isfinite(seen).all()
    away, cosine = on_the_ground(scene)
    none, last = floors.FADE * RADIUS * np.sqrt(3.0), np.sqrt(0.5)  # of a box of 1 m a side
    share = np.clip((none - away) / (none - last), 0.0, 1.0)
    f = share * share * (3.0 - 2.0 * share) * (COAT_F0 + (1.0 - COAT_F0) * (1.0 - cosine) ** 5)
    far = beside_the_ball() & (np.mgrid[:SIZE, :SIZE][0] < 6)  # of whose sky the ball hides less than 1 %
    assert f[far].min() > 0.1
    # 32 paths a sample, 8 bits of the ground's picture
    np.testing.assert_allclose(seen[far].mean(0), (0.5 * (1.0 - f[far]) + f[far]).mean(), rtol=0.02)


def test_of_a_shadow_nothing_else_is_seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """x metres from where a ball of radius r lies it hides (1 + x²/r²)^(-3/2) of an even sky; there is as much less of
    the environment behind."""
    monkeypatch.setattr(floors, "SHADOW_SIZE", 256)
    scene = with_floor(ball(), Floor(kind="shadow"), floor_shadow)
    seen = picture(scene, tmp_path / "pem")[..., :3].mean(-1)
    away, _ = on_the_ground(scene)
    expected = 0.5 * (1.0 - (1.0 + (away / 0.5) ** 2) ** -1.5)
    dark = beside_the_ball() & (np.mgrid[:SIZE, :SIZE][0] >= SIZE // 2)
    assert expected[dark].min() < 0.47
    assert np.abs(seen - expected)[dark].mean() < 0.025  # 64 samples a pixel, each of the environment or black
    # the same, by pixels of 5 % of the ball, and texels of 3 %
    np.testing.assert_allclose(seen[dark].mean(), expected[dark].mean(), atol=0.006)
    np.testing.assert_allclose(seen[:2, [0, 1, -2, -1]], 0.5, rtol=0.01)
    pem = reflet.open_pem(tmp_path / "pem")
    bounces = verify_bounces(pem, pem.space.orbit.camera({"azimuth_deg": 60.0}))
    assert bounces.rays > 100 and bounces.equal_share > 0.999  # but for those that part at random at the shadow
    assert bounces.difference < 1e-3
