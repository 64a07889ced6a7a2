"""Lobes as few taps."""

import numpy as np
import pytest

from reflet.errors import RefletError
from reflet.reflectance.brdfs.ggx import GgxKernel
from reflet.reflectance.brdfs.kernel import Kernel
from reflet.reflectance.brdfs.lambert import DiffuseKernel
from reflet.reflectance.brdfs.phong import PhongKernel
from reflet.reflectance.brdfs.tabulated_kernel import TabulatedKernel
from reflet.reflectance.lobes.lobe_taps import PER_RING, RINGS, LobeTaps, lobe_taps, phong_taps


def density(taps: LobeTaps, direction: np.ndarray) -> np.ndarray:
    """Of true blurs, von Mises and Fisher's, around the taps."""
    sharpness = 1.0 / taps.blur**2
    scale = taps.weight * sharpness / (-2.0 * np.pi * np.expm1(-2.0 * sharpness))
    return np.exp(sharpness * (direction @ taps.direction.T - 1.0)) @ scale


# The distances that are left, rounded up. The diffuse lobe, which ends with a bend at the horizon, costs most; it is
# summed without taps where it is wanted.
@pytest.mark.parametrize(
    ("kernel", "most"),
    [
        (PhongKernel(10.0), 0.01),
        (PhongKernel(400.0), 0.01),
        (GgxKernel(0.014), 0.02),
        (GgxKernel(0.04), 0.02),
        (GgxKernel(0.25), 0.03),
        (GgxKernel(1.0), 0.05),
        (DiffuseKernel(), 0.05),
        # its integral is 1
        (TabulatedKernel(np.radians([0.0, 10.0, 22.0]), np.array([1.0, 0.8, 0.0]) / 0.2099), 0.06),
    ],
    ids=lambda value: type(value).__name__,
)
def test_blurs_add_up_to_the_lobe(kernel: Kernel, most: float) -> None:
    taps = lobe_taps(kernel)
    assert len(taps.weight) <= 1 + RINGS * PER_RING
    assert taps.weight.min() > 0.0
    assert taps.weight.sum() == pytest.approx(1.0)
    np.testing.assert_allclose(np.linalg.norm(taps.direction, axis=-1), 1.0)
    assert distance(taps, kernel) < most + 0.02  # a ring's ripple over the azimuth adds some hundredths


def distance(taps: LobeTaps, kernel: Kernel) -> float:
    """∫ |Σ w·g - k| dω on a polar grid, fine towards the middle: θ = π·x², midpoints."""
    x = (np.arange(400) + 0.5) / 400
    theta, phi = np.meshgrid(np.pi * x * x, 2.0 * np.pi * np.arange(24) / 24, indexing="ij")
    solid_angle = np.sin(theta) * (2.0 * np.pi * x / 400)[:, None] * (2.0 * np.pi / 24)
    direction = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)
    return float((np.abs(density(taps, direction) - kernel.density(np.sin(0.5 * theta) ** 2)) * solid_angle).sum())


@pytest.mark.parametrize(
    ("phong_exponent", "most"), [(1.0, 0.03), (4.0, 0.03), (11.0, 0.03), (60.0, 0.007), (5e3, 0.007)]
)
def test_phong_lobes_need_no_search(phong_exponent: float, most: float) -> None:
    taps = phong_taps(phong_exponent)
    assert taps.weight.min() > 0.0
    assert taps.weight.sum() == pytest.approx(1.0)
    assert distance(taps, PhongKernel(phong_exponent)) < most + 0.02  # as above


def test_an_exponent_of_zero_is_no_lobe() -> None:
    with pytest.raises(RefletError, match="greater than 0"):
        phong_taps(-1.0)
