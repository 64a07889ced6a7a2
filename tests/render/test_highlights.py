"""What rough parts show of lights without extent: beside the formula in NumPy."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import pem_of, quad, scene_of, traced_pem

from reflet.envmap.env_map import EnvMap
from reflet.envmap.geometry import InfiniteSphere
from reflet.envmap.mip_chain import MipChain
from reflet.pem.pem import ParameterizedEnvironmentMap
from reflet.reflectance.materials.material import dfg_lookup
from reflet.render.playback.renderer import Renderer
from reflet.scene.material import Material
from reflet.scene.punctual_light import PunctualLight
from reflet.scene.scene import Part
from reflet.scene.surfaces.irradiance import IrradianceMap

ROUGHNESS = 0.3
LAMP = PunctualLight("lamp", (3.0, 2.0, 1.0), (0.3, 0.6, -0.2), range=1.4)
SPOT = PunctualLight("spot", (2.0, 2.0, 4.0), (-0.3, 0.8, 0.1), (0.28, -0.96, 0.0), cone=(0.1, 0.5))
SUN = PunctualLight("sun", (0.5, 1.0, 1.0), None, (-0.6, -0.8, 0.0))
LIGHTS = (LAMP, SPOT, SUN)
PAINTED = Material("painted", (0.9, 0.6, 0.3), 0.5, ROUGHNESS)  # half metal
FLOOR = quad(np.array([(-0.5, 0.0, -0.5), (-0.5, 0.0, 0.5), (0.5, 0.0, 0.5), (0.5, 0.0, -0.5)]))
BLACK = EnvMap(MipChain(1), np.zeros((MipChain(1).texel_count, 3), np.float32), InfiniteSphere())


def lit(pem: ParameterizedEnvironmentMap, seen: np.ndarray) -> ParameterizedEnvironmentMap:
    """Without diffuse light; of two triangles of the floor the corners see ``seen`` of the lights, others see all."""
    count = pem.scene.triangle_offsets[-1]
    visibility = np.full((3 * count, len(LIGHTS)), 255, np.uint8)
    visibility[:6] = seen
    colours = IrradianceMap(
        np.ones(count, np.uint32),
        3 * np.arange(count, dtype=np.uint32),
        np.zeros((3 * count, 3), np.float32),
        visibility=visibility,
    )
    return replace(pem, scene=replace(pem.scene, lights=LIGHTS), irradiance=colours)


def shine(eye: np.ndarray, place: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Radiance towards ``eye`` of places of the floor, F·D·V·n·l·E with the gain of further bounces."""
    v = eye - place
    v /= np.linalg.norm(v, axis=-1, keepdims=True)
    n_v, alpha = v[:, 1], ROUGHNESS**2
    a, b = dfg_lookup(n_v, np.full(len(v), ROUGHNESS))[..., :2].T
    lost = (1.0 / (a + b) - 1.0)[:, None]
    metal, paint = np.array(PAINTED.base_color), np.full(3, 0.04)
    out = np.zeros((len(v), 3))
    for k, light in enumerate(LIGHTS):
        away = -np.tile(light.direction, (len(v), 1)) if light.position is None else light.position - place
        distance = np.linalg.norm(away, axis=-1)
        towards = away / distance[:, None]
        arriving = seen[:, k] if light.position is None else seen[:, k] / distance**2
        arriving = arriving * (1.0 - np.minimum(distance / light.range, 1.0) ** 4)
        if light.cone is not None:
            inner, outer = np.cos(light.cone)
            arriving = (
                arriving * np.clip((towards @ -np.array(light.direction) - outer) / (inner - outer), 0.0, 1.0) ** 2
            )
        h = v + towards
        h /= np.linalg.norm(h, axis=-1, keepdims=True)
        n_l, n_h, v_h = towards[:, 1], h[:, 1], (v * h).sum(-1)
        d = alpha**2 / (np.pi * (n_h**2 * (alpha**2 - 1.0) + 1.0) ** 2)
        root = n_l * np.sqrt(alpha**2 + (1 - alpha**2) * n_v**2) + n_v * np.sqrt(alpha**2 + (1 - alpha**2) * n_l**2)
        grazing = ((1.0 - v_h) ** 5)[:, None]
        fresnel = sum(0.5 * (1 + f0 * lost) * (f0 + (1 - f0) * grazing) for f0 in (metal, paint))
        # f90 has the factor of f0 too: (f0 + (1 - f0)·g)·(1 + f0·lost)
        out += fresnel * (d * 0.5 / root * np.maximum(n_l, 0.0) * arriving)[:, None] * light.intensity
    return out


