"""Masked and blended surfaces in pictures: in every kind of pass, and as the tracer sees them."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import MIRROR, analytic_map, pem_of, quad, scene_of

from reflet.envmap.geometry import InfiniteSphere
from reflet.render.playback.renderer import Renderer
from reflet.render.playback.visibility import rasterized_visibility
from reflet.scene.material import CLAMPS, Material, Texture
from reflet.scene.scene import Part
from reflet.scene.surfaces.irradiance import IrradianceMap
from reflet.scene.views.camera import Camera
from reflet.trace.tracer import Tracer

LAMP = Material("lamp", (0.0, 0.0, 0.0), 0.0, emission=(1.0, 1.0, 1.0))
HALVES = Texture(np.uint8([[[255, 255, 255, 255], [255, 255, 255, 0]]]), CLAMPS)
MASKED = replace(MIRROR, alpha_mode="mask", base_color_texture_srgb=HALVES)
BLENDED = replace(MIRROR, alpha_mode="blend", alpha=0.3)
UV = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], float)
VIEW = Camera((0, 0, 4.0), (0, 0, 0), width=32, height=32)


def pem_with(material: Material, *, reflective: bool = True):  # type: ignore[no-untyped-def]
    """A pane before a wall that glows, in black surroundings."""
    pane = Part(
        "pane", quad(np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], float), UV), material, reflective
    )
    wall = quad(np.array([(-9, -9, -2), (9, -9, -2), (9, 9, -2), (-9, 9, -2)], float))
    far = quad(np.array([(-1, -90, 0), (1, -90, 0), (1, -90, 1), (-1, -90, 1)], float))
    scene = scene_of(*([pane] if reflective else [Part("far", far, MIRROR, True), pane]), Part("wall", wall, LAMP))
    none = np.zeros(scene.triangle_offsets[-1], np.uint32)
    dark = analytic_map(8, lambda d: np.zeros(d.shape), InfiniteSphere())
    return pem_of(scene, [dark], irradiance=IrradianceMap(none, none, np.zeros((1, 3), np.float32)))


@pytest.mark.parametrize("reflective", [True, False])
@pytest.mark.parametrize("drawn", ["exact", "fast", "multisampled", "adaptive"])
def test_what_lies_behind_shows_through(drawn, reflective) -> None:  # type: ignore[no-untyped-def]
    modes = {
        "exact": {"samples": 16}, "fast": {"samples": 4, "exact": False},
        "multisampled": {"samples": 4, "multisampled": True, "exact": False}, "adaptive": {"samples": "adaptive"},
    }  # fmt: skip
    for material in (MASKED, BLENDED):
        black = material if reflective else replace(material, base_color=(0.0, 0.0, 0.0), metallic=0.0)
        picture = Renderer(pem_with(black, reflective=reflective)).frame(VIEW, **modes[drawn])[8:24, 8:24, 0]
        if material is MASKED:
            np.testing.assert_array_equal(picture, np.tile(np.repeat([0.0, 1.0], 8), (16, 1)))
        else:
            # 256 pixels of at least 4 samples that are evenly spread: a pixel is off by at most a quarter
            assert picture.mean() == pytest.approx(0.7, abs=0.02)
            assert np.abs(picture - 0.7).max() <= 0.25 + 0.05


@pytest.mark.parametrize("material", [MASKED, BLENDED])
def test_rasterizer_and_tracer_see_the_same_samples(material) -> None:  # type: ignore[no-untyped-def]
    """The G-buffer is that of what playback draws: sub-sample by sub-sample, at random or not."""
    pem = pem_with(material)
    drawn = rasterized_visibility(Renderer(pem), VIEW, 16)
    traced = Tracer(pem.scene, irradiance=pem.irradiance).view(VIEW, spp=1, sample_count=16).visibility
    keys = [it.pixel.astype(np.int64) * 16 + it.sub_sample for it in (drawn, traced)]
    covered = 2 / (2 * 4 * np.tan(np.radians(18.0))) * 32
    assert len(keys[0]) == pytest.approx((0.5 if material is MASKED else 0.3) * 16 * covered**2, rel=0.02)
    # rounding decides at edges, of the pane or of its mask, and where a threshold is alpha itself
    assert len(np.setxor1d(*keys)) <= 0.004 * len(keys[0])


def test_dielectrics_reflect_by_their_index() -> None:
    """A black plate of index 1.33 under white light, seen head-on: ((n - 1)/(n + 1))² of it, 2 %."""
    for fields, expected in (({}, 0.04), ({"ior": 1.33}, 0.02006), ({"specular": 0.5}, 0.02), ({"ior": 0.0}, 1.0)):
        plate = replace(MIRROR, base_color=(0.0, 0.0, 0.0), metallic=0.0, **fields)
        pem = pem_with(plate)
        white = analytic_map(8, lambda d: np.ones(d.shape), InfiniteSphere())
        pem = pem_of(pem.scene, [white], irradiance=pem.irradiance)
        assert Renderer(pem).frame(VIEW, samples=1)[16, 16, 0] == pytest.approx(expected, abs=2e-5)


def test_unlit_surfaces_send_their_base_colour() -> None:
    texture = Texture(np.uint8([[[188, 255, 0, 255]]]))  # sRGB 188 is linear 0.503
    sign = Material("sign", (0.5, 0.25, 1.0), 0.0, unlit=True, base_color_texture_srgb=texture)
    for reflective in (True, False):
        pem = pem_with(replace(sign, specular=0.0), reflective=reflective)  # nothing is reflected
        shown = Renderer(pem).frame(VIEW, samples=1)[16, 16, :3]
        # texture units decode sRGB in their own way, to a tenth of a code of 8 bits
        np.testing.assert_allclose(shown, [0.25144, 0.25, 0.0], atol=4e-4)
