"""Floors beneath models: where they lie, what they show of the environment, and their shadow."""

from dataclasses import replace

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from reflet.envmap.parameterizations.latlong import LatLong
from reflet.errors import RefletError
from reflet.scene.assemble import assemble
from reflet.scene.floor import BELOW, FADE, irradiance_over_pi, with_floor
from reflet.scene.floor_kinds import Floor
from reflet.scene.material import EnvironmentLight, Material
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.meshes.primitives import sphere_mesh
from reflet.scene.scene import Part, Scene
from reflet.trace.device_scene import DeviceScene
from reflet.trace.light.irradiance import trace_irradiance
from reflet.trace.surface import surface_at
from reflet.trace.variant import use_variant

GREY = Material("grey", (0.5, 0.5, 0.5), 0.0, 0.1)
BLACK = Material("black", (0.0, 0.0, 0.0), 0.0, 1.0, double_sided=True)


def sky(ground: float = 0.3) -> EnvironmentLight:
    """Smooth, coloured, brighter above, and of another brightness all around."""
    d = LatLong().texel_directions(128)[0][0]
    x, y, z = np.moveaxis(d, -1, 0)
    light = np.stack([1.0 + 0.3 * x, 1.0 + 0.2 * z, 1.2 - 0.2 * y], -1) * np.where(y > 0.0, 1.0, ground)[..., None]
    return EnvironmentLight(light.astype(np.float32))


def ball(name: str = "ball") -> Part:
    return Part(name, sphere_mesh(0.5, (1.0, 2.5, -3.0), 16), GREY)


def at_middles(scene: Scene, spp: int = 256, budget: int = 20_000) -> tuple[np.ndarray, np.ndarray]:
    """The middle of each of the floor's triangles, and what it shows from above."""
    use_variant()
    device = DeviceScene(scene)
    device.set_irradiance(trace_irradiance(device, spp=spp, budget=budget))
    triangle = mi.UInt32(np.arange(*scene.triangle_offsets[-2:], dtype=np.uint32))
    down = mi.Vector3f(0.0, -1.0, 0.0) + dr.zeros(mi.Vector3f, dr.width(triangle))
    surface = surface_at(device, triangle, mi.Point2f(1.0 / 3.0), down, mi.Bool(True))
    return np.asarray(surface.position).T, np.asarray(surface.glow).T


def seen(light: EnvironmentLight, direction: np.ndarray) -> np.ndarray:
    """The environment in some directions, which is smooth: of the nearest texels."""
    rows, columns = light.radiance.shape[:2]
    _, uv = LatLong().uv_from_direction(direction / np.linalg.norm(direction, axis=-1, keepdims=True))
    return light.radiance[(uv[:, 1] * rows).astype(int), (uv[:, 0] * columns).astype(int) % columns]


def test_a_floor_lies_beneath_everything_and_does_not_reflect() -> None:
    plain = assemble([ball(), replace(ball("Floor"), mesh=sphere_mesh(0.2, (1.0, 2.3, -3.0), 8))], environment=sky())
    scene = with_floor(plain, Floor(2.0, 8.0))
    *parts, floor = scene.parts
    assert tuple(parts) == plain.parts and scene.objects == plain.objects
    assert floor.name == "floor_2" and not floor.reflective and floor.material.metallic == 0.0
    places = floor.mesh.positions
    np.testing.assert_allclose(places[:, 1], 2.0 - BELOW * np.sqrt(3.0), atol=1e-6)  # of a box of 1 m a side
    reach = np.linalg.norm(places[:, ::2] - (1.0, -3.0), axis=-1)
    assert reach.max() == pytest.approx(8.0, rel=1e-6)
    alpha = floor.mesh.colors[:, 3]
    assert (alpha[reach < 8.0 * FADE] == 1.0).all() and (alpha[reach > 7.999] == 0.0).all()
    corners = places[floor.mesh.triangles]
    assert (np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 1] > 0.0).all()
    default = with_floor(plain, Floor()).parts[-1].mesh.positions
    assert np.ptp(default[:, 0]) == pytest.approx(2 * 10.0 * np.sqrt(3.0), rel=1e-6)


def test_a_free_floor_gets_the_light_of_the_upper_half() -> None:
    """Uniform light shows itself; light that grows as the cosine from straight up shows two thirds of its best."""
    uniform = np.full((8, 16, 3), 0.7)
    np.testing.assert_allclose(irradiance_over_pi(uniform), 0.7, rtol=1e-12)
    up = np.maximum(LatLong().texel_directions(512)[0][0][..., 1:2], 0.0)
    np.testing.assert_allclose(irradiance_over_pi(np.repeat(up, 3, -1)), 2.0 / 3.0, rtol=1e-4)  # rows of 0.35°


