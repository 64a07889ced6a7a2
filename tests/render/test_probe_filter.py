"""Prefiltering of cubes on the device by taps from a pyramid."""

from functools import cache

import numpy as np
import pytest
from map_scenes import analytic_levels, linear

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.latlong import LatLong
from reflet.errors import RefletError
from reflet.reflectance.brdfs.ggx import GgxKernel
from reflet.reflectance.brdfs.kernel import Kernel
from reflet.reflectance.brdfs.lambert import DiffuseKernel
from reflet.reflectance.brdfs.phong import PhongKernel
from reflet.reflectance.brdfs.quadrature import filtered_reference
from reflet.reflectance.prefilter.ggx_levels import GEOMETRIC
from reflet.render.device.device import shared_device
from reflet.render.filters.probe_filter import ProbeFilter, ggx_kernels
from reflet.render.filters.probe_pyramid import FILLED
from reflet.render.maps.env_map_texture import HALF, EnvMapTexture, create_env_map, upload_env_map

SIZE = 64
KERNELS = (GgxKernel(0.1), GgxKernel(0.5), PhongKernel(30.0))


@cache
def probe_filter() -> ProbeFilter:
    """One for all tests."""
    return ProbeFilter(shared_device(), SIZE, KERNELS)


def refiltered(finest: EnvImage) -> EnvMapTexture:
    """A cube of 64 rows, filtered; the same texture every time."""
    encoder = shared_device().create_command_encoder()
    half = EnvImage(CUBE, finest.texels.astype(np.float16))
    env_map = probe_filter().refilter(encoder, upload_env_map(shared_device(), [half]))
    shared_device().queue.submit([encoder.finish()])
    return env_map


def error(env_map: EnvMapTexture, level: int, finest: EnvImage, kernel: Kernel) -> float:
    """Mean over directions of what some texels are off, as a share of the mean of what they should hold."""
    size = SIZE >> level
    some = np.random.default_rng(3).permutation(6 * size * size)[:300]
    expected = filtered_reference(finest, kernel, CUBE.texel_directions(size)[0].reshape(-1, 3)[some])
    weight = CUBE.texel_solid_angle(size).reshape(-1, 1)[some]
    texels = env_map.read(level).texels.reshape(-1, 4)[some, :3].astype(float)
    return float(np.sum(weight * np.abs(texels - expected)) / np.sum(weight * expected))


def test_white_furnace() -> None:
    for radiance in (1.0, 0.699707):  # a half float too
        env_map = refiltered(EnvImage(CUBE, np.full((6, SIZE, SIZE, 3), radiance, np.float32)))
        for level in range(4):
            texels = env_map.read(level).texels[..., :3].astype(float)
            # The very half float that came: it is the mean of itself to float32's rounding, far below half a step.
            np.testing.assert_allclose(texels, radiance, rtol=1e-6)


def test_level_0_is_a_mirror() -> None:
    finest = analytic_levels(CUBE, SIZE, linear, np.float16)[0]
    # One half float lower here and there: lookups at texels' centres, to float32's rounding of the coordinate.
    np.testing.assert_allclose(refiltered(finest).read().texels[..., :3], finest.texels, rtol=1e-3)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_slope_keeps_what_the_lobe_leaves_of_it(axis: int) -> None:
    finest = analytic_levels(CUBE, SIZE, lambda direction: 1.0 + 0.5 * np.repeat(direction[..., axis, None], 3, -1))[0]
    env_map = refiltered(finest)
    direction = CUBE.texel_directions(SIZE >> 3)[0]
    expected = 1.0 + 0.5 * 31.0 / 32.0 * direction[..., axis]  # (N + 1)/(N + 2)
    # Half a hundredth: blurs that are wider or narrower than they should be by a tenth change 31/32 by 0.004.
    assert np.abs(env_map.read(3).texels[..., 0] - expected).max() < 5e-3


def lamps(direction: np.ndarray) -> np.ndarray:
    """Lamps some 10° wide: amid a face, on an edge, at a corner."""
    axes = np.array([[0.1, 0.2, 1.0], [1.0, 0.1, 1.0], [-1.0, -1.0, -1.0]])
    axes /= np.linalg.norm(axes, axis=-1, keepdims=True)
    colours = np.array([[8.0, 2.0, 1.0], [1.0, 6.0, 2.0], [2.0, 1.0, 9.0]])
    return 0.3 + 0.2 * direction[..., 1:2] + np.exp(150.0 * (direction @ axes.T - 1.0)) @ colours


