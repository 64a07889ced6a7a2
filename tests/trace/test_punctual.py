"""Lights without extent: closed forms of diffuse light and of lobes, and the path traced reference."""

from dataclasses import replace

import numpy as np
import pytest
from trace_scenes import camera, constant_light, no_irradiance, quad, scene, sphere

from reflet.scene.material import Material
from reflet.scene.punctual_light import PunctualLight
from reflet.scene.scene import Part, Scene
from reflet.scene.surfaces.irradiance import IrradianceMap
from reflet.trace.compose import compose
from reflet.trace.device_scene import DeviceScene
from reflet.trace.light.irradiance import trace_irradiance
from reflet.trace.references.path_reference import PathReference
from reflet.trace.tracer import Tracer
from reflet.trace.variant import use_variant

BLACK = Material("black", (1e-9, 1e-9, 1e-9), 0.0, 1.0)  # nothing comes back from it
METAL = Material("metal", (1.0, 0.8, 0.3), 1.0, 0.3)
LAMP = PunctualLight("lamp", (3.0, 2.0, 1.0), (0.3, 1.0, 0.1))
SUN = PunctualLight("sun", (3.0, 2.0, 1.0), None, (0.0, -0.6, -0.8))
SPOT = replace(LAMP, direction=(0.0, -1.0, 0.0), cone=(0.3, 0.7))


def floor(*lights: PunctualLight) -> Scene:
    return replace(scene([Part("floor", quad((-1, 0, 1), (2, 0, 0), (0, 0, -2)), BLACK)], []), lights=lights)


def diffuse(what: Scene, spp: int = 1) -> IrradianceMap:
    use_variant()
    return trace_irradiance(DeviceScene(what), spp=spp, budget=10_000)


def inside(irradiance: IrradianceMap) -> tuple[np.ndarray, np.ndarray]:
    """Places of the samples of the floor's first triangle that do not lie on its edges, and irradiance/π there."""
    r = int(irradiance.resolution[0])
    i = np.repeat(np.arange(r + 1), np.arange(r + 1, 0, -1))
    j = np.concatenate([np.arange(r + 1 - k) for k in range(r + 1)])
    corners = np.array([(-1, 0, 1), (1, 0, 1), (1, 0, -1)], float)
    place = corners[0] + (i / r)[:, None] * (corners[1] - corners[0]) + (j / r)[:, None] * (corners[2] - corners[0])
    within = (i > 0) & (j > 0) & (i + j < r)
    return place[within], irradiance.radiosity[: len(i)][within]


def arriving(light: PunctualLight, place: np.ndarray) -> np.ndarray:
    """Irradiance of a floor, by the specification's formulas."""
    if light.position is None:
        return np.tile(np.multiply(light.intensity, 0.6), (len(place), 1))
    away = light.position - place
    distance = np.linalg.norm(away, axis=-1)
    cosine = away[:, 1] / distance  # from the floor's normal, and of the angle to a spot that shines down
    share = cosine / distance**2 * np.clip(1.0 - (distance / light.range) ** 4, 0.0, 1.0)
    if light.cone is not None:
        inner, outer = np.cos(light.cone)
        share *= np.clip((cosine - outer) / (inner - outer), 0.0, 1.0) ** 2
    return share[:, None] * light.intensity


@pytest.mark.parametrize("light", [LAMP, replace(LAMP, range=1.5), SUN, SPOT], ids=["point", "range", "sun", "spot"])
def test_diffuse_light_is_that_of_the_formulas(light: PunctualLight) -> None:
    irradiance = diffuse(floor(light))
    place, radiosity = inside(irradiance)
    wanted = arriving(light, place) / np.pi  # a candela a metre away and a lux show 1/π on white
    error = np.abs(radiosity - wanted).max(1) / wanted.max()
    # of the mean over a sample's cell, a hundredth of the floor wide; cones and ranges end with a kink in some of them
    assert np.median(error) < 2e-4 and np.quantile(error, 0.99) < 4e-3 and error.max() < 0.02
    assert wanted.max() > 0.3 and irradiance.visibility.shape[1] == 1 and (irradiance.visibility == 255).all()


def test_lights_add_up_and_things_stand_in_their_way() -> None:
    """Half of the floor lies in the shadow of a roof from the lamp straight above it; the sun shines in below."""
    above = replace(LAMP, position=(0.0, 1.0, 0.0))
    roof = Part("roof", quad((0, 0.5, 2), (2, 0, 0), (0, 0, -4)), replace(BLACK, double_sided=True))
    lit = floor(above, SUN)
    irradiance = diffuse(replace(lit, parts=(*lit.parts, roof)))
    place, radiosity = inside(irradiance)
    x = place[:, 0]
    shaded = (place[:, 1] + 0.5 * 0.8 / 0.6 + place[:, 2] < 2.0) & (x > 0.0)  # towards the sun, half a metre up
    both = arriving(above, place) * (x < 0.0)[:, None] + arriving(SUN, place) * ~shaded[:, None]
    clear = np.abs(x) > 0.03  # the cells are 0.02 wide
    np.testing.assert_allclose(radiosity[clear], both[clear] / np.pi, atol=2e-3)
    assert 0.3 < (x[clear] > 0.0).mean() < 0.9
    seen = irradiance.visibility[: len(irradiance.radiosity)]
    assert set(np.unique(seen[:, 0])) >= {0, 255}


def test_a_white_diffuse_floor_shows_its_light_back() -> None:
    """What is lit lights others: a wall beside a lit floor is not black."""
    white = replace(BLACK, base_color=(0.8, 0.8, 0.8))
    wall = Part("wall", quad((-1, 0, -1), (2, 0, 0), (0, 2, 0)), white)
    lit = floor(replace(SPOT, position=(0.0, 1.0, 0.0)))
    parts = (replace(lit.parts[0], material=white), wall)
    light = diffuse(replace(lit, parts=parts), 16)
    samples = int(light.offset[2])  # the wall's are behind
    assert (light.visibility[samples:, 0] == 255).mean() > 0.9 and light.radiosity[samples:].mean() > 5e-3