def floor_points(pem: ParameterizedEnvironmentMap) -> tuple[np.ndarray, np.ndarray]:
    """The eye, and where the ray through each pixel's centre meets y = 0."""
    view = pem.space.orbit.camera()
    corner, dx, dy = view.ray_basis()
    y, x = np.mgrid[: view.height, : view.width] + 0.5
    ray = corner + x[..., None] * dx + y[..., None] * dy
    eye = np.asarray(view.position)
    return eye, eye - ray * (eye[1] / ray[..., 1:2])


def test_highlights_are_those_of_the_formula() -> None:
    """Of three kinds of light, on what is half metal; corners of triangles that see half of a light show half of it."""
    seen = np.array([[255, 51, 204]] * 6, np.uint8)
    pem = lit(pem_of(scene_of(Part("floor", FLOOR, PAINTED, True)), [BLACK]), seen)
    picture = Renderer(pem).frame(pem.space.orbit.camera(), samples=1, what="object")
    eye, place = floor_points(pem)
    inside = picture[..., 3] == 1.0
    wanted = shine(eye, place[inside], np.tile([1.0, 0.2, 0.8], (int(inside.sum()), 1)))
    # the table is kept in half floats, and pixels are seen within float32
    np.testing.assert_allclose(picture[inside][:, :3], wanted, rtol=2e-3, atol=1e-4)
    assert inside.sum() > 800 and wanted.max() > 1.0


def test_what_hides_a_light_hides_it_between_samples() -> None:
    """Two corners in the light and one out of it: the share is linear in between."""
    one = np.zeros((6, 3), np.uint8)
    one[[0, 3]] = 255  # the corner (-0.5, 0, -0.5) that both triangles begin with
    pem = lit(pem_of(scene_of(Part("floor", FLOOR, PAINTED, True)), [BLACK]), one)
    picture = Renderer(pem).frame(pem.space.orbit.camera(), samples=1, what="object")
    eye, place = floor_points(pem)
    inside = picture[..., 3] == 1.0
    at = place[inside]
    share = 0.5 - np.maximum(at[:, 0], at[:, 2])  # 1 at that corner, 0 along the two far edges
    wanted = shine(eye, at, np.repeat(share[:, None], 3, 1))
    np.testing.assert_allclose(picture[inside][:, :3], wanted, rtol=3e-3, atol=3e-4)


def test_highlights_are_seen_in_mirrors_that_show_no_light_themselves() -> None:
    """A perfect mirror behind the floor shows the floor as from behind it, and nothing of the lights."""
    wall = quad(np.array([(-0.5, 0.0, -0.5), (0.5, 0.0, -0.5), (0.5, 0.6, -0.5), (-0.5, 0.6, -0.5)]))
    white = Material("mirror", (1.0, 1.0, 1.0), 1.0, 0.0)
    pem = traced_pem(Part("floor", FLOOR, PAINTED, True), Part("wall", wall, white, True), sky=np.zeros_like)
    pem = lit(replace(pem, space=replace(pem.space, orbit=replace(pem.space.orbit, azimuth_deg=270.0))), np.uint8(255))
    picture = Renderer(pem).frame(pem.space.orbit.camera(), samples=1, what="object")
    view = pem.space.orbit.camera()
    corner, dx, dy = view.ray_basis()
    y, x = np.mgrid[: view.height, : view.width] + 0.5
    ray = corner + x[..., None] * dx + y[..., None] * dy
    eye = np.asarray(view.position)
    on_wall = eye + ray * ((-0.5 - eye[2]) / ray[..., 2:3])
    mirrored_ray, mirrored_eye = ray * (1, 1, -1), eye * (1, 1, -1) - (0, 0, 1.0)
    at = on_wall - mirrored_ray * (on_wall[..., 1:2] / mirrored_ray[..., 1:2])
    shows = (
        (np.abs(at[..., 0]) < 0.49) & (np.abs(at[..., 2]) < 0.49) & (on_wall[..., 1] > 0.01) & (on_wall[..., 1] < 0.59)
    )
    shows &= np.abs(on_wall[..., 0]) < 0.49
    wanted = shine(mirrored_eye, at[shows], np.ones((int(shows.sum()), 3)))
    np.testing.assert_allclose(picture[shows][:, :3], wanted, rtol=3e-3, atol=3e-4)
    above = (on_wall[..., 1] > 0.01) & (on_wall[..., 1] < 0.59) & (np.abs(on_wall[..., 0]) < 0.49) & (at[..., 2] > 0.51)
    assert shows.sum() > 100 and not picture[above][:, :3].any()


@pytest.mark.parametrize("known", [True, False])
def test_lights_without_visibility_are_not_shown(known: bool) -> None:
    pem = lit(pem_of(scene_of(Part("floor", FLOOR, PAINTED, True)), [BLACK]), np.uint8(255))
    if not known:
        pem = replace(pem, irradiance=replace(pem.irradiance, visibility=np.zeros((0, 0), np.uint8)))
    assert Renderer(pem).frame(pem.space.orbit.camera(), samples=1, what="object")[..., :3].any() == known
