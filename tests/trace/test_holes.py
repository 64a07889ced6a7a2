"""Surfaces that are masked or half transparent: what goes through them, seen, mirrored, and lit from behind."""

from dataclasses import replace

import numpy as np
import pytest
from trace_scenes import CHROME, camera, no_irradiance, quad, scene, sphere

from reflet.scene.material import CLAMPS, Material, Texture
from reflet.scene.scene import Part, Scene
from reflet.scene.surfaces.hull import hull_triangles
from reflet.trace.compose import compose
from reflet.trace.layers import Shells
from reflet.trace.references.path_reference import PathReference
from reflet.trace.tracer import Tracer

BLACK = Material("black", (0.0, 0.0, 0.0), 0.0, double_sided=True)
LAMP = Material("lamp", (0.0, 0.0, 0.0), 0.0, emission=(1.0, 1.0, 1.0))
HALVES = Texture(np.uint8([[[255, 255, 255, 255], [255, 255, 255, 0]]]), CLAMPS)  # the right half is not there
MASKED = replace(BLACK, alpha_mode="mask", base_color_texture_srgb=HALVES)
BLENDED = replace(BLACK, alpha_mode="blend", alpha=0.3)

LIGHT = Part("light", quad((-20, -20, -3), (40, 0, 0), (0, 40, 0)), LAMP)  # behind all, its front towards the camera


def pane(material: Material, z: float = 0.0) -> Part:
    return Part(f"pane{z}", quad((-1, -1, z), (2, 0, 0), (0, 2, 0)), material)


def picture(what: Scene, spp: int = 64, size: int = 32) -> np.ndarray:
    tracer = Tracer(what, irradiance=no_irradiance(what))
    return compose(tracer.view(camera((0, 0, 4.0), size=size), spp=spp, surroundings=True).layers)[..., 0]


def beside(what: Part) -> Scene:
    """With a mirror far to the left, which is not in the picture."""
    return scene([what, LIGHT, Part("far", sphere((-90, 0, 0), 1.0, rows=8), CHROME, True)], [(2,)])


def middle(image: np.ndarray) -> np.ndarray:
    """Pixels well within a pane of two metres, four metres away, at 36 degrees of view."""
    return image[8:24, 8:24]


def test_a_mask_lets_exactly_the_rays_through_that_meet_its_holes() -> None:
    image = middle(picture(beside(pane(MASKED))))
    # alpha is 1 up to the left texel's centre, 0 from the right one's, and crosses the cutoff of a half in the middle
    np.testing.assert_array_equal(image, np.tile(np.repeat([0.0, 1.0], 8), (16, 1)))
    low = middle(picture(beside(pane(replace(MASKED, alpha_cutoff=0.25)))))
    # alpha is a quarter at u = 5/8: 0.25 m beyond the middle, of 2.6 m that 32 pixels show
    edge = 8 + 0.25 * 32 / (2 * 4 * np.tan(np.radians(18.0)))
    np.testing.assert_allclose(low.mean(0), np.clip(np.arange(16) + 1 - edge, 0, 1), atol=0.02)  # of 64 samples


def test_blending_hides_its_share_and_layers_multiply() -> None:
    one = middle(picture(beside(pane(BLENDED)), spp=256))
    assert one.mean() == pytest.approx(0.7, abs=2e-3)  # 65536 samples, evenly spread within each pixel
    assert one.std() < 0.01  # at random it were 0.029
    two = scene([*beside(pane(BLENDED)).parts, pane(BLENDED, 0.5)], [(2,)])
    # a pixel passes 0.4 to 0.7 of its samples, as its two shifts lie: 0.09 from 0.49 in the mean, of 256 pixels 0.0056
    assert middle(picture(two, spp=256)).mean() == pytest.approx(0.49, abs=0.02)


def test_alpha_is_the_product_of_factor_texture_and_vertices() -> None:
    half = Texture(np.uint8([[[255, 255, 255, 204]]]))
    part = pane(replace(BLENDED, alpha=0.75, base_color_texture_srgb=half))
    colors = np.float32([[1, 1, 1, 0.2], [1, 1, 1, 1.0], [1, 1, 1, 1.0], [1, 1, 1, 0.2]])
    image = middle(picture(beside(replace(part, mesh=replace(part.mesh, colors=colors))), spp=256))
    across = (np.arange(8, 24) + 0.5 - 16) / 32 * 2 * 4 * np.tan(np.radians(18.0))  # metres from the middle
    expected = 1.0 - 0.75 * 0.8 * (0.2 + 0.8 * (across + 1) / 2)
    np.testing.assert_allclose(image.mean(0), expected, atol=0.02)  # 4096 samples each: 0.008 at random


