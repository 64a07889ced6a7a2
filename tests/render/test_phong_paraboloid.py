"""Prefiltering on the device by two plane filters."""

import numpy as np
import pytest
from map_scenes import analytic_levels

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.dual_paraboloid import DualParaboloid
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.errors import RefletError
from reflet.reflectance.brdfs.ggx import GgxKernel
from reflet.reflectance.brdfs.kernel import Kernel
from reflet.reflectance.brdfs.phong import PhongKernel
from reflet.reflectance.brdfs.quadrature import filtered_reference
from reflet.reflectance.brdfs.tabulated_kernel import TabulatedKernel
from reflet.reflectance.prefilter.plane_filter import lobe_angle
from reflet.render.device.device import shared_device
from reflet.render.filters.phong_paraboloid import PhongParaboloidFilter
from reflet.render.maps.env_map_texture import EnvMapTexture, upload_env_map

PARABOLOID = DualParaboloid()
SIZE = 64


def refiltered(
    source: EnvMapTexture, kernel: Kernel, limit: float = 0.1, border: int | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Unit directions of the map's texels, and what they hold."""
    encoder = shared_device().create_command_encoder()
    env_map = PhongParaboloidFilter(shared_device(), SIZE, border).refilter(encoder, source, kernel, limit)
    shared_device().queue.submit([encoder.finish()])
    direction, valid = PARABOLOID.texel_directions(SIZE)
    return direction[valid], env_map.read().texels[valid][:, :3].astype(float)


def lamps(direction: np.ndarray) -> np.ndarray:
    """A dim sky with coloured lamps in it, some 15° wide, two of them on the equator z = 0."""
    axes = np.array([[1.0, 0.0, 0.0], [-0.6, -0.8, 0.0], [0.0, 0.6, 0.8], [0.48, -0.6, -0.64]])
    colours = np.array([[8.0, 2.0, 1.0], [1.0, 6.0, 2.0], [2.0, 1.0, 9.0], [4.0, 4.0, 4.0]])
    return 0.3 + 0.2 * direction[..., 1:2] + np.exp(60.0 * (direction @ axes.T - 1.0)) @ colours


@pytest.mark.parametrize("kernel", [PhongKernel(1.0), PhongKernel(30.0), PhongKernel(2000.0), GgxKernel(0.3)], ids=str)
def test_white_furnace(kernel: Kernel) -> None:
    grey = EnvImage(PARABOLOID, np.full((*PARABOLOID.shape(SIZE), 3), 0.7, np.float32))
    _, texels = refiltered(upload_env_map(shared_device(), [grey]), kernel, border=8)
    np.testing.assert_allclose(texels, 0.7, rtol=2e-6)  # rounding of float32, some ten operations deep


@pytest.mark.parametrize("source", [PARABOLOID, CUBE], ids=str)
def test_a_slope_keeps_what_the_lobe_leaves_of_it(source: Parameterization) -> None:
    exponent = 50.0
    levels = analytic_levels(source, SIZE, lambda direction: 1.0 + 0.5 * np.repeat(direction[..., 2:], 3, -1))
    direction, texels = refiltered(upload_env_map(shared_device(), levels), PhongKernel(exponent))
    # ∫ t^N·t dt / ∫ t^N dt from the cosine where the lobe is cut off to 1.
    end = np.cos(lobe_angle(PhongKernel(exponent), 0.1))
    left = (1.0 - end ** (exponent + 2.0)) / (exponent + 2.0) * (exponent + 1.0) / (1.0 - end ** (exponent + 1.0))
    error = np.abs(texels[:, 0] - (1.0 + 0.5 * left * direction[:, 2]))
    # In the middle the filter is the lobe, in some 20 texels 4/64 = 0.0625 wide: boxes and the stretching widen it by
    # (1/12 + 1/6) texel² an axis, 4·0.5·0.0625² radians² in all, a quarter of which is lost: 0.002. A mirror: 0.0073.
    assert error[np.abs(direction[:, 2]) > 0.97].max() < 3e-3
    # At the rim it reaches from 17° inside to 13° outside: its mean lies within half of the difference, 2° or 0.035.
    assert error.max() < 0.5 * 0.035


# Flat in the middle, gone at 22°: no Phong lobe is like it. Not normalized either, as measured BRDFs' lobes are not.
PLATEAU = TabulatedKernel(np.radians([0.0, 10.0, 22.0]), np.array([3.0, 2.5, 0.0]))


@pytest.mark.parametrize(
    ("kernel", "most"),
    [(PhongKernel(50.0), 0.06), (PhongKernel(250.0), 0.06), (PLATEAU, 0.06)],
    ids=["Phong 50", "Phong 250", "table"],
)
def test_against_brute_force(kernel: Kernel, most: float) -> None:
    levels = analytic_levels(PARABOLOID, SIZE, lamps)
    direction, texels = refiltered(upload_env_map(shared_device(), levels), kernel)
    some = slice(None, None, 5)
    expected = filtered_reference(levels[0], kernel, direction[some])
    assert np.abs(texels[some] - expected).mean() / expected.mean() < most


def test_the_rim_is_no_seam() -> None:
    """Beside the rim the two faces hold nearly the same: no dark or bright ring, with lamps right on it."""
    levels = analytic_levels(PARABOLOID, SIZE, lamps)
    direction, texels = refiltered(upload_env_map(shared_device(), levels), PhongKernel(30.0))
    front, back = direction[:, 2] >= 0.0, direction[:, 2] < 0.0
    near = np.flatnonzero(front & (direction[:, 2] < 0.03))
    partner = np.argmax(direction[near] @ direction[back].T, 1)
    expected = filtered_reference(levels[0], PhongKernel(30.0), direction[near])
    jump = np.abs(texels[near] - texels[back][partner]).mean() / expected.mean()
    assert jump < 0.05
    assert abs(texels[near].mean() / expected.mean() - 1.0) < 0.05


def test_sizes_that_cannot_be() -> None:
    with pytest.raises(RefletError, match="power of two"):
        PhongParaboloidFilter(shared_device(), 100)
    with pytest.raises(RefletError, match="multiple of 8"):
        PhongParaboloidFilter(shared_device(), 64, 5)
