"""The map that engines look up."""

import numpy as np
import pytest

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.shapes import Box, InfiniteSphere
from reflet.reflectance.brdfs.ggx import GgxKernel
from reflet.reflectance.prefilter.ggx_levels import FILAMENT
from reflet.reflectance.prefilter.prefilter import Prefilter
from reflet.reflectance.prefilter.split_sum_map import split_sum_map

SIZE = 64


def smooth_light() -> EnvImage:
    direction, _ = CUBE.texel_directions(SIZE)
    return EnvImage(CUBE, (1.0 + 0.8 * direction * np.abs(direction)).astype(np.float32))


def some_rays(count: int = 500) -> np.ndarray:
    r = np.random.default_rng(3).normal(size=(count, 3))
    return r / np.linalg.norm(r, axis=1, keepdims=True)


@pytest.mark.parametrize("roughness", [0.0, 0.1, 0.37, 1.0])
def test_constant_light_stays_what_it_is(roughness: float) -> None:
    light = split_sum_map(EnvImage(CUBE, np.full((6, SIZE, SIZE, 3), [0.5, 1.0, 2.0], np.float32)), InfiniteSphere())
    rays = some_rays()
    seen = light.radiance(np.zeros_like(rays), rays, np.full(len(rays), roughness))
    np.testing.assert_allclose(seen, np.broadcast_to([0.5, 1.0, 2.0], seen.shape), rtol=1e-4)  # sums of float32


@pytest.mark.parametrize("level", [0, 1, 2])
def test_a_levels_own_roughness_sees_what_its_kernel_filters(level: int) -> None:
    image, rays = smooth_light(), some_rays()
    light = split_sum_map(image, InfiniteSphere())
    assert len(light.levels) == 3 and light.levels[-1].size == 16
    roughness = FILAMENT.roughness_of_level(level, 3)
    seen = light.radiance(np.zeros_like(rays), rays, np.full(len(rays), roughness))
    wanted = Prefilter(image).radiance(GgxKernel(roughness**2), rays) if level else 1.0 + 0.8 * rays * np.abs(rays)
    # interpolated between texels of 6 degrees, which the light's bends are lost by
    np.testing.assert_allclose(seen, wanted, atol=0.006)


def test_between_two_levels_lies_their_mean_and_each_ray_has_its_own_roughness() -> None:
    light, rays = split_sum_map(smooth_light(), InfiniteSphere()), some_rays()
    at = np.zeros_like(rays)
    halfway = float(1.0 - np.sqrt(1.0 - 0.25))  # r(2 - r) = 1/4: between levels 0 and 1 of 3
    ends = [light.radiance(at, rays, np.full(len(rays), FILAMENT.roughness_of_level(k, 3))) for k in (0, 1)]
    mixed = np.where(np.arange(len(rays)) % 2, halfway, 0.0)
    seen = light.radiance(at, rays, mixed)
    np.testing.assert_allclose(seen[1::2], 0.5 * (ends[0] + ends[1])[1::2], atol=1e-6)
    np.testing.assert_allclose(seen[::2], ends[0][::2], atol=1e-6)


def test_lookups_meet_the_box() -> None:
    image, rays = smooth_light(), some_rays()
    box = Box((-1.0, -1.0, -1.0), (1.0, 2.0, 1.0), (0.1, 0.2, 0.0))
    points = 0.5 * some_rays(1000)[500:]
    free, projected = split_sum_map(image, InfiniteSphere()), split_sum_map(image, box)
    direction = box.lookup_direction(points, rays)
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    roughness = np.full(len(rays), 0.3)
    np.testing.assert_allclose(
        projected.radiance(points, rays, roughness), free.radiance(points, direction, roughness), atol=1e-5
    )
    assert np.abs(projected.radiance(points, rays, roughness) - free.radiance(points, rays, roughness)).max() > 0.2
