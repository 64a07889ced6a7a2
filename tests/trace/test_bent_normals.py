"""Diffuse light of normal maps: closed forms, and the path tracer on a bumpy floor."""

from dataclasses import replace

import mitsuba as mi
import numpy as np
import pytest
from trace_scenes import CHROME, camera, constant_light, quad, scene, sphere

from reflet.scene.material import EnvironmentLight, Material, Texture
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.punctual_light import PunctualLight
from reflet.scene.scene import Part, Scene
from reflet.scene.surfaces.irradiance import IrradianceMap
from reflet.trace.compose import compose
from reflet.trace.device_scene import DeviceScene
from reflet.trace.light.bent_normals import gradient_of
from reflet.trace.light.irradiance import trace_irradiance
from reflet.trace.references.path_reference import PathReference
from reflet.trace.surface import surface_at
from reflet.trace.tracer import Tracer
from reflet.trace.variant import use_variant

GREY = Material("grey", (0.8, 0.6, 0.4), 0.0, 1.0)
LUMINANCE = (0.2126, 0.7152, 0.0722)


def bump(*normals: tuple[float, float, float]) -> Texture:
    """A row of texels with these normals in the tangents' frame."""
    unit = np.asarray(normals) / np.linalg.norm(normals, axis=1, keepdims=True)
    pixels = np.full((1, len(unit), 4), 255, np.uint8)
    pixels[0, :, :3] = np.rint(127.5 * unit + 127.5)
    return Texture(pixels)


def bumpy_floor(texture: Texture | None, half: float = 0.5, double_sided: bool = False) -> Part:
    """At y = 0, its tangents along +x and +z."""
    flat = quad((-half, 0, -half), (0, 0, 2 * half), (2 * half, 0, 0))
    tangents = np.tile(np.float32([1.0, 0.0, 0.0, -1.0]), (4, 1))  # y × x = -z
    uv = np.float32([[0, 0], [0, 1], [1, 1], [1, 0]])
    mesh = Mesh(flat.positions, flat.normals, flat.triangles, uv, tangents)
    return Part("floor", mesh, replace(GREY, normal_texture=texture, double_sided=double_sided))


def lit(what: Scene, spp: int = 256, budget: int = 300) -> IrradianceMap:
    use_variant()
    return trace_irradiance(DeviceScene(what), spp=spp, budget=budget)


def glow(what: Scene, light: IrradianceMap, direction: tuple[float, float, float] = (0.0, -1.0, 0.0)) -> np.ndarray:
    """What the first triangle's middle shows along a ray."""
    use_variant()
    device = DeviceScene(what)
    device.set_irradiance(light)
    yes = mi.Bool(True)
    surface = surface_at(device, mi.UInt32(0), mi.Point2f(1 / 3), mi.Vector3f(*direction), yes)
    return np.array([channel.numpy()[0] for channel in surface.glow])


def test_uniform_light_has_half_its_irradiance_for_gradient() -> None:
    """Then a normal θ off the plane's sees (1 + cos θ)/2 of it: the plane itself hides the rest."""
    what = scene([bumpy_floor(bump((1, 0, 1)))], [], constant_light(1.5))
    found = lit(what)
    np.testing.assert_allclose(found.radiosity, 1.5, rtol=0.05)  # 256 paths a sample
    np.testing.assert_allclose(found.gradient.mean(0), (0.0, 0.75, 0.0), atol=0.01)  # 300 samples of them
    exact = replace(found, radiosity=np.full_like(found.radiosity, 1.5), gradient=np.full_like(found.gradient, 0.0))
    exact.gradient[:, 1] = 0.75
    # texels of 8 bits tilt it by up to 0.2°
    expected = 1.5 * np.array(GREY.base_color) * (1.0 + np.cos(np.pi / 4)) / 2.0
    np.testing.assert_allclose(glow(what, exact), expected, rtol=2e-3)


@pytest.mark.parametrize(("elevation", "most"), [(80, 0.02), (60, 0.03), (40, 0.06), (20, 0.09), (5, 0.13)])
def test_light_from_one_direction_falls_as_its_cosine(elevation: float, most: float) -> None:
    """For normals up to 45° off, in the root mean square of the directions' own irradiance; without a gradient it would
    be off by 0.3 on average. Grazing light is hardest: a first-order function does not stop at the horizon."""
    use_variant()
    n, towards = np.array([0.0, 1.0, 0.0]), np.radians(elevation)
    towards = np.array([np.cos(towards), np.sin(towards), 0.0])
    gradient = np.array([c.numpy()[0] for c in gradient_of(mi.Vector3f(n), mi.Vector3f(towards))])
    tilt, turn = np.meshgrid(np.radians([8, 16, 25, 35, 45]), np.arange(8) * np.pi / 4)
    m = np.stack([np.sin(tilt) * np.cos(turn), np.cos(tilt), np.sin(tilt) * np.sin(turn)], -1)
    at_n = towards @ n
    shown = np.maximum(at_n * (1.0 + (m - n) @ gradient), 0.0)
    wrong = shown - np.maximum(m @ towards, 0.0)
    assert np.sqrt((wrong**2).mean()) < most
    assert np.sqrt(((at_n - np.maximum(m @ towards, 0.0)) ** 2).mean()) > 1.7 * most


