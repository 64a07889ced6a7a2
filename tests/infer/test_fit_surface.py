"""Surface layers from traced light: what playback shows with them is what was traced."""

from dataclasses import replace

import numpy as np
import pytest

from reflet.envmap.env_map import EnvMap
from reflet.envmap.geometry import InfiniteSphere
from reflet.envmap.mip_chain import MipChain
from reflet.infer.fit_surface import MOST_GAIN, fit_surface
from reflet.scene.surfaces.surface_layer import SIDES, neighbours, texel_directions
from reflet.trace.layers import TracedSurface

COLOUR = np.float32([0.8, 0.5, 0.2])


def constant_map(radiance: float) -> EnvMap:
    chain = MipChain(8)
    return EnvMap(chain, np.full((chain.texel_count, 3), radiance, np.float32), InfiniteSphere())


def traced(local: np.ndarray, alpha: float, distant: np.ndarray, noise: float = 0.0, strip: int = 20) -> TracedSurface:
    """A strip of squares on the floor, each two triangles, with rows of what rises above it."""
    sites = 2 * (strip + 1)
    a = np.arange(strip)
    corners = np.concatenate(
        [np.stack([a, a + strip + 1, a + 1], -1), np.stack([a + 1, a + strip + 1, a + strip + 2], -1)]
    )
    up = np.flatnonzero(texel_directions(SIDES[0])[:, 1] > 0.05)
    row_site, row_texel = (each.ravel() for each in np.meshgrid(np.arange(sites), up, indexing="ij"))
    rows = len(row_site)
    dither = 1.0 + noise * np.random.default_rng(1).standard_normal((rows, 1)).astype(np.float32)
    return TracedSurface(
        side=SIDES[0],
        resolution=np.ones(len(corners), np.uint32),
        offset=3 * np.arange(len(corners), dtype=np.uint32),
        site=corners.ravel().astype(np.uint32),
        object=np.zeros(sites, np.int32),
        position=np.zeros((sites, 3), np.float32),
        normal=np.tile(np.float32([0, 1, 0]), (sites, 1)),
        roughness=np.full(sites, 0.5, np.float32),
        row_site=row_site.astype(np.int32),
        row_texel=row_texel.astype(np.int32),
        mirrored=texel_directions(SIDES[0])[row_texel].astype(np.float32),
        local=(local * dither).astype(np.float32),
        alpha=np.full(rows, alpha, np.float32),
        distant=(distant * dither).astype(np.float32),
    )


@pytest.mark.parametrize("looked_up", [1.0, 0.9, 1.2, 0.2, 0.0])
def test_maps_and_layer_show_the_traced_light_together(looked_up: float) -> None:
    """Whatever the maps show: a little wrong, far too dark, or nothing."""
    found = fit_surface(traced(0.3 * COLOUR, 0.25, COLOUR), [[constant_map(looked_up)]], 0.0)
    light = found.light.astype(float)
    wanted = 0.3 * COLOUR + 0.75 * COLOUR
    np.testing.assert_allclose(
        light[..., :3] + (1.0 - light[..., 3:]) * looked_up, np.tile(wanted, (42, 64, 1)), atol=2e-3
    )
    assert (1.0 - light[..., 3] <= MOST_GAIN).all()


def test_right_maps_leave_alpha_and_local_light_as_they_are() -> None:
    found = fit_surface(traced(0.3 * COLOUR, 0.25, np.float32([1, 1, 1])), [[constant_map(1.0)]], 0.0)
    np.testing.assert_allclose(found.light, np.tile([*(0.3 * COLOUR), 0.25], (42, 64, 1)), atol=1e-3)  # half floats


def test_noise_of_sites_is_averaged_and_edges_stay() -> None:
    """A bright half beside a dark one; averages of a handful of neighbours leave less than half of the noise."""
    noisy = traced(COLOUR, 1.0, COLOUR, noise=0.1)
    bright = np.arange(42) % 21 > 10
    noisy = replace(noisy, local=noisy.local * np.where(bright, 4.0, 1.0)[noisy.row_site, None].astype(np.float32))
    found = fit_surface(noisy, [[constant_map(1.0)]], 0.0).light[..., 1].astype(float) / COLOUR[1]
    assert np.abs(found[bright].mean() - 4.0) < 0.05 and np.abs(found[~bright].mean() - 1.0) < 0.02
    up = texel_directions(SIDES[0])[:, 1] > 0.05
    before = (noisy.local[:, 1] / COLOUR[1]).reshape(42, -1)
    for half, value in ((bright, 4.0), (~bright, 1.0)):
        assert found[half][:, up].std() < 0.5 * before[half].std()
        assert np.abs(found[half] - value).max() < 0.35 * value  # also where the halves meet


def test_texels_are_beside_those_around_them() -> None:
    """Over the fold, too: no neighbour is farther than one on the coarsest part of the map."""
    near, direction = neighbours(SIDES[0]), texel_directions(SIDES[0])
    assert near.shape == (SIDES[0] ** 2, 4)
    for side in range(4):
        assert ((near[near[:, side]] == np.arange(SIDES[0] ** 2)[:, None]).any(1)).all(), "neighbours know each other"
    cosine = np.einsum("tc,tkc->tk", direction, direction[near])
    assert cosine.min() > np.cos(np.radians(40.0))
    assert cosine.max() < 1.0 - 1e-6