@pytest.mark.parametrize("material", [MASKED, BLENDED])
def test_mirrors_shadows_probes_and_the_reference_agree(material: Material) -> None:
    """A mirror shows the light through the pane before it; a white wall beneath takes its shadow; the mirrors' distant
    light has the hole too, ray by ray."""
    mirror = Part("mirror", quad((-1, -1, -1), (2, 0, 0), (0, 2, 0)), CHROME, True)
    light = Part("light", quad((20, -20, 9), (-40, 0, 0), (0, 40, 0)), LAMP)  # behind the camera
    white = Part("white", quad((-1, -1.2, -1), (0, 0, 2), (2, 0, 0)), Material("white", (1, 1, 1), 0.0))
    what = scene([mirror, pane(material, 2.0), light, white], [(0,)])
    view = camera((0.8, 0.3, 6.0), size=24)
    tracer = Tracer(what, irradiance_spp=256)
    shown = compose(tracer.view(view, spp=256, surroundings=True).layers)
    expected = PathReference(what).picture(view, spp=1024)
    assert np.abs(shown - expected).mean() < 0.012  # the noise of 256 and 1024 samples, and of edges
    assert abs(shown.mean() - expected.mean()) < 0.004
    probe = tracer.probe(0, Shells((0.0, 0.0, 0.0)), size=32, spp=64)
    ahead = probe.texels[: 6 * 32 * 32].reshape(6, 32, 32, 3)[4, 12:20, 12:20, 0]  # +z, through the pane
    # of a blended pane 4096 samples at random: a standard deviation of 0.0072
    assert ahead.mean() == pytest.approx(0.5 if material is MASKED else 0.7, abs=0.025)


def test_a_light_with_holes_gives_less() -> None:
    """An emitter of alpha 0.3 lights a floor with 0.3 of its light, whichever way paths find it."""
    floor = Part("floor", quad((-1, 0, -1), (0, 0, 2), (2, 0, 0)), Material("white", (1, 1, 1), 0.0))
    lamp = quad((-1, 1, -1), (2, 0, 0), (0, 0, 2))
    values = []
    for alpha in (1.0, 0.3):
        material = replace(LAMP, alpha_mode="blend", alpha=alpha)
        far = Part("far", sphere((0, -90, 0), 1.0, rows=8), CHROME, True)
        what = scene([floor, Part("lamp", lamp, material), far], [(2,)])
        irradiance = Tracer(what, irradiance_spp=128).irradiance
        count = int(((irradiance.resolution[:2].astype(int) + 1) * (irradiance.resolution[:2] + 2) // 2).sum())
        values.append(irradiance.radiosity[:count].mean())
    assert values[1] / values[0] == pytest.approx(0.3, rel=0.02)


def test_masked_triangles_stay_on_the_hull() -> None:
    """What leaves a front on the hull meets nothing of its object, whatever holes that has."""
    ball = sphere(rows=8)
    for material in (CHROME, replace(CHROME, alpha_mode="mask", base_color_texture_srgb=HALVES)):
        assert hull_triangles(scene([Part("ball", ball, material, True)], [(0,)])).all()


def test_an_unlit_surface_sends_its_base_colour() -> None:
    pixels = Texture(np.uint8([[[188, 255, 0, 255]]]))  # sRGB 188 is linear 0.503
    unlit = Material("sign", (0.5, 0.25, 1.0), 0.0, unlit=True, base_color_texture_srgb=pixels)
    what = beside(pane(unlit))
    tracer = Tracer(what, irradiance=no_irradiance(what))
    image = compose(tracer.view(camera((0, 0, 4.0), size=32), spp=4, surroundings=True).layers)
    np.testing.assert_allclose(image[16, 16], [0.25144, 0.25, 0.0], atol=1e-4)
    for materials in ("mirrors", "gltf"):
        shown = PathReference(what, materials=materials).picture(camera((0, 0, 4.0), size=32), spp=16)
        np.testing.assert_allclose(shown[16, 16], [0.25144, 0.25, 0.0], atol=1e-4)
