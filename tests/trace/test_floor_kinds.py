"""Floors that mirror the model, and floors of which nothing but its shadow is seen."""

from dataclasses import replace

import mitsuba as mi
import numpy as np
import pytest

from reflet.envmap.parameterizations.latlong import LatLong
from reflet.errors import RefletError
from reflet.scene import floor as floors
from reflet.scene.assemble import assemble
from reflet.scene.companions import companions
from reflet.scene.floor import with_floor
from reflet.scene.floor_kinds import RADIUS, Floor
from reflet.scene.material import COAT_F0, EnvironmentLight, Material, Refraction
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.meshes.primitives import sphere_mesh
from reflet.scene.scene import Part, ReflectiveObject, Scene
from reflet.scene.surface_mean import coat_mean
from reflet.scene.views.framing import frame_orbit
from reflet.trace.device_scene import DeviceScene
from reflet.trace.light.floor_shadow import COARSE, floor_shadow
from reflet.trace.light.radiance import coat_light, radiance
from reflet.trace.surface import surface_at
from reflet.trace.variant import use_variant

GREY = Material("grey", (0.5, 0.5, 0.5), 0.0, 0.1)
GLOWING = Material("glowing", (3.0, 2.0, 1.0), 0.0, 1.0, unlit=True)
EVEN = EnvironmentLight(np.full((64, 128, 3), [0.6, 1.0, 1.4], np.float32))
SIDE = 8 * COARSE


def grid(left: float, right: float, height: float = 0.0) -> np.ndarray:
    """Corners of `SIDE`² texels between two x, and as far along z."""
    at = np.linspace(left, right, SIDE + 1)
    x, z = np.meshgrid(at, at - 0.5 * (left + right))
    return np.stack([x, np.full_like(x, height), z], -1)


def upright(x: float, tall: float, long: float) -> Mesh:
    """A wall along z."""
    corners = np.float32([(x, 0, -long), (x, 0, long), (x, tall, long), (x, tall, -long)])
    return Mesh(corners, np.tile(np.float32([1, 0, 0]), (4, 1)), np.uint32([[0, 1, 2], [0, 2, 3]]))


def test_the_shadow_of_a_wall_under_an_even_sky() -> None:
    """x metres from one H high (1 - x/√(x² + H²))/2 of the light is missing; exactly nothing is where there is none."""
    scene = Scene((Part("wall", upright(0.0, 1.0, 200.0), GREY),), (), EVEN)
    places = grid(0.5, 3.5)
    shadow = floor_shadow(scene, places, np.ones((SIDE, SIDE), bool))
    x = 0.5 * (places[0, 1:, 0] + places[0, :-1, 0])
    expected = 0.5 * (1.0 - x / np.hypot(x, 1.0))
    np.testing.assert_allclose(shadow, np.tile(expected, (SIDE, 1)), atol=0.006)  # 1024 directions: six of them
    assert not floor_shadow(scene, grid(0.5, 3.5, height=2.0), np.ones((SIDE, SIDE), bool)).any()
    few = np.zeros((SIDE, SIDE), bool)
    few[:, :3] = True
    assert not floor_shadow(scene, places, few)[:, 3:].any()


def test_the_shadow_of_what_lets_light_through() -> None:
    """A blended wall takes its share, thin glass what it keeps."""
    shares = {}
    clear = Refraction(transmission=0.75, thin=True)
    for name, material in (
        ("whole", GREY),
        ("blended", replace(GREY, alpha=0.5, alpha_mode="blend")),
        ("glass", replace(GREY, base_color=(1.0, 1.0, 1.0), refraction=clear)),
    ):
        scene = Scene((Part("wall", upright(0.0, 1.0, 200.0), material),), (), EVEN)
        shares[name] = float(floor_shadow(scene, grid(0.5, 1.0), np.ones((SIDE, SIDE), bool)).mean())
    assert shares["blended"] / shares["whole"] == pytest.approx(0.5, abs=0.03)  # rays go through at random
    assert shares["glass"] / shares["whole"] == pytest.approx(1.0 - 0.75 * (1.0 - COAT_F0), abs=0.03)


def sunny(towards: tuple[float, float, float]) -> EnvironmentLight:
    """One bright texel of 2.8° in that direction, under a dark sky."""
    _, uv = LatLong().uv_from_direction(np.array([towards]) / np.linalg.norm(towards))
    light = np.full((64, 128, 3), 1e-4, np.float32)
    light[int(uv[0, 1] * 64), int(uv[0, 0] * 128)] = 1000.0
    return EnvironmentLight(light)


