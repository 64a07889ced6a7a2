"""Glass in the ray tracer: closed forms, and Mitsuba's path integrator on the same scene."""

from dataclasses import replace

import numpy as np
import pytest
from trace_scenes import CHROME, camera, constant_light, no_irradiance, quad, room, scene, sphere

from reflet.reflectance.brdfs.fresnel import fresnel_dielectric
from reflet.scene.material import EnvironmentLight, Material, Refraction
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.meshes.primitives import torus_mesh
from reflet.scene.scene import Part, Scene
from reflet.trace.compose import compose
from reflet.trace.layers import SegmentedLayers
from reflet.trace.references.path_reference import path_traced
from reflet.trace.tracer import Tracer

GLASS = Material("glass", (1.0, 1.0, 1.0), 0.0, 0.0, refraction=Refraction(1.5))


def layers_of(what: Scene, size: int = 48, spp: int = 64, **more: object) -> SegmentedLayers:
    tracer = Tracer(what, irradiance=no_irradiance(what))
    return tracer.view(camera(size=size, **more), spp=spp, surroundings=True).layers  # type: ignore[arg-type]


def rays_to(layers: SegmentedLayers) -> tuple[np.ndarray, np.ndarray]:
    """Eye, and unit rays through the middles of the rows' pixels."""
    view = layers.camera
    corner, dx, dy = view.ray_basis()
    y, x = np.divmod(layers.pixel, view.width)
    d = corner + (x + 0.5)[:, None] * dx + (y + 0.5)[:, None] * dy
    return np.asarray(view.position), d / np.linalg.norm(d, axis=-1, keepdims=True)


def sloping_light() -> EnvironmentLight:
    """Radiance 1 + d/2 in direction d."""
    v, u = np.meshgrid((np.arange(64) + 0.5) / 64, (np.arange(128) + 0.5) / 128, indexing="ij")
    theta, phi = np.pi * v, 2.0 * np.pi * (u - 0.5)
    d = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)], -1)
    return EnvironmentLight((1.0 + 0.5 * d).astype(np.float32))