def ggx(n: np.ndarray, v: np.ndarray, light: np.ndarray, roughness: float) -> np.ndarray:
    """D·V·n·l of unit vectors [glTF 2.0, appendix B], and v·h."""
    alpha = roughness**2
    h = (v + light) / np.linalg.norm(v + light, axis=-1, keepdims=True)
    n_l, n_v, n_h = ((n * other).sum(-1) for other in (light, v, h))
    d = alpha**2 / (np.pi * (n_h**2 * (alpha**2 - 1.0) + 1.0) ** 2)
    root = n_l * np.sqrt(alpha**2 + (1 - alpha**2) * n_v**2) + n_v * np.sqrt(alpha**2 + (1 - alpha**2) * n_l**2)
    return d * 0.5 / root * np.maximum(n_l, 0.0), (v * h).sum(-1)


def test_a_lobe_shows_the_light_as_its_formula_says() -> None:
    """Of a black dielectric, which gains next to nothing by further bounces: F·D·V·n·l·I/d², in the mean of pixels."""
    roughness = 0.2
    part = Part("floor", quad((-1, 0, 1), (2, 0, 0), (0, 0, -2)), replace(BLACK, perceptual_roughness=roughness), True)
    lit = replace(scene([part], [(0,)]), lights=(replace(LAMP, position=(0.5, 1.0, 0.0)),))
    view = camera((-0.5, 1.0, 0.001), 32)
    layers = Tracer(lit, irradiance=no_irradiance(lit)).view(view, spp=256).layers
    corner, dx, dy = view.ray_basis()
    shown = np.zeros(len(layers.pixel))
    for x, y in np.ndindex(8, 8):
        column, row = layers.pixel % 32 + (x + 0.5) / 8, layers.pixel // 32 + (y + 0.5) / 8
        ray = corner + column[:, None] * dx + row[:, None] * dy
        place = view.position - ray * (view.position[1] / ray[:, 1:2])
        v, away = -ray / np.linalg.norm(ray, axis=-1, keepdims=True), np.array([0.5, 1.0, 0.0]) - place
        distance = np.linalg.norm(away, axis=-1, keepdims=True)
        shape, v_dot_h = ggx(np.array([0.0, 1.0, 0.0]), v, away / distance, roughness)
        shown += (0.04 + 0.96 * (1.0 - v_dot_h) ** 5) * shape / distance[:, 0] ** 2 / 64
    assert layers.coverage.min() > 0.999 and shown.max() > 1.0
    # 256 samples against 64 of a picture that is smooth within its pixels: 0.25 % at the most, in the median 0.03 %
    np.testing.assert_allclose(layers.diffuse, shown[:, None] * LAMP.intensity, rtol=4e-3)
    assert not layers.distant.any() and not layers.local.any()


def test_mirrors_show_no_lights() -> None:
    part = Part("floor", quad((-1, 0, 1), (2, 0, 0), (0, 0, -2)), replace(METAL, perceptual_roughness=0.0), True)
    lit = replace(scene([part], [(0,)]), lights=(LAMP,))
    layers = Tracer(lit, irradiance=no_irradiance(lit)).view(camera((-0.3, 1.0, 0.1), 16), spp=16).layers
    assert not layers.diffuse.any() and not layers.combined.any()


def test_pictures_are_those_of_the_path_reference() -> None:
    """Metal and paint, each mirrored in the other, on a floor, under a faint sky and one light of each kind."""
    point = PunctualLight("point", (30.0, 20.0, 20.0), (-2.0, 2.5, 2.0), range=9.0)
    spot = PunctualLight("spot", (70.0, 70.0, 60.0), (2.0, 3.0, 3.0), (-0.4264, -0.6396, -0.6396), cone=(0.2, 0.5))
    sun = PunctualLight("sun", (1.5, 1.2, 1.0), None, (0.6, -0.8, 0.0))
    parts = [
        Part("floor", quad((-4, -1, 4), (8, 0, 0), (0, 0, -8)), replace(BLACK, base_color=(0.3, 0.3, 0.3))),
        Part("ball", sphere(), replace(METAL, perceptual_roughness=0.4), True),
        Part("knob", sphere((1.6, -0.4, 0.6), 0.6), Material("paint", (0.1, 0.1, 0.8), 0.0, 0.4), True),
    ]
    lit = replace(scene(parts, [(1,), (2,)], constant_light(0.05)), lights=(point, spot, sun))
    view = camera((0.4, 1.5, 6.0), 40)
    tracer = Tracer(lit, irradiance=diffuse(lit, 64))
    picture = compose(tracer.view(view, spp=16, surroundings=True).layers)
    reference = PathReference(lit, materials="gltf").picture(view, spp=128, max_depth=4)
    ours, theirs = (1.0 - np.exp(-1.6 * each) for each in (picture, reference))
    error = np.abs(ours - theirs)
    # noise of what rough metal throws on the floor and back, in single pixels, in both
    print(
        np.median(error),
        np.quantile(error, 0.95),
        ours.mean() - theirs.mean(),
        np.median(error[theirs > 0.8]),
        (theirs > 0.8).sum(),
    )
    assert np.median(error) < 6e-3 and np.quantile(error, 0.95) < 0.06 and abs(ours.mean() - theirs.mean()) < 4e-3
    shine = theirs > 0.8  # the highlights
    assert shine.sum() > 50 and np.median(error[shine]) < 0.02