def test_a_floor_of_which_the_shadow_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    """Away from a sun at 45° a ball's shadow lies one height off; all else is not there, to rays in any direction."""
    monkeypatch.setattr(floors, "SHADOW_SIZE", 128)
    use_variant()
    ball = Part("ball", sphere_mesh(0.2, (3.0, 2.0, -1.0), 16), GREY)
    plain = assemble([ball], environment=sunny((1.0, 1.0, 0.0)))
    scene = with_floor(plain, Floor(height=2.0, kind="shadow"), floor_shadow)
    part = scene.parts[-1]
    assert not part.reflective and scene.objects == plain.objects and not any(part.material.base_color)
    assert companions(scene) == (1,)  # rays of mirrors meet it
    device = DeviceScene(scene)
    ground = 1.8
    x = np.array([3.0 - 0.2, 3.0 - 0.2 - 0.4, 3.0 + 0.5, 3.0], np.float32)
    ray = mi.Ray3f(mi.Point3f(mi.Float(x), ground + 0.001, mi.Float([-1.0, -1.0, -1.0, -1.4])), mi.Vector3f(0, -1, 0))
    seen = np.asarray(radiance(device, ray, mi.Bool(True))).T
    below = np.float32(1e-4)
    np.testing.assert_allclose(seen[1:], below, rtol=1e-6)  # the environment itself
    np.testing.assert_array_equal(seen[0], 0.0)
    up = mi.Ray3f(mi.Point3f(mi.Float(x), ground - 0.1, -3.0), mi.Vector3f(0, 1, 0))
    np.testing.assert_allclose(np.asarray(radiance(device, up, mi.Bool(True))).T, below, rtol=1e-6)
    assert part.material.base_color_texture_srgb is not None
    alpha = part.material.base_color_texture_srgb.pixels[..., 3]
    row, column = np.nonzero(alpha > 127)
    middle = 2.0 * (np.array([column.mean(), row.mean()]) + 0.5) / 128 - 1.0
    share = np.arctan(0.2 / 2.0) / np.arctan(10.0)  # of the radius, as texture coordinates go
    np.testing.assert_allclose(middle, (-share, 0.0), atol=0.01)  # a third of a texel


def test_under_a_dark_sky_there_is_no_shadow() -> None:
    dark = EnvironmentLight(np.concatenate([np.zeros((32, 128, 3)), np.ones((32, 128, 3))]).astype(np.float32))
    scene = Scene((Part("wall", upright(0.0, 1.0, 200.0), GREY),), (), dark)
    assert not floor_shadow(scene, grid(0.5, 3.5), np.ones((SIDE, SIDE), bool)).any()


def test_a_polished_floor_mirrors_what_stands_on_it() -> None:
    """Towards the mirrored ball by Schlick's law of its coat; past it the environment; farther out less and less."""
    use_variant()
    ball = Part("ball", sphere_mesh(0.5, (1.0, 2.5, -3.0), 16), GLOWING)
    stone = Part("stone", sphere_mesh(0.05, (1.0, 2.05, -3.0), 8), GREY)
    plain = assemble([ball, stone], environment=EVEN)
    scene = with_floor(plain, Floor(kind="polished", roughness=0.0))
    rings = tuple(range(len(plain.parts), len(scene.parts)))
    assert all(scene.parts[ring].reflective for ring in rings) and scene.floor == rings
    assert scene.objects == (*plain.objects, ReflectiveObject("floor", rings))
    means = [coat_mean(scene.parts[ring])[0] for ring in rings]  # what mirrored rays take for the coat's share
    assert len(means) == floors.COAT_STEPS + 1 and means[0] > 0.9 and means[-1] < 1e-5
    assert (np.abs(np.diff(means[:-1]) + 0.17) < 0.03).all()
    assert frame_orbit(scene) == frame_orbit(plain)
    eye = np.array([4.0, 3.5, -3.0])
    level = float(scene.parts[-1].mesh.positions[0, 1])
    image = np.array([1.0, 2.0 * level - 2.5, -3.0])  # of the ball's middle
    beside = image + (0.0, 0.0, 2.0)
    outside = np.array([-6.0, level, -3.0])
    ways = np.stack([(to - eye) / np.linalg.norm(to - eye) for to in (image, beside, outside)]).astype(np.float32)
    device = DeviceScene(scene)
    direction = mi.Vector3f(*(mi.Float(np.ascontiguousarray(axis)) for axis in ways.T))
    hit = device.all.ray_intersect_preliminary(mi.Ray3f(mi.Point3f(*eye.tolist()), direction))
    surface = surface_at(device, mi.UInt32(hit.prim_index), mi.Point2f(hit.prim_uv), direction, hit.is_valid())
    assert np.isin(np.asarray(surface.part), rings).all()
    light = np.asarray(coat_light(device, surface, [mi.Float(0.3)] * 5, mi.Bool(True))).T
    fresnel = COAT_F0 + (1.0 - COAT_F0) * (1.0 + ways[:, 1]) ** 5
    away = np.linalg.norm(np.asarray(surface.position).T[:, ::2] - (1.0, -3.0), axis=-1)
    none, last = floors.FADE * RADIUS * np.sqrt(3.0), np.sqrt(0.5)  # of a box of 1 m a side
    share = np.clip((none - away) / (none - last), 0.0, 1.0)
    share = share * share * (3.0 - 2.0 * share)
    assert share[0] > 0.99 and share[1] > 0.9 and share[2] < 0.2
    mirrored = np.array([[3.0, 2.0, 1.0], [0.6, 1.0, 1.4], [0.6, 1.0, 1.4]])
    # a coat's picture of 8 bits, and 256 texels
    np.testing.assert_allclose(light, (share * fresnel)[:, None] * mirrored, rtol=0.02)


@pytest.mark.parametrize(
    ("floor", "says"),
    [
        (Floor(roughness=0.1), "A matte floor mirrors nothing, it has no roughness; make it polished"),
        (Floor(kind="polished", roughness=0.3), "lies between 0 and 0.2, not at 0.3"),
        (Floor(kind="polished", roughness=float("nan")), "lies between 0 and 0.2, not at nan"),
        (Floor(kind="wet"), "one of matte, polished, shadow; wet is none"),
    ],
)
def test_kinds_that_are_none_are_one_sentence(floor: Floor, says: str) -> None:
    ball = Part("ball", sphere_mesh(0.5, (1.0, 2.5, -3.0), 16), GREY)
    with pytest.raises(RefletError, match=says):
        with_floor(assemble([ball], environment=EVEN), floor)