def test_lights_without_extent_have_gradients_too() -> None:
    """Those of the one direction that a sun shines from, exactly; every site sees it."""
    sun = PunctualLight("sun", (3.0, 2.0, 1.0), None, (0.6, -0.8, 0.0))
    found = lit(replace(scene([bumpy_floor(bump((1, 0, 1)))], []), lights=(sun,)), spp=1)
    of_one = np.array([c.numpy()[0] for c in gradient_of(mi.Vector3f(0, 1, 0), mi.Vector3f(-0.6, 0.8, 0.0))])
    light = 0.8 / np.pi * np.array(sun.intensity)
    np.testing.assert_allclose(found.radiosity, np.tile(light, (len(found.radiosity), 1)), rtol=1e-5)
    np.testing.assert_allclose(found.gradient, np.tile(light @ LUMINANCE * of_one, (len(found.gradient), 1)), atol=1e-5)


def test_a_normal_map_that_bends_nothing_changes_nothing() -> None:
    """Exactly: whatever the gradient is."""
    light = constant_light(1.0)
    flat, bumpy = (scene([bumpy_floor(texture)], [], light) for texture in (None, bump((0, 0, 1))))
    found = lit(bumpy)
    plain = replace(found, gradient=np.zeros((0, 3), np.float32))
    # no code of 8 bits is 0: (128, 128, 255) tilts by 0.3°
    np.testing.assert_allclose(glow(bumpy, found), glow(flat, plain), rtol=0.01)
    assert not lit(flat).gradient.size


def test_only_what_bends_normals_has_gradients_and_backs_have_their_own() -> None:
    """A sun above: the front's gradient points up, towards it, the back's is 0 as all its light."""
    sky = np.zeros((32, 64, 3), np.float32)
    sky[:2] = (1.0, 2.0, 3.0)
    beside = Part("plain", quad((2, 0, 2), (0, 0, 1), (1, 0, 0)), GREY)
    what = scene([bumpy_floor(bump((1, 0, 1)), double_sided=True), beside], [], EnvironmentLight(sky))
    found = lit(what)
    assert not found.gradient[found.offset[2] :].any()
    samples = int((found.resolution[0] + 1) * (found.resolution[0] + 2) // 2)
    front, back = found.gradient[:samples], found.gradient[samples : 2 * samples]
    # light from within 11° of the normal: its gradient is its irradiance, up to the square of that angle
    luminance = found.radiosity[:samples] @ np.float32(LUMINANCE)
    np.testing.assert_allclose(front[:, 1], luminance, rtol=0.03)
    assert np.abs(front[:, [0, 2]]).max() < 0.05 * luminance.max()  # noise of the sun's place
    assert not back.any()
    # seen from below the floor's normal is turned, and nothing arrives
    assert not glow(what, found, (0.0, 1.0, 0.0)).any()
    assert glow(what, found).min() > 0.0


def test_the_path_tracer_sees_the_same_bumps() -> None:
    """Ridges on a floor beside a bright wall and below a dim sky, hidden in part by a ball; with smooth normals the
    picture would be off by three times as much."""
    ridges = bump(*[(np.sin(a), 0.4 * np.cos(a), 1.2) for a in np.arange(16) * np.pi / 8])
    wall = Material("wall", (0.2, 0.2, 0.2), 0.0, 1.0, emission=(3.0, 2.4, 1.5))
    lamp = Part("wall", quad((0.8, 0, -0.6), (0, 0, 1.2), (0, 0.8, 0)), wall)
    ball = Part("ball", sphere((-0.2, 0.2, 0.0), 0.2, 16), replace(GREY, name="ball"))
    dull = replace(GREY, specular=0.0)  # the reference's paint would shine
    floor = replace(bumpy_floor(ridges), material=replace(dull, normal_texture=ridges))
    far = Part("far", quad((50, 0, 0), (0, 1, 0), (0, 0, 1)), CHROME, True)
    what = scene([floor, lamp, replace(ball, material=dull), far], [(3,)], constant_light(0.2))
    view = camera((0.0, 2.0, 0.6), 40)
    expected = PathReference(what, materials="gltf").picture(view, spp=256, max_depth=6)
    sees = (expected.max(-1) < 1.0) & (expected.max(-1) > 0.01)  # no lamp

    def error(light: IrradianceMap) -> float:
        shown = compose(Tracer(what, irradiance=light).view(view, spp=64, surroundings=True).layers)
        return float(np.sqrt(((shown - expected)[sees] ** 2).mean()) / expected[sees].mean())

    light = lit(what, 256, 3000)
    bent, smooth = error(light), error(replace(light, gradient=np.zeros((0, 3), np.float32)))
    assert bent < 0.09  # noise of 256 samples is 0.03; the wall's light grazes
    assert smooth > 2.5 * bent, (smooth, bent)