def turned(d: np.ndarray, towards: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Unit vectors d turned by an angle towards the unit vectors ``towards``, which are at right angles to them."""
    return np.cos(angle)[:, None] * d + np.sin(angle)[:, None] * towards


@pytest.mark.parametrize("thin", [False, True])
def test_clear_glass_in_a_constant_environment_is_not_seen(thin: bool) -> None:
    material = replace(GLASS, refraction=Refraction(1.5, thin=thin))
    shape = torus_mesh(0.7, 0.3, around=48, sides=24)
    found = layers_of(scene([Part("torus", shape, material, True)], [(0,)], constant_light(1.7)), spp=16)
    # a ring holds light long: 0.3 % of it is still inside after 64 reflections
    np.testing.assert_allclose(found.combined.mean(), 1.7, rtol=4e-3)
    assert np.median(np.abs(found.combined - 1.7)) < 1e-4
    assert not found.diffuse.any()


def test_a_glass_sphere_shows_the_series_of_its_reflections() -> None:
    """All rays stay in the plane of the first and the centre; inside, each meets the sphere at the same angle."""
    found = layers_of(scene([Part("ball", sphere(rows=96), GLASS, True)], [(0,)], sloping_light()), spp=64)
    eye, d = rays_to(found)
    b = d @ eye
    normal = eye + (-b - np.sqrt(np.maximum(b * b - eye @ eye + 1.0, 0.0)))[:, None] * d
    cosine = -(normal * d).sum(-1)
    inside = (found.coverage == 1.0) & (cosine > 0.4)  # nearer the rim the pixel's centre does not stand for it
    d, normal, cosine = d[inside], normal[inside], cosine[inside]
    i = np.arccos(cosine)
    t = np.arcsin(np.sin(i) / 1.5)
    f = fresnel_dielectric(cosine, 1.5)[:, None]
    across = (-normal - cosine[:, None] * d) / np.maximum(np.sin(i), 1e-9)[:, None]  # to the normal turned inwards
    light = lambda angle: 1.0 + 0.5 * turned(d, across, angle)  # noqa: E731
    expected = f * light(-(np.pi - 2.0 * i))
    for k in range(12):  # turned by 2(i - t) on the way through, by π - 2t at each reflection inside
        expected += (1.0 - f) ** 2 * f**k * light(2.0 * (i - t) + k * (np.pi - 2.0 * t))
    error = found.combined[inside] - expected
    assert len(error) > 300
    # a chance of 4 to 20 % in each of 64 samples for another light: 0.03 a pixel
    assert np.sqrt((error**2).mean()) < 0.02
    assert np.abs(error.mean(0)).max() < 2e-3


def slab(half: float, thickness: float) -> Mesh:
    """A plate about the origin, its faces towards ±z, without rims."""
    z, side = thickness / 2.0, 2.0 * half
    front = quad((-half, -half, z), (side, 0, 0), (0, side, 0))
    back = quad((-half, -half, -z), (0, side, 0), (side, 0, 0))
    return Mesh(
        np.concatenate([front.positions, back.positions]),
        np.concatenate([front.normals, back.normals]),
        np.concatenate([front.triangles, back.triangles + 4]).astype(np.uint32),
    )


def test_a_plate_attenuates_by_its_thickness() -> None:
    """The sum over all reflections to and fro inside, looked at straight, in a constant environment."""
    kind = Refraction(1.5, attenuation_color=(0.5, 0.9, 1.0), attenuation_distance=0.2)
    what = scene([Part("plate", slab(9.0, 0.4), replace(GLASS, refraction=kind), True)], [(0,)], constant_light(1.0))
    found = layers_of(what, size=8, spp=256, position=(0.0, 0.0, 60.0))
    _, d = rays_to(found)
    inside = found.coverage == 1.0
    cosine = np.sqrt(1.0 - (1.0 - d[inside, 2:] ** 2) / 1.5**2)
    r, a = 0.04, np.array([0.5, 0.9, 1.0]) ** (2.0 / cosine)  # the slant lengthens the way by less than 1 %
    series = (1.0 - r) ** 2 / (1.0 - (r * a) ** 2)
    expected = series * a + r + series * r * a**2
    assert len(expected) >= 4
    # 4 pixels of 256 samples, each with a chance of 4 % for a second way through
    np.testing.assert_allclose(found.combined[inside].mean(0), expected.mean(0), atol=4e-3)


def test_a_thin_sheet_reflects_from_both_faces_and_is_tinted_once() -> None:
    kind = replace(GLASS, base_color=(0.25, 0.5, 1.0), refraction=Refraction(1.5, transmission=0.5, thin=True))
    front = quad((-9, -9, 0), (18, 0, 0), (0, 18, 0))
    what = scene([Part("sheet", front, kind, True)], [(0,)], constant_light(1.0))
    for side in (60.0, -60.0):
        found = layers_of(what, size=4, spp=16, position=(0.0, 0.0, side))
        r = 2.0 * 0.04 / 1.04
        # two degrees off the normal F rises by less than 1e-5
        np.testing.assert_allclose(found.fresnel, r, atol=1e-4)
        expected = np.tile(r + (1.0 - r) * 0.5 * np.array([0.25, 0.5, 1.0]), (len(found.pixel), 1))
        np.testing.assert_allclose(found.combined, expected, atol=1e-4)
        assert not found.alpha.any()


def test_what_does_not_go_through_is_diffuse() -> None:
    """Half of what is not reflected, as `Part` says; its irradiance/π is 1 in a constant environment."""
    kind = replace(GLASS, base_color=(0.5, 0.5, 0.5), refraction=Refraction(1.5, transmission=0.25, thin=True))
    what = scene([Part("ball", sphere(rows=16), kind, True)], [(0,)], constant_light(1.0))
    found = Tracer(what, irradiance_spp=64).view(camera(size=24), spp=16).layers
    # from outside light comes undisturbed: 0.5·0.75; 64 paths a sample, alike in every direction
    np.testing.assert_allclose(found.diffuse.mean(), 0.375, atol=2e-3)


@pytest.mark.parametrize("absorbs", [False, True])
def test_glass_beside_mitsuba(absorbs: bool) -> None:
    """A ring, a ball within it, and a mirror, in a room that glows: refraction, total reflection, both at once."""
    kind = Refraction(1.5, attenuation_color=(0.3, 0.9, 0.6), attenuation_distance=0.5) if absorbs else Refraction(1.4)
    glass = replace(GLASS, base_color=(1.0, 0.9, 1.0), refraction=kind)
    glow = Material("glow", (0, 0, 0), 0.0, emission=(0.3, 0.9, 2.0))
    lamp = Material("lamp", (0, 0, 0), 0.0, emission=(4.0, 2.0, 1.0), double_sided=True)
    parts = [
        Part("ring", torus_mesh(0.8, 0.3, around=96, sides=48), glass, True),
        Part("ball", sphere((0.0, 0.1, 0.0), 0.4), glass, True),
        Part("mirror", sphere((0.3, -0.9, 0.2), 0.5), CHROME, True),
        Part("room", room(3.0), glow),
        Part("lamp", quad((-1.5, 1.2, -1.5), (1.0, 0, 0), (0, 0, 3.0)), lamp),
    ]
    what = scene(parts, [(0, 1, 2)])
    view = camera(size=48, position=(0.4, 1.1, 2.6))
    found = compose(Tracer(what, irradiance=no_irradiance(what)).view(view, spp=256, surroundings=True).layers)
    truth = path_traced(what, view, spp=1024 if absorbs else 256, max_depth=34)
    # both are noisy; at rims of smooth meshes Mitsuba tells sides by the smooth normal, we by the triangle's
    difference = found - truth
    assert np.abs(difference.mean((0, 1)) / truth.mean((0, 1))).max() < 0.01
    assert 10 * np.log10(truth.max() ** 2 / (difference**2).mean()) > 33.0