def test_a_floor_shows_the_environment_as_from_its_height() -> None:
    """In the direction from there to each of its points; 0.5 m above it, far from what stands on it."""
    light, height = sky(), 3.0
    small = Part("grain", sphere_mesh(0.001, (1.0, 2.0, -3.0), 8), GREY)
    scene = with_floor(assemble([small], environment=light), Floor(height, 12.0))
    place, shown = at_middles(scene)
    away = place - (1.0, 1.999 + height, -3.0)
    far = (np.hypot(away[:, 0], away[:, 2]) > 0.1) & (np.hypot(away[:, 0], away[:, 2]) < 11.0)
    expected = seen(light, away[far])
    # 256 paths a sample, 8 bits and JPEG; the nearest texel is 0.7° off, and rings are a degree or two wide
    error = np.abs(shown[far] / expected - 1.0)
    assert np.median(error) < 0.01 and np.quantile(error, 0.99) < 0.04 and far.sum() > 5000


def test_a_floor_is_darker_by_what_stands_on_it() -> None:
    """Beside a long black wall of height H, x metres away, (1 - x/√(x² + H²))/2 of a uniform sky is hidden."""
    light = EnvironmentLight(np.full((256, 512, 3), [0.6, 1.0, 1.4], np.float32))
    light.radiance[128:] *= 0.4
    tall, long = 1.0, 200.0
    corners = np.float32([(0, 0, -long), (0, 0, long), (0, tall, long), (0, tall, -long)])
    wall = Mesh(corners, np.tile(np.float32([1, 0, 0]), (4, 1)), np.uint32([[0, 1, 2], [0, 2, 3]]))
    scene = with_floor(Scene((Part("wall", wall, BLACK),), (), light), Floor(2.0, 2.1 * long))
    scene = replace(scene, parts=(scene.parts[0], replace(scene.parts[1], material=_opaque(scene.parts[1].material))))
    place, shown = at_middles(scene, budget=40_000)
    x = np.abs(place[:, 0])
    near = (x > 0.3) & (x < 6.0) & (np.abs(place[:, 2]) < 10.0)
    hidden = 0.5 * (1.0 - x[near] / np.hypot(x[near], tall))
    expected = (1.0 - hidden)[:, None] * light.radiance[-1, 0]
    error = np.abs(shown[near] / expected - 1.0)
    assert np.median(error) < 0.015 and np.quantile(error, 0.95) < 0.06 and near.sum() > 100  # as above
    assert hidden.max() > 0.3


def _opaque(material: Material) -> Material:
    return replace(material, alpha_mode="opaque")


def test_ground_that_is_brighter_than_its_light_is_shown_all_the_same() -> None:
    """Under a black sky nothing lights the floor: it shines as its picture does."""
    light = EnvironmentLight(np.zeros((256, 512, 3), np.float32))
    light.radiance[128:] = 2.5, 0.5, 0.1
    scene = with_floor(assemble([ball()], environment=light), Floor(1.0, 8.0))
    place, shown = at_middles(scene, spp=8, budget=2000)
    near = np.hypot(place[:, 0] - 1.0, place[:, 2] + 3.0) < 4.0
    np.testing.assert_allclose(shown[near], np.tile([2.5, 0.5, 0.1], (int(near.sum()), 1)), rtol=0.01)  # 8 bits


@pytest.mark.parametrize(
    ("floor", "says"),
    [
        (Floor(height=0.0), "The floor's height is 0 m; it has to be above 0"),
        (Floor(radius=-1.0), "The floor's radius is -1 m"),
        (Floor(height=float("inf")), "The floor's height is inf m"),
        (Floor(radius=1.0), "fades from 0.5 m on, where the model itself is, which reaches 0.707.* --floor-radius 3.5"),
    ],
)
def test_sizes_that_cannot_be_are_one_sentence(floor: Floor, says: str) -> None:
    with pytest.raises(RefletError, match=says):
        with_floor(assemble([ball()], environment=sky()), floor)


def test_without_an_environment_a_floor_has_nothing_to_show() -> None:
    lit = assemble([replace(ball(), material=replace(GREY, emission=(1.0, 1.0, 1.0)))])
    with pytest.raises(RefletError, match="A floor shows the environment, and there is none; add --environment FILE"):
        with_floor(lit, Floor())