@pytest.mark.parametrize("level", [1, 2, 3])
def test_against_brute_force(level: int) -> None:
    finest = analytic_levels(CUBE, SIZE, lamps)[0]
    # What 49 taps leave; 32 importance samples leave 0.08 to 0.2 (benchmarks/gpu_prefilter_time.py).
    assert error(refiltered(finest), level, finest, KERNELS[level - 1]) < 0.04


def test_a_sun_keeps_its_light_wherever_it_is() -> None:
    for row, column in [(32, 32), (33, 61), (63, 62), (50, 49)]:
        texels = np.zeros((6, SIZE, SIZE, 3), np.float32)
        texels[4, row - 1 : row + 1, column - 1 : column + 1] = 500.0
        finest = EnvImage(CUBE, texels)
        env_map = refiltered(finest)
        light = float((texels * CUBE.texel_solid_angle(SIZE)[..., None]).sum())
        kept = env_map.read(2).texels[..., :3].astype(float) * CUBE.texel_solid_angle(SIZE >> 2)[..., None]
        # Texels of the pyramid sample the cube's at nine points: a sun of four texels is caught within some hundredths
        # (0.02 in the root mean square over 44 places, 0.042 at most: at the first of these).
        assert kept.sum() == pytest.approx(light, rel=0.05)


def diffuse_of(finest: EnvImage) -> np.ndarray:
    """Texels of the diffuse cube of 8 rows."""
    refiltered(finest)
    target = create_env_map(shared_device(), CUBE, 8, 1, HALF, FILLED)
    encoder = shared_device().create_command_encoder()
    probe_filter().pyramid.diffuse(encoder, target)
    shared_device().queue.submit([encoder.finish()])
    return target.read().texels[..., :3].astype(float)


def test_diffuse_maps_of_what_has_a_closed_form() -> None:
    white = diffuse_of(EnvImage(CUBE, np.full((6, SIZE, SIZE, 3), 0.699707, np.float32)))
    np.testing.assert_allclose(white, 0.699707, rtol=1e-6)  # the very half float, as above
    finest = analytic_levels(CUBE, SIZE, lambda direction: 1.0 + 0.5 * np.repeat(direction[..., 1:2], 3, -1))[0]
    # 2/3 of the slope are left. B-splines of texels of 0.098 take σ² = 0.098²/4 of it, 0.0008; half floats 0.0005.
    np.testing.assert_allclose(diffuse_of(finest)[..., 0], 1.0 + CUBE.texel_directions(8)[0][..., 1] / 3.0, atol=0.002)


def test_diffuse_maps_against_brute_force() -> None:
    finest = analytic_levels(CUBE, SIZE, lamps)[0]
    expected = filtered_reference(finest, DiffuseKernel(), CUBE.texel_directions(8)[0].reshape(-1, 3))
    # What is asked of prefiltered diffuse maps: 1 %.
    assert np.abs(diffuse_of(finest).reshape(-1, 3) - expected).sum() < 0.01 * expected.sum()


def test_ggx_of_roughness_1_is_diffuse() -> None:
    finest = analytic_levels(CUBE, SIZE, lamps)[0]
    half = EnvImage(CUBE, finest.texels.astype(np.float16))
    encoder = shared_device().create_command_encoder()
    chain = ProbeFilter(shared_device(), SIZE, (GgxKernel(0.25), GgxKernel(1.0)))
    env_map = chain.refilter(encoder, upload_env_map(shared_device(), [half]))
    shared_device().queue.submit([encoder.finish()])
    assert error(env_map, 2, finest, GgxKernel(1.0)) < 0.01  # as of diffuse maps


def test_levels_are_those_of_the_roughness_scale() -> None:
    kernels = ggx_kernels(128)
    assert len(kernels) == 4
    assert kernels[-1] == GgxKernel(1.0)
    for level, kernel in enumerate(kernels, start=1):
        assert isinstance(kernel, GgxKernel)
        assert GEOMETRIC.lod_from_roughness(np.sqrt(kernel.alpha), 5) == pytest.approx(level)


def test_refusals() -> None:
    with pytest.raises(RefletError, match="power of two"):
        ProbeFilter(shared_device(), 48)
    with pytest.raises(RefletError, match="filtered levels"):
        ProbeFilter(shared_device(), 64, [])
    encoder = shared_device().create_command_encoder()
    latlong = upload_env_map(shared_device(), analytic_levels(LatLong(), 16))
    with pytest.raises(RefletError, match="warp it to a cube"):
        ProbeFilter(shared_device(), 16, [PhongKernel(10.0)]).refilter(encoder, latlong)
